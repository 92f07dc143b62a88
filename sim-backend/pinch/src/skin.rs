//! Skin of a fingertip on a flat face, as bristles by indentation at contact.
//!
//! A dome on a flat is axisymmetric: its 41 elements of 7 bristles reduce to ten bristles, a
//! Winkler foundation whose area grows linearly with depth (spherical cap: 2πR·h). The element
//! rings of the perception remain (1, 7, 13; the outermost touches only beyond 1.4 mm).

/// Bristles of one fingertip.
pub(crate) const BRISTLES: usize = 10;
/// Element rings that can touch.
pub(crate) const RINGS: usize = 3;
/// Elements of each ring (layout `dome-41`).
pub(crate) const ELEMENTS: [f32; RINGS] = [1.0, 7.0, 13.0];
/// Values of the full simulation (`sim-backend/src/contact.rs`): tangential damping time, s; share
/// of a light object's momentum absorbed per step; shear over normal stiffness; kinetic over static
/// friction.
pub(crate) const DAMPING_S: f32 = 0.002;
pub(crate) const DAMPING_SHARE: f32 = 0.1;
pub(crate) const SHEAR_RATIO: f32 = 0.7;
pub(crate) const KINETIC_RATIO: f32 = 0.9;
/// Damping time of the object, s (`sim-backend/src/contact/compression.rs`).
pub(crate) const OBJECT_DAMPING_S: f32 = 0.005;

/// Radius of the dome, m.
const RADIUS_M: f32 = 0.015;
/// Foundation stiffness, N/m³: 8 % below the full simulation with its inclined bristles (1.84 N at
/// 0.5 mm).
const FOUNDATION_N_M3: f32 = 1.56e8;
/// Indentation at which each ring begins, m: R·(1 − cos θ), 41 elements of equal area over 35°.
const RING_M: [f32; RINGS + 1] = [0.0, 6.61e-5, 5.29e-4, 1.388e-3];
/// Bristles of each ring.
const PER_RING: [usize; RINGS] = [1, 4, 5];

#[derive(Clone, Copy, Debug)]
pub(crate) struct Bristle {
    /// Indentation at first contact, m.
    pub(crate) from_m: f32,
    /// Normal stiffness, N/m.
    pub(crate) normal_n_m: f32,
    pub(crate) ring: usize,
}

/// Bristles, innermost first.
pub(crate) const SKIN: [Bristle; BRISTLES] = {
    let none = Bristle {
        from_m: 0.0,
        normal_n_m: 0.0,
        ring: 0,
    };
    let mut skin = [none; BRISTLES];
    let (mut ring, mut next) = (0, 0);
    while ring < RINGS {
        let width_m = (RING_M[ring + 1] - RING_M[ring]) / PER_RING[ring] as f32;
        let mut place = 0;
        while place < PER_RING[ring] {
            skin[next] = Bristle {
                from_m: RING_M[ring] + (place as f32 + 0.5) * width_m,
                normal_n_m: FOUNDATION_N_M3 * core::f32::consts::TAU * RADIUS_M * width_m,
                ring,
            };
            place += 1;
            next += 1;
        }
        ring += 1;
    }
    skin
};
