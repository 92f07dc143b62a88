//! Pixels of a drawing. Every mark is filled as convex areas.

use std::f64::consts::TAU;

use super::mark::{Drawing, Mark, Rgb};

/// Lines per pixel row on which the coverage of an area is computed (design choice: smooth edges).
const LINES: usize = 4;
/// Corners of a disc (design choice: smooth up to a radius of 100 px).
const DISC_CORNERS: usize = 32;
/// Lengths of a dash and of the gap behind it, px.
const DASH_PX: [f64; 2] = [5.0, 3.0];

impl Drawing {
    /// Returns the drawing as rows of pixels with three bytes each: red, green, blue. Texts are
    /// left out.
    #[must_use]
    pub fn pixels(&self) -> (usize, usize, Vec<u8>) {
        let [width, height] = self.size_px.map(|size| size.round().max(1.0) as usize);
        let mut pixels = Pixels {
            width,
            height,
            bytes: vec![255; 3 * width * height],
            row: vec![0.0; width],
        };
        for mark in &self.marks {
            pixels.draw(mark);
        }
        (width, height, pixels.bytes)
    }
}

struct Pixels {
    width: usize,
    height: usize,
    bytes: Vec<u8>,
    /// Coverage of each pixel of the present row, 0 to 1.
    row: Vec<f64>,
}

impl Pixels {
    fn draw(&mut self, mark: &Mark) {
        match mark {
            Mark::Area { corners, fill, .. } => self.fill(corners, *fill),
            Mark::Disc {
                centre,
                radius,
                fill,
            } => self.fill(&circle(*centre, *radius), *fill),
            Mark::Line {
                ends,
                width,
                colour,
                is_dashed: false,
            } => self.fill(&rounded_line(*ends, width / 2.0), *colour),
            Mark::Line {
                ends,
                width,
                colour,
                ..
            } => {
                for dash in dashes(*ends) {
                    self.fill(&rounded_line(dash, width / 2.0), *colour);
                }
            }
            Mark::Text { .. } => {}
        }
    }

    fn fill(&mut self, corners: &[[f64; 2]], rgb: Rgb) {
        let ys = || corners.iter().map(|[_, y]| *y);
        let (top, bottom) = (
            ys().fold(f64::INFINITY, f64::min),
            ys().fold(f64::NEG_INFINITY, f64::max),
        );
        // A corner that is not finite draws nothing.
        if !(top < bottom && (bottom - top).is_finite()) {
            return;
        }
        let rows =
            top.floor().max(0.0) as usize..(bottom.ceil().max(0.0) as usize).min(self.height);
        for y in rows {
            self.row.fill(0.0);
            for line in 0..LINES {
                let at = y as f64 + (line as f64 + 0.5) / LINES as f64;
                if let Some(span) = span_at(corners, at) {
                    self.cover(span);
                }
            }
            self.blend(y, rgb);
        }
    }

    /// Adds the share that a line covers of each pixel.
    fn cover(&mut self, [from, to]: [f64; 2]) {
        let (from, to) = (from.max(0.0), to.min(self.width as f64));
        if from >= to {
            return;
        }
        let last = (to.ceil() as usize).min(self.width);
        for (x, share) in self.row[..last].iter_mut().enumerate().skip(from as usize) {
            let x = x as f64;
            *share += ((x + 1.0).min(to) - x.max(from)) / LINES as f64;
        }
    }

    fn blend(&mut self, y: usize, rgb: Rgb) {
        let row = &mut self.bytes[3 * y * self.width..3 * (y + 1) * self.width];
        for (pixel, share) in row.chunks_exact_mut(3).zip(&self.row) {
            if *share <= 0.0 {
                continue;
            }
            for (byte, wanted) in pixel.iter_mut().zip(rgb) {
                let mixed = f64::from(*byte) * (1.0 - share) + f64::from(wanted) * share;
                *byte = mixed.round().clamp(0.0, 255.0) as u8;
            }
        }
    }
}

/// Returns the least and the largest x of a convex area at a height.
fn span_at(corners: &[[f64; 2]], y: f64) -> Option<[f64; 2]> {
    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
    for (index, [ax, ay]) in corners.iter().enumerate() {
        let [bx, by] = corners[(index + 1) % corners.len()];
        if (*ay <= y) != (by <= y) {
            let x = ax + (y - ay) / (by - ay) * (bx - ax);
            span = [span[0].min(x), span[1].max(x)];
        }
    }
    (span[0] < span[1]).then_some(span)
}

fn circle([x, y]: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let corner = |index: usize| {
        let (sin, cos) = libm::sincos(TAU * index as f64 / DISC_CORNERS as f64);
        [x + radius * cos, y + radius * sin]
    };
    (0..DISC_CORNERS).map(corner).collect()
}

fn rounded_line(ends: [[f64; 2]; 2], half_px: f64) -> Vec<[f64; 2]> {
    let rims = ends.into_iter().flat_map(|end| circle(end, half_px));
    super::view::hull(&rims.collect::<Vec<_>>())
}

fn dashes([[ax, ay], [bx, by]]: [[f64; 2]; 2]) -> Vec<[[f64; 2]; 2]> {
    let length = libm::hypot(bx - ax, by - ay);
    let point = |along: f64| {
        let share = along.min(length) / length;
        [ax + share * (bx - ax), ay + share * (by - ay)]
    };
    let [dash, gap] = DASH_PX;
    let count = (length / (dash + gap)).ceil();
    let starts = (0..count.clamp(0.0, 1000.0) as usize).map(|n| n as f64 * (dash + gap));
    starts.map(|at| [point(at), point(at + dash)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(marks: Vec<Mark>) -> Vec<u8> {
        let size_px = [8.0, 6.0];
        Drawing { size_px, marks }.pixels().2
    }

    fn at(bytes: &[u8], x: usize, y: usize) -> [u8; 3] {
        let first = 3 * (8 * y + x);
        [bytes[first], bytes[first + 1], bytes[first + 2]]
    }

    #[test]
    fn area_covers_its_pixels_and_half_of_its_edge() {
        let corners = vec![[2.0, 1.0], [5.5, 1.0], [5.5, 4.0], [2.0, 4.0]];
        let bytes = drawn(vec![Mark::Area {
            corners,
            fill: [0, 0, 0],
            edge: [0, 0, 0],
        }]);
        assert_eq!(at(&bytes, 1, 2), [255; 3], "outside");
        assert_eq!(at(&bytes, 3, 2), [0; 3], "inside");
        assert_eq!(at(&bytes, 5, 2), [128; 3], "half covered");
        assert_eq!(at(&bytes, 3, 5), [255; 3], "below");
    }

    #[test]
    fn marks_outside_or_not_finite_change_nothing() {
        let nan = Mark::Disc {
            centre: [f64::NAN, 2.0],
            radius: 2.0,
            fill: [0; 3],
        };
        let far = Mark::Line {
            ends: [[-90.0, -90.0], [-50.0, 1e9]],
            width: 2.0,
            colour: [0; 3],
            is_dashed: true,
        };
        assert!(drawn(vec![nan, far]).iter().all(|byte| *byte == 255));
    }

    #[test]
    fn dashed_line_has_gaps() {
        let line = |is_dashed| Mark::Line {
            ends: [[0.0, 2.5], [8.0, 2.5]],
            width: 1.0,
            colour: [0; 3],
            is_dashed,
        };
        let dark = |bytes: Vec<u8>| (0..8).filter(|x| at(&bytes, *x, 2)[0] < 128).count();
        assert!(dark(drawn(vec![line(false)])) > dark(drawn(vec![line(true)])));
    }
}
