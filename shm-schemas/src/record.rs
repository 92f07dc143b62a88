//! Records for bit-exact replay: the initial state of a run, and the inputs of every tick.
//!
//! The header is always published, because viewers use it as well. Tick inputs are published only
//! if the daemon was started with recording enabled, because a replay begins with the first tick. A
//! recorder that joins later misses the beginning, detects this by the sequence number, and must
//! report it.

use crate::capacity::{ELEMENTS, HANDS, JOINTS, LEVELS, SENSOR_BITS, SETTINGS, STEPS, TABLE_WORDS};
use crate::code::code;
use crate::frame::HandFrame;
use crate::goal::GoalRequest;
use crate::joints::{JointCommand, JointState};
use crate::payload::payload;
use crate::reason_record::ReasonRecord;
use crate::sensor_bit::SensorBit;
use crate::stamp::Stamp;
use crate::target::GraspTarget;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// Request from the supervisor to a tick.
    OrderKind as "atas.OrderKind.v1" {
        /// No request.
        NONE = 0, "none";
        /// Starts `goal`.
        START = 1, "start";
        /// Ends the goal `goal_id`.
        CANCEL = 2, "cancel";
        /// The client of the goal `goal_id` disconnected.
        CLIENT_GONE = 3, "client-gone";
        /// Stops and latches because of `reason`.
        STOP = 4, "stop";
        /// Leaves SAFE_STOP.
        RECOVER = 5, "recover";
        /// Sets the parameter at `index` to `value`.
        SET_PARAMETER = 6, "set-parameter";
        /// Replaces all settings by `settings`.
        CONFIGURE = 7, "configure";
        /// Takes the reading of the hand at `index` as zero force.
        BIAS = 8, "bias";
        /// Holds in this tick because of `reason`.
        HOLD = 9, "hold";
    }
}

payload! {
    /// All tunable parameters, in the order of the daemon's parameter table.
    SettingsRecord as "atas.SettingsRecord.v1" {
        /// FNV-1a 64 of the parameter names; values of another table are incompatible.
        pub names_hash: u64,
        /// Number of used entries in `value`, at most [`SETTINGS`].
        pub count: u32,
        /// Written as zero.
        pub pad: u32,
        /// Parameter values.
        pub value: [f64; SETTINGS],
    }
}

payload! {
    /// One step of a task. The numeric codes are defined in `tasks::words` of the crate `atas`.
    StepRecord as "atas.StepRecord.v1" {
        /// Display name.
        pub name: Text<16>,
        /// Motion of the hand.
        pub motion: u32,
        /// Waypoint of the motion, if it has one.
        pub waypoint: u32,
        /// Active modules: bit n stands for module number n.
        pub modules: u32,
        /// Condition that ends the step.
        pub transition: u32,
        /// Meeting point, for a step that ends at one.
        pub point: u32,
        /// Written as zero.
        pub pad: u32,
        /// Time limit, s; infinite for none.
        pub timeout_s: f64,
    }
}

payload! {
    /// Step sequence of one hand.
    TrackRecord as "atas.TrackRecord.v1" {
        /// Number of used entries in `steps`, at most [`STEPS`]; 0 for an idle hand.
        pub count: u32,
        /// Written as zero.
        pub pad: u32,
        /// Steps.
        pub steps: [StepRecord; STEPS],
    }
}

payload! {
    /// Behaviour table of a task (paper Table 1): one row per combination of sensor bits, one level
    /// per actuator and row.
    TableRecord as "atas.TableRecord.v1" {
        /// FNV-1a over all other fields; 0 if the task has no table.
        pub hash: u64,
        /// Number of used sensor bits, at most [`SENSOR_BITS`]; the first is the lowest bit of the
        /// row number.
        pub count: u32,
        /// Sensor bits.
        pub bits: [SensorBit; SENSOR_BITS],
        /// Written as zero.
        pub pad: u32,
        /// Closing speed of the fingers per level, m/s; negative opens.
        pub fingers_m_s: [f64; LEVELS],
        /// Factor on the path speed of the hand per level, −1 (backwards) to 1.
        pub hand: [f64; LEVELS],
        /// Four bits per row, row 0 lowest: finger level plus four times hand level.
        pub rows: [u64; TABLE_WORDS],
    }
}

payload! {
    /// Task of a goal: built-in or user-defined.
    TaskRecord as "atas.TaskRecord.v2" {
        /// Display name.
        pub name: Text<16>,
        /// Steps of the hand that the goal names.
        pub acting: TrackRecord,
        /// Steps of the other hand.
        pub helping: TrackRecord,
        /// Table of the module "behaviour table".
        pub table: TableRecord,
    }
}

