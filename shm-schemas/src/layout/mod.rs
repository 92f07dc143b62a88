//! Sensor layouts: positions and sensing axes of the elements of a fingertip.
//!
//! All values are in the tip frame: z points out of the centre of the sensing face, y = u × z. Here
//! u is up for a hand that points straight down (−x of the hand), made normal to z. The origin is
//! the centre of a dome; for any other face it is [`NamedLayout::depth_m`] behind the face centre.
//! A frame on the bus carries the hash of its layout; readers reject a frame with another hash.

use crate::capacity::ELEMENTS;
use core::hash::Hasher;
use fnv::FnvHasher;

mod named;

pub use named::{Grid, Millimetres, NamedLayout, UnknownLayout};

/// Elements of one fingertip. The first `count` entries of each array are used.
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
    /// Position of each element, tip frame, m.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub position_m: [[f64; 3]; ELEMENTS],
    /// Sensing area of one element, m².
    pub element_area_m2: f64,
}

/// Half-angle of the sensing cap of `dome-41`, rad (35°; design choice, tactile design).
pub const DOME_HALF_ANGLE_RAD: f64 = 35.0 * core::f64::consts::PI / 180.0;
/// Radius of the built-in domes, m (design choice).
pub const DOME_RADIUS_M: f64 = 0.015;
/// Sensing area of one element of `pad-N`, m². Elements of commercial pads are 4 to 5 mm apart.
pub const PAD_ELEMENT_AREA_M2: f64 = 2.0e-5;
/// Elements per ring of `dome-41`, from the pole outwards.
const RINGS: [usize; 4] = [1, 7, 13, 20];

/// Tolerance on the length of a unit vector. Design choice: rounding in hand-written files only.
const UNIT_TOLERANCE: f64 = 1e-3;

impl Layout {
    /// Layout names that observers recognise by hash, in addition to `pad-N`; see [`NamedLayout`]
    /// for all others.
    pub const NAMES: [&'static str; 4] =
        ["dome-41", "dome-1", "flat-4x4-4.5", "cylinder-4x4-4.5-12"];

    /// Returns the layout with this name; see [`NamedLayout`].
    ///
    /// ```
    /// # use shm_schemas::Layout;
    /// let dome = Layout::from_name("dome-41").expect("a named layout");
    /// assert_eq!(dome.hash(), Layout::dome_41().hash());
    /// assert!(Layout::from_name("cube").is_none());
    /// ```
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        name.parse().ok().map(NamedLayout::layout)
    }

    /// Creates a layout from outward normals and positions, tip frame, m.
    ///
    /// Returns `None` if the number of elements is 0 or above [`ELEMENTS`], a position is not
    /// finite, or a normal is no unit vector. A normal that points up or down is also rejected,
    /// because it does not define the tangents.
    #[must_use]
    pub fn from_elements(
        elements: impl IntoIterator<Item = ([f64; 3], [f64; 3])>,
        element_area_m2: f64,
    ) -> Option<Self> {
        let mut layout = Self::empty(0, element_area_m2);
        for (normal, position_m) in elements {
            // Also false for NaN.
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

    /// Creates the dome of the paper: 41 elements of equal area in rings 1+7+13+20 within a 35°
    /// cap.
    #[must_use]
    pub fn dome_41() -> Self {
        Self::rings(&RINGS)
    }

    /// Creates a layout of one element at the pole of the same dome.
    fn dome_1() -> Self {
        Self::rings(&RINGS[..1])
    }

    /// Creates a flat pad. Element positions are unknown, so all are at the pole.
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

    /// Creates equal-area rings. A ring of n elements has the polar angle that halves its share of
    /// the cap area, φ = 2π(i + (r mod 2)/2)/n for ring r, d = z·cosθ + sinθ(y·cosφ + u·sinφ).
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

    /// Sets normal, tangents and position of an element.
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

    /// Returns true if all elements are on one sphere about the tip origin with radial normals. The
    /// positions then follow from the normals.
    fn is_dome(&self) -> bool {
        let radius_m = libm::sqrt(dot(self.position_m[0], self.position_m[0]));
        let elements = self.normal.iter().zip(&self.position_m);
        elements.take(self.count).all(|(d, position_m)| {
            (0..3).all(|axis| micro(position_m[axis] - d[axis] * radius_m) == 0)
        })
    }

    /// Returns the FNV-1a 64 hash of element count, normals and tangents, used in
    /// [`crate::HandFrame::layout_hash`]. Positions are included unless the layout is a dome.
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

/// Rounds to micro-units, so that equal layouts of other languages have equal hashes despite
/// rounding.
fn micro(value: f64) -> i64 {
    libm::round(value * 1e6) as i64
}

/// Returns the direction at a polar angle from z and an azimuth from y towards up.
fn on_sphere(theta: f64, phi: f64) -> [f64; 3] {
    let (sin_theta, cos_theta) = libm::sincos(theta);
    let (sin_phi, cos_phi) = libm::sincos(phi);
    [-sin_theta * sin_phi, sin_theta * cos_phi, cos_theta]
}

/// Start value of FNV-1a 64.
pub const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// Continues an FNV-1a 64 hash over more bytes.
///
/// ```
/// use shm_schemas::layout::{FNV_OFFSET, fnv1a};
///
/// // Hashing in two parts equals hashing the whole.
/// let parts = fnv1a(fnv1a(FNV_OFFSET, b"robot."), b"urdf");
/// assert_eq!(parts, fnv1a(FNV_OFFSET, b"robot.urdf"));
/// ```
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
