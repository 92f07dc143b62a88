//! Errors of the tactile sensors beyond gain, bias and crosstalk: effects of the sensor model, each
//! as one number, so that an evaluation can enable it alone.
//!
//! They are not part of [`Errors::KINDS`] and [`Errors::ALL`](super::Errors::ALL): the published
//! tables cover those kinds. A set error replaces the same effect of the scene's sensor model.

use super::{ErrorKind, Errors};
use crate::random::Random;
use crate::range::{OutOfRange, in_range};
use crate::sensor_model::{
    CreepModel, DeadModel, DeadReading, DriftModel, FrameModel, HysteresisModel, SensorModel,
    WearModel,
};

/// Full scale of a fingertip, N. Design choice: the largest force of the hand (tactile design).
const FULL_SCALE_N: f64 = 8.0;
/// Share of the elements that carry the force of a contact. Design choice: about eight of the 41
/// elements of a dome.
const LOADED_SHARE: f64 = 0.2;
/// Largest drift per fingertip, N. Design choice: a minute at the default rate.
const DRIFT_LIMIT_N: f64 = 3.0;

/// Sizes of the sensor errors; zero is off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorErrors {
    /// Rate of the zero drift of the normal force per fingertip, N/s, up to 3 N; each fingertip
    /// draws its own within ± this rate.
    pub drift_n_s: f64,
    /// Hysteresis, relative to the peak of a cycle.
    pub hysteresis: f64,
    /// Creep per decade of time, relative.
    pub creep_per_decade: f64,
    /// Largest reading of an element per axis, N.
    pub saturation_n: f64,
    /// Probability that an element is dead and reads zero.
    pub dead: f64,
    /// Loss of gain of all elements, relative.
    pub wear: f64,
    /// Latency of the frames, s.
    pub latency_s: f64,
    /// Additional latency, s; each frame draws its own from zero to this.
    pub jitter_s: f64,
    /// Probability that a frame is lost.
    pub frame_loss: f64,
}

impl SensorErrors {
    /// No errors.
    pub const NONE: Self = Self {
        drift_n_s: 0.0,
        hysteresis: 0.0,
        creep_per_decade: 0.0,
        saturation_n: 0.0,
        dead: 0.0,
        wear: 0.0,
        latency_s: 0.0,
        jitter_s: 0.0,
        frame_loss: 0.0,
    };

    /// Default size of each error.
    pub const SIZES: Self = Self {
        drift_n_s: 0.05,
        hysteresis: 0.05,
        creep_per_decade: 0.05,
        saturation_n: 0.5,
        dead: 0.05,
        wear: 0.20,
        latency_s: 0.005,
        jitter_s: 0.002,
        frame_loss: 0.05,
    };

    /// Returns the model with these errors for a fingertip; `random` draws its drift.
    pub(crate) fn apply(
        &self,
        model: &SensorModel,
        elements: usize,
        random: &mut Random,
    ) -> SensorModel {
        let mut model = model.clone();
        if self.drift_n_s > 0.0 {
            let rate_n_s = self.drift_n_s * random.between(-1.0, 1.0);
            model.drift = Some(DriftModel {
                rate_n_s: [rate_n_s, 0.0, 0.0],
                limit_n: DRIFT_LIMIT_N,
                from_s: 0.0,
            });
        }
        if self.hysteresis > 0.0 {
            let loaded = (LOADED_SHARE * elements as f64).max(1.0);
            model.hysteresis = Some(HysteresisModel {
                share: self.hysteresis,
                full_scale_n: [FULL_SCALE_N / loaded; 2],
            });
        }
        if self.creep_per_decade > 0.0 {
            let per_decade = self.creep_per_decade;
            model.creep = Some(CreepModel { per_decade });
        }
        if self.saturation_n > 0.0 {
            model.saturation_n = Some([self.saturation_n; 2]);
        }
        if self.dead > 0.0 {
            model.dead = Some(DeadModel {
                share: self.dead,
                reading: DeadReading::Zero,
                from_s: 0.0,
            });
        }
        if self.wear > 0.0 {
            model.wear = Some(WearModel {
                loss: self.wear,
                ..WearModel::default()
            });
        }
        model
    }

    /// Returns the transport of a model with these errors.
    pub(crate) fn apply_to_frames(&self, frames: &FrameModel) -> FrameModel {
        let or = |error: f64, of_model: f64| if error > 0.0 { error } else { of_model };
        FrameModel {
            latency_s: or(self.latency_s, frames.latency_s),
            jitter_s: or(self.jitter_s, frames.jitter_s),
            loss: or(self.frame_loss, frames.loss),
            stamp: frames.stamp,
        }
    }

    /// Rejects errors that cannot be simulated.
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        for (what, value, upper) in [
            (
                "the drift error in newtons per second",
                self.drift_n_s,
                100.0,
            ),
            ("the hysteresis error", self.hysteresis, 0.2),
            ("the creep error per decade", self.creep_per_decade, 0.5),
            ("the saturation error in newtons", self.saturation_n, 1e4),
            ("the share of dead elements", self.dead, 1.0),
            ("the wear error", self.wear, 1.0),
            ("the frame latency in seconds", self.latency_s, 0.5),
            ("the frame jitter in seconds", self.jitter_s, 0.5),
            ("the share of lost frames", self.frame_loss, 1.0),
        ] {
            in_range(what, value, 0.0, upper)?;
        }
        Ok(())
    }
}

