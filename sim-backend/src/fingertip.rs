//! Single fingertip under known loads, as on a calibration bench.
//!
//! ```text
//!  World::fingertip ─▶ Fingertip ── load(N) ─▶ plate moves until loaded ── sample ─▶ readings
//! ```
//!
//! Skin and electronics equal those on the hand; the noise comes from another stream. The load acts
//! through a rigid, sticky plate, flat against the pole. All quantities are in the plate's frame:
//! the pole points along −z, its tangents are x and ±y.

use nalgebra::{Matrix3, Vector3};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;
use shm_schemas::layout::NamedLayout;

use crate::contact::{Approach, Contact, Surface};
use crate::pad::Pad;
use crate::sensor::TipSensor;
use crate::shape::Shape;

/// Half edge of the plate, m, its friction, and its mass, kg. Design choice: larger than any
/// fingertip, no sliding, heavy.
const PLATE_HALF_M: f64 = 0.05;
const PLATE_FRICTION: f64 = 5.0;
const PLATE_KG: f64 = 10.0;
/// Time step, s: that of the world.
const STEP_S: f64 = 250e-6;
/// Plate speed per missing load, m/s per N, and its limit, m/s. Design choice: stable up to five
/// times this gain with the stiffest skin (60 kN/m); the softest skin settles within 0.1 s.
const PLATE_GAIN_M_S_N: f64 = 0.004;
const SPEED_MAX_M_S: f64 = 0.01;
/// Settling time of a load, s. Design choice: the remaining error is below 0.1 %.
const SETTLING_S: f64 = 1.0;
/// Distance of the plate without load, m.
const CLEAR_M: f64 = 0.001;

/// Fingertip with the plate that loads it.
#[derive(Clone, Debug)]
pub struct Fingertip {
    pad: Pad,
    contact: Contact,
    sensor: TipSensor,
    named: NamedLayout,
    layout: Layout,
    /// Distance from the tip frame's origin to the skin at the pole, m.
    radius_m: f64,
    /// Axes of the tip in the plate's frame.
    plate_from_tip: Matrix3<f64>,
    /// Signs of the tangents along x and y.
    tangents: [f64; 2],
    /// Displacement of the skin at the pole from first contact with the unloaded plate: shear along
    /// x and y, indentation, m.
    displacement_m: Vector3<f64>,
}

impl Fingertip {
    /// Returns a fingertip with this skin and electronics; `radius_m` is the distance from the
    /// frame's origin to the skin.
    pub(crate) fn new(pad: &Pad, radius_m: f64, sensor: TipSensor, named: NamedLayout) -> Self {
        let layout = named.layout();
        let axis = |of: [f64; 3]| Vector3::from(of);
        let (x, z) = (axis(layout.tangent1[0]), -axis(layout.normal[0]));
        let y = z.cross(&x);
        let second = y.dot(&axis(layout.tangent2[0]));
        Self {
            pad: pad.clone(),
            contact: Contact::new(pad),
            sensor,
            named,
            layout,
            radius_m,
            plate_from_tip: Matrix3::from_columns(&[x, y, z]).transpose(),
            tangents: [1.0, second.signum()],
            displacement_m: Vector3::new(0.0, 0.0, -CLEAR_M),
        }
    }

    /// Returns the layout of the elements.
    #[must_use]
    pub fn layout(&self) -> NamedLayout {
        self.named
    }

    /// Applies the load `[f_n, f_t1, f_t2]`, N, along the axes of an element at the pole, to an
    /// unloaded skin. Returns the indentation, m; 0 without a normal load, where the plate does not
    /// touch.
    pub fn load(&mut self, force_n: [f64; 3]) -> f64 {
        let [normal_n, t1_n, t2_n] = force_n;
        self.contact = Contact::new(&self.pad);
        self.displacement_m = Vector3::new(0.0, 0.0, -CLEAR_M);
        if normal_n.is_nan() || normal_n <= 0.0 {
            return 0.0;
        }
        self.displacement_m.z = 0.0;
        let [x, y] = self.tangents;
        let wanted_n = Vector3::new(x * t1_n, y * t2_n, normal_n);
        let mut speed_m_s = Vector3::zeros();
        for _ in 0..(SETTLING_S / STEP_S) as usize {
            self.displacement_m += speed_m_s * STEP_S;
            let felt_n = self.press(&speed_m_s);
            // Shear force opposes the displacement.
            let missing_n = wanted_n - felt_n;
            let towards = Vector3::new(-missing_n.x, -missing_n.y, missing_n.z);
            speed_m_s =
                (towards * PLATE_GAIN_M_S_N).map(|m_s| m_s.clamp(-SPEED_MAX_M_S, SPEED_MAX_M_S));
        }
        self.displacement_m.z
    }

