//! Rigid object on its support.
//!
//! Semi-implicit Euler: forces update the velocity, then the new velocity moves the body. Supports
//! (`support.rs`) act on the corners: a spring with damper along the normal, and a spring with a
//! friction limit along the surface. Base frame; the table is the plane z = 0.

use nalgebra::{Matrix3, Vector3};

use crate::base_motion::BaseMotion;
use crate::contact::Wrench;
use crate::shape::Shape;
use crate::support::{Ground, RimLoad};

/// Standard gravity, m/s² (prototype: 9.81).
pub const GRAVITY_M_S2: f64 = 9.81;
/// Table stiffness under one corner, N/m (prototype).
const TABLE_N_M: f64 = 2e4;
/// Tangential table stiffness per corner, N/m (prototype).
const TABLE_SHEAR_N_M: f64 = 1e4;
/// Friction coefficient of the table (prototype).
const TABLE_FRICTION: f64 = 0.3;
/// Damping per corner over √(stiffness·mass) (prototype).
const TABLE_DAMPING_RATIO: f64 = 0.6;
/// Upper bound of the damping per corner over its stiffness, s (prototype).
const TABLE_DAMPING_S: f64 = 0.003;
/// Upper bound of the damping per corner over the mass, 1/s. Derived: 0.05 per substep. Above it,
/// the tilting of a 12 g object is unstable at 250 µs.
const TABLE_DAMPING_PER_S: f64 = 200.0;
/// Tangential damping over normal damping (prototype).
const TABLE_SHEAR_DAMPING_RATIO: f64 = 0.5;

/// Rigid body on or above its support.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) shape: Shape,
    mass_kg: f64,
    inertia_kg_m2: Vector3<f64>,
    corners: Vec<Corner>,
    table_damping_n_s_m: f64,
    /// Centre of mass from the middle of the shape, body frame, m.
    centre_of_mass_m: Vector3<f64>,
    /// Middle of the shape, origin of the body frame, m.
    pub(crate) position_m: Vector3<f64>,
    /// Unit quaternion w, x, y, z.
    orientation: [f64; 4],
    /// Body axes in the base frame; matrix form of the orientation.
    pub(crate) base_from_body: Matrix3<f64>,
    /// Velocity of the middle, m/s.
    pub(crate) velocity_m_s: Vector3<f64>,
    /// Angular velocity, base frame, rad/s.
    pub(crate) angular_rad_s: Vector3<f64>,
    load: Wrench,
    /// Constant force at the centre of mass, base frame, N.
    pub(crate) pull_n: Vector3<f64>,
    /// Sum of the support normal forces in the last step, N.
    pub(crate) table_n: f64,
    /// Share of the rim in that sum, N.
    pub(crate) rim_n: f64,
    rim_load: RimLoad,
}

/// Pose and velocity of a body, base frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Middle of the shape, m.
    pub(crate) position_m: Vector3<f64>,
    /// Unit quaternion w, x, y, z.
    pub(crate) orientation: [f64; 4],
    pub(crate) velocity_m_s: Vector3<f64>,
    pub(crate) angular_rad_s: Vector3<f64>,
}

/// Contact point with the support.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Position, body frame, m.
    position_m: Vector3<f64>,
    /// Tangential spring deflection, m.
    shear_m: [f64; 2],
}

impl Body {
    /// Creates a body at rest, upright on a level support, with its corners pressed in by its
    /// weight.
    pub(crate) fn standing(shape: Shape, mass_kg: f64, at_m: [f64; 3], yaw_rad: f64) -> Self {
        let corners: Vec<Corner> = shape
            .corners_m()
            .into_iter()
            .map(|place_m| Corner {
                position_m: place_m,
                shear_m: [0.0; 2],
            })
            .collect();
        let standing_on = corners.len() / 2;
        let sunk_m = mass_kg * GRAVITY_M_S2 / (TABLE_N_M * standing_on as f64);
        let orientation = quaternion_about_z(yaw_rad);
        Self {
            shape,
            mass_kg,
            inertia_kg_m2: shape.inertia_kg_m2(mass_kg),
            corners,
            table_damping_n_s_m: table_damping_n_s_m(mass_kg),
            centre_of_mass_m: Vector3::zeros(),
            position_m: Vector3::from(at_m) + Vector3::z() * (shape.half_height_m() - sunk_m),
            orientation,
            base_from_body: rotation_matrix(orientation),
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
            load: Wrench::default(),
            pull_n: Vector3::zeros(),
            table_n: mass_kg * GRAVITY_M_S2,
            rim_n: 0.0,
            rim_load: RimLoad::default(),
        }
    }

    /// Raises every moment of inertia to at least this value.
    pub(crate) fn with_min_inertia(mut self, least_kg_m2: f64) -> Self {
        self.inertia_kg_m2 = self.inertia_kg_m2.sup(&Vector3::repeat(least_kg_m2));
        self
    }

    /// Sets the centre of mass, body frame, m. The moment of inertia about it stays that about the
    /// middle.
    pub(crate) fn with_centre_of_mass(mut self, centre_of_mass_m: Vector3<f64>) -> Self {
        self.centre_of_mass_m = centre_of_mass_m;
        self
    }

