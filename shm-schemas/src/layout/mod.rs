//! Layouts: where a fingertip's elements sit and along which axes they feel.
//!
//! Everything is in the tip frame: z out of the middle of the sensing face, y = u × z with u the direction that points up
//! when the hand hangs straight down (−x of the hand), made normal to z. Its origin is the centre of a dome, and stands
//! behind the middle of any other face by [`NamedLayout::depth_m`]. A frame on the bus carries the layout's hash; a reader with
//! another layout refuses it.

use crate::capacity::ELEMENTS;
use core::hash::Hasher;
use fnv::FnvHasher;

mod named;

pub use named::{Grid, Millimetres, NamedLayout, UnknownLayout};

/// One fingertip's elements. The first `count` entries of each array are used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Layout {
    /// Number of elements, 1 to [`ELEMENTS`].
    pub count: usize,
    /// Outward normal d of each element, unit vectors, tip frame.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub normal: [[f64; 3]; ELEMENTS],
    /// First tangent t1 = t2 × d of each element, unit vectors, tip frame.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub tangent1: [[f64; 3]; ELEMENTS],
    /// Second tangent t2 (up made normal to d) of each element, unit vectors, tip frame.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub tangent2: [[f64; 3]; ELEMENTS],
    /// Where each element sits, tip frame, m.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub position_m: [[f64; 3]; ELEMENTS],
    /// Sensing area of one element, m².
    pub element_area_m2: f64,
}

/// Half-angle of the sensing cap of `dome-41`, rad (35°, tactile design: ours).
pub const DOME_HALF_ANGLE_RAD: f64 = 35.0 * core::f64::consts::PI / 180.0;
/// Radius of the built-in domes, m (ours).
pub const DOME_RADIUS_M: f64 = 0.015;
/// Sensing area of one element of `pad-N`, m²: taxels of commercial pads stand 4 to 5 mm apart.
pub const PAD_ELEMENT_AREA_M2: f64 = 2.0e-5;
/// Elements per ring of `dome-41`, from the pole outwards.
const RINGS: [usize; 4] = [1, 7, 13, 20];

/// How far from 1 the length of a direction may be: rounding in hand-written files, nothing more. Ours.
const UNIT_TOLERANCE: f64 = 1e-3;

impl Layout {
    /// Names that observers know by their hash, beside `pad-N`: see [`NamedLayout`] for all others.
    pub const NAMES: [&'static str; 4] =
        ["dome-41", "dome-1", "flat-4x4-4.5", "cylinder-4x4-4.5-12"];

    /// The layout with this name, see [`NamedLayout`].
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        name.parse().ok().map(NamedLayout::layout)
    }

    /// A layout of elements with these outward normals at these places, tip frame, m. `None` if there are none or too many,
    /// or a normal is no unit vector or points up or down, so that it leaves the tangents open, or a place is not finite.
    #[must_use]
    pub fn of_elements(
        elements: impl IntoIterator<Item = ([f64; 3], [f64; 3])>,
        element_area_m2: f64,
    ) -> Option<Self> {
        let mut layout = Self::empty(0, element_area_m2);
        for (normal, position_m) in elements {
            // False for NaN as well.
            let is_unit = (libm::sqrt(dot(normal, normal)) - 1.0).abs() <= UNIT_TOLERANCE;
            let leans = libm::hypot(normal[1], normal[2]) > UNIT_TOLERANCE;
            let is_somewhere = position_m.iter().all(|x| x.is_finite());
            if !is_unit || !leans || !is_somewhere || layout.count == ELEMENTS {
                return None;
            }
            layout.set(layout.count, normal, position_m);
            layout.count += 1;
        }
        (layout.count > 0).then_some(layout)
    }

    /// The paper's dome: 41 elements of equal area in rings 1+7+13+20 within a 35° cap.
    #[must_use]
    pub fn dome_41() -> Self {
        Self::rings(&RINGS)
    }

    /// One element at the pole of the same dome.
    fn dome_1() -> Self {
        Self::rings(&RINGS[..1])
    }

    /// A flat pad. Where its elements sit is not known here, so all stand at the pole.
    fn pad(count: usize) -> Self {
        let mut pad = Self::empty(count, PAD_ELEMENT_AREA_M2);
        for element in 0..count {
            pad.set(element, [0.0, 0.0, 1.0], [0.0, 0.0, DOME_RADIUS_M]);
        }
        pad
    }

