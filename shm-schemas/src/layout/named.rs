//! Named sensor layouts: shape of a fingertip's sensing face and distribution of its elements.

use core::fmt;
use core::str::FromStr;

use super::{DOME_RADIUS_M, Layout};
use crate::capacity::ELEMENTS;

/// Layout named in a configuration, a robot file or a command line. [`fmt::Display`] writes the
/// format that [`FromStr`] reads.
///
/// ```
/// use shm_schemas::layout::NamedLayout;
///
/// let pad: NamedLayout = "flat-4x4-4.5".parse()?;
/// assert!(!pad.is_dome());
/// assert_eq!(pad.to_string(), "flat-4x4-4.5");
/// # Ok::<(), shm_schemas::layout::UnknownLayout>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NamedLayout {
    /// `dome-41`: the paper's dome, rings of 1+7+13+20 elements on a 35° cap.
    Dome41,
    /// `dome-1`: one three-axis element at the pole of the same dome, such as a single OMD sensor.
    Dome1,
    /// `pad-N`: N elements along the tip axis, at unknown positions.
    Pad {
        /// Elements, 1 to [`ELEMENTS`].
        count: usize,
    },
    /// `flat-RxC-P`: flat pad; rows from top to bottom of a hand that points straight down, columns
    /// across.
    Flat(Grid),
    /// `cylinder-RxC-P-Q`: the same grid, bent about an axis parallel to the columns through the
    /// tip origin.
    Cylinder(Grid, Millimetres),
}

/// Elements in rows and columns.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Grid {
    /// Rows, along −x of the tip (up).
    pub rows: usize,
    /// Columns, along y of the tip.
    pub columns: usize,
    /// Distance between neighbouring elements in a row or column.
    pub pitch: Millimetres,
}

/// Length in millimetres, as written in a layout name.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Millimetres(pub f64);

/// Error for an unknown layout name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownLayout;

/// Allowed distance between elements, mm. Design choice: from finer than any skin to one element
/// per fingertip.
const PITCH_MM: [f64; 2] = [0.5, 30.0];
/// Allowed cylinder radius, mm.
const RADIUS_MM: [f64; 2] = [2.0, 100.0];
/// Largest angle of an element around its cylinder, rad. Design choice, 80°: the outermost elements
/// must still measure the contact.
const WRAP_ANGLE_MAX_RAD: f64 = 80.0 * core::f64::consts::PI / 180.0;

impl NamedLayout {
    /// Formats of layout names, for messages.
    pub const FORMS: &'static str = "dome-41, dome-1, pad-N with N taxels, flat-RxC-P with R rows and C columns P mm apart, or \
                                     cylinder-RxC-P-Q bent to a radius of Q mm";

    /// Returns positions and axes of the elements.
    #[must_use]
    pub fn layout(self) -> Layout {
        match self {
            Self::Dome41 => Layout::dome_41(),
            Self::Dome1 => Layout::dome_1(),
            Self::Pad { count } => Layout::pad(count),
            Self::Flat(grid) | Self::Cylinder(grid, _) => {
                grid.layout(|down_m, across_m| self.surface_point(down_m, across_m))
            }
        }
    }

    /// Returns outward normal and position, tip frame, m, of a point on a flat or bent face. The
    /// point is given by its distances down and across from the face centre, m, along the face. Not
    /// meaningful for a dome.
    #[must_use]
    pub fn surface_point(self, down_m: f64, across_m: f64) -> ([f64; 3], [f64; 3]) {
        let depth_m = self.depth_m();
        let Self::Cylinder(_, radius) = self else {
            return ([0.0, 0.0, 1.0], [down_m, across_m, depth_m]);
        };
        let radius_m = radius.metres();
        let (sin, cos) = libm::sincos(across_m / radius_m);
        let out_m = depth_m - radius_m * (1.0 - cos);
        ([0.0, sin, cos], [down_m, radius_m * sin, out_m])
    }

    /// Returns true if the face is part of a sphere.
    #[must_use]
    pub fn is_dome(self) -> bool {
        matches!(self, Self::Dome41 | Self::Dome1)
    }

    /// Distance of the face centre from the tip origin, m. It is at least half the face height, so
    /// that a hand at this height above a table does not touch it with the face.
    #[must_use]
    pub fn depth_m(self) -> f64 {
        match self {
            Self::Dome41 | Self::Dome1 | Self::Pad { .. } => DOME_RADIUS_M,
            Self::Flat(grid) => grid.half_height_m().max(DOME_RADIUS_M),
            Self::Cylinder(grid, radius) => grid.half_height_m().max(radius.metres()),
        }
    }
}

