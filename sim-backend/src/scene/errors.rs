//! Errors: deviations of reality from the controller's model and from the client's data.
//!
//! Every number is a half width or, where stated, a maximum; the default is zero. A trial draws
//! each error from its own stream, so that enabling one changes no other draw.
//!
//! ```
//! use sim_backend::{Errors, Object, Scene};
//! use robot_model::HandSide;
//!
//! # fn main() -> Result<(), sim_backend::ObjectError> {
//! let nominal = Scene::grasp(Object::built_in("wood")?, HandSide::Right);
//! // Each kind of error alone, then all of them together.
//! for kind in &Errors::KINDS {
//!     let scene = nominal.varied(7).with_errors(&kind.errors, 7);
//!     assert_eq!(scene.errors, kind.errors);
//! }
//! let scene = nominal.varied(7).with_errors(&Errors::ALL, 7);
//! // Custom errors: crosstalk of up to 10 % and all others.
//! let harsh = nominal.with_errors(&Errors { crosstalk: 0.10, ..Errors::ALL }, 7);
//! # assert!(scene.grasp_hint(0) != nominal.grasp_hint(0) && harsh.errors.crosstalk == 0.10);
//! # Ok(())
//! # }
//! ```

use core::f64::consts::PI;

use super::{GraspHint, Placed, Scene, SensorErrors, grasp_height_m, stream};
use crate::random::Random;
use crate::range::{OutOfRange, in_range};
use crate::shape::Shape;

/// Sizes of all errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Servo stiffness per joint, relative.
    pub servo_stiffness: f64,
    /// Length per link, m.
    pub link_m: f64,
    /// Skin stiffness per fingertip, relative.
    pub tip_stiffness: f64,
    /// Crosstalk per element: each axis reads up to this share of each other axis' force.
    pub crosstalk: f64,
    /// Offset per element and axis, N.
    pub bias_n: f64,
    /// Gain per fingertip, relative.
    pub gain: f64,
    /// Horizontal offset of the centre of mass across the closing axis, m.
    pub centre_of_mass_m: f64,
    /// Offset of every object from its nominal position, x and y, m.
    pub position_m: f64,
    /// Yaw of every object relative to nominal, rad.
    pub yaw_rad: f64,
    /// Error of the expected width of every object, m. For caps and bottles the true size changes.
    pub expected_width_m: f64,
    /// Largest object height, m, drawn upwards from the object's own. Clients know it; caps and
    /// bottles keep their height.
    pub height_m: f64,
    /// Time constant of a first-order lag between command and set-point of every servo, s.
    pub servo_lag_s: f64,
    /// Further errors of the tactile sensors.
    pub sensor: SensorErrors,
}

/// Default lag of a servo, s. Design choice: four times the time constant of the sensor filter, and
/// ten times the command latency of the simulated drives.
const SERVO_LAG_S: f64 = 0.02;

/// One kind of error, a row of an evaluation table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorKind {
    /// Name, one word.
    pub name: &'static str,
    /// Description with size.
    pub about: &'static str,
    /// This error only.
    pub errors: Errors,
}

impl Errors {
    /// No errors.
    pub const NONE: Self = Self {
        servo_stiffness: 0.0,
        link_m: 0.0,
        tip_stiffness: 0.0,
        crosstalk: 0.0,
        bias_n: 0.0,
        gain: 0.0,
        centre_of_mass_m: 0.0,
        position_m: 0.0,
        yaw_rad: 0.0,
        expected_width_m: 0.0,
        height_m: 0.0,
        servo_lag_s: 0.0,
        sensor: SensorErrors::NONE,
    };

    /// Default size of each error.
    pub(super) const SIZES: Self = Self {
        servo_lag_s: SERVO_LAG_S,
        sensor: SensorErrors::SIZES,
        ..Self::ALL
    };

    /// All errors, each with its size in [`Errors::KINDS`]; no servo lag and no [`SensorErrors`].
    pub const ALL: Self = Self {
        servo_stiffness: 0.10,
        link_m: 0.001,
        tip_stiffness: 0.20,
        crosstalk: 0.05,
        bias_n: 0.005,
        gain: 0.10,
        centre_of_mass_m: 0.005,
        position_m: 0.005,
        yaw_rad: 15.0 * PI / 180.0,
        expected_width_m: 0.004,
        height_m: 0.20,
        servo_lag_s: 0.0,
        sensor: SensorErrors::NONE,
    };

