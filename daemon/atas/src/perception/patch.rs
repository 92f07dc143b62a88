//! Contact patch of one fingertip: total force, normal, and shear statistics of its elements.

use crate::limits::{NORMAL_FLOOR_N, PATCH_FLOOR_N};
use arrayvec::ArrayVec;
use nalgebra::{Matrix3, Vector3};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// Multiple of the sensor noise that an element needs for the friction estimate (design choice).
const NOISE_CLEARANCE: f64 = 6.0;
/// Determinant of the mean n·nᵀ of element normals above which a face is curved in both directions
/// (`dome-41`: 0.006).
const ROUND_DETERMINANT: f64 = 1e-6;
/// Smallest cosine between element normals of a flat face.
const FLAT_COS: f64 = 0.999;
/// Evenness (Σf)²/(n·Σf²) of n forces that rise linearly from zero, as under an inclined face.
const WEDGE_EVENNESS: f64 = 0.75;

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ElementAxes {
    pub(super) count: usize,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    normal: [Vector3<f64>; ELEMENTS],
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    tangent1: [Vector3<f64>; ELEMENTS],
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    tangent2: [Vector3<f64>; ELEMENTS],
    /// Curved in both directions: the pressure decreases towards the rim, which slips first.
    pub(super) is_round: bool,
    /// All elements lie in one plane: an edge may press alone.
    is_flat: bool,
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    position_m: [Vector3<f64>; ELEMENTS],
}

impl ElementAxes {
    pub(super) fn new(layout: &Layout) -> Self {
        let normals = &layout.normal[..layout.count];
        Self {
            count: layout.count,
            is_round: is_round(normals),
            is_flat: is_flat(normals),
            normal: layout.normal.map(Vector3::from),
            tangent1: layout.tangent1.map(Vector3::from),
            tangent2: layout.tangent2.map(Vector3::from),
            position_m: layout.position_m.map(Vector3::from),
        }
    }

    /// Returns the loaded share of a flat face, from one element to 1 (derived from the evenness of
    /// the forces). A linear pressure wedge counts as 1.
    pub(super) fn loaded_share(&self, elements_n: &[[f64; 3]; ELEMENTS], noise_n2: f64) -> f64 {
        if !self.is_flat {
            return 1.0;
        }
        let count = self.count as f64;
        let (mut sum_n, mut square_n2) = (0.0, -count * noise_n2);
        for [normal_n, ..] in &elements_n[..self.count] {
            sum_n += normal_n;
            square_n2 += normal_n * normal_n;
        }
        if sum_n <= 0.0 || square_n2 <= 0.0 {
            return 1.0;
        }
        let share = sum_n * sum_n / (count * square_n2) / WEDGE_EVENNESS;
        share.clamp(1.0 / count, 1.0)
    }

    /// Force of the object on one element, tip frame: F = −d·f_n + t1·f_t1 + t2·f_t2.
    fn force(&self, element: usize, [n, t1, t2]: [f64; 3]) -> Vector3<f64> {
        self.tangent1[element] * t1 + self.tangent2[element] * t2 - self.normal[element] * n
    }
}

fn is_round(normals: &[[f64; 3]]) -> bool {
    let spread = normals.iter().fold(Matrix3::zeros(), |sum, normal| {
        let normal = Vector3::from(*normal);
        sum + normal * normal.transpose()
    });
    (spread / normals.len() as f64).determinant() > ROUND_DETERMINANT
}

fn is_flat(normals: &[[f64; 3]]) -> bool {
    normals.len() > 1
        && normals.iter().all(|normal| {
            let cos = Vector3::from(*normal).dot(&Vector3::from(normals[0]));
            cos > FLAT_COS
        })
}

