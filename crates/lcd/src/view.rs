use crate::glyph::Glyph;
use crate::line::Line;

/// Everything the glass shows at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct View {
    /// The upper line.
    pub upper: Line,
    /// The lower line.
    pub lower: Line,
    /// The arrows.
    pub arrows: Arrows,
}

/// The two direction arrows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arrows {
    /// The one that points to the left.
    pub left: bool,
    /// The one that points to the right.
    pub right: bool,
}

impl Arrows {
    /// Both off.
    pub const NONE: Self = Self { left: false, right: false };

    /// Whether at least one is on.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.right
    }
}

impl View {
    /// The view that looks like this one on a device mounted upside down (NM17x DISP-11). The point
    /// of a digit of the glass then lies on the digit's other side, so it serves the neighbour; a
    /// point behind the last digit has no place and goes.
    #[must_use]
    pub fn upside_down(&self) -> Self {
        Self {
            upper: turned(&self.lower),
            lower: turned(&self.upper),
            arrows: Arrows { left: self.arrows.right, right: self.arrows.left },
        }
    }
}

fn turned(line: &Line) -> Line {
    let mut turned = Line::BLANK;
    let with_neighbour =
        line.glyphs.iter().zip(core::iter::once(&Glyph::BLANK).chain(&line.glyphs));
    for (place, (glyph, before)) in turned.glyphs.iter_mut().rev().zip(with_neighbour) {
        *place = glyph.upside_down();
        if before.shows(Glyph::POINT) {
            *place = place.with(Glyph::POINT);
        }
    }
    turned
}
