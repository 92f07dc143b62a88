//! Configuration: turns TOML files and `--set` flags into a validated [`Config`], or into an error
//! that lists every invalid key with its location, value and permitted values.
//!
//! Values are merged by key, later ones win: built-in defaults, `/etc/atas/atas.toml`,
//! `/etc/atas/conf.d/*.toml` by name (or instead the `--config` files), `--set`. The file
//! `atas.example.toml` shows every key.
//!
//! * **Invariants:** a [`Config`] from [`Source::load`] is complete, finite and within all ranges.
//!   Unknown keys are rejected. [`Config::text`] contains all effective values and reads back to
//!   the same configuration.
//! * The bus name is not part of it, because all processes share it (`--bus`, `ATAS_BUS`).

mod document;
mod error;
mod keys;
mod layout;
mod source;
mod tasks;

pub use error::{ConfigError, Location, Problem};
pub use keys::{known_keys, suggested_parameter};
pub use layout::{CustomLayout, LayoutChoice};
pub use source::Source;
pub use tasks::{TaskProblem, Tasks};

use std::ffi::OsStr;
use std::path::PathBuf;

use atas_core::{HandSensorSetup, SensorSetup, Settings, settings};
use atas_process::configuration::GroupRight;
use robot_model::{HandModel, HandSide, ModelError, RobotModel, TWO_HAND_ARM};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

/// Complete configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Scheduling of the tick.
    pub realtime: Realtime,
    /// The robot.
    pub robot: Robot,
    /// The sensors.
    pub hands: Hands,
    /// Recording.
    pub recording: Recording,
    /// Rights of other users.
    pub access: Access,
    /// Acceptance of frames and joint states.
    pub intake: settings::Intake,
    /// Estimation of contact values from element forces.
    pub perception: settings::Perception,
    /// Modules 1, 2 and 3.
    pub grasp: settings::Grasp,
    /// Modules 0' and 4: placing.
    pub place: settings::Place,
    /// Modules 0 and 4: screwing.
    pub screw: settings::Screw,
    /// Teleoperation by a client.
    pub teleop: settings::Teleop,
    /// Motion of the hand.
    pub motion: settings::Motion,
    /// Safety gate.
    pub safety: settings::Safety,
    /// User tasks.
    #[serde(skip_serializing)]
    pub tasks: Tasks,
}

/// Recording of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recording {
    /// True if the inputs of every tick are published for a recorder.
    pub stream: bool,
    /// Folder of the flight recorder; empty for the service's own.
    pub flight_folder: String,
}

/// Rights of users other than the bus's. `atas-gate` reads them from the same files at each use.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Access {
    /// Members of group `atas`.
    pub group: GroupRight,
}

/// Treatment of missing real-time scheduling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RealtimeMode {
    /// The daemon does not start without it.
    Require,
    /// The daemon runs without it and reports `DEGRADED`.
    Try,
    /// Real-time scheduling is not requested.
    Off,
}

/// Scheduling of the tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Realtime {
    /// Real-time scheduling and memory locking.
    pub mode: RealtimeMode,
    /// `SCHED_FIFO` priority of the tick thread.
    pub priority: u32,
    /// Core of the tick thread.
    pub cpu: Cpu,
    /// Tick rate, Hz.
    pub rate_hz: u32,
    /// Maximum spin before a deadline, µs.
    pub spin_us: u32,
    /// True if the cores are kept out of slow idle states.
    pub keep_awake: bool,
    /// True if ticks align with the arrival of frames.
    pub phase_lock: bool,
    /// Initial estimate of the time from a frame's stamp to its arrival, µs.
    pub phase_offset_us: u32,
    /// Maximum time that a tick waits for a late frame, µs.
    pub arrival_wait_us: u32,
}

/// Choice of the core.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cpu {
    /// Core with this number.
    Core(u32),
    /// `"any"`: chosen by the kernel.
    Any(AnyCpu),
}

/// The word `any`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AnyCpu {
    /// `"any"`.
    Any,
}

/// The robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Robot {
    /// Name of a shipped robot, or path of a robot file.
    pub model: String,
    /// True if joint feedback exists; without it the daemon only senses.
    pub joints_required: bool,
}

/// The sensors of both hands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Hands {
    /// Left hand.
    pub left: HandSensor,
    /// Right hand.
    pub right: HandSensor,
}

