//! Flash contents kept between runs.
//!
//! One file for each controller holds its flash from the first address of bank 1. A file is
//! written beside the old one and then takes its place, so that whatever interrupts the bench
//! leaves the old contents or the new ones.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use world::{Engine, FlashImage, Mcu};

/// Flash of an STM32F429ZI, in bytes: a file holds no more.
const FLASH_LEN_MAX: usize = 2 << 20;

/// Says which product the contents belong to.
const PRODUCT_FILE: &str = "product";

/// Keeps two benches from sharing a directory.
const LOCK_FILE: &str = "lock";

/// A directory with the flash contents of all devices.
#[derive(Debug)]
pub struct StateDir {
    dir: PathBuf,
    /// Flash operations seen when the contents were last written, by device.
    saved_at: Vec<[u64; 2]>,
    _lock: File,
}

/// Flash contents of one device, STM and MSP; none where there is no file yet.
pub type Contents = [Option<FlashImage>; 2];

impl StateDir {
    /// Takes `dir`, which is made when it does not exist, for devices of `product`.
    ///
    /// # Errors
    /// A sentence: it can not be read or written, another bench has it, or what it holds belongs
    /// to another product.
    pub fn open(dir: &Path, product: &str) -> Result<Self, String> {
        let unusable =
            |error| format!("the state directory {} is unusable: {error}", dir.display());
        fs::create_dir_all(dir).map_err(unusable)?;
        let lock = File::create(dir.join(LOCK_FILE)).map_err(unusable)?;
        lock.try_lock().map_err(|_| {
            format!("the state directory {} is in use by another bench", dir.display())
        })?;
        let label = dir.join(PRODUCT_FILE);
        match fs::read_to_string(&label) {
            Ok(found) if found.trim() == product => {}
            Ok(found) => {
                let (dir, found) = (dir.display(), found.trim());
                return Err(format!("the state directory {dir} belongs to {found:?}"));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                fs::write(&label, format!("{product}\n")).map_err(unusable)?;
            }
            Err(error) => return Err(unusable(error)),
        }
        Ok(Self { dir: dir.to_owned(), saved_at: Vec::new(), _lock: lock })
    }

    /// The contents of the first `nodes` devices.
    ///
    /// # Errors
    /// A sentence that names the file that can not be read or holds something else.
    pub fn load(&self, nodes: usize) -> Result<Vec<Contents>, String> {
        (0..nodes)
            .map(|node| {
                let [stm, msp] = Mcu::BOTH.map(|mcu| read(&self.file(node, mcu)));
                Ok([stm?, msp?])
            })
            .collect()
    }

    /// Writes the contents of every device whose flash has changed since they were last written.
    ///
    /// # Errors
    /// A sentence that names the file that can not be written.
    pub fn save_changed(&mut self, engine: &dyn Engine) -> Result<(), String> {
        for node in 0..engine.node_count() {
            let operations = engine.stats(node).map(|stats| stats.flash_ops + stats.sector_erases);
            if self.saved_at.len() == node {
                self.saved_at.push([0; 2]);
            }
            let saved = self.saved_at.get(node).copied().unwrap_or_default();
            if operations != saved {
                self.save(engine, node)?;
                if let Some(saved) = self.saved_at.get_mut(node) {
                    *saved = operations;
                }
            }
        }
        Ok(())
    }

    /// Writes the contents of every device, half-done flash operations included.
    ///
    /// # Errors
    /// A sentence that names the file that can not be written.
    pub fn save_all(&mut self, engine: &dyn Engine) -> Result<(), String> {
        (0..engine.node_count()).try_for_each(|node| self.save(engine, node))
    }

    fn save(&self, engine: &dyn Engine, node: usize) -> Result<(), String> {
        Mcu::BOTH
            .into_iter()
            .try_for_each(|mcu| replace(&self.file(node, mcu), &engine.flash(node, mcu)))
    }

    fn file(&self, node: usize, mcu: Mcu) -> PathBuf {
        self.dir.join(format!("node{node}-{}.flash", mcu.name()))
    }
}

fn read(file: &Path) -> Result<Option<FlashImage>, String> {
    match fs::read(file) {
        Ok(bytes) if bytes.is_empty() || bytes.len() > FLASH_LEN_MAX => {
            Err(format!("{} holds no flash contents: it has {} bytes", file.display(), bytes.len()))
        }
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(format!("{} can not be read: {error}", file.display())),
    }
}

fn replace(file: &Path, bytes: &[u8]) -> Result<(), String> {
    let beside = file.with_extension("new");
    let write = || {
        let mut new = File::create(&beside)?;
        new.write_all(bytes)?;
        new.sync_all()?;
        fs::rename(&beside, file)
    };
    write().map_err(|error: io::Error| format!("{} can not be written: {error}", file.display()))
}
