//! Soft skin of a fingertip: positions, stiffness and element of its bristles.
//!
//! Elements of the paper's dome have seven bristles, one at the centre and six around it; elements
//! of a grid have nine, three by three. One per element is too coarse: elements enter the contact
//! in jumps, and the force slope is too low (524 instead of 844 N/m in the stiffness probe).

use nalgebra::Vector3;
use robot_model::{Compression, Skin};
use shm_schemas::Layout;
use shm_schemas::layout::{DOME_RADIUS_M, Grid, Millimetres, NamedLayout};

use crate::lanes::{LANES, Rows};

/// Bristles per element of a dome (tactile design; 1 is measurably wrong, 19 gives the same results
/// as 7).
pub(crate) const BRISTLES_PER_ELEMENT: usize = 7;
/// Bristles along each edge of a grid element. Design choice: the smallest odd square above the
/// dome's 7.
const BRISTLES_PER_EDGE: usize = 3;

/// Winkler foundation stiffness, N/m per m² (prototype: gives 1.84 N at 0.5 mm on a flat).
pub(crate) const FOUNDATION_N_M3: f64 = 1.7e8;
/// Distance of outer bristles from their element's centre, in radii of a disc of the element's area
/// (prototype).
const RING_RADIUS: f64 = 0.66;

/// Returns the simulated skin of a layout.
///
/// Its force F on a rigid flat face follows from shape and foundation stiffness K: F = K·A·δ for a
/// flat pad of area A, F = (4/3)·K·L·√(2R)·δ^1.5 for a cylinder of length L and radius R.
#[must_use]
pub fn simulated_skin(layout: NamedLayout) -> Skin {
    let compression = match layout {
        NamedLayout::Dome41 | NamedLayout::Dome1 | NamedLayout::Pad { .. } => {
            Skin::DOME_41.compression
        }
        NamedLayout::Flat(grid) => {
            let [height_m, width_m] = grid.size_m();
            Compression {
                at_1n_m: 1.0 / (FOUNDATION_N_M3 * height_m * width_m),
                exponent: 1.0,
            }
        }
        NamedLayout::Cylinder(grid, radius) => {
            let [length_m, _] = grid.size_m();
            let at_1m_n =
                4.0 / 3.0 * FOUNDATION_N_M3 * length_m * libm::sqrt(2.0 * radius.metres());
            Compression {
                at_1n_m: libm::pow(at_1m_n, -2.0 / 3.0),
                exponent: 2.0 / 3.0,
            }
        }
    };
    Skin {
        layout,
        compression,
    }
}

/// Error: a skin without element positions cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot simulate fingertips of layout {0}: it has no element positions; choose flat-RxC-P, \
     cylinder-RxC-P-Q or a dome"
)]
pub struct MissingElementPositions(NamedLayout);

/// Bristles of one fingertip, tip frame.
#[derive(Clone, Debug)]
pub(crate) struct Pad {
    /// Bristle positions divided by `reach_m`, in blocks of [`LANES`]. Padding is NaN, which never
    /// lies below a plane.
    pub(crate) blocks: Vec<Rows>,
    /// Largest distance of a bristle from the tip frame's origin, m.
    pub(crate) reach_m: f64,
    pub(crate) stiffness_n_m: f64,
    /// True stiffness over that of the layout.
    stiffness_factor: f64,
    /// Element index of each bristle.
    elements: Vec<u8>,
}

impl Pad {
    /// Returns the skin of a layout with its face `tip_radius_m` from the frame's origin.
    ///
    /// # Errors
    /// [`NoPlaces`] if the layout has no element positions.
    pub(crate) fn from_layout(
        layout: NamedLayout,
        tip_radius_m: f64,
    ) -> Result<Self, MissingElementPositions> {
        match layout {
            NamedLayout::Dome41 => Ok(Self::dome(tip_radius_m, BRISTLES_PER_ELEMENT)),
            NamedLayout::Dome1 => {
                let mut pad = Self::dome(tip_radius_m, BRISTLES_PER_ELEMENT);
                pad.elements.fill(0);
                Ok(pad)
            }
            NamedLayout::Flat(grid) | NamedLayout::Cylinder(grid, _) => {
                Ok(Self::grid(layout, grid, tip_radius_m))
            }
            NamedLayout::Pad { .. } => Err(MissingElementPositions(layout)),
        }
    }

