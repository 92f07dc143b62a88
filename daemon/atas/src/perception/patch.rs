//! Contact patch of one fingertip: total force, normal, and shear statistics of its elements.

use super::lanes::{self, Lanes, Row, Rows, VectorSum, cross, dot, splat};
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

/// Axes and positions of the elements of one layout, tip frame.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ElementAxes {
    pub(super) count: usize,
    normal: Rows,
    tangent1: Rows,
    tangent2: Rows,
    position_m: Rows,
    /// Curved in both directions: the pressure decreases towards the rim, which slips first.
    pub(super) is_round: bool,
    /// All elements lie in one plane: an edge may press alone.
    is_flat: bool,
}

impl ElementAxes {
    pub(super) fn new(layout: &Layout) -> Self {
        let normals = &layout.normal[..layout.count];
        let rows = |vectors: &[[f64; 3]; ELEMENTS]| lanes::to_rows(&vectors[..layout.count]);
        Self {
            count: layout.count,
            is_round: is_round(normals),
            is_flat: is_flat(normals),
            normal: rows(&layout.normal),
            tangent1: rows(&layout.tangent1),
            tangent2: rows(&layout.tangent2),
            position_m: rows(&layout.position_m),
        }
    }

    /// Returns the loaded share of a flat face, from one element to 1 (derived from the evenness of
    /// the forces). A linear pressure wedge counts as 1.
    pub(super) fn loaded_share(&self, [normals_n, ..]: &Rows, noise_n2: f64) -> f64 {
        if !self.is_flat {
            return 1.0;
        }
        let count = self.count as f64;
        let mut squares_n2 = Lanes::ZERO;
        for group in Row::groups(self.count) {
            let normal_n = normals_n.group(group);
            squares_n2 += normal_n * normal_n;
        }
        let sum_n = normals_n.sum(self.count);
        let square_n2 = lanes::sum(squares_n2) - count * noise_n2;
        if sum_n <= 0.0 || square_n2 <= 0.0 {
            return 1.0;
        }
        let share = sum_n * sum_n / (count * square_n2) / WEDGE_EVENNESS;
        share.clamp(1.0 / count, 1.0)
    }

    /// Forces of the object on a group of elements, tip frame: F = −d·f_n + t1·f_t1 + t2·f_t2.
    #[inline(always)]
    fn group_forces(&self, elements_n: &Rows, group: usize) -> [Lanes; 3] {
        let [n, t1, t2] = lanes::group(elements_n, group);
        let [along1_x, along1_y, along1_z] = lanes::group(&self.tangent1, group);
        let [along2_x, along2_y, along2_z] = lanes::group(&self.tangent2, group);
        let [normal_x, normal_y, normal_z] = lanes::group(&self.normal, group);
        [
            along1_x * t1 + along2_x * t2 - normal_x * n,
            along1_y * t1 + along2_y * t2 - normal_y * n,
            along1_z * t1 + along2_z * t2 - normal_z * n,
        ]
    }

    /// Returns force, N, and torque about the origin, N·m, of the object on the fingertip.
    fn wrench(&self, elements_n: &Rows) -> [Vector3<f64>; 2] {
        let (mut force_n, mut torque_n_m) = (VectorSum::default(), VectorSum::default());
        for group in Row::groups(self.count) {
            let of_group_n = self.group_forces(elements_n, group);
            let position_m = lanes::group(&self.position_m, group);
            force_n.add(of_group_n);
            torque_n_m.add(cross(position_m, of_group_n));
        }
        [force_n.total(), torque_n_m.total()]
    }

    /// Returns the outward unit normal of the patch; the default for weak contacts.
    pub(super) fn patch_normal(&self, [normals_n, ..]: &Rows) -> Vector3<f64> {
        let mut lean = VectorSum::default();
        for group in Row::groups(self.count) {
            let pressing_n = lanes::keep_above(normals_n.group(group), NORMAL_FLOOR_N);
            let [x, y, z] = lanes::group(&self.normal, group);
            lean.add([x * pressing_n, y * pressing_n, z * pressing_n]);
        }
        let lean = lean.total();
        let strength_n = lean.norm();
        if strength_n > PATCH_FLOOR_N {
            lean / strength_n
        } else {
            self.default_normal()
        }
    }

