//! What the devices are made of: where the firmware images are, and the engines.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use emulated::{Firmware, Fleet, Images, Options};
use world::Engine;

use crate::args::{EngineKind, Up};
use crate::state::Contents;
use crate::{PAIRS, SINGLES};

/// Names another directory than the one cargo writes images to.
pub const IMAGES_VARIABLE: &str = "SPINDLE_IMAGES";

/// Where cargo writes the images, below its target directory.
const BELOW_TARGET: &str = "thumbv7em-none-eabihf/release";

/// The directory the images are in, unless [`IMAGES_VARIABLE`] names it.
#[must_use]
pub fn directory() -> PathBuf {
    if let Some(directory) = std::env::var_os(IMAGES_VARIABLE) {
        return directory.into();
    }
    // This crate lies two levels below the workspace.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = std::env::var_os("CARGO_TARGET_DIR");
    workspace.join(target.unwrap_or_else(|| "target".into())).join(BELOW_TARGET)
}

/// Says what is wrong when `engine` makes no such product.
///
/// # Errors
/// A sentence with what helps.
pub fn check_product(product: &str, engine: EngineKind) -> Result<(), String> {
    let image = PAIRS.contains(&product) || SINGLES.contains(&product);
    let twin = twin::kind(product).is_some();
    match engine {
        EngineKind::Image if image => Ok(()),
        EngineKind::Image if twin => {
            Err(format!("there are no images of {product:?}: use --engine twin"))
        }
        EngineKind::Twin if twin => Ok(()),
        EngineKind::Twin if image => {
            Err(format!("there is no twin of {product:?}: use --engine image"))
        }
        EngineKind::Image | EngineKind::Twin => {
            let products: Vec<_> = twin::slugs().chain(SINGLES).collect();
            Err(format!("there is no product {product:?}: this bench has {}", products.join(", ")))
        }
    }
}

/// The engine `up` asks for, on `kept` flash contents.
///
/// # Errors
/// A sentence: an image is missing or can not run, or there is no such engine.
pub fn engine(up: &Up, kept: Vec<Contents>) -> Result<Box<dyn Engine>, String> {
    match up.engine {
        EngineKind::Image => image_engine(up, kept),
        EngineKind::Twin => twin_engine(up, kept),
    }
}

fn image_engine(up: &Up, flash: Vec<Contents>) -> Result<Box<dyn Engine>, String> {
    let directory = directory();
    let image = |controller: &str| {
        let path = directory.join(format!("{controller}-{}", up.product));
        if !path.is_file() {
            let hint =
                format!("`cargo xtask up {}` builds it, or set {IMAGES_VARIABLE}", up.product);
            return Err(format!("the image {} is missing: {hint}", path.display()));
        }
        Firmware::read(&path).map(Arc::new).map_err(|error| error.to_string())
    };
    let images = if SINGLES.contains(&up.product.as_str()) {
        Images::single(image("stm")?)
    } else {
        Images::pair(image("stm")?, image("msp")?)
    };
    let options = Options { nodes: nodes(up), seed: up.seed, flash };
    let fleet = Fleet::new(&images, options).map_err(|error| error.to_string())?;
    Ok(Box::new(fleet))
}

fn twin_engine(up: &Up, flash: Vec<Contents>) -> Result<Box<dyn Engine>, String> {
    let kind =
        twin::kind(&up.product).ok_or_else(|| format!("there is no twin of {:?}", up.product))?;
    let options = twin::Options { nodes: nodes(up), seed: up.seed, flash };
    let fleet = twin::Fleet::new(kind, options).map_err(|error| error.to_string())?;
    Ok(Box::new(fleet))
}

fn nodes(up: &Up) -> usize {
    usize::try_from(up.nodes).unwrap_or(usize::MAX)
}
