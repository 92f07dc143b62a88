//! What a hand's fingertips feel with: where their elements sit, and how far the skin gives way.

use shm_schemas::layout::NamedLayout;

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
}