/// Clearly loaded element, in the plane of the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoadedElement {
    /// Force along the patch's inward normal, N.
    pub(super) normal_n: f64,
    /// Force along the two axes of the plane, N.
    shear_n: [f64; 2],
    /// Position in the plane relative to the centre of pressure, m.
    position_m: [f64; 2],
    /// Force along the local shear direction of the whole patch, N.
    pub(super) along_n: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Sum over all elements, tip frame, N. Weak elements are included; their noise averages out.
    pub(super) force_n: Vector3<f64>,
    /// Torque of these forces about the origin of the tip frame, tip frame, N·m.
    pub(super) torque_n_m: Vector3<f64>,
    /// Outward unit normal, tip frame; the fingertip axis for weak contacts.
    pub(super) normal: Vector3<f64>,
    /// Axes that complete the normal to a right-handed frame.
    plane: [Vector3<f64>; 2],
    /// Force along the inward normal, N.
    pub(super) normal_n: f64,
    /// Force in the patch plane, tip frame, N.
    pub(super) tangential_n: Vector3<f64>,
    /// Moment of the shear about the outward normal through the centre of pressure, N·m.
    pub(super) moment_n_m: f64,
    /// Sum of the normal forces times their distance from the centre of pressure, N·m.
    pub(super) arm_n_m: f64,
    /// Scatter of the shear direction between elements, standard deviation over their normal force.
    pub(super) scatter: f64,
    pub(super) elements: ArrayVec<LoadedElement, ELEMENTS>,
    /// Standard deviation of one tangential axis of an element, N.
    pub(super) noise_n: f64,
}

impl Patch {
    pub(super) fn new(
        axes: &ElementAxes,
        elements_n: &[[f64; 3]; ELEMENTS],
        noise_n2: f64,
        floor_n: f64,
    ) -> Self {
        let mut force_n = Vector3::zeros();
        let mut torque_n_m = Vector3::zeros();
        let mut lean = Vector3::zeros();
        for (element, &reading) in elements_n.iter().enumerate().take(axes.count) {
            let element_n = axes.force(element, reading);
            force_n += element_n;
            torque_n_m += axes.position_m[element].cross(&element_n);
            if reading[0] > NORMAL_FLOOR_N {
                lean += axes.normal[element] * reading[0];
            }
        }
        let strength_n = lean.norm();
        let normal = if strength_n > PATCH_FLOOR_N {
            lean / strength_n
        } else {
            default_normal(axes)
        };
        let normal_n = -force_n.dot(&normal);
        let mut patch = Self {
            force_n,
            torque_n_m,
            normal,
            plane: plane_axes(&normal),
            normal_n,
            tangential_n: force_n + normal * normal_n,
            moment_n_m: 0.0,
            arm_n_m: 0.0,
            scatter: 0.0,
            elements: ArrayVec::new_const(),
            noise_n: libm::sqrt(noise_n2),
        };
        patch.collect_loaded(axes, elements_n, floor_n);
        patch.compute_shear();
        patch
    }

    fn collect_loaded(
        &mut self,
        axes: &ElementAxes,
        elements_n: &[[f64; 3]; ELEMENTS],
        floor_n: f64,
    ) {
        let clear_n = NOISE_CLEARANCE * self.noise_n;
        let floor_n = if clear_n > floor_n { clear_n } else { floor_n };
        for (element, &reading) in elements_n.iter().enumerate().take(axes.count) {
            if reading[0] <= NORMAL_FLOOR_N {
                continue;
            }
            let force_n = axes.force(element, reading);
            let normal_n = -force_n.dot(&self.normal);
            if normal_n > floor_n {
                let way = axes.position_m[element];
                self.elements.push(LoadedElement {
                    normal_n,
                    shear_n: self.plane.map(|axis| axis.dot(&force_n)),
                    position_m: self.plane.map(|axis| axis.dot(&way)),
                    along_n: 0.0,
                });
            }
        }
    }

