//! What a recorder needs so that a run can be replayed bit for bit: how it began, and what every tick took in.
//!
//! The header is always published: whoever shows the robot needs it, too. What the ticks took in is only published when the daemon was
//! started with recording switched on, because a replay begins with the controller's first tick. A recorder that joins later
//! misses the beginning, sees that by the sequence, and must say so.

use crate::capacity::{ELEMENTS, HANDS, JOINTS, LEVELS, SENSOR_BITS, SETTINGS, STEPS, TABLE_WORDS};
use crate::code::code;
use crate::frame::HandFrame;
use crate::goal::GoalRequest;
use crate::joints::{JointCommand, JointState};
use crate::payload::payload;
use crate::reason::Reason;
use crate::sensor_bit::SensorBit;
use crate::stamp::Stamp;
use crate::target::GraspTarget;
use crate::text::Text;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// What a tick was told by the daemon's supervisor.
    OrderKind as "atas.OrderKind.v1" {
        /// Nothing.
        NONE = 0, "none";
        /// Start `goal`.
        START = 1, "start";
        /// End the goal `goal_id`.
        CANCEL = 2, "cancel";
        /// The client of the goal `goal_id` went away.
        CLIENT_GONE = 3, "client-gone";
        /// Stop and latch for `reason`.
        STOP = 4, "stop";
        /// Leave SAFE_STOP.
        RECOVER = 5, "recover";
        /// Set the parameter with this `index` to `value`.
        SET_PARAMETER = 6, "set-parameter";
        /// Replace all settings by `settings`.
        CONFIGURE = 7, "configure";
        /// Take the reading of the hand with this `index` as zero force.
        BIAS = 8, "bias";
        /// Hold in this tick for `reason`.
        HOLD = 9, "hold";
    }
}

payload! {
    /// Every tunable number, in the order of the daemon's table of parameters.
    SettingsRecord as "atas.SettingsRecord.v1" {
        /// FNV-1a 64 of the names: values of another table mean something else.
        pub names_hash: u64,
        /// Numbers that are used, at most [`SETTINGS`].
        pub count: u32,
        /// Written as zero.
        pub pad: u32,
        /// The numbers.
        pub value: [f64; SETTINGS],
    }
}

payload! {
    /// One step of a task. The numbers are those of the daemon's words for tasks (crate `atas`, `tasks::words`).
    StepRecord as "atas.StepRecord.v1" {
        /// Name, as users see it.
        pub name: Text<16>,
        /// How the hand moves.
        pub motion: u32,
        /// Where to, for a motion that has a waypoint.
        pub waypoint: u32,
        /// Which modules work: bit n stands for the module with the number n.
        pub modules: u32,
        /// When the step is done.
        pub transition: u32,
        /// Meeting point, for a step that ends at one.
        pub point: u32,
        /// Written as zero.
        pub pad: u32,
        /// When it has taken too long, s; infinite for never.
        pub timeout_s: f64,
    }
}

payload! {
    /// The steps of one hand.
    TrackRecord as "atas.TrackRecord.v1" {
        /// Steps that are used, at most [`STEPS`]; 0 for a hand that does nothing.
        pub count: u32,
        /// Written as zero.
        pub pad: u32,
        /// The steps.
        pub steps: [StepRecord; STEPS],
    }
}

payload! {
    /// The behaviour table of a task (paper Table 1): one row per combination of sensor bits, one level per actuator and row.
    TableRecord as "atas.TableRecord.v1" {
        /// FNV-1a over all other fields; 0 with no bits: the task has no table.
        pub hash: u64,
        /// Sensor bits that are used, at most [`SENSOR_BITS`]; the first is the lowest of the row's number.
        pub count: u32,
        /// Which bits.
        pub bits: [SensorBit; SENSOR_BITS],
        /// Written as zero.
        pub pad: u32,
        /// Closing speed of the fingers per level, m/s, negative opens.
        pub fingers_m_s: [f64; LEVELS],
        /// Factor on the hand's speed along its path per level, −1 (back) to 1.
        pub hand: [f64; LEVELS],
        /// Four bits per row, row 0 lowest: level of the fingers, then level of the hand times four.
        pub rows: [u64; TABLE_WORDS],
    }
}

