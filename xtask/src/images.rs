//! The firmware images, two per product.

use std::path::PathBuf;

use crate::run::{self, Failure};
use crate::tools;

/// The processor of both boards.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// Every product there are images for.
pub(crate) const PRODUCTS: &[&str] = &["nm172"];

/// One of the two controllers of a device.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Controller {
    /// The CAN interface controller.
    Stm,
    /// The application controller.
    Msp,
}

impl Controller {
    /// Both of them.
    pub(crate) const BOTH: [Self; 2] = [Self::Stm, Self::Msp];

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Stm => "stm",
            Self::Msp => "msp",
        }
    }

    const fn package(self) -> &'static str {
        match self {
            Self::Stm => "firmware-stm",
            Self::Msp => "firmware-msp",
        }
    }

    /// The image as an ELF file.
    pub(crate) fn image(self, product: &str) -> PathBuf {
        directory().join(format!("{}-{product}", self.name()))
    }
}

/// The directory of all images.
pub(crate) fn directory() -> PathBuf {
    run::target_dir().join(TARGET).join("release")
}

/// The product of that name.
pub(crate) fn product(name: &str) -> Result<&'static str, Failure> {
    PRODUCTS.iter().copied().find(|&known| known == name).ok_or_else(|| {
        Failure::Usage(format!("there is no product `{name}`; there is: {}", PRODUCTS.join(", ")))
    })
}

/// Builds both images of `product`, one at a time: together their features would be unified.
pub(crate) fn build(product: &str) -> Result<(), Failure> {
    tools::require(&[tools::Tool::ThumbTarget])?;
    for controller in Controller::BOTH {
        let bin = format!("{}-{product}", controller.name());
        run::step(&mut run::cargo([
            "build",
            "--release",
            "--package",
            controller.package(),
            "--target",
            TARGET,
            "--bin",
            &bin,
        ]))?;
    }
    Ok(())
}
