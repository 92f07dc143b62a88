//! Marks of a drawing in pixel coordinates: x to the right, y downwards.

/// Red, green, blue, 0 to 255.
pub(super) type Rgb = [u8; 3];

/// Colour of texts and of the scale.
pub(super) const INK: Rgb = [68, 68, 68];

/// Colour of the edges of areas and discs.
pub(super) const EDGE: Rgb = [51, 51, 51];

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Mark {
    /// Convex area and the colour of its edge.
    Area {
        corners: Vec<[f64; 2]>,
        fill: Rgb,
        edge: Rgb,
    },
    /// Disc.
    Disc {
        centre: [f64; 2],
        radius: f64,
        fill: Rgb,
    },
    /// Line with round ends, or dashed.
    Line {
        ends: [[f64; 2]; 2],
        width: f64,
        colour: Rgb,
        is_dashed: bool,
    },
    /// Text that begins at a point of its base line.
    Text { start: [f64; 2], text: String },
}

/// Marks in the order of drawing, on a white ground.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Width and height, px.
    pub(super) size_px: [f64; 2],
    pub(super) marks: Vec<Mark>,
}

impl Drawing {
    /// Adds the marks of another drawing, moved to the right.
    pub(super) fn append_at(&mut self, x_px: f64, other: Self) {
        let moved = other.marks.into_iter().map(|mark| mark.moved(x_px));
        self.marks.extend(moved);
        self.size_px[0] = self.size_px[0].max(x_px + other.size_px[0]);
        self.size_px[1] = self.size_px[1].max(other.size_px[1]);
    }

    pub(super) fn add_text(&mut self, start: [f64; 2], text: &str) {
        let text = text.to_owned();
        self.marks.push(Mark::Text { start, text });
    }

    pub(super) fn add_line(&mut self, ends: [[f64; 2]; 2], width: f64, colour: Rgb) {
        self.marks.push(Mark::Line {
            ends,
            width,
            colour,
            is_dashed: false,
        });
    }
}

impl Mark {
    fn moved(mut self, x_px: f64) -> Self {
        match &mut self {
            Self::Area { corners, .. } => corners.iter_mut().for_each(|[x, _]| *x += x_px),
            Self::Disc { centre, .. } => centre[0] += x_px,
            Self::Line { ends, .. } => ends.iter_mut().for_each(|[x, _]| *x += x_px),
            Self::Text { start, .. } => start[0] += x_px,
        }
        self
    }
}

/// Converts a colour of a URDF, 0 to 1 per channel.
pub(super) fn rgb_of(rgba: [f64; 4]) -> Rgb {
    let [r, g, b, _] = rgba.map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8);
    [r, g, b]
}