payload! {
    /// What a goal made the hands do: a built-in task or a user's own.
    TaskRecord as "atas.TaskRecord.v2" {
        /// Name, as users see it.
        pub name: Text<16>,
        /// The hand that the goal names.
        pub acting: TrackRecord,
        /// The other hand.
        pub helping: TrackRecord,
        /// What the module "behaviour table" reads.
        pub table: TableRecord,
    }
}

payload! {
    /// One order; only what its kind names is used, the rest is zero.
    OrderRecord as "atas.OrderRecord.v5" {
        /// What is ordered.
        pub kind: OrderKind,
        /// Index of a parameter or of a hand.
        pub index: u32,
        /// Which goal.
        pub goal_id: u64,
        /// Value of a parameter; of a goal to start, how far its hands may grasp beside where they were told, m.
        pub value: f64,
        /// Why.
        pub reason: Reason,
        /// A goal to start.
        pub goal: GoalRequest,
        /// Its task, as the configuration had it then.
        pub task: TaskRecord,
        /// All settings.
        pub settings: SettingsRecord,
    }
}

payload! {
    /// What one tick took in, and the command that came out. A tick that took more than one frame of a hand, or more
    /// than one target, is told in several parts, one after the other.
    TickInputs as "atas.TickInputs.v7" {
        /// `sequence` counts the parts of all ticks since the start, from 0; `captured_ns` is the tick's time.
        pub stamp: Stamp,
        /// Index of the tick; a gap means missed ticks.
        pub tick: u64,
        /// Which part this is, from 0. What is not per frame stands in every part.
        pub part: u32,
        /// Parts of this tick.
        pub parts: u32,
        /// Per hand, 1 if this part has a frame.
        pub has_frame: [u32; HANDS],
        /// 1 if a joint state arrived.
        pub has_joints: u32,
        /// 1 if this part has a target.
        pub has_target: u32,
        /// Frame number `part` of each hand, as it came, unchecked.
        pub frames: [HandFrame; HANDS],
        /// The newest joint state, as it came, unchecked.
        pub joints: JointState,
        /// Target number `part`, as it came, unchecked.
        pub target: GraspTarget,
        /// The order that was taken.
        pub order: OrderRecord,
        /// The command that was published.
        pub command: JointCommand,
    }
}

payload! {
    /// One hand's sensor, as the controller is wired to it.
    HandWiringRecord as "atas.HandWiringRecord.v2" {
        /// Fingers that carry sensors.
        pub fingers: u32,
        /// 1 if the robot must hold when this hand is silent.
        pub required: u32,
        /// Nominal frame rate, Hz.
        pub rate_hz: f64,
        /// Elements of the layout, at most [`ELEMENTS`].
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
    /// How a run began: what the controller was made from.
    RunHeader as "atas.RunHeader.v2" {
        /// `captured_ns` is when the daemon started; the epoch is that of its commands.
        pub stamp: Stamp,
        /// Version of the daemon. Another version may compute another command.
        pub version: Text<32>,
        /// FNV-1a 64 of `config`.
        pub config_hash: u64,
        /// The robot: `built-in`, or the path of its URDF.
        pub robot: Text<256>,
        /// FNV-1a 64 of the URDF's text, 0 for the built-in robot.
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
        /// Servo stiffness of each joint of one hand, N·m/rad; zero where there is no joint.
        pub stiffness_n_m_rad: [f64; JOINTS],
        /// Per hand.
        pub hands: [HandWiringRecord; HANDS],
        /// The settings of the first tick. Later changes are orders.
        pub settings: SettingsRecord,
        /// The whole configuration as TOML, for people: what a replay needs of it stands in the other fields.
        pub config: Text<16384>,
    }
}
