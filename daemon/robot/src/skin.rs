//! Tactile skin of fingertips: element layout and compression.

use shm_schemas::layout::{DOME_HALF_ANGLE_RAD, NamedLayout};

/// Largest force of one fingertip, N: the upper limit of F_2 (tactile design).
const FORCE_MAX_N: f64 = 8.0;

/// Skin of a hand's fingertips, equal on all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Skin {
    /// Element layout.
    pub layout: NamedLayout,
    /// Compression under a rigid flat face.
    pub compression: Compression,
}

/// Compression of a fingertip over its force: a·F^p.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Compression {
    /// a: compression at 1 N, m.
    pub at_1n_m: f64,
    /// p: 1 for a linear spring, such as a flat pad on a flat face; 0.5 for a dome.
    pub exponent: f64,
}

impl Compression {
    /// Returns the compression d(F) = a·F^p under a force, N, zero or more; m.
    #[must_use]
    pub fn depth_m(&self, force_n: f64) -> f64 {
        self.at_1n_m * libm::pow(force_n, self.exponent)
    }

    /// Returns the compliance d'(F) = a·p·F^(p−1) under a force, N, above zero; m/N.
    #[must_use]
    pub fn compliance_m_n(&self, force_n: f64) -> f64 {
        self.at_1n_m * self.exponent * libm::pow(force_n, self.exponent - 1.0)
    }
}

impl Skin {
    /// Domes of the paper, with the compression of the simulated skin (measured on a rigid block).
    pub const DOME_41: Skin = Skin {
        layout: NamedLayout::Dome41,
        compression: Compression {
            at_1n_m: 0.000_44,
            exponent: 0.48,
        },
    };

    /// Returns the largest angle between the pole of a dome of this radius, m, and a touched face,
    /// radians. At full force the elements must still cover the whole contact patch. A sphere looks
    /// alike everywhere, so friction sets no narrower limit. `None` for other faces: an edge or a
    /// single element does not measure orientation.
    #[must_use]
    pub fn tilt_max_rad(&self, radius_m: f64) -> Option<f64> {
        let depth_m = self.compression.depth_m(FORCE_MAX_N);
        let patch_rad = libm::acos((1.0 - depth_m / radius_m).clamp(-1.0, 1.0));
        let bears_rad = (DOME_HALF_ANGLE_RAD - patch_rad).max(0.0);
        (self.layout == NamedLayout::Dome41).then_some(bears_rad)
    }
}
