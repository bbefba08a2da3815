use canopen::Settings;
use object_dictionary::Dictionary;
use profiles::{ap04, encoder};

use crate::family::Family;

/// A product as a sensor.
#[derive(Debug)]
pub struct Model {
    /// Name on the command line.
    pub slug: &'static str,
    /// All objects.
    pub dictionary: &'static Dictionary,
    pub(crate) family: Family,
    pub(crate) settings: &'static Settings,
    steps_per_turn: u32,
}

impl Model {
    /// Steps of the sensor in a turn of the shaft.
    #[must_use]
    pub const fn steps_per_turn(&self) -> u32 {
        self.steps_per_turn
    }
}

const fn encoder(
    slug: &'static str,
    dictionary: &'static Dictionary,
    steps_per_turn: u32,
) -> Model {
    let settings = &crate::encoder::SETTINGS;
    Model { slug, dictionary, family: Family::Encoder, settings, steps_per_turn }
}

/// All models.
pub static MODELS: &[Model] = &[
    Model {
        slug: "ap04",
        dictionary: &ap04::DICTIONARY,
        family: Family::Ap04,
        settings: &crate::ap04::SETTINGS,
        steps_per_turn: crate::ap04::STEPS_PER_TURN,
    },
    encoder("gxmm", &encoder::gxmm::DICTIONARY, 1 << 13),
    encoder("gxam", &encoder::gxam::DICTIONARY, 1 << 13),
    encoder("gcmm", &encoder::gcmm::DICTIONARY, 1 << 12),
    encoder("gcam", &encoder::gcam::DICTIONARY, 1 << 12),
    encoder("gbmm", &encoder::gbmm::DICTIONARY, 1 << 18),
    encoder("gbam", &encoder::gbam::DICTIONARY, 1 << 18),
    encoder("gdmm", &encoder::gdmm::DICTIONARY, 1 << 18),
    encoder("gdam", &encoder::gdam::DICTIONARY, 1 << 18),
];
