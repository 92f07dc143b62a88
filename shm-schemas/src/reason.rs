//! Reasons: why something was refused, held or stopped, in a form that prints as one clear sentence.

use crate::code::code;
use crate::module::ModuleId;
use crate::payload::payload;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

code! {
    /// What went wrong.
    Cause as "atas.Cause.v1" {
        /// Nothing.
        NONE = 0, "none";
        /// A value of the goal is not finite.
        NOT_FINITE = 1, "not-finite";
        /// A value of the goal is out of its range.
        OUT_OF_RANGE = 2, "out-of-range";
        /// The position cannot be reached.
        UNREACHABLE = 3, "unreachable";
        /// The goal's kind, hand or policy is unknown.
        UNKNOWN_GOAL = 4, "unknown-goal";
        /// Another goal is active.
        BUSY = 5, "busy";
        /// The daemon is not ready: see its mode.
        NOT_READY = 6, "not-ready";
        /// The hand still holds an object.
        HAND_FULL = 7, "hand-full";
        /// The hand has no tactile sensor.
        NO_SENSOR = 8, "no-sensor";
        /// The two arms would come too near to each other.
        ARMS_COLLIDE = 9, "arms-collide";
        /// No object was touched on the way in.
        NOTHING_TOUCHED = 10, "nothing-touched";
        /// The object needs more force than the fingers may press with (`grasp.f2_max_n`).
        TOO_HEAVY = 11, "too-heavy";
        /// The object slipped out of the hand.
        LOST_OBJECT = 12, "lost-object";
        /// Force is at its ceiling and the object still slips while held.
        OUT_OF_FORCE = 13, "out-of-force";
        /// A step took longer than allowed.
        TIMED_OUT = 14, "timed-out";
        /// The client cancelled.
        CANCELLED = 15, "cancelled";
        /// The client of an attached goal went away.
        CLIENT_GONE = 16, "client-gone";
        /// Nothing carried the object where it should have been set down; the hand has lifted it again.
        NO_SUPPORT = 17, "no-support";
        /// A fingertip touched something while the hand moved freely; the hand has gone back.
        OBSTRUCTED = 18, "obstructed";
        /// The goal names a task that the configuration does not have.
        UNKNOWN_TASK = 19, "unknown-task";
        /// No tactile frame for too long.
        FRAMES_STOPPED = 20, "frames-stopped";
        /// A frame's stamp is too old.
        FRAME_STALE = 21, "frame-stale";
        /// A frame's stamp lies in the future.
        FRAME_FUTURE = 22, "frame-future";
        /// Too many frames were lost in a row.
        FRAMES_LOST = 23, "frames-lost";
        /// A frame failed its checksum.
        FRAME_CORRUPT = 24, "frame-corrupt";
        /// A frame came from a writer that is not the pinned one, or follows another layout.
        FRAME_FOREIGN = 25, "frame-foreign";
        /// Too many elements are invalid.
        ELEMENTS_INVALID = 26, "elements-invalid";
        /// The readings do not change any more although the counter advances.
        FRAMES_FROZEN = 27, "frames-frozen";
        /// The sensor process restarted in mid-task.
        SENSOR_RESTARTED = 28, "sensor-restarted";
        /// An object that is held slides through the fingers.
        SLIDING = 29, "sliding";
        /// No joint state for too long.
        JOINTS_STOPPED = 30, "joints-stopped";
        /// A joint state is not finite, out of range or jumps.
        JOINTS_INVALID = 31, "joints-invalid";
        /// A joint does not follow its command.
        FOLLOWING_ERROR = 32, "following-error";
        /// A command was not finite.
        COMMAND_NOT_FINITE = 33, "command-not-finite";
        /// A command jumped.
        COMMAND_STEP = 34, "command-step";
        /// A grip force rose above its ceiling.
        GRIP_CEILING = 35, "grip-ceiling";
        /// The robot process restarted.
        ROBOT_RESTARTED = 36, "robot-restarted";
        /// A fingertip's force cannot be: it is more than a hand can press.
        FORCE_IMPLAUSIBLE = 37, "force-implausible";
        /// An order that is not allowed now: the robot moves, or the hand is not empty.
        NOT_NOW = 38, "not-now";
        /// There is no robot to move: the daemon was told to sense only.
        SENSE_ONLY = 39, "sense-only";
        /// A module panicked.
        MODULE_PANICKED = 40, "module-panicked";
        /// The loop stood still for a while.
        LOOP_STALLED = 41, "loop-stalled";
        /// Stopped by a person: `atas estop`.
        ESTOP = 42, "estop";
        /// The daemon is shutting down.
        SHUTDOWN = 43, "shutdown";
        /// The daemon's supervisor, which takes orders and tells users, has been silent.
        SUPERVISOR_SILENT = 44, "supervisor-silent";
        /// Some elements of a fingertip keep their reading although frames keep coming: they are not believed.
        ELEMENT_STUCK = 45, "element-stuck";
        /// What a skin says that a hand presses, and what its joints bear, do not agree.
        FORCE_AGAINST_JOINTS = 46, "force-against-joints";
        /// The object needs more force than its stiffness bears (`grasp.compression_m`).
        TOO_SOFT = 50, "too-soft";
        /// The hand was found gripping something; it keeps it and watches it.
        GRIP_FOUND = 51, "grip-found";
        /// The object turned about the closing axis while it was held.
        TURNED_IN_HAND = 52, "turned-in-hand";
        /// The object slipped through the fingers on the way, and was held again.
        SLIPPED_IN_HAND = 53, "slipped-in-hand";
        /// The object needs more force than the goal allows ([`crate::GoalRequest`]).
        ABOVE_MAX_FORCE = 54, "above-max-force";
        /// The ways of the task are too long, or those of both hands together too many, to be checked.
        TASK_TOO_LONG = 60, "task-too-long";
        /// The robot has no such hand.
        NO_HAND = 61, "no-hand";
        /// The fingertips cannot pass each other, as turning a cap needs.
        CANNOT_TURN = 62, "cannot-turn";
        /// A client can lead only a hand whose robot file states a workspace.
        NO_WORKSPACE = 63, "no-workspace";
        /// The hand holds nothing that the task could go on with.
        HAND_EMPTY = 64, "hand-empty";
        /// Closed to this width, the jaws' domes would not face each other well enough to feel.
        DOMES_ASKEW = 65, "domes-askew";
        /// The client's stream of targets has ended or pauses: the hand stands and keeps what it holds.
        TARGETS_STOPPED = 70, "targets-stopped";
        /// A target failed its checksum.
        TARGET_CORRUPT = 71, "target-corrupt";
        /// A target comes from another writer than the one whose goal opened the stream.
        TARGET_FOREIGN = 72, "target-foreign";
        /// A target is older than the one before, was made before its goal began or ahead of time, or has expired.
        TARGET_STALE = 73, "target-stale";
        /// A target names a hand that its goal does not have, or an order that this version does not know.
        TARGET_UNKNOWN = 74, "target-unknown";
        /// A value of a target is not finite.
        TARGET_NOT_FINITE = 75, "target-not-finite";
        /// A value of a target is out of its range.
        TARGET_OUT_OF_RANGE = 76, "target-out-of-range";
        /// An arm stands across the middle, which both keep clear of while a client leads them.
        ACROSS_THE_MIDDLE = 77, "across-the-middle";
    }
}

