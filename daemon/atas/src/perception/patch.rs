//! The contact patch: the sum of all elements, split along the patch's own normal.

use crate::limits::{NORMAL_FLOOR_N, PATCH_FLOOR_N};
use nalgebra::Vector3;
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// How far an element's normal force must stand out of the noise to take part in the friction estimate (ours).
const NOISE_CLEARANCE: f64 = 6.0;

/// The axes of every element in tip coordinates.
#[derive(Clone, Debug)]
pub(super) struct ElementAxes {
    pub(super) count: usize,
    normal: [Vector3<f64>; ELEMENTS],
    tangent1: [Vector3<f64>; ELEMENTS],
    tangent2: [Vector3<f64>; ELEMENTS],
}

impl ElementAxes {
    pub(super) fn new(layout: &Layout) -> Self {
        Self {
            count: layout.count,
            normal: layout.normal.map(Vector3::from),
            tangent1: layout.tangent1.map(Vector3::from),
            tangent2: layout.tangent2.map(Vector3::from),
        }
    }

    /// Force of the object on one element, tip frame: F = −d·f_n + t1·f_t1 + t2·f_t2.
    fn force(&self, element: usize, [n, t1, t2]: [f64; 3]) -> Vector3<f64> {
        self.tangent1[element] * t1 + self.tangent2[element] * t2 - self.normal[element] * n
    }
}

/// One patch.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Sum over all elements, tip frame, N. Weak elements are not clipped: their noise averages out.
    pub(super) force_n: Vector3<f64>,
    /// Outward normal, unit vector, tip frame; the dome axis while the contact is too weak to tell.
    pub(super) normal: Vector3<f64>,
    /// Force along the inward normal, N.
    pub(super) normal_n: f64,
    /// Force in the patch plane, tip frame, N.
    pub(super) tangential_n: Vector3<f64>,
    /// Pressed elements in the patch frame: tangential over normal force, and the normal force that weighs it.
    pub(super) ratios: [(f64, f64); ELEMENTS],
    /// How many of them.
    pub(super) pressed: usize,
    /// Standard deviation of one tangential axis of an element, N.
    pub(super) noise_n: f64,
}

impl Patch {
    pub(super) fn of(
        axes: &ElementAxes,
        elements_n: &[[f64; 3]; ELEMENTS],
        noise_n2: f64,
        floor_n: f64,
    ) -> Self {
        let mut force_n = Vector3::zeros();
        let mut lean = Vector3::zeros();
        for (element, &reading) in elements_n.iter().enumerate().take(axes.count) {
            force_n += axes.force(element, reading);
            if reading[0] > NORMAL_FLOOR_N {
                lean += axes.normal[element] * reading[0];
            }
        }
        let strength_n = lean.norm();
        let normal = if strength_n > PATCH_FLOOR_N {
            lean / strength_n
        } else {
            resting_normal(axes)
        };
        let normal_n = -force_n.dot(&normal);
        let mut patch = Self {
            force_n,
            normal,
            normal_n,
            tangential_n: force_n + normal * normal_n,
            ratios: [(0.0, 0.0); ELEMENTS],
            pressed: 0,
            noise_n: libm::sqrt(noise_n2),
        };
        patch.collect_ratios(axes, elements_n, floor_n);
        patch
    }

    fn collect_ratios(
        &mut self,
        axes: &ElementAxes,
        elements_n: &[[f64; 3]; ELEMENTS],
        floor_n: f64,
    ) {
        let clear_n = NOISE_CLEARANCE * self.noise_n;
        let noise_n2 = self.noise_n * self.noise_n;
        let floor_n = if clear_n > floor_n { clear_n } else { floor_n };
        for (element, &reading) in elements_n.iter().enumerate().take(axes.count) {
            if reading[0] <= NORMAL_FLOOR_N {
                continue;
            }
            let force_n = axes.force(element, reading);
            let normal_n = -force_n.dot(&self.normal);
            if normal_n > floor_n {
                let squared_n2 = (force_n + self.normal * normal_n).norm_squared() - 2.0 * noise_n2;
                let tangential_n = if squared_n2 > 0.0 {
                    libm::sqrt(squared_n2)
                } else {
                    0.0
                };
                self.ratios[self.pressed] = (tangential_n / normal_n, normal_n);
                self.pressed += 1;
            }
        }
    }
}

/// The normal of a patch that is too weak to tell: the pole for a dome, the element's own axis for a single element.
fn resting_normal(axes: &ElementAxes) -> Vector3<f64> {
    if axes.count == 1 {
        axes.normal[0]
    } else {
        Vector3::z()
    }
}
