//! Configuration: TOML files and `--set` flags go in, a checked [`Config`] comes out, or an error that names every
//! wrong key with its place, its value and what it needs.
//!
//! Values are merged key by key, later over earlier: built-in defaults, `/etc/atas/atas.toml`,
//! `/etc/atas/conf.d/*.toml` in the order of their names (or the `--config` files instead of those), then `--set`.
//! The file `atas.example.toml` shows every key.
//!
//! * **Invariants:** a [`Config`] from [`Source::load`] is complete, finite and within every range. Unknown keys are
//!   refused. [`Config::text`] says everything that is in force, and reading it back gives the same configuration.
//! * **Absent on purpose:** the name of the bus, which every process on it must share (`--bus`, `ATAS_BUS`).

mod document;
mod error;
mod keys;
mod layout;
mod source;
mod tasks;

pub use error::{ConfigError, Place, Problem};
pub use keys::{known_keys, nearest_parameter};
pub use layout::{CustomLayout, LayoutChoice};
pub use source::Source;
pub use tasks::{TaskProblem, Tasks};

use std::ffi::OsStr;
use std::path::PathBuf;

use atas_core::{HandWiring, Settings, Wiring, settings};
use atas_process::configuration::GroupRight;
use robot_model::{HandModel, ModelError, RobotModel, Side, TWO_HAND_ARM};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

/// Everything that can be configured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Scheduling of the tick.
    pub realtime: Realtime,
    /// The robot.
    pub robot: Robot,
    /// The sensors.
    pub hands: Hands,
    /// What is kept of a run.
    pub recording: Recording,
    /// Who besides the bus's user may do what.
    pub access: Access,
    /// Which frames and joint states are believed.
    pub intake: settings::Intake,
    /// From element forces to what a fingertip feels.
    pub perception: settings::Perception,
    /// Modules 1, 2 and 3.
    pub grasp: settings::Grasp,
    /// Modules 0' and 4: placing.
    pub place: settings::Place,
    /// Modules 0 and 4: screwing.
    pub screw: settings::Screw,
    /// Following a client's targets.
    pub follow: settings::Follow,
    /// How the hand moves.
    pub motion: settings::Motion,
    /// The last gate.
    pub safety: settings::Safety,
    /// The user's own tasks.
    #[serde(skip_serializing)]
    pub tasks: Tasks,
}

/// What is kept of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recording {
    /// Whether every tick's inputs are published, for a recorder.
    pub stream: bool,
    /// Folder of the flight recorder; empty for the service's own.
    pub flight_folder: String,
}

/// Who besides the bus's user may do what. Read by `atas-gate` from the same files, at each use; checked here.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Access {
    /// Members of group `atas`.
    pub group: GroupRight,
}

/// Whether the daemon insists on real-time scheduling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RealtimeMode {
    /// It does not start without.
    Require,
    /// It runs without, and says so (`DEGRADED`).
    Try,
    /// It does not ask.
    Off,
}

/// Scheduling of the tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Realtime {
    /// What to do about real-time scheduling and memory locking.
    pub mode: RealtimeMode,
    /// `SCHED_FIFO` priority of the tick thread.
    pub priority: u32,
    /// Core of the tick thread.
    pub cpu: Cpu,
    /// Tick rate, Hz.
    pub rate_hz: u32,
    /// Longest spin before a deadline, µs.
    pub spin_us: u32,
    /// Whether the cores are kept from idle states that they wake up from slowly.
    pub keep_awake: bool,
    /// Whether ticks follow the frames.
    pub phase_lock: bool,
    /// First guess of the time from a frame's stamp to its arrival, µs.
    pub phase_offset_us: u32,
    /// Longest time that a tick awaits a frame beyond its usual arrival, µs.
    pub arrival_wait_us: u32,
}

/// A core, or any.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cpu {
    /// The core with this number.
    Core(u32),
    /// `"any"`: the kernel chooses.
    Any(AnyWord),
}

