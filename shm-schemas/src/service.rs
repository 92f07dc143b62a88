//! Service table: name, payload and messaging pattern of every service on the bus.
//!
//! Service names carry a version because a live observer keeps an old service alive.

/// Publish-subscribe, per hand: [`crate::HandFrame`], one publisher, at the sensor's rate.
pub const HAND_FRAME: [&str; 2] = ["atas/v2/hand-frame/left", "atas/v2/hand-frame/right"];
/// Publish-subscribe: [`crate::JointState`], one publisher, 1 kHz.
pub const JOINT_STATE: &str = "atas/v3/joint-state";
/// Publish-subscribe: [`crate::JointCommand`], one publisher (the daemon), every tick, closed set
/// of peers.
pub const JOINT_COMMAND: &str = "atas/v2/joint-command";
/// Request-response: [`crate::GoalRequest`] answered by a stream of [`crate::GoalUpdate`].
pub const GOAL: &str = "atas/v3/goal";
/// Request-response: [`crate::ControlRequest`] answered by one [`crate::ControlReply`].
pub const CONTROL: &str = "atas/v1/control";
/// Publish-subscribe: [`crate::GraspTarget`], one publisher (the client of a goal `teleop`), 1 to
/// 1,000 Hz for each hand.
pub const GRASP_TARGET: &str = "atas/v1/grasp-target";
/// Publish-subscribe: [`crate::Status`], 50 Hz, from the daemon's supervisor.
pub const STATUS: &str = "atas/v3/status";
/// Publish-subscribe: [`crate::TickReport`], one per tick, from the daemon's supervisor.
pub const TICK_REPORT: &str = "atas/v1/tick-report";
/// Publish-subscribe: [`crate::View`], about 60 Hz, from the daemon's supervisor.
pub const VIEW: &str = "atas/v2/view";
/// Publish-subscribe: [`crate::ModuleEvent`], on change, from the daemon's supervisor.
pub const MODULE_EVENT: &str = "atas/v1/module-event";
/// Publish-subscribe: [`crate::RunHeader`], once, from the daemon's supervisor.
pub const RUN_HEADER: &str = "atas/v2/run-header";
/// Publish-subscribe: [`crate::TickInputs`], every tick, from the daemon's supervisor while
/// recording.
pub const TICK_INPUTS: &str = "atas/v7/tick-inputs";
/// Publish-subscribe: [`crate::SensorStatus`], about 10 Hz, from each sensor process.
pub const SENSOR_STATUS: &str = "atas/v1/sensor-status";
/// Publish-subscribe: [`crate::WorldTruth`], from the simulator, for evaluation only; the daemon
/// never opens it.
pub const WORLD_TRUTH: &str = "atas/v3/world-truth";
/// Publish-subscribe: [`crate::AgentSensors`], one per field frame, from the field process.
pub const AGENT_SENSORS: &str = "atas/v1/agent-sensors";
/// Publish-subscribe: [`crate::WheelCommands`], one per field frame, from the agents process.
pub const WHEEL_COMMANDS: &str = "atas/v1/wheel-commands";
/// Publish-subscribe: [`crate::BaseState`], one per frame of a course, from the base or the
/// simulator.
pub const BASE_STATE: &str = "atas/v1/base-state";
/// Publish-subscribe: [`crate::BaseCommand`], one per frame of a course, from the coordinator.
pub const BASE_COMMAND: &str = "atas/v1/base-command";
/// Publish-subscribe: [`crate::ArenaTruth`], up to 60 Hz and at the end of every trial, from the
/// field process, for observers only; agents never open it.
pub const ARENA_TRUTH: &str = "atas/v2/arena-truth";

/// Every service with the name of its constant.
pub const NAMES: [(&str, &str); 20] = [
    ("HAND_FRAME_LEFT", HAND_FRAME[0]),
    ("HAND_FRAME_RIGHT", HAND_FRAME[1]),
    ("JOINT_STATE", JOINT_STATE),
    ("JOINT_COMMAND", JOINT_COMMAND),
    ("GOAL", GOAL),
    ("CONTROL", CONTROL),
    ("GRASP_TARGET", GRASP_TARGET),
    ("STATUS", STATUS),
    ("TICK_REPORT", TICK_REPORT),
    ("VIEW", VIEW),
    ("MODULE_EVENT", MODULE_EVENT),
    ("RUN_HEADER", RUN_HEADER),
    ("TICK_INPUTS", TICK_INPUTS),
    ("SENSOR_STATUS", SENSOR_STATUS),
    ("WORLD_TRUTH", WORLD_TRUTH),
    ("AGENT_SENSORS", AGENT_SENSORS),
    ("WHEEL_COMMANDS", WHEEL_COMMANDS),
    ("BASE_STATE", BASE_STATE),
    ("BASE_COMMAND", BASE_COMMAND),
    ("ARENA_TRUTH", ARENA_TRUTH),
];