impl Millimetres {
    /// Returns the length in metres.
    #[must_use]
    pub fn metres(self) -> f64 {
        self.0 * 1e-3
    }

    fn parse(text: &str, [least, most]: [f64; 2]) -> Result<Self, UnknownLayout> {
        let value: f64 = text.parse().map_err(|_| UnknownLayout)?;
        // Also false for NaN.
        let possible = value >= least && value <= most;
        possible.then_some(Self(value)).ok_or(UnknownLayout)
    }
}

impl Grid {
    /// Returns height and width along the face, m.
    #[must_use]
    pub fn size_m(self) -> [f64; 2] {
        [self.rows, self.columns].map(|elements| elements as f64 * self.pitch.metres())
    }

    fn half_height_m(self) -> f64 {
        0.5 * self.size_m()[0]
    }

    /// Creates the layout, row by row.
    fn layout(self, place: impl Fn(f64, f64) -> ([f64; 3], [f64; 3])) -> Layout {
        let pitch_m = self.pitch.metres();
        let mut layout = Layout::empty(self.rows * self.columns, pitch_m * pitch_m);
        for (element, (down_m, across_m)) in self.element_offsets_m().enumerate() {
            let (normal, position_m) = place(down_m, across_m);
            layout.set(element, normal, position_m);
        }
        layout
    }

    /// Returns the distances of each element down and across from the face centre, row by row, m.
    pub fn element_offsets_m(self) -> impl Iterator<Item = (f64, f64)> {
        let pitch_m = self.pitch.metres();
        let from_middle_m =
            move |index: usize, of: usize| (index as f64 - 0.5 * (of as f64 - 1.0)) * pitch_m;
        (0..self.rows * self.columns).map(move |element| {
            let (row, column) = (element / self.columns, element % self.columns);
            (
                from_middle_m(row, self.rows),
                from_middle_m(column, self.columns),
            )
        })
    }

    fn parse(size: &str, pitch: &str) -> Result<Self, UnknownLayout> {
        let (rows, columns) = size.split_once('x').ok_or(UnknownLayout)?;
        let grid = Self {
            rows: count(rows)?,
            columns: count(columns)?,
            pitch: Millimetres::parse(pitch, PITCH_MM)?,
        };
        let fits = grid.rows * grid.columns <= ELEMENTS;
        fits.then_some(grid).ok_or(UnknownLayout)
    }
}

fn count(text: &str) -> Result<usize, UnknownLayout> {
    let count = text.parse().map_err(|_| UnknownLayout)?;
    let possible = (1..=ELEMENTS).contains(&count);
    possible.then_some(count).ok_or(UnknownLayout)
}

impl FromStr for NamedLayout {
    type Err = UnknownLayout;

    fn from_str(name: &str) -> Result<Self, UnknownLayout> {
        let mut words = name.split('-');
        let words: [Option<&str>; 5] = core::array::from_fn(|_| words.next());
        match words {
            [Some("dome"), Some("41"), None, ..] => Ok(Self::Dome41),
            [Some("dome"), Some("1"), None, ..] => Ok(Self::Dome1),
            [Some("pad"), Some(taxels), None, ..] => Ok(Self::Pad {
                count: count(taxels)?,
            }),
            [Some("flat"), Some(size), Some(pitch), None, _] => {
                Ok(Self::Flat(Grid::parse(size, pitch)?))
            }
            [
                Some("cylinder"),
                Some(size),
                Some(pitch),
                Some(radius),
                None,
            ] => {
                let (grid, radius) = (
                    Grid::parse(size, pitch)?,
                    Millimetres::parse(radius, RADIUS_MM)?,
                );
                let outermost_mm = 0.5 * (grid.columns as f64 - 1.0) * grid.pitch.0;
                let bends = outermost_mm <= WRAP_ANGLE_MAX_RAD * radius.0;
                bends
                    .then_some(Self::Cylinder(grid, radius))
                    .ok_or(UnknownLayout)
            }
            _ => Err(UnknownLayout),
        }
    }
}

impl fmt::Display for NamedLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dome41 => f.write_str("dome-41"),
            Self::Dome1 => f.write_str("dome-1"),
            Self::Pad { count } => write!(f, "pad-{count}"),
            Self::Flat(grid) => write!(f, "flat-{grid}"),
            Self::Cylinder(grid, radius) => write!(f, "cylinder-{grid}-{}", radius.0),
        }
    }
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}-{}", self.rows, self.columns, self.pitch.0)
    }
}

impl fmt::Display for UnknownLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown layout; choose {}", NamedLayout::FORMS)
    }
}

impl core::error::Error for UnknownLayout {}