payload! {
    /// A cause with the module that saw it and the value against its limit.
    Reason as "atas.Reason.v1" {
        /// What went wrong.
        pub cause: Cause,
        /// Which module saw it; [`ModuleId::NONE`] outside the modules.
        pub module: ModuleId,
        /// The value that broke the limit, in the unit that the sentence of [`Reason`]'s `Display` names.
        pub value: f64,
        /// The limit it broke.
        pub limit: f64,
        /// Which field, joint, finger or hand, by index; its meaning depends on the cause.
        pub index: u32,
        /// Written as zero.
        pub pad: u32,
    }
}

impl Reason {
    /// A cause without figures.
    #[must_use]
    pub fn of(cause: Cause) -> Self {
        Self {
            cause,
            ..Self::default()
        }
    }

    /// A cause with the value that broke a limit.
    #[must_use]
    pub fn limit(cause: Cause, value: f64, limit: f64) -> Self {
        Self {
            cause,
            value,
            limit,
            ..Self::default()
        }
    }

    /// The same reason, attributed to a module.
    #[must_use]
    pub fn by(self, module: ModuleId) -> Self {
        Self { module, ..self }
    }

    /// The same reason, about the joint, finger, hand or field with this index.
    #[must_use]
    pub fn about(self, index: usize) -> Self {
        Self {
            index: u32::try_from(index).unwrap_or(u32::MAX),
            ..self
        }
    }

    /// Whether there is anything to report.
    #[must_use]
    pub fn is_some(&self) -> bool {
        self.cause != Cause::NONE
    }
}