    /// Each kind of error alone.
    pub const KINDS: [ErrorKind; 11] = [
        ErrorKind {
            name: "servo",
            about: "servo stiffness ±10 %",
            errors: Self {
                servo_stiffness: Self::ALL.servo_stiffness,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "links",
            about: "link lengths ±1 mm",
            errors: Self {
                link_m: Self::ALL.link_m,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "tips",
            about: "fingertip stiffness ±20 %",
            errors: Self {
                tip_stiffness: Self::ALL.tip_stiffness,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "crosstalk",
            about: "crosstalk up to 5 % per element",
            errors: Self {
                crosstalk: Self::ALL.crosstalk,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "bias",
            about: "bias ±5 mN per element and axis",
            errors: Self {
                bias_n: Self::ALL.bias_n,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "gain",
            about: "gain ±10 % per fingertip",
            errors: Self {
                gain: Self::ALL.gain,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "centre-of-mass",
            about: "centre of mass up to 5 mm beside the grip",
            errors: Self {
                centre_of_mass_m: Self::ALL.centre_of_mass_m,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "position",
            about: "position ±5 mm",
            errors: Self {
                position_m: Self::ALL.position_m,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "yaw",
            about: "yaw ±15°",
            errors: Self {
                yaw_rad: Self::ALL.yaw_rad,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "expected-width",
            about: "expected widths wrong by up to 4 mm",
            errors: Self {
                expected_width_m: Self::ALL.expected_width_m,
                ..Self::NONE
            },
        },
        ErrorKind {
            name: "height",
            about: "objects up to 20 cm high",
            errors: Self {
                height_m: Self::ALL.height_m,
                ..Self::NONE
            },
        },
    ];

    /// Kinds of drive errors alone. `all` does not include them: the published tables do not.
    pub const DRIVE_KINDS: [ErrorKind; 1] = [ErrorKind {
        name: "servo-lag",
        about: "every servo follows its commands with a lag of 20 ms",
        errors: Self {
            servo_lag_s: SERVO_LAG_S,
            ..Self::NONE
        },
    }];

    /// Returns the kind of this name.
    #[must_use]
    pub fn kind_from_name(name: &str) -> Option<&'static ErrorKind> {
        let outside_all = Self::SENSOR_KINDS.iter().chain(&Self::DRIVE_KINDS);
        let mut kinds = Self::KINDS.iter().chain(outside_all);
        kinds.find(|kind| kind.name == name)
    }

    /// Rejects errors that cannot be simulated.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        for (what, value, upper) in [
            ("the servo stiffness error", self.servo_stiffness, 0.5),
            ("the link error in metres", self.link_m, 0.01),
            ("the tip stiffness error", self.tip_stiffness, 0.5),
            ("the crosstalk", self.crosstalk, 0.5),
            ("the bias in newtons", self.bias_n, 10.0),
            ("the gain error", self.gain, 0.5),
            (
                "the centre of mass error in metres",
                self.centre_of_mass_m,
                0.05,
            ),
            ("the position error in metres", self.position_m, 0.05),
            ("the yaw error in radians", self.yaw_rad, PI),
            (
                "the expected width error in metres",
                self.expected_width_m,
                0.05,
            ),
            ("the height in metres", self.height_m, 0.3),
            ("the servo lag in seconds", self.servo_lag_s, 1.0),
        ] {
            in_range(what, value, 0.0, upper)?;
        }
        self.sensor.check()
    }
}

impl Scene {
    /// Returns the scene with these errors. `seed` draws those of objects and nominal data; the
    /// world's seed draws those of robot and sensors.
    #[must_use]
    pub fn with_errors(&self, errors: &Errors, seed: u64) -> Self {
        let mut scene = self.clone();
        scene.errors = *errors;
        for (index, placed) in scene.objects.iter_mut().enumerate() {
            let before_m = placed.nominal.from_m[2];
            placed.apply_errors(errors, &mut Draws::new(seed, index));
            let raised_m = placed.nominal.from_m[2] - before_m;
            if let Some(place) = scene.place.as_mut().filter(|_| index == 0) {
                place.from_m[2] += raised_m;
                place.height_m = placed.nominal.height_m;
                place.width_m = placed.nominal.width_m;
            }
        }
        scene.align_cap_with_bottle();
        scene
    }
}

/// One random stream per error, so that each draw is independent of the other errors.
struct Draws {
    position: Random,
    yaw: Random,
    width: Random,
    height: Random,
    centre_of_mass: Random,
}

impl Draws {
    fn new(seed: u64, index: usize) -> Self {
        let kinds = 5;
        let stream =
            |kind: u64| Random::new(seed, stream::OBJECT_ERRORS + kinds * index as u64 + kind);
        Self {
            position: stream(0),
            yaw: stream(1),
            width: stream(2),
            height: stream(3),
            centre_of_mass: stream(4),
        }
    }
}

impl Placed {
    fn apply_errors(&mut self, errors: &Errors, draws: &mut Draws) {
        if errors.position_m > 0.0 {
            let [x_m, y_m, _] = self.nominal.from_m;
            let mut off = || {
                draws
                    .position
                    .between(-errors.position_m, errors.position_m)
            };
            self.position_m = [x_m + off(), y_m + off()];
        }
        if errors.yaw_rad > 0.0 {
            let off_rad = draws.yaw.between(-errors.yaw_rad, errors.yaw_rad);
            self.yaw_rad = self.nominal.yaw_rad + off_rad;
        }
        let told_m = draws.width.between(-1.0, 1.0) * errors.expected_width_m;
        self.nominal.width_m += told_m;
        let aside_m = draws.centre_of_mass.between(-1.0, 1.0) * errors.centre_of_mass_m;
        self.object.centre_of_mass_m.y += aside_m;
        if self.object.thread.is_none() && self.object.neck.is_none() {
            self.increase_height(errors.height_m, draws.height.uniform());
        }
    }

    /// Increases the height by this share of the difference to `height_m`, also in the nominal
    /// data.
    fn increase_height(&mut self, height_m: f64, share: f64) {
        let before = self.object.shape;
        let missing_m = (height_m - 2.0 * before.half_height_m()).max(0.0);
        let half_m = before.half_height_m() + missing_m * share / 2.0;
        self.object.shape = match before {
            Shape::Box {
                half_m: mut edges_m,
            } => {
                edges_m.z = half_m;
                Shape::Box { half_m: edges_m }
            }
            Shape::Cylinder { radius_m, .. } => Shape::Cylinder {
                radius_m,
                half_height_m: half_m,
            },
        };
        let GraspHint {
            from_m, height_m, ..
        } = &mut self.nominal;
        from_m[2] += grasp_height_m(&self.object.shape) - grasp_height_m(&before);
        *height_m += 2.0 * (half_m - before.half_height_m());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Object;
    use robot_model::HandSide;

    fn nominal_scene() -> Scene {
        Scene::pick_place(
            Object::built_in("wood").expect("built-in object"),
            HandSide::Right,
        )
    }

    #[test]
    fn no_errors_change_nothing() {
        let scene = nominal_scene().varied(3);
        assert_eq!(scene.with_errors(&Errors::NONE, 3), scene);
        assert_eq!(Errors::default(), Errors::NONE);
    }

    #[test]
    fn kinds_are_distinct_and_all_combines_them() {
        let (mut all, mut names) = (Errors::NONE, Vec::new());
        for kind in &Errors::KINDS {
            assert_ne!(kind.errors, Errors::NONE, "{}", kind.name);
            assert_eq!(Errors::kind_from_name(kind.name), Some(kind));
            names.push(kind.name);
            let (total, one) = (&mut all, &kind.errors);
            total.servo_stiffness += one.servo_stiffness;
            total.link_m += one.link_m;
            total.tip_stiffness += one.tip_stiffness;
            total.crosstalk += one.crosstalk;
            total.bias_n += one.bias_n;
            total.gain += one.gain;
            total.centre_of_mass_m += one.centre_of_mass_m;
            total.position_m += one.position_m;
            total.yaw_rad += one.yaw_rad;
            total.expected_width_m += one.expected_width_m;
            total.height_m += one.height_m;
            total.servo_lag_s += one.servo_lag_s;
        }
        assert_eq!(all, Errors::ALL);
        assert_eq!(Errors::kind_from_name("moon"), None);
    }

    /// Compares one error with all together, in fields that no other error affects.
    #[test]
    fn enabling_an_error_changes_no_other_draw() {
        let (one, all) = (
            Errors::kind_from_name("yaw").expect("known kind"),
            Errors::ALL,
        );
        let yaw = |errors: &Errors| nominal_scene().with_errors(errors, 5).objects[0].yaw_rad;
        assert_eq!(yaw(&one.errors), yaw(&all));
        assert_ne!(yaw(&one.errors), nominal_scene().objects[0].yaw_rad);
    }

    #[test]
    fn client_knows_the_height_but_not_the_position() {
        let tall = Errors {
            height_m: 0.2,
            position_m: 0.005,
            ..Errors::NONE
        };
        for seed in 0..50 {
            let scene = nominal_scene().with_errors(&tall, seed);
            let (placed, nominal_scene) = (&scene.objects[0], &nominal_scene().objects[0]);
            let hint = placed.nominal;
            let height_m = 2.0 * placed.object.shape.half_height_m();
            let own_m = 2.0 * nominal_scene.object.shape.half_height_m();
            assert!((own_m..=0.2).contains(&height_m), "{height_m} m");
            let foot_m = nominal_scene.nominal.height_m - own_m;
            assert!((hint.height_m - foot_m - height_m).abs() < 1e-12);
            assert!(hint.from_m[2] < hint.height_m - 0.009, "below its top");
            assert_eq!(hint.from_m[..2], nominal_scene.nominal.from_m[..2]);
            let off_m = placed.position_m[0] - hint.from_m[0];
            assert!(off_m.abs() <= 0.005 && off_m != 0.0);
        }
    }

    #[test]
    fn check_rejects_excessive_errors() {
        for errors in [
            Errors {
                crosstalk: f64::NAN,
                ..Errors::NONE
            },
            Errors {
                link_m: -0.001,
                ..Errors::NONE
            },
            Errors {
                servo_stiffness: 1.0,
                ..Errors::NONE
            },
        ] {
            let scene = Scene {
                errors,
                ..Scene::default()
            };
            assert!(scene.check().is_err(), "{errors:?}");
        }
    }
}
