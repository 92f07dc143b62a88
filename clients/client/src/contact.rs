//! Contact forces of a fingertip from its elements.

use shm_schemas::Layout;

/// Returns position and force of each valid element, tip frame, m and N, and the normal force.
pub fn points<'a>(
    layout: &'a Layout,
    valid: u64,
    force_n: &'a [[f32; 3]],
) -> impl Iterator<Item = [f32; 7]> + 'a {
    let count = layout.count.min(force_n.len());
    let is_valid = move |element: &usize| valid >> element & 1 == 1;
    (0..count).filter(is_valid).map(|element| {
        let force = force_on(layout, element, force_n[element]);
        let [x, y, z] = layout.position_m[element].map(|x| x as f32);
        let [fx, fy, fz] = force.map(|f| f as f32);
        [x, y, z, fx, fy, fz, force_n[element][0]]
    })
}

/// Returns the force of the object on the fingertip and its torque about the tip frame's origin,
/// tip frame, N and N·m.
///
/// ```
/// use atas_client::contact::wrench;
/// use shm_schemas::Layout;
///
/// let layout = Layout::dome_41();
/// let mut force_n = [[0.0_f32; 3]; 41];
/// force_n[3] = [2.0, 0.0, 0.0];
/// let [force, _torque] = wrench(&layout, 1 << 3, &force_n);
/// // The object presses against the outward normal.
/// let normal = layout.normal[3];
/// assert!((force[2] + 2.0 * normal[2]).abs() < 1e-6);
/// assert_eq!(wrench(&layout, 0, &force_n), [[0.0; 3]; 2], "no valid element");
/// ```
#[must_use]
pub fn wrench(layout: &Layout, valid: u64, force_n: &[[f32; 3]]) -> [[f64; 3]; 2] {
    let mut sum = [[0.0; 3]; 2];
    for [x, y, z, fx, fy, fz, _] in points(layout, valid, force_n).map(|p| p.map(f64::from)) {
        let torque = [y * fz - z * fy, z * fx - x * fz, x * fy - y * fx];
        for (sum, part) in sum.iter_mut().zip([[fx, fy, fz], torque]) {
            sum.iter_mut()
                .zip(part)
                .for_each(|(sum, part)| *sum += part);
        }
    }
    sum
}

/// Returns the force on an element with axes d, t1, t2: `F = −f_n·d + f_t1·t1 + f_t2·t2` (see
/// [`shm_schemas::HandFrame`]).
fn force_on(layout: &Layout, element: usize, force_n: [f32; 3]) -> [f64; 3] {
    let [f_n, f_t1, f_t2] = force_n.map(f64::from);
    core::array::from_fn(|axis| {
        f_t1 * layout.tangent1[element][axis] + f_t2 * layout.tangent2[element][axis]
            - f_n * layout.normal[element][axis]
    })
}