/// The word `any`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AnyWord {
    /// `"any"`.
    Any,
}

/// The robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Robot {
    /// Name of a robot that ships, or path of a robot file.
    pub model: String,
    /// Whether joint feedback exists; without it the daemon senses and never moves anything.
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

/// One hand's sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandSensor {
    /// Where the elements sit.
    pub layout: LayoutChoice,
    /// Fingers that carry sensors; 0: as many as the robot has there.
    pub fingers: usize,
    /// Nominal frame rate, Hz.
    pub rate_hz: f64,
    /// Whether the robot must hold when this sensor is silent. A hand without a required sensor takes no goals.
    pub required: bool,
}

impl Default for Realtime {
    fn default() -> Self {
        Self {
            mode: RealtimeMode::Try,
            priority: 80,
            cpu: Cpu::Any(AnyWord::Any),
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
            layout: LayoutChoice::of_robot(),
            fingers: 0,
            rate_hz: 1000.0,
            required: true,
        }
    }
}

impl Config {
    /// The numbers that may change while the daemon runs.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            intake: self.intake,
            perception: self.perception,
            grasp: self.grasp,
            place: self.place,
            screw: self.screw,
            motion: self.motion,
            follow: self.follow,
            safety: self.safety,
        }
    }

    /// The same configuration with other settings.
    #[must_use]
    pub fn with_settings(&self, settings: &Settings) -> Self {
        Self {
            intake: settings.intake,
            perception: settings.perception,
            grasp: settings.grasp,
            place: settings.place,
            screw: settings.screw,
            follow: settings.follow,
            motion: settings.motion,
            safety: settings.safety,
            ..self.clone()
        }
    }

    /// What the controller of a robot is wired to.
    ///
    /// # Errors
    /// [`ConfigError`] for a layout that [`Source::load`] would have refused.
    pub fn wiring(&self, robot: &RobotModel, writer_epoch: u64) -> Result<Wiring, ConfigError> {
        let [left, right] = Side::BOTH.map(|side| robot.hand(side));
        Ok(Wiring {
            hands: [
                self.hands.left.wiring(left, "hands.left.layout")?,
                self.hands.right.wiring(right, "hands.right.layout")?,
            ],
            joints_required: self.robot.joints_required,
            tick_s: 1.0 / f64::from(self.realtime.rate_hz),
            writer_epoch,
        })
    }

    /// Loads the robot.
    ///
    /// # Errors
    /// [`ModelError`] if there is no such robot, or its files do not fit.
    pub fn robot_model(&self) -> Result<RobotModel, ModelError> {
        RobotModel::find(&self.robot.model)
    }

    /// The effective configuration as TOML.
    #[must_use]
    pub fn text(&self) -> String {
        // Every field is a number, a word, a truth value or an array of those, which TOML can always write.
        toml::to_string(self).unwrap_or_default() + &self.tasks.text()
    }

    /// FNV-1a 64 of [`Config::text`].
    #[must_use]
    pub fn hash(&self) -> u64 {
        fnv1a(FNV_OFFSET, self.text().as_bytes())
    }
}

impl HandSensor {
    fn wiring(&self, hand: &HandModel, key: &str) -> Result<HandWiring, ConfigError> {
        let unsound = || {
            let (key, value) = (key.to_owned(), format!("{:?}", self.layout));
            let needs = keys::needs(&key).unwrap_or_default();
            ConfigError(vec![Problem::Value {
                place: None,
                key,
                value,
                needs,
            }])
        };
        let fingers = match self.fingers {
            0 => hand.finger_count().max(1),
            fingers => fingers,
        };
        Ok(HandWiring {
            layout: self.layout.resolve(hand).ok_or_else(unsound)?,
            fingers,
            required: self.required && hand.is_present(),
            rate_hz: self.rate_hz,
        })
    }
}

impl Recording {
    /// Folder of the flight recorder: the configured one, else `flight` in the state folder that a service manager gives
    /// (`$STATE_DIRECTORY`), else none.
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