    /// Adds a wrench about the middle, body frame, to the next step.
    pub(crate) fn apply(&mut self, wrench: &Wrench) {
        self.load.force_n += self.base_from_body * wrench.force_n;
        self.load.moment_n_m += self.base_from_body * wrench.moment_n_m;
    }

    /// Adds a wrench about a point, base frame, to the next step.
    pub(crate) fn apply_at(&mut self, point_m: &Vector3<f64>, wrench: &Wrench) {
        let arm_m = point_m - self.position_m;
        self.load.force_n += wrench.force_n;
        self.load.moment_n_m += wrench.moment_n_m + arm_m.cross(&wrench.force_n);
    }

    /// Returns the applied wrenches, the constant force and the weight about the middle, base
    /// frame; clears the wrenches.
    pub(crate) fn take_load(&mut self) -> Wrench {
        let mut load = core::mem::take(&mut self.load);
        let at_centre_n = self.pull_n - Vector3::z() * self.weight_n();
        load.force_n += at_centre_n;
        load.moment_n_m += self.lever_m().cross(&at_centre_n);
        load
    }

    /// Returns the vector from the middle to the centre of mass, base frame, m.
    fn lever_m(&self) -> Vector3<f64> {
        self.base_from_body * self.centre_of_mass_m
    }

    pub(crate) fn weight_n(&self) -> f64 {
        self.mass_kg * GRAVITY_M_S2
    }

    /// Returns the load of the body on the rim in the last step, and clears it.
    pub(crate) fn take_rim_load(&mut self) -> Wrench {
        core::mem::take(&mut self.rim_load).0
    }

    /// Advances one step under the applied wrenches, gravity and the supports; clears the wrenches.
    pub(crate) fn step(&mut self, ground: &Ground<'_>, dt_s: f64) {
        let mut load = self.take_load();
        if ground.ride.is_moving() {
            self.add_inertial_forces(&ground.ride, &mut load, dt_s);
        }
        self.add_support_forces(ground, &mut load, dt_s);
        // Forces move the centre of mass; the middle follows from the rotation.
        let lever_m = self.lever_m();
        let velocity_m_s = self.velocity_m_s
            + self.angular_rad_s.cross(&lever_m)
            + load.force_n * (dt_s / self.mass_kg);
        self.integrate_rotation(&(load.moment_n_m - lever_m.cross(&load.force_n)), dt_s);
        let lever_after_m = self.lever_m();
        self.velocity_m_s = velocity_m_s - self.angular_rad_s.cross(&lever_after_m);
        self.position_m += velocity_m_s * dt_s + (lever_m - lever_after_m);
    }

    /// Adds the inertial forces of the moving base. A supported body gets no heave force.
    fn add_inertial_forces(&mut self, ride: &BaseMotion, load: &mut Wrench, dt_s: f64) {
        let lever_m = self.lever_m();
        let centre_m = self.position_m + lever_m;
        let velocity_m_s = self.velocity_m_s + self.angular_rad_s.cross(&lever_m);
        let mut inertial_n = ride.inertial_m_s2(&centre_m, &velocity_m_s) * self.mass_kg;
        if self.table_n > 0.0 {
            inertial_n.z = 0.0;
        }
        load.force_n += inertial_n;
        load.moment_n_m += lever_m.cross(&inertial_n);
        self.angular_rad_s += ride.inertial_rad_s2(&self.angular_rad_s) * dt_s;
    }

    /// Adds the support forces to the load.
    fn add_support_forces(&mut self, ground: &Ground<'_>, load: &mut Wrench, dt_s: f64) {
        (self.table_n, self.rim_n) = (0.0, 0.0);
        if self.position_m.z - self.shape.bounding_radius_m() > ground.highest_m() {
            return;
        }
        for corner in &mut self.corners {
            let arm_m = self.base_from_body * corner.position_m;
            let point_m = self.position_m + arm_m;
            let support = ground.under(&point_m);
            let height_m = point_m.z - support.height_m;
            if height_m >= 0.0 {
                corner.shear_m = [0.0; 2];
                continue;
            }
            let velocity =
                self.velocity_m_s + self.angular_rad_s.cross(&arm_m) - support.velocity_m_s;
            let force_n =
                corner.contact_force_n(height_m, &velocity, self.table_damping_n_s_m, dt_s);
            self.table_n += force_n.z;
            load.force_n += force_n;
            load.moment_n_m += arm_m.cross(&force_n);
            if let Some(rim) = ground.rim.filter(|_| support.is_rim) {
                self.rim_n += force_n.z;
                self.rim_load.add_reaction(&rim, &point_m, &force_n);
            }
        }
    }

    /// Sets the motion directly; supports get no load.
    pub(crate) fn set_motion(&mut self, motion: &Motion) {
        self.position_m = motion.position_m;
        self.orientation = motion.orientation;
        self.base_from_body = rotation_matrix(motion.orientation);
        self.velocity_m_s = motion.velocity_m_s;
        self.angular_rad_s = motion.angular_rad_s;
        (self.table_n, self.rim_n) = (0.0, 0.0);
    }

