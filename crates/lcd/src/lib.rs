//! What the glass of a device shows: two lines of six digits with a point each, and two arrows.
//!
//! Content is plain data. A [`View`] is made of [`Line`]s, a line of [`Glyph`]s, and
//! [`View::ram`] is the picture as the display driver holds it ([`pcf8576`]). Blinking and turning
//! the picture round are done by making another view, never by the driver.
//!
//! ```
//! use lcd::{Arrows, Line, View};
//!
//! let view = View { upper: Line::number(20_000, 2), lower: Line::number(-5, 2), arrows: Arrows::NONE };
//! assert_eq!(view.to_string().lines().count(), 9);
//! assert_eq!(view.ram().len(), lcd::pcf8576::RAM_LEN);
//! ```
#![no_std]

#[cfg(test)]
extern crate std;

mod glyph;
mod line;
pub mod pcf8576;
mod picture;
mod view;

pub use glyph::Glyph;
pub use line::{DIGITS, Line};
pub use view::{Arrows, View};