payload! {
    /// One supervisor request. Only the fields that its kind uses are set; all others are zero.
    OrderRecord as "atas.OrderRecord.v5" {
        /// Kind of the request.
        pub kind: OrderKind,
        /// Index of a parameter or of a hand.
        pub index: u32,
        /// Goal of the request.
        pub goal_id: u64,
        /// Value of a parameter. For START: largest allowed offset of the grasp from the commanded
        /// position, m.
        pub value: f64,
        /// Reason of a stop or hold.
        pub reason: ReasonRecord,
        /// Goal to start.
        pub goal: GoalRequest,
        /// Task of that goal, as configured at that time.
        pub task: TaskRecord,
        /// New settings.
        pub settings: SettingsRecord,
    }
}

payload! {
    /// Inputs of one tick and the resulting command. A tick with several frames of a hand, or
    /// several targets, is split into consecutive parts.
    TickInputs as "atas.TickInputs.v7" {
        /// `sequence` counts the parts of all ticks from 0; `captured_ns` is the time of the tick.
        pub stamp: Stamp,
        /// Index of the tick; a gap means missed ticks.
        pub tick: u64,
        /// Index of this part, from 0. Fields that are not per frame are repeated in every part.
        pub part: u32,
        /// Number of parts of this tick.
        pub parts: u32,
        /// Per hand, 1 if this part has a frame.
        pub has_frame: [u32; HANDS],
        /// 1 if a joint state arrived.
        pub has_joints: u32,
        /// 1 if this part has a target.
        pub has_target: u32,
        /// Frame number `part` of each hand, as received, not validated.
        pub frames: [HandFrame; HANDS],
        /// Newest joint state, as received, not validated.
        pub joints: JointState,
        /// Target number `part`, as received, not validated.
        pub target: GraspTarget,
        /// Supervisor request processed in this tick.
        pub order: OrderRecord,
        /// Published command.
        pub command: JointCommand,
    }
}

payload! {
    /// Sensor set-up of one hand.
    HandWiringRecord as "atas.HandWiringRecord.v2" {
        /// Number of fingertips with sensors.
        pub fingers: u32,
        /// 1 if the robot must hold when frames of this hand stop arriving.
        pub required: u32,
        /// Nominal frame rate, Hz.
        pub rate_hz: f64,
        /// Number of elements of the layout, at most [`ELEMENTS`].
        pub element_count: u32,
        /// Written as zero.
        pub pad: u32,
        /// [`crate::Layout::normal`].
        pub normal: [[f64; 3]; ELEMENTS],
        /// [`crate::Layout::tangent1`].
        pub tangent1: [[f64; 3]; ELEMENTS],
        /// [`crate::Layout::tangent2`].
        pub tangent2: [[f64; 3]; ELEMENTS],
        /// [`crate::Layout::position_m`].
        pub position_m: [[f64; 3]; ELEMENTS],
        /// [`crate::Layout::element_area_m2`].
        pub element_area_m2: f64,
    }
}

payload! {
    /// Header of a run: everything that determines the controller's initial state.
    RunHeader as "atas.RunHeader.v2" {
        /// `captured_ns` is the start time of the daemon; the epoch is that of its commands.
        pub stamp: Stamp,
        /// Version of the daemon. Other versions may compute other commands.
        pub version: Text<32>,
        /// FNV-1a 64 of `config`.
        pub config_hash: u64,
        /// Robot: name of a shipped robot, or absolute path of its model file.
        pub robot: Text<256>,
        /// FNV-1a 64 of the URDF and robot file texts; 0 if the files are missing.
        pub robot_hash: u64,
        /// Tick rate, Hz.
        pub rate_hz: u32,
        /// [`crate::StatusFlags`].
        pub flags: u32,
        /// Nominal tick period, s.
        pub tick_s: f64,
        /// 1 if joint feedback exists.
        pub joints_required: u32,
        /// Written as zero.
        pub pad: u32,
        /// Servo stiffness of each joint of one hand, N·m/rad; zero in unused entries.
        pub stiffness: [f64; JOINTS],
        /// Per hand.
        pub hands: [HandWiringRecord; HANDS],
        /// Settings of the first tick. Later changes are supervisor requests.
        pub settings: SettingsRecord,
        /// Complete configuration as TOML, for readers only; a replay uses the other fields.
        pub config: Text<16384>,
    }
}