    /// Normal of a weak contact: the fingertip axis, or that of a single element.
    fn default_normal(&self) -> Vector3<f64> {
        if self.count == 1 {
            Vector3::from(lanes::element(&self.normal, 0))
        } else {
            Vector3::z()
        }
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

/// Clearly loaded elements of one group, in the plane of the patch; other lanes are 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoadedGroup {
    /// Force along the patch's inward normal, N.
    normal_n: Lanes,
    /// Force along the two axes of the plane, N.
    shear_n: [Lanes; 2],
    /// Position in the plane relative to the centre of pressure, m.
    position_m: [Lanes; 2],
    /// Force along the local shear direction of the whole patch, and across it, N.
    along_n: Lanes,
    across_n: Lanes,
    /// Mask of the loaded lanes.
    is_loaded: Lanes,
}

impl LoadedGroup {
    /// Returns the tangential force along the shear direction and the normal force of each loaded
    /// element, N.
    fn forces_n(&self) -> impl Iterator<Item = [f64; 2]> {
        let (along_n, normal_n) = (self.along_n.to_array(), self.normal_n.to_array());
        let forces_n = along_n.into_iter().zip(normal_n);
        forces_n.filter_map(|(along_n, normal_n)| (normal_n > 0.0).then_some([along_n, normal_n]))
    }
}

/// Friction reading of the elements closest to slip.
pub(super) struct MostLoaded {
    /// Mean ratio of tangential to normal force, weighted by normal force.
    pub(super) ratio: f64,
    /// Standard deviation of the ratio due to sensor noise.
    pub(super) error: f64,
}

/// Groups with a loaded element. Large: a local variable of the caller, so that no return copies
/// it.
pub(super) type LoadedGroups = ArrayVec<LoadedGroup, { Row::GROUPS }>;

/// Clearly loaded elements of a patch.
#[derive(Debug)]
pub(super) struct LoadedElements<'a> {
    groups: &'a mut LoadedGroups,
    count: usize,
    /// Sum of the normal forces, N.
    normal_n: f64,
    /// Moment of the shear about the outward normal through the centre of pressure, N·m.
    moment_n_m: f64,
    /// Standard deviation of one tangential axis of an element, N.
    noise_n: f64,
}

impl<'a> LoadedElements<'a> {
    /// Collects the elements above the sensor noise and `floor_n`, and computes their shear.
    pub(super) fn new(
        groups: &'a mut LoadedGroups,
        (axes, elements_n): (&ElementAxes, &Rows),
        normal: &Vector3<f64>,
        noise_n: f64,
        floor_n: f64,
    ) -> Self {
        let mut elements = Self {
            groups,
            count: 0,
            normal_n: 0.0,
            moment_n_m: 0.0,
            noise_n,
        };
        let clear_n = NOISE_CLEARANCE * noise_n;
        let floor_n = if clear_n > floor_n { clear_n } else { floor_n };
        elements.collect(axes, elements_n, normal, floor_n);
        if elements.count > 0 {
            elements.centre();
            elements.compute_shear();
        }
        elements
    }

