//! Layouts: where a fingertip's elements sit and along which axes they feel.
//!
//! Everything is in the tip frame: origin at the dome centre, z the dome axis, y = u × z with u the direction that
//! points up when the hand hangs straight down (−x of the hand), made normal to z. A frame on the bus carries the
//! layout's hash; a reader with another layout refuses it.

use crate::capacity::ELEMENTS;
use core::hash::Hasher;
use fnv::FnvHasher;

/// One fingertip's elements. The first `count` entries of each array are used.
#[derive(Clone, Debug, PartialEq)]
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
    /// Distance of each element from the dome centre, m.
    pub radius_m: f64,
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

impl Layout {
    /// The layout with this name: `dome-41` (rings 1+7+13+20 on a 35° cap), `dome-1` (one three-axis element at the
    /// pole, such as a single OMD dome) or `pad-N` (a flat pad of 1 to 64 elements that all feel along the dome axis).
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "dome-41" => Some(Self::dome_41()),
            "dome-1" => Some(Self::rings(&RINGS[..1])),
            _ => Self::pad(name.strip_prefix("pad-")?.parse().ok()?),
        }
    }

    /// A flat pad. Where its elements sit is not known here, so all stand at the pole.
    fn pad(count: usize) -> Option<Self> {
        if !(1..=ELEMENTS).contains(&count) {
            return None;
        }
        let mut pad = Self::rings(&RINGS[..1]);
        for element in 1..count {
            pad.place(element, 0.0, 0.0);
        }
        pad.count = count;
        pad.element_area_m2 = PAD_ELEMENT_AREA_M2;
        Some(pad)
    }

    /// Names that [`Layout::named`] knows, beside `pad-N`.
    pub const NAMES: [&'static str; 2] = ["dome-41", "dome-1"];

    /// The paper's dome: 41 elements of equal area in rings 1+7+13+20 within a 35° cap.
    #[must_use]
    pub fn dome_41() -> Self {
        Self::rings(&RINGS)
    }

    /// Equal-area rings: ring r of n elements lies at the polar angle that halves its share of the cap's area,
    /// φ = 2π(i + (r mod 2)/2)/n, d = z·cosθ + sinθ(y·cosφ + u·sinφ).
    fn rings(rings: &[usize]) -> Self {
        let count: usize = rings.iter().sum();
        let depth = 1.0 - libm::cos(DOME_HALF_ANGLE_RAD);
        let area_m2 = core::f64::consts::TAU * DOME_RADIUS_M * DOME_RADIUS_M * depth / count as f64;
        let mut layout = Self {
            count,
            normal: [[0.0; 3]; ELEMENTS],
            tangent1: [[0.0; 3]; ELEMENTS],
            tangent2: [[0.0; 3]; ELEMENTS],
            radius_m: DOME_RADIUS_M,
            element_area_m2: area_m2,
        };
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
                layout.place(element, theta, phi);
                element += 1;
            }
        }
        layout
    }

    fn place(&mut self, element: usize, theta: f64, phi: f64) {
        let (sin_theta, cos_theta) = libm::sincos(theta);
        let (sin_phi, cos_phi) = libm::sincos(phi);
        // With y = u × z and x = y × z, up is u = −x.
        let up = [-1.0, 0.0, 0.0];
        let d = [-sin_theta * sin_phi, sin_theta * cos_phi, cos_theta];
        let along = dot(up, d);
        let t2 = unit([
            up[0] - d[0] * along,
            up[1] - d[1] * along,
            up[2] - d[2] * along,
        ]);
        self.normal[element] = d;
        self.tangent2[element] = t2;
        self.tangent1[element] = cross(t2, d);
    }

    /// FNV-1a 64 of the element count and of every direction, as it travels in [`crate::HandFrame::layout_hash`].
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = fnv1a(FNV_OFFSET, &(self.count as u64).to_le_bytes());
        for table in [&self.normal, &self.tangent1, &self.tangent2] {
            for value in table[..self.count].iter().flatten() {
                // Micro-units: equal layouts written by other languages hash equally in spite of rounding.
                let micro = libm::round(value * 1e6) as i64;
                hash = fnv1a(hash, &micro.to_le_bytes());
            }
        }
        hash
    }
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

/// What tells recordings of one robot from those of another: FNV-1a 64 over its two texts.
#[must_use]
pub fn robot_hash(urdf: &str, robot_file: &str) -> u64 {
    let urdf = fnv1a(FNV_OFFSET, urdf.as_bytes());
    fnv1a(urdf, robot_file.as_bytes())
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
