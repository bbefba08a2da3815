//! The numbers a controller keeps without supply.
//!
//! A device whose memory fails works on with what it has in RAM and says so in its log: an
//! indicator that shows the position is worth more than one that stands still.
use embassy_stm32::Peri;
use embassy_stm32::peripherals::FLASH;
use heapless::{LinearMap, Vec};
use storage::{Opened, Record, Store, Value};

use crate::parameter_flash::ParameterFlash;

/// Keys a controller may use.
pub const RECORDS_MAX: usize = 256;
/// Numbers of a set.
const SET_LEN: usize = 32;
/// Numbers by their keys.
pub type Records = LinearMap<u32, u32, RECORDS_MAX>;

/// Numbers that are stored together, with their keys.
pub type NumberSet = Vec<(u32, u32), SET_LEN>;

/// What became of what was to be stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is stored.
    Stored,
    /// The memory did not take it.
    Failed,
}

/// The store in the parameter sectors; `None` if their flash could not be used.
pub struct Parameters(Option<Store<ParameterFlash>>);

impl Parameters {
    /// Opens the store. Erases sectors if the memory is new, or if a loss of supply had interrupted
    /// an erase; takes 0.25 s to 0.5 s per sector then.
    pub async fn open(flash: Peri<'static, FLASH>) -> Self {
        match Store::open(ParameterFlash::new(flash), 0..ParameterFlash::LEN).await {
            Ok((store, opened)) => {
                match opened {
                    Opened::Blank => defmt::info!("parameters: memory is new"),
                    Opened::Intact => {}
                    Opened::Resumed => defmt::info!("parameters: finished an interrupted erase"),
                    Opened::Lost => defmt::error!("parameters: unreadable, all at default"),
                }
                Self(Some(store))
            }
            Err(error) => {
                defmt::error!("parameters: no memory ({})", defmt::Debug2Format(&error));
                Self(None)
            }
        }
    }

    /// What is stored.
    pub async fn load(&mut self) -> Records {
        let mut records = Records::new();
        let Some(store) = &mut self.0 else { return records };
        let loaded = store.load_all(|record| {
            if let Some(number) = record.value.as_u32()
                && records.insert(record.key, number).is_err()
            {
                defmt::error!("more parameters than places: {=u32:#x} not read", record.key);
            }
        });
        if let Err(error) = loaded.await {
            defmt::error!("parameters: not all read ({})", defmt::Debug2Format(&error));
        }
        records
    }

    /// Stores `number` under `key`, unless it is stored already.
    pub(crate) async fn keep(&mut self, key: u32, number: u32) -> Outcome {
        let Some(store) = &mut self.0 else { return Outcome::Failed };
        outcome(store.store(&record(key, number)).await.map(|_| ()))
    }

    /// Replaces the numbers that are stored as a set by these.
    pub(crate) async fn keep_set(&mut self, set: &NumberSet) -> Outcome {
        let Some(store) = &mut self.0 else { return Outcome::Failed };
        let records = set.iter().map(|(key, number)| record(*key, *number));
        outcome(store.store_all(records).await.map(|_| ()))
    }

    /// Forgets everything stored, in one step.
    pub(crate) async fn forget(&mut self) -> Outcome {
        let Some(store) = &mut self.0 else { return Outcome::Failed };
        outcome(store.erase_all().await)
    }
}

fn record(key: u32, number: u32) -> Record {
    Record { key, value: Value::from(number) }
}

fn outcome(stored: Result<(), storage::Error>) -> Outcome {
    match stored {
        Ok(()) => Outcome::Stored,
        Err(error) => {
            defmt::error!("parameters: not stored ({})", defmt::Debug2Format(&error));
            Outcome::Failed
        }
    }
}