    /// Returns the readings `[f_n, f_t1, f_t2]` of all elements under the current load, N, with new
    /// noise.
    pub fn sample(&mut self) -> Vec<[f32; 3]> {
        let count = self.layout.count;
        let mut force_n = [Vector3::zeros(); ELEMENTS];
        let force_n = &mut force_n[..count];
        self.contact.element_forces(&self.pad, force_n);
        let mut readings_n = vec![[0.0; 3]; count];
        self.sensor.sample(&self.layout, force_n, &mut readings_n);
        readings_n
    }

    /// Simulates one step; returns the force of the plate on the fingertip, z along the load, N.
    fn press(&mut self, speed_m_s: &Vector3<f64>) -> Vector3<f64> {
        let [x, y, depth_m] = self.displacement_m.into();
        let surface = Surface {
            shape: Shape::Box {
                half_m: Vector3::repeat(PLATE_HALF_M),
            },
            friction: PLATE_FRICTION,
            mass_kg: PLATE_KG,
            stiffness_n_m: f64::INFINITY,
        };
        let approach = Approach {
            object_from_tip: self.plate_from_tip,
            centre_m: Vector3::new(x, y, PLATE_HALF_M + self.radius_m - depth_m),
            velocity_m_s: Vector3::new(speed_m_s.x, speed_m_s.y, -speed_m_s.z),
            angular_rad_s: Vector3::zeros(),
        };
        let on_plate = self.contact.press(&self.pad, &surface, &approach, STEP_S);
        -on_plate.force_n
    }
}

#[cfg(test)]
mod tests {
    use robot_model::{HandSide, RobotModel};
    use shm_schemas::layout::NamedLayout;

    use crate::{Scene, World, simulated_skin};

    #[test]
    fn elements_sum_to_the_load() {
        let arm = RobotModel::two_hand_arm().expect("built-in robot");
        for layout in ["dome-41", "dome-1", "flat-4x4-4.5"] {
            let named: NamedLayout = layout.parse().expect("layout name");
            let robot = arm.clone().with_skin(simulated_skin(named));
            let object = crate::Object::built_in("wood").expect("built-in object");
            let mut scene = Scene::grasp(object, HandSide::Right);
            scene.noise_factor = 0.0;
            let world = World::new(&robot, &scene, 3).expect("valid scene");
            let mut tip = world.fingertip(1, 0).expect("fingertip 0 exists");
            let axes = named.layout();
            for load_n in [
                [0.5, 0.0, 0.0],
                [2.0, 1.0, 0.0],
                [2.0, 0.0, -1.0],
                [5.0, 0.0, 0.0],
            ] {
                assert!(tip.load(load_n) > 0.0);
                let mut total_n = [0.0; 3];
                for (element, [n, a, b]) in tip.sample().into_iter().enumerate() {
                    for (axis, total_n) in total_n.iter_mut().enumerate() {
                        let along = |of: [f64; 3]| {
                            let pole = [
                                axes.normal[0].map(|n| -n),
                                axes.tangent1[0],
                                axes.tangent2[0],
                            ];
                            (0..3).map(|k| of[k] * pole[axis][k]).sum::<f64>()
                        };
                        *total_n += f64::from(n) * along(axes.normal[element].map(|n| -n))
                            + f64::from(a) * along(axes.tangent1[element])
                            + f64::from(b) * along(axes.tangent2[element]);
                    }
                }
                // Gains of elements spread by 3 %.
                for (total_n, load_n) in total_n.into_iter().zip(load_n) {
                    assert!(
                        (total_n - load_n).abs() < 0.1 * load_n.abs() + 0.05,
                        "{layout}: {total_n} {load_n}"
                    );
                }
            }
            assert_eq!(tip.load([0.0; 3]), 0.0);
            assert!(tip.sample().iter().flatten().all(|n| *n == 0.0));
        }
        let world = World::new(&arm, &Scene::default(), 1).expect("valid scene");
        assert!(world.fingertip(2, 0).is_none() && world.fingertip(0, 9).is_none());
    }

    /// Reference of the tactile design: force over indentation on a rigid flat.
    #[test]
    fn indentation_matches_the_design() {
        let arm = RobotModel::two_hand_arm().expect("built-in robot");
        let world = World::new(&arm, &Scene::default(), 1).expect("valid scene");
        let mut tip = world.fingertip(0, 0).expect("fingertip 0 exists");
        for (depth_m, force_n) in [
            (0.2e-3, 0.25),
            (0.3e-3, 0.6),
            (0.5e-3, 1.84),
            (0.8e-3, 4.65),
        ] {
            let pressed_m = tip.load([force_n, 0.0, 0.0]);
            assert!(
                (pressed_m / depth_m - 1.0).abs() < 0.025,
                "{pressed_m} {depth_m}"
            );
        }
    }
}
