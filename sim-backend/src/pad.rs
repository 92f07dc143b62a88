//! The fingertip's soft skin: where its bristles are and how stiff they are.
//!
//! Every element of the layout carries seven bristles, one at its centre and six around it. A single bristle per
//! element is wrong: new elements then enter the contact in jumps, and the force rises too slowly with the indentation
//! (slope 524 instead of 844 N/m in the stiffness probe).

use nalgebra::Vector3;
use shm_schemas::Layout;

/// Bristles per element (tactile design; 1 is measurably wrong, 19 changes nothing more).
pub(crate) const BRISTLES_PER_ELEMENT: usize = 7;
/// Bristles of a full dome.
pub(crate) const BRISTLES: usize = DOME_ELEMENTS * BRISTLES_PER_ELEMENT;
/// Elements of the simulated dome, layout `dome-41`.
pub(crate) const DOME_ELEMENTS: usize = 41;
/// Bristles that are tested for contact together: a whole number of vectors on every machine.
pub(crate) const BLOCK: usize = 8;
/// Blocks of a full dome.
const BLOCKS: usize = BRISTLES.div_ceil(BLOCK);

/// Winkler foundation stiffness of the skin, N/m per m² (prototype: gives 1.84 N at 0.5 mm on a flat).
pub(crate) const FOUNDATION_N_M3: f64 = 1.7e8;
/// Distance of the six outer bristles from their element's centre, in radii of a disc of the element's area (prototype).
const RING_RADIUS: f64 = 0.66;

/// The bristles of one dome, tip frame; the same for every fingertip.
#[derive(Clone, Debug)]
pub(crate) struct Pad {
    /// Outward unit vectors of the bristles: block, component, place in the block. Padding is zero.
    blocks: [[[f64; BLOCK]; 3]; BLOCKS],
    /// Distance of the bristles from the dome's centre, m.
    pub(crate) radius_m: f64,
    /// Normal stiffness of one bristle, N/m.
    pub(crate) stiffness_n_m: f64,
    /// Bristles in use.
    count: usize,
    /// The element that each bristle belongs to.
    elements: [u8; BRISTLES],
}

impl Pad {
    /// The skin of a dome of layout `dome-41`.
    #[must_use]
    pub(crate) fn dome_41() -> Self {
        Self::with_bristles(&Layout::dome_41(), BRISTLES_PER_ELEMENT)
    }

    /// The same skin, stiffer by this factor.
    pub(crate) fn stiffer(mut self, factor: f64) -> Self {
        self.stiffness_n_m *= factor;
        self
    }

    /// The skin of a layout with this many bristles per element, 1 to [`BRISTLES_PER_ELEMENT`].
    pub(crate) fn with_bristles(layout: &Layout, per_element: usize) -> Self {
        let ring_rad = RING_RADIUS * libm::sqrt(layout.element_area_m2 / core::f64::consts::PI)
            / layout.radius_m;
        let mut pad = Self {
            blocks: [[[0.0; BLOCK]; 3]; BLOCKS],
            radius_m: layout.radius_m,
            stiffness_n_m: FOUNDATION_N_M3 * layout.element_area_m2 / per_element as f64,
            count: layout.count * per_element,
            elements: core::array::from_fn(|bristle| (bristle / per_element) as u8),
        };
        for element in 0..layout.count {
            for sub in 0..per_element {
                let (offset1, offset2) = offset_in_element(sub, per_element, ring_rad);
                let bristle = element * per_element + sub;
                pad.place(layout, element, bristle, offset1, offset2);
            }
        }
        pad
    }

    fn place(
        &mut self,
        layout: &Layout,
        element: usize,
        bristle: usize,
        offset1: f64,
        offset2: f64,
    ) {
        let (d, t1, t2) = (
            layout.normal[element],
            layout.tangent1[element],
            layout.tangent2[element],
        );
        let leaning = [0, 1, 2].map(|axis| d[axis] + t1[axis] * offset1 + t2[axis] * offset2);
        let length = libm::sqrt(leaning.iter().map(|x| x * x).sum());
        for (component, leaning) in self.blocks[bristle / BLOCK].iter_mut().zip(leaning) {
            component[bristle % BLOCK] = leaning / length;
        }
    }

    /// Shows every bristle that lies below a plane: its index and its direction, tip frame. The plane has this outward
    /// normal, tip frame, and this distance from the dome's centre.
    #[inline]
    pub(crate) fn below_plane(
        &self,
        normal: &Vector3<f64>,
        gap_m: f64,
        mut show: impl FnMut(usize, Vector3<f64>),
    ) {
        let reach_m = -normal * self.radius_m;
        for (index, [x, y, z]) in self.blocks.iter().enumerate() {
            let depth_m: [f64; BLOCK] = core::array::from_fn(|i| {
                x[i] * reach_m.x + y[i] * reach_m.y + z[i] * reach_m.z - gap_m
            });
            let mut below = (0..BLOCK).fold(0_u32, |set, i| set | u32::from(depth_m[i] > 0.0) << i);
            while below != 0 {
                let i = below.trailing_zeros() as usize;
                below &= below - 1;
                if index * BLOCK + i < self.count {
                    show(index * BLOCK + i, Vector3::new(x[i], y[i], z[i]));
                }
            }
        }
    }

    /// The element that a bristle belongs to.
    pub(crate) fn element_of(&self, bristle: usize) -> usize {
        self.elements[bristle].into()
    }
}

/// Where a bristle stands in its element, rad along both tangents: the first at the centre, the others on a ring.
fn offset_in_element(sub: usize, per_element: usize, ring_rad: f64) -> (f64, f64) {
    if sub == 0 {
        return (0.0, 0.0);
    }
    let angle = core::f64::consts::TAU * sub as f64 / (per_element - 1) as f64;
    let (sin, cos) = libm::sincos(angle);
    (ring_rad * cos, ring_rad * sin)
}