    fn collect(
        &mut self,
        axes: &ElementAxes,
        elements_n: &Rows,
        normal: &Vector3<f64>,
        floor_n: f64,
    ) {
        let (inward, plane) = (splat(&-normal), plane_axes(normal).each_ref().map(splat));
        let mut sum_n = Lanes::ZERO;
        for index in Row::groups(axes.count) {
            let pressing = elements_n[0]
                .group(index)
                .simd_gt(Lanes::splat(NORMAL_FLOOR_N));
            if !pressing.any() {
                continue;
            }
            let force_n = axes.group_forces(elements_n, index);
            let normal_n = dot(&inward, &force_n);
            let is_loaded = pressing & normal_n.simd_gt(Lanes::splat(floor_n));
            let position_m = lanes::group(&axes.position_m, index);
            let [right, up] = &plane;
            let group = LoadedGroup {
                normal_n: normal_n & is_loaded,
                shear_n: [
                    dot(right, &force_n) & is_loaded,
                    dot(up, &force_n) & is_loaded,
                ],
                position_m: [dot(right, &position_m), dot(up, &position_m)],
                along_n: Lanes::ZERO,
                across_n: Lanes::ZERO,
                is_loaded,
            };
            let count = is_loaded.to_bitmask().count_ones();
            if count > 0 {
                self.count += count as usize;
                sum_n += group.normal_n;
                self.groups.push(group);
            }
        }
        self.normal_n = lanes::sum(sum_n);
    }

    /// Makes the positions relative to the centre of pressure.
    fn centre(&mut self) {
        let [mut x_n_m, mut y_n_m] = [Lanes::ZERO; 2];
        for group in self.groups.iter() {
            let [x, y] = group.position_m;
            x_n_m += x * group.normal_n;
            y_n_m += y * group.normal_n;
        }
        let [centre_x, centre_y] =
            [x_n_m, y_n_m].map(|n_m| Lanes::splat(lanes::sum(n_m) / self.normal_n));
        for group in self.groups.iter_mut() {
            let [x, y] = group.position_m;
            group.position_m = [
                (x - centre_x) & group.is_loaded,
                (y - centre_y) & group.is_loaded,
            ];
        }
    }

    /// Computes the shear of the patch: translation per element, and rotation per metre from the
    /// centre of pressure.
    fn compute_shear(&mut self) {
        let [mut moment_n_m, mut square_m2, mut u_n, mut v_n] = [Lanes::ZERO; 4];
        for group in self.groups.iter() {
            let ([x, y], [u, v]) = (group.position_m, group.shear_n);
            square_m2 += x * x + y * y;
            moment_n_m += x * v - y * u;
            u_n += u;
            v_n += v;
        }
        self.moment_n_m = lanes::sum(moment_n_m);
        let straight_n = [u_n, v_n].map(|sum_n| lanes::sum(sum_n) / self.count as f64);
        let spin_n_m = self.moment_n_m / lanes::sum(square_m2).max(f64::MIN_POSITIVE);
        self.project_shear(straight_n, spin_n_m);
    }

    /// Projects each element's force onto the local shear direction. Noise and crosstalk then
    /// average out, whereas vector lengths would only grow.
    fn project_shear(&mut self, straight_n: [f64; 2], spin_n_m: f64) {
        let ([right_n, up_n], spin) = (straight_n.map(Lanes::splat), Lanes::splat(spin_n_m));
        for group in self.groups.iter_mut() {
            let ([x, y], [u, v]) = (group.position_m, group.shear_n);
            let [way_x, way_y] = [right_n - spin * y, up_n + spin * x];
            let inverse = lanes::positive_inverse((way_x * way_x + way_y * way_y).sqrt());
            group.along_n = (u * way_x + v * way_y) * inverse;
            group.across_n = (v * way_x - u * way_y) * inverse;
        }
    }

    /// Evaluates the third of the loaded elements (at least two) with the highest ratio.
    pub(super) fn most_loaded(&self) -> Option<MostLoaded> {
        if self.count < 2 {
            return None;
        }
        let top = (self.count / 3).max(2);
        let loaded = || self.groups.iter().flat_map(LoadedGroup::forces_n);
        let mut ratios: ArrayVec<f64, ELEMENTS> = loaded().map(|[t, n]| t / n).collect();
        // All ratios are finite: intake rejects other readings.
        let (_, least, _) = ratios.select_nth_unstable_by(top - 1, |a, b| b.total_cmp(a));
        let above = loaded().filter(|[t, n]| t / n > *least);
        let equal = loaded().filter(|[t, n]| t / n == *least);
        let chosen = above.chain(equal).take(top);
        let [along_n, normal_n] = chosen.fold([0.0, 0.0], |[ts, ns], [t, n]| [ts + t, ns + n]);
        Some(MostLoaded {
            ratio: along_n / normal_n,
            error: self.noise_n * libm::sqrt(top as f64) / normal_n,
        })
    }