    /// Computes the shear of the patch: translation per element, and rotation per metre from the
    /// centre of pressure.
    fn compute_shear(&mut self) {
        let elements = &mut self.elements;
        let (mut pressure_n, mut centre_n_m) = (0.0, [0.0; 2]);
        for LoadedElement {
            normal_n,
            position_m: [x, y],
            ..
        } in elements.iter()
        {
            pressure_n += normal_n;
            centre_n_m[0] += x * normal_n;
            centre_n_m[1] += y * normal_n;
        }
        if pressure_n <= 0.0 {
            return;
        }
        let centre_m = centre_n_m.map(|n_m| n_m / pressure_n);
        let (mut sum_n, mut square_m2) = ([0.0; 2], 0.0);
        for element in elements.iter_mut() {
            element.position_m[0] -= centre_m[0];
            element.position_m[1] -= centre_m[1];
            let ([x, y], [u, v]) = (element.position_m, element.shear_n);
            let distance_m2 = x * x + y * y;
            sum_n[0] += u;
            sum_n[1] += v;
            square_m2 += distance_m2;
            self.moment_n_m += x * v - y * u;
            self.arm_n_m += element.normal_n * libm::sqrt(distance_m2);
        }
        let straight_n = sum_n.map(|n| n / elements.len() as f64);
        let spin_n_m = self.moment_n_m / square_m2.max(f64::MIN_POSITIVE);
        self.project_shear(straight_n, spin_n_m);
    }

    /// Projects each element's force onto the local shear direction. Noise and crosstalk then
    /// average out, whereas vector lengths would only grow. The surface curvature explains a cross
    /// component that is constant or linear in position; the rest is sensor error.
    fn project_shear(&mut self, straight_n: [f64; 2], spin_n_m: f64) {
        let elements = &mut self.elements;
        let mut across = CrossShear::default();
        for element in elements.iter_mut() {
            let ([x, y], [u, v]) = (element.position_m, element.shear_n);
            let way = [straight_n[0] - spin_n_m * y, straight_n[1] + spin_n_m * x];
            let length_n = libm::sqrt(way[0] * way[0] + way[1] * way[1]);
            if length_n > 0.0 {
                let way = way.map(|n| n / length_n);
                element.along_n = u * way[0] + v * way[1];
                across.add(v * way[0] - u * way[1], element);
            }
        }
        let count = elements.len() as f64;
        let noise_n2 = count * self.noise_n * self.noise_n;
        self.scatter = across.scatter(count, noise_n2);
    }
}

/// Sums of a least-squares plane through the cross components over normal force.
#[derive(Default)]
struct CrossShear {
    square_n2: f64,
    with_n2: [f64; 3],
    normal_n2: [f64; 3],
}

impl CrossShear {
    fn add(&mut self, across_n: f64, element: &LoadedElement) {
        let n = element.normal_n;
        let [x, y] = element.position_m;
        self.square_n2 += across_n * across_n;
        for (axis, by) in [1.0, x, y].into_iter().enumerate() {
            self.with_n2[axis] += across_n * n * by;
            self.normal_n2[axis] += n * by * n * by;
        }
    }

    /// Returns the standard deviation that the plane does not explain, over the normal force.
    fn scatter(&self, count: f64, noise_n2: f64) -> f64 {
        let spare = count - self.with_n2.len() as f64 - 1.0;
        let terms = self.with_n2.iter().zip(self.normal_n2);
        let explained_n2: f64 = terms
            .map(|(with, own)| with * with / own.max(f64::MIN_POSITIVE))
            .sum();
        let rest_n2 = self.square_n2 - explained_n2 - noise_n2;
        if spare > 0.0 && rest_n2 > 0.0 {
            libm::sqrt(rest_n2 * count / (spare * self.normal_n2[0]))
        } else {
            0.0
        }
    }
}

/// Completes a unit vector to a right-handed frame (T. Duff et al., "Building an orthonormal basis,
/// revisited", 2017).
fn plane_axes(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let sign = if normal.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        Vector3::new(
            1.0 + sign * normal.x * normal.x * a,
            sign * b,
            -sign * normal.x,
        ),
        Vector3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// Normal of a weak contact: the fingertip axis, or that of a single element.
fn default_normal(axes: &ElementAxes) -> Vector3<f64> {
    if axes.count == 1 {
        axes.normal[0]
    } else {
        Vector3::z()
    }
}