/// Sensor of one hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandSensor {
    /// Arrangement of the elements.
    pub layout: LayoutChoice,
    /// Number of fingertips with sensors; 0: as in the robot file.
    pub fingers: usize,
    /// Nominal frame rate, Hz.
    pub rate_hz: f64,
    /// True if the robot must hold while this sensor is silent. A hand without a required sensor
    /// takes no goals.
    pub required: bool,
}

impl Default for Realtime {
    fn default() -> Self {
        Self {
            mode: RealtimeMode::Try,
            priority: 80,
            cpu: Cpu::Any(AnyCpu::Any),
            rate_hz: 1000,
            spin_us: 50,
            keep_awake: true,
            phase_lock: true,
            phase_offset_us: 40,
            arrival_wait_us: 200,
        }
    }
}

impl Default for Robot {
    fn default() -> Self {
        Self {
            model: TWO_HAND_ARM.name.to_string(),
            joints_required: true,
        }
    }
}

impl Default for HandSensor {
    fn default() -> Self {
        Self {
            layout: LayoutChoice::from_robot(),
            fingers: 0,
            rate_hz: 1000.0,
            required: true,
        }
    }
}

impl Config {
    /// Values that may change at run time.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            intake: self.intake,
            perception: self.perception,
            grasp: self.grasp,
            place: self.place,
            screw: self.screw,
            motion: self.motion,
            teleop: self.teleop,
            safety: self.safety,
        }
    }

    /// The configuration with other settings.
    #[must_use]
    pub fn with_settings(&self, settings: &Settings) -> Self {
        Self {
            intake: settings.intake,
            perception: settings.perception,
            grasp: settings.grasp,
            place: settings.place,
            screw: settings.screw,
            teleop: settings.teleop,
            motion: settings.motion,
            safety: settings.safety,
            ..self.clone()
        }
    }

    /// Sensor set-up of the controller of a robot.
    ///
    /// # Errors
    /// [`ConfigError`] for a layout that [`Source::load`] would reject.
    pub fn sensor_setup(
        &self,
        robot: &RobotModel,
        writer_epoch: u64,
    ) -> Result<SensorSetup, ConfigError> {
        let [left, right] = HandSide::BOTH.map(|side| robot.hand(side));
        Ok(SensorSetup {
            hands: [
                self.hands.left.sensor_setup(left, "hands.left.layout")?,
                self.hands.right.sensor_setup(right, "hands.right.layout")?,
            ],
            joints_required: self.robot.joints_required,
            tick_s: 1.0 / f64::from(self.realtime.rate_hz),
            writer_epoch,
        })
    }

    /// Loads the robot.
    ///
    /// # Errors
    /// [`ModelError`] if the robot does not exist or its files are inconsistent.
    pub fn robot_model(&self) -> Result<RobotModel, ModelError> {
        RobotModel::find(&self.robot.model)
    }

    /// The effective configuration as TOML.
    #[must_use]
    pub fn text(&self) -> String {
        // All fields are numbers, words, truth values or arrays of them, which TOML can represent.
        toml::to_string(self).unwrap_or_default() + &self.tasks.text()
    }

    /// FNV-1a 64 of [`Config::text`].
    #[must_use]
    pub fn hash(&self) -> u64 {
        fnv1a(FNV_OFFSET, self.text().as_bytes())
    }
}

impl HandSensor {
    fn sensor_setup(&self, hand: &HandModel, key: &str) -> Result<HandSensorSetup, ConfigError> {
        let unsound = || {
            let (key, value) = (key.to_owned(), format!("{:?}", self.layout));
            let needs = keys::permitted_values(&key).unwrap_or_default();
            ConfigError(vec![Problem::InvalidValue {
                place: None,
                key,
                value,
                needs,
            }])
        };
        let fingers = match self.fingers {
            0 => hand.fingertip_count().max(1),
            fingers => fingers,
        };
        Ok(HandSensorSetup {
            layout: self.layout.resolve(hand).ok_or_else(unsound)?,
            fingers,
            required: self.required && hand.is_present(),
            rate_hz: self.rate_hz,
        })
    }
}

impl Recording {
    /// Folder of the flight recorder: the configured one, else `flight` in the service manager's
    /// state folder (`$STATE_DIRECTORY`), else none.
    #[must_use]
    pub fn flight_folder(&self, state_directory: Option<&OsStr>) -> Option<PathBuf> {
        if !self.flight_folder.is_empty() {
            return Some(self.flight_folder.clone().into());
        }
        // Several folders are separated by colons.
        let state = std::env::split_paths(state_directory?).next()?;
        Some(state.join("flight"))
    }
}