    /// Returns the sum of the forces along the local shear direction, N.
    fn along_n(&self) -> f64 {
        let lanes = self.groups.iter().map(|group| group.along_n);
        lanes::sum(lanes.fold(Lanes::ZERO, |sum, along_n| sum + along_n))
    }

    /// Returns the sum of the normal forces times their distance from the centre of pressure, N·m.
    fn arm_n_m(&self) -> f64 {
        let mut arm_n_m = Lanes::ZERO;
        for group in self.groups.iter() {
            let [x, y] = group.position_m;
            arm_n_m += group.normal_n * (x * x + y * y).sqrt();
        }
        lanes::sum(arm_n_m)
    }

    /// Returns the scatter of the shear direction between elements: standard deviation of the cross
    /// components over their normal force. The surface curvature explains a cross component that
    /// is constant or linear in position (least-squares plane); the rest is sensor error.
    fn scatter(&self) -> f64 {
        let mut square_n2 = Lanes::ZERO;
        let (mut with_n2, mut normal_n2) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3]);
        for group in self.groups.iter() {
            let (n, [x, y], across_n) = (group.normal_n, group.position_m, group.across_n);
            square_n2 += across_n * across_n;
            for (axis, weighted) in [n, n * x, n * y].into_iter().enumerate() {
                with_n2[axis] += across_n * weighted;
                normal_n2[axis] += weighted * weighted;
            }
        }
        let (count, normal_n2) = (self.count as f64, normal_n2.map(lanes::sum));
        let spare = count - with_n2.len() as f64 - 1.0;
        let terms = with_n2.map(lanes::sum).into_iter().zip(normal_n2);
        let explained_n2: f64 = terms
            .map(|(with, own)| with * with / own.max(f64::MIN_POSITIVE))
            .sum();
        let rest_n2 = lanes::sum(square_n2) - explained_n2 - count * self.noise_n * self.noise_n;
        if spare > 0.0 && rest_n2 > 0.0 {
            libm::sqrt(rest_n2 * count / (spare * normal_n2[0]))
        } else {
            0.0
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Sum over all elements, tip frame, N. Weak elements are included; their noise averages out.
    pub(super) force_n: Vector3<f64>,
    /// Torque of these forces about the origin of the tip frame, tip frame, N·m.
    pub(super) torque_n_m: Vector3<f64>,
    /// Outward unit normal, tip frame; the fingertip axis for weak contacts.
    pub(super) normal: Vector3<f64>,
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
    /// Sums of the forces of the loaded elements along their shear direction and normal, N.
    pub(super) loaded_along_n: f64,
    pub(super) loaded_normal_n: f64,
    /// Standard deviation of one tangential axis of an element, N.
    pub(super) noise_n: f64,
}

impl Patch {
    pub(super) fn new(axes: &ElementAxes, elements_n: &Rows, noise_n2: f64, floor_n: f64) -> Self {
        let [force_n, torque_n_m] = axes.wrench(elements_n);
        let normal = axes.patch_normal(elements_n);
        let normal_n = -force_n.dot(&normal);
        let noise_n = libm::sqrt(noise_n2);
        let mut groups = LoadedGroups::new();
        let of = (axes, elements_n);
        let loaded = LoadedElements::new(&mut groups, of, &normal, noise_n, floor_n);
        Self {
            force_n,
            torque_n_m,
            normal,
            normal_n,
            tangential_n: force_n + normal * normal_n,
            moment_n_m: loaded.moment_n_m,
            arm_n_m: loaded.arm_n_m(),
            scatter: loaded.scatter(),
            loaded_along_n: loaded.along_n(),
            loaded_normal_n: loaded.normal_n,
            noise_n,
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