    /// Integrates Euler's equation in the body frame, then the quaternion.
    fn integrate_rotation(&mut self, moment_n_m: &Vector3<f64>, dt_s: f64) {
        let spin = self.base_from_body.tr_mul(&self.angular_rad_s);
        let moment = self.base_from_body.tr_mul(moment_n_m);
        let gyroscopic = spin.cross(&spin.component_mul(&self.inertia_kg_m2));
        let spin = spin + (moment - gyroscopic).component_div(&self.inertia_kg_m2) * dt_s;
        self.angular_rad_s = self.base_from_body * spin;
        self.orientation = rotated(self.orientation, &(self.angular_rad_s * dt_s));
        self.base_from_body = rotation_matrix(self.orientation);
    }

    /// Returns the height of the lowest corner above its support, m.
    pub(crate) fn clearance_m(&self, ground: &Ground<'_>) -> f64 {
        let above_m = |corner: &Corner| {
            let point_m = self.position_m + self.base_from_body * corner.position_m;
            point_m.z - ground.under(&point_m).height_m
        };
        self.corners
            .iter()
            .map(above_m)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the orientation, base frame, quaternion w, x, y, z.
    pub(crate) fn orientation(&self) -> [f64; 4] {
        self.orientation
    }

    /// Returns the angle between the body's z axis and the vertical, rad.
    pub(crate) fn tilt_rad(&self) -> f64 {
        libm::acos(self.base_from_body[(2, 2)].clamp(-1.0, 1.0))
    }

    /// Returns true if every state is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let linear = self.position_m.sum() + self.velocity_m_s.sum() + self.angular_rad_s.sum();
        (linear + self.orientation.iter().sum::<f64>()).is_finite()
    }
}

fn table_damping_n_s_m(mass_kg: f64) -> f64 {
    (TABLE_DAMPING_RATIO * (TABLE_N_M * mass_kg).sqrt())
        .min(TABLE_DAMPING_S * TABLE_N_M)
        .min(TABLE_DAMPING_PER_S * mass_kg)
}

impl Corner {
    /// Returns the support force on the corner at a height, N.
    fn contact_force_n(
        &mut self,
        height_m: f64,
        velocity: &Vector3<f64>,
        damping_n_s_m: f64,
        dt_s: f64,
    ) -> Vector3<f64> {
        let normal_n = (-TABLE_N_M * height_m - damping_n_s_m * velocity.z).max(0.0);
        let [x, y] = self.friction_force_n([velocity.x, velocity.y], normal_n, damping_n_s_m, dt_s);
        Vector3::new(x, y, normal_n)
    }

    /// Returns the friction force on the corner after one step of sliding, N.
    fn friction_force_n(
        &mut self,
        velocity_m_s: [f64; 2],
        normal_n: f64,
        damping_n_s_m: f64,
        dt_s: f64,
    ) -> [f64; 2] {
        let damping_n_s_m = TABLE_SHEAR_DAMPING_RATIO * damping_n_s_m;
        for axis in [0, 1] {
            self.shear_m[axis] += velocity_m_s[axis] * dt_s;
        }
        let force_n = [0, 1]
            .map(|axis| -TABLE_SHEAR_N_M * self.shear_m[axis] - damping_n_s_m * velocity_m_s[axis]);
        let magnitude_n = (force_n[0] * force_n[0] + force_n[1] * force_n[1]).sqrt();
        let limit_n = TABLE_FRICTION * normal_n;
        if magnitude_n <= limit_n {
            return force_n;
        }
        let force_n = force_n.map(|component| component * (limit_n / magnitude_n));
        self.shear_m = force_n.map(|component| -component / TABLE_SHEAR_N_M);
        force_n
    }
}

/// Rotates a unit quaternion by a small rotation vector, base frame, rad: first order, then
/// normalised. The error is the cube of the angle over 12: 10⁻¹⁰ rad at 4 rad/s and 250 µs.
pub(crate) fn rotated([w, x, y, z]: [f64; 4], by: &Vector3<f64>) -> [f64; 4] {
    let half = by * 0.5;
    let turned = [
        w - half.x * x - half.y * y - half.z * z,
        x + half.x * w + half.y * z - half.z * y,
        y + half.y * w + half.z * x - half.x * z,
        z + half.z * w + half.x * y - half.y * x,
    ];
    let length = turned.iter().map(|c| c * c).sum::<f64>().sqrt();
    turned.map(|component| component / length)
}

/// Multiplies two unit quaternions: the right rotation first, then the left one.
pub(crate) fn quaternion_product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// Returns the unit quaternion of a rotation about z.
pub(crate) fn quaternion_about_z(angle_rad: f64) -> [f64; 4] {
    let (sin, cos) = libm::sincos(0.5 * angle_rad);
    [cos, 0.0, 0.0, sin]
}

/// Returns the rotation matrix of a unit quaternion.
pub(crate) fn rotation_matrix([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    Matrix3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

#[cfg(test)]
mod tests;