    pub(crate) fn with_stiffness_factor(mut self, factor: f64) -> Self {
        self.stiffness_n_m *= factor;
        self.stiffness_factor *= factor;
        self
    }

    pub(crate) fn stiffness_factor(&self) -> f64 {
        self.stiffness_factor
    }

    /// Returns the paper's dome with 1 to [`BRISTLES_PER_ELEMENT`] bristles per element.
    pub(crate) fn dome(radius_m: f64, per_element: usize) -> Self {
        let (layout, scale) = (Layout::dome_41(), radius_m / DOME_RADIUS_M);
        let ring_rad = RING_RADIUS * libm::sqrt(layout.element_area_m2 / core::f64::consts::PI)
            / DOME_RADIUS_M;
        let area_m2 = layout.element_area_m2 * scale * scale;
        let mut pad = Self::empty(radius_m, FOUNDATION_N_M3 * area_m2 / per_element as f64);
        for element in 0..layout.count {
            let axes = [
                &layout.normal[element],
                &layout.tangent1[element],
                &layout.tangent2[element],
            ];
            for sub in 0..per_element {
                let [offset1, offset2] = offset_in_element(sub, per_element, ring_rad);
                let leaning = [0, 1, 2]
                    .map(|axis| axes[0][axis] + axes[1][axis] * offset1 + axes[2][axis] * offset2);
                let length = libm::sqrt(leaning.iter().map(|x| x * x).sum());
                pad.add(element, leaning.map(|leaning| leaning / length));
            }
        }
        pad
    }

    /// Returns a flat or cylindrical grid.
    fn grid(layout: NamedLayout, coarse: Grid, tip_radius_m: f64) -> Self {
        let fine = Grid {
            rows: coarse.rows * BRISTLES_PER_EDGE,
            columns: coarse.columns * BRISTLES_PER_EDGE,
            pitch: Millimetres(coarse.pitch.0 / BRISTLES_PER_EDGE as f64),
        };
        let pitch_m = fine.pitch.metres();
        let ahead_m = tip_radius_m - layout.depth_m();
        let places_m: Vec<Vector3<f64>> = fine
            .element_offsets_m()
            .map(|(down_m, across_m)| {
                Vector3::from(layout.surface_point(down_m, across_m).1) + Vector3::z() * ahead_m
            })
            .collect();
        let reach_m = places_m.iter().map(Vector3::norm).fold(0.0, f64::max);
        let mut pad = Self::empty(reach_m, FOUNDATION_N_M3 * pitch_m * pitch_m);
        for (bristle, place_m) in places_m.iter().enumerate() {
            let (row, column) = (bristle / fine.columns, bristle % fine.columns);
            let element = row / BRISTLES_PER_EDGE * coarse.columns + column / BRISTLES_PER_EDGE;
            pad.add(element, (place_m / reach_m).into());
        }
        pad
    }

    fn empty(reach_m: f64, stiffness_n_m: f64) -> Self {
        Self {
            blocks: Vec::new(),
            reach_m,
            stiffness_n_m,
            stiffness_factor: 1.0,
            elements: Vec::new(),
        }
    }

    fn add(&mut self, element: usize, over_reach: [f64; 3]) {
        let lane = self.elements.len() % LANES;
        if lane == 0 {
            self.blocks.push([[f64::NAN; LANES]; 3]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (component, value) in block.iter_mut().zip(over_reach) {
                component[lane] = value;
            }
        }
        self.elements.push(element as u8);
    }

    pub(crate) fn element_of(&self, block: usize, lane: usize) -> usize {
        self.elements[block * LANES + lane].into()
    }
}

/// Returns a bristle's offset in its element, rad along both tangents: first the centre, then a
/// ring.
fn offset_in_element(sub: usize, per_element: usize, ring_rad: f64) -> [f64; 2] {
    if sub == 0 {
        return [0.0, 0.0];
    }
    let angle = core::f64::consts::TAU * sub as f64 / (per_element - 1) as f64;
    let (sin, cos) = libm::sincos(angle);
    [ring_rad * cos, ring_rad * sin]
}