/// Kind with one field of [`SensorErrors::SIZES`].
macro_rules! kind {
    ($name:literal, $field:ident, $about:literal) => {
        ErrorKind {
            name: $name,
            about: $about,
            errors: Errors {
                sensor: SensorErrors {
                    $field: SensorErrors::SIZES.$field,
                    ..SensorErrors::NONE
                },
                ..Errors::NONE
            },
        }
    };
}

impl Errors {
    /// Each kind of sensor error alone. `all` does not include them.
    pub const SENSOR_KINDS: [ErrorKind; 9] = [
        kind!(
            "drift",
            drift_n_s,
            "zero drift ±0.05 N/s per fingertip, up to 3 N"
        ),
        kind!(
            "hysteresis",
            hysteresis,
            "hysteresis of 5 % of the peak force"
        ),
        kind!("creep", creep_per_decade, "creep of 5 % per decade of time"),
        kind!(
            "saturation",
            saturation_n,
            "readings of an element limited to 0.5 N"
        ),
        kind!("dead", dead, "5 % of the elements read zero"),
        kind!("wear", wear, "gain of all elements reduced by 20 %"),
        kind!(
            "latency",
            latency_s,
            "frames arrive 5 ms late, stamped at arrival"
        ),
        kind!(
            "jitter",
            jitter_s,
            "frames arrive 0 to 2 ms late, stamped at arrival"
        ),
        kind!("frame-loss", frame_loss, "5 % of the frames are lost"),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Object, Scene, Sensed, World};
    use robot_model::{HandSide, RobotModel};

    #[test]
    fn kinds_have_one_error_each_and_unique_names() {
        let mut names: Vec<&str> = Errors::KINDS.iter().map(|kind| kind.name).collect();
        for kind in &Errors::SENSOR_KINDS {
            assert_ne!(kind.errors.sensor, SensorErrors::NONE, "{}", kind.name);
            let without = Errors {
                sensor: SensorErrors::NONE,
                ..kind.errors
            };
            assert_eq!(without, Errors::NONE, "{}", kind.name);
            assert_eq!(Errors::kind_from_name(kind.name), Some(kind));
            assert!(!names.contains(&kind.name), "{}", kind.name);
            names.push(kind.name);
        }
        assert_eq!(Errors::ALL.sensor, SensorErrors::NONE);
    }

    #[test]
    fn errors_replace_the_effects_of_a_valid_model() {
        let mut random = Random::new(1, 2);
        let plain = SensorModel::default();
        assert_eq!(SensorErrors::NONE.apply(&plain, 41, &mut random), plain);
        for elements in [1, 16, 41] {
            let model = SensorErrors::SIZES.apply(&plain, elements, &mut random);
            model.check().expect("valid model");
            let full_scale_n = model.hysteresis.expect("set").full_scale_n[0];
            assert!(full_scale_n > 0.9 && full_scale_n <= 8.0, "{full_scale_n}");
            let rate_n_s = model.drift.expect("set").rate_n_s[0];
            assert!(rate_n_s != 0.0 && rate_n_s.abs() <= 0.05, "{rate_n_s}");
        }
        let frames = SensorErrors::SIZES.apply_to_frames(&plain.frames);
        assert_eq!((frames.latency_s, frames.loss), (0.005, 0.05));
    }

    #[test]
    fn excessive_errors_are_rejected() {
        for sensor in [
            SensorErrors {
                hysteresis: 0.3,
                ..SensorErrors::NONE
            },
            SensorErrors {
                drift_n_s: f64::NAN,
                ..SensorErrors::NONE
            },
            SensorErrors {
                latency_s: -0.1,
                ..SensorErrors::NONE
            },
        ] {
            let errors = Errors {
                sensor,
                ..Errors::NONE
            };
            let scene = Scene {
                errors,
                ..Scene::default()
            };
            assert!(scene.check().is_err(), "{sensor:?}");
        }
    }

    /// Frames of the first ticks, in the given scene.
    fn frames(scene: &Scene) -> Vec<Option<shm_schemas::HandFrame>> {
        let robot = RobotModel::two_hand_arm().expect("built-in robot");
        let mut world = World::new(&robot, scene, 7).expect("valid scene");
        let mut sensed = Sensed::default();
        let mut frames = Vec::new();
        for _ in 0..50 {
            world.sense(&mut sensed);
            frames.extend(sensed.frames);
            world.advance(None);
        }
        frames
    }

    #[test]
    fn equal_models_sense_equal_bits() {
        let wood = Object::built_in("wood").expect("built-in object");
        let plain = Scene::grasp(wood, HandSide::Right);
        let scene = |sensor| {
            let errors = Errors {
                sensor,
                ..Errors::NONE
            };
            plain.with_errors(&errors, 7)
        };
        let bytes = |frames: &[Option<shm_schemas::HandFrame>]| format!("{frames:?}");
        let reference = bytes(&frames(&plain));
        assert_eq!(bytes(&frames(&scene(SensorErrors::NONE))), reference);
        let all = frames(&scene(SensorErrors::SIZES));
        assert_eq!(bytes(&frames(&scene(SensorErrors::SIZES))), bytes(&all));
        assert_ne!(bytes(&all), reference);
        assert!(all[..10].iter().all(Option::is_none), "latency of 5 ms");
    }
}
