//! What a hand's fingertips feel with: where their elements sit, and how far the skin gives way.

use shm_schemas::layout::{DOME_HALF_ANGLE_RAD, NamedLayout};

/// Force with which a fingertip presses at most, N: the ceiling of F_2 (tactile design).
const PRESSED_N: f64 = 8.0;

/// The skin of a hand's fingertips, which all have the same.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Skin {
    /// Where its elements sit.
    pub layout: NamedLayout,
    /// How far it gives way to a rigid flat face.
    pub compression: Compression,
}

/// Compression of a fingertip over the force that presses it: a·F^p.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Compression {
    /// a: compression at 1 N, m.
    pub at_1n_m: f64,
    /// p: 1 for a linear spring, such as a flat pad on a flat face; 0.5 for a dome.
    pub exponent: f64,
}

impl Skin {
    /// The paper's domes, with the compression of the simulated skin (measured on a rigid block).
    pub const DOME_41: Skin = Skin {
        layout: NamedLayout::Dome41,
        compression: Compression {
            at_1n_m: 0.000_44,
            exponent: 0.48,
        },
    };

    /// How far beside its pole a dome of this radius, m, may touch a face, radians: its elements must still feel the whole patch
    /// when it is pressed the hardest. The face of a ball is the same wherever it is touched, so friction sets no narrower bound.
    /// `None` for every other face: an edge or one element alone does not tell how it is turned.
    #[must_use]
    pub fn tilt_max_rad(&self, radius_m: f64) -> Option<f64> {
        let depth_m = self.compression.at_1n_m * libm::pow(PRESSED_N, self.compression.exponent);
        let patch_rad = libm::acos((1.0 - depth_m / radius_m).clamp(-1.0, 1.0));
        let bears_rad = (DOME_HALF_ANGLE_RAD - patch_rad).max(0.0);
        (self.layout == NamedLayout::Dome41).then_some(bears_rad)
    }
}