    fn empty(count: usize, element_area_m2: f64) -> Self {
        let none = [[0.0; 3]; ELEMENTS];
        Self {
            count,
            normal: none,
            tangent1: none,
            tangent2: none,
            position_m: none,
            element_area_m2,
        }
    }

    /// Equal-area rings: ring r of n elements lies at the polar angle that halves its share of the cap's area,
    /// φ = 2π(i + (r mod 2)/2)/n, d = z·cosθ + sinθ(y·cosφ + u·sinφ).
    fn rings(rings: &[usize]) -> Self {
        let count: usize = rings.iter().sum();
        let depth = 1.0 - libm::cos(DOME_HALF_ANGLE_RAD);
        let area_m2 = core::f64::consts::TAU * DOME_RADIUS_M * DOME_RADIUS_M * depth / count as f64;
        let mut layout = Self::empty(count, area_m2);
        let mut element = 0;
        for (ring, &n) in rings.iter().enumerate() {
            let middle = (element as f64 + 0.5 * n as f64) / count as f64;
            let theta = if ring == 0 {
                0.0
            } else {
                libm::acos(1.0 - middle * depth)
            };
            for i in 0..n {
                let phi = core::f64::consts::TAU * (i as f64 + 0.5 * (ring % 2) as f64) / n as f64;
                let d = on_sphere(theta, phi);
                layout.set(element, d, d.map(|d| d * DOME_RADIUS_M));
                element += 1;
            }
        }
        layout
    }

    /// Element at a place, with the tangents that belong to its normal.
    fn set(&mut self, element: usize, d: [f64; 3], position_m: [f64; 3]) {
        // With y = u × z and x = y × z, up is u = −x.
        let up = [-1.0, 0.0, 0.0];
        let along = dot(up, d);
        let t2 = unit([
            up[0] - d[0] * along,
            up[1] - d[1] * along,
            up[2] - d[2] * along,
        ]);
        self.normal[element] = d;
        self.tangent2[element] = t2;
        self.tangent1[element] = cross(t2, d);
        self.position_m[element] = position_m;
    }

    /// Whether every element sits on one sphere about the tip frame's origin and feels straight out of it: its place then
    /// follows from its direction.
    fn is_dome(&self) -> bool {
        let radius_m = libm::sqrt(dot(self.position_m[0], self.position_m[0]));
        let elements = self.normal.iter().zip(&self.position_m);
        elements.take(self.count).all(|(d, position_m)| {
            (0..3).all(|axis| micro(position_m[axis] - d[axis] * radius_m) == 0)
        })
    }

    /// FNV-1a 64 of the element count and of every direction, as it travels in [`crate::HandFrame::layout_hash`]; of every
    /// place as well unless it is a dome.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let tables = [
            &self.normal,
            &self.tangent1,
            &self.tangent2,
            &self.position_m,
        ];
        let told = if self.is_dome() { 3 } else { 4 };
        let mut hash = fnv1a(FNV_OFFSET, &(self.count as u64).to_le_bytes());
        for table in &tables[..told] {
            for value in table[..self.count].iter().flatten() {
                hash = fnv1a(hash, &micro(*value).to_le_bytes());
            }
        }
        hash
    }
}

/// In micro-units: equal layouts written by other languages hash equally in spite of rounding.
fn micro(value: f64) -> i64 {
    libm::round(value * 1e6) as i64
}

/// The direction at a polar angle from z and an azimuth from y towards up.
fn on_sphere(theta: f64, phi: f64) -> [f64; 3] {
    let (sin_theta, cos_theta) = libm::sincos(theta);
    let (sin_phi, cos_phi) = libm::sincos(phi);
    [-sin_theta * sin_phi, sin_theta * cos_phi, cos_theta]
}

/// Start value of FNV-1a 64.
pub const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// Continues an FNV-1a 64 hash over more bytes.
#[must_use]
pub fn fnv1a(hash: u64, bytes: &[u8]) -> u64 {
    let mut hasher = FnvHasher::with_key(hash);
    hasher.write(bytes);
    hasher.finish()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let norm = libm::sqrt(dot(v, v));
    [v[0] / norm, v[1] / norm, v[2] / norm]
}
