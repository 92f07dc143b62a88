//! Reasons for a rejection, a hold or a stop, as typed values. [`ReasonRecord`] is their wire form.
//!
//! A new reason is one row of the table below, with its text, and a [`Cause`].

use crate::body::BodyPair;
use crate::cause::Cause;
use crate::fields::{GoalField, TargetField};
use crate::goal::GoalKind;
use crate::joints::Mode;
use crate::module::ModuleId;
use crate::reason_parts::{
    Joints, collision_text, goal_text, mm, ms, number, silence_text, unreachable_text,
};
use crate::reason_record::ReasonRecord;
use crate::stamp::Hand;
use crate::wire_value::WireValue;
use core::fmt::{self, Formatter};

/// Declares [`Reason`], its conversions and its texts from one table: variant, cause on the wire,
/// values with their places in the [`ReasonRecord`], and text. `at` and `if` separate variants that
/// share a cause: by a fixed index and by a condition.
macro_rules! reasons {
    (|$joints:ident| $($variant:ident = $cause:ident $(at $index:ident)? $(if $condition:ident)?
        $({ $($field:ident: $type:ty = $place:ident),* $(,)? })?
        => $text:literal $(, $shown:expr)*;)*) => {
        /// Reason for a rejection, a hold or a stop. Prints as one sentence with value and limit.
        ///
        /// Each variant has the values that its [`Cause`] needs. Names give the unit; a `value` or
        /// `limit` without unit is in the SI unit of its field or joint. `module` is the module
        /// that reports the reason, or [`ModuleId::NONE`].
        ///
        /// ```
        /// use shm_schemas::{Cause, GoalField, Reason, ReasonRecord};
        ///
        /// let reason = Reason::Unreachable { field: GoalField::FROM_X, value: 0.55, limit: 0.40 };
        /// assert!(reason.to_string().contains("from x is 0.5500 m, the limit is 0.4000 m"));
        ///
        /// let record = ReasonRecord::from(reason);
        /// assert_eq!((record.cause, record.value, record.index), (Cause::UNREACHABLE, 0.55, 0));
        /// assert_eq!(Reason::from(record), reason);
        /// ```
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(from = "ReasonRecord", into = "ReasonRecord"))]
        pub enum Reason {
            /// No reason.
            #[default]
            None,
            $(
                #[doc = concat!("Reason with the cause [`Cause::", stringify!($cause), "`].")]
                $variant $({ $(
                    #[doc = concat!("Stored in [`ReasonRecord::", stringify!($place), "`].")]
                    $field: $type,
                )* })?,
            )*
            /// Reason with a cause that this version does not know, as received.
            Unknown(ReasonRecord),
        }

        impl From<Reason> for ReasonRecord {
            fn from(reason: Reason) -> Self {
                match reason {
                    Reason::None => Self::default(),
                    $(Reason::$variant $({ $($field),* })? => Self {
                        cause: Cause::$cause,
                        $(index: $index,)?
                        $($($place: $field.to_wire(),)*)?
                        ..Self::default()
                    },)*
                    Reason::Unknown(record) => record,
                }
            }
        }

        impl From<ReasonRecord> for Reason {
            /// Drops values that the cause does not use. Never fails: an unknown cause becomes
            /// [`Reason::Unknown`].
            fn from(record: ReasonRecord) -> Self {
                match record.cause {
                    Cause::NONE => Self::None,
                    $(Cause::$cause
                        $(if record.index == $index)?
                        $(if $condition(&record))? => Self::$variant $({
                            $($field: WireValue::from_wire(record.$place),)*
                        })?,)*
                    _ => Self::Unknown(record),
                }
            }
        }

        impl Reason {
            /// Writes the text without the module.
            #[allow(unused_variables, reason = "a text may leave out a value")]
            pub(crate) fn write(self, $joints: Joints<'_>, f: &mut Formatter<'_>) -> fmt::Result {
                match self {
                    Self::None => f.write_str("nothing to report"),
                    $(Self::$variant $({ $($field),* })? => write!(f, $text $(, $shown)*),)*
                    Self::Unknown(ReasonRecord { cause, value, limit, .. }) => {
                        write!(f, "{cause}: value {value}, limit {limit}")
                    }
                }
            }
        }
    };
}

reasons! { |joints|
    NotFinite = NOT_FINITE { field: GoalField = index } =>
        "{field} of the goal is not finite; send finite numbers";
    OutOfRange = OUT_OF_RANGE {
        field: GoalField = index, value: f64 = value, limit: f64 = limit,
    } =>
        "{field} of the goal is {}, the limit is {}; choose a value within it",
        field.with_unit(value), field.with_unit(limit);
    NoPosture = UNREACHABLE if is_posture_error {
        place: GoalField = index, error_m: f64 = value,
    } =>
        "no arm posture for the place {:?} with this yaw, width and lift: the fingertips stay \
         {:.1} mm off; move the place or turn the closing axis", place.place(), mm(error_m);
    Unreachable = UNREACHABLE {
        field: GoalField = index, value: f64 = value, limit: f64 = limit,
    } =>
        "{}", unreachable_text(field, value, limit);
    UnknownGoal = UNKNOWN_GOAL { field: u32 = index, code: u32 = value } =>
        "field {field} of the goal has the unknown code {code}; update the client";
    Busy = BUSY { active: Option<GoalKind> = value } =>
        "{} is active; wait for it or cancel it", goal_text(active);
    NotReady = NOT_READY { mode: Mode = value } =>
        "the daemon is in mode {mode}, needs ready; see `atas status`";
    HandFull = HAND_FULL { hand: Hand = index } =>
        "the {hand} hand still holds an object; release it first with `atas release --hand {hand}`";
    NoSensor = NO_SENSOR { hand: Hand = index } =>
        "the {hand} hand has no tactile sensor in the configuration; use the other hand";
    ArmsCollide = ARMS_COLLIDE {
        bodies: Option<BodyPair> = index, gap_m: f64 = value, limit_m: f64 = limit,
    } =>
        "{}", collision_text(bodies, gap_m, limit_m);
    NothingTouched = NOTHING_TOUCHED {
        width_m: f64 = value, limit_m: f64 = limit, module: ModuleId = module,
    } =>
        "closed to {:.1} mm and touched nothing; is the object there?", mm(width_m);
    TooHeavy = TOO_HEAVY {
        force_n: f64 = value, limit_n: f64 = limit, module: ModuleId = module,
    } =>
        "object too heavy: not held with {force_n:.2} N, the limit is {limit_n:.2} N \
         (`grasp.f2_max_n`)";
    LostObject = LOST_OBJECT { force_n: f64 = value, limit_n: f64 = limit } =>
        "the hand no longer feels the object: force {force_n:.2} N, needs {limit_n:.2} N";
    OutOfForce = OUT_OF_FORCE {
        force_n: f64 = value, limit_n: f64 = limit, module: ModuleId = module,
    } =>
        "still slipping at {force_n:.2} N, the force limit F_2 is {limit_n:.2} N: the load is too \
         high";
    TimedOut = TIMED_OUT { elapsed_s: f64 = value, limit_s: f64 = limit } =>
        "took {elapsed_s:.1} s, allowed {limit_s:.1} s";
    Cancelled = CANCELLED => "cancelled by the client";
    ClientGone = CLIENT_GONE => "the client of this attached goal disconnected";
    NoSupport = NO_SUPPORT {
        height_m: f64 = value, expected_m: f64 = limit, module: ModuleId = module,
    } =>
        "no support found down to {:.1} mm, expected at {:.1} mm; the hand keeps the object",
        mm(height_m), mm(expected_m);
    Obstructed = OBSTRUCTED {
        fingertip: usize = index, force_n: f64 = value, limit_n: f64 = limit,
        module: ModuleId = module,
    } =>
        "finger {} touched an obstacle at {force_n:.2} N, the limit is {limit_n:.2} N; clear the \
         path or grasp nearer to the object's top", number(fingertip);
    UnknownTask = UNKNOWN_TASK =>
        "the daemon's configuration has no task of this name; `atasd --check-config` lists the \
         configured tasks";
    FramesStopped = FRAMES_STOPPED {
        hand: Hand = index, age_ns: Option<f64> = value, limit_ns: f64 = limit,
    } =>
        "no tactile frame of hand {hand} {}; is the sensor process running?",
        silence_text(age_ns, limit_ns);
    FrameStale = FRAME_STALE { hand: Hand = index, age_ns: f64 = value, limit_ns: f64 = limit } =>
        "the newest frame of hand {hand} is {:.1} ms old, allowed {:.1} ms",
        ms(age_ns), ms(limit_ns);
    FrameFuture = FRAME_FUTURE {
        hand: Hand = index, ahead_ns: f64 = value, limit_ns: f64 = limit,
    } =>
        "a frame of hand {hand} is stamped {:.1} ms ahead, allowed {:.1} ms; use CLOCK_MONOTONIC \
         of this machine", ms(ahead_ns), ms(limit_ns);
    FramesLost = FRAMES_LOST { hand: Hand = index, lost: u64 = value, limit: f64 = limit } =>
        "{lost} frames of hand {hand} lost in a row, allowed {limit}";
    FrameCorrupt = FRAME_CORRUPT { hand: Hand = index, corrupt: u64 = value } =>
        "{corrupt} frames of hand {hand} failed their checksum";
    FrameForeign = FRAME_FOREIGN { hand: Hand = index } =>
        "a frame of hand {hand} comes from another writer or follows another layout than \
         configured";
    ElementsInvalid = ELEMENTS_INVALID {
        hand: Hand = index, share: f64 = value, limit: f64 = limit,
    } =>
        "{:.0} % of the elements of hand {hand} are invalid, allowed {:.0} %",
        share * 100.0, limit * 100.0;
    FramesFrozen = FRAMES_FROZEN {
        hand: Hand = index, identical: u32 = value, limit: f64 = limit,
    } =>
        "the readings of hand {hand} have not changed for {identical} frames, allowed {limit}";
    SensorRestarted = SENSOR_RESTARTED { hand: Hand = index } =>
        "the sensor process of hand {hand} restarted";
    Sliding = SLIDING { slip_s: f64 = value, limit_s: f64 = limit } =>
        "the object has been sliding between the fingertips for {slip_s:.2} s, allowed \
         {limit_s:.2} s";
    JointsStopped = JOINTS_STOPPED { age_ns: Option<f64> = value, limit_ns: f64 = limit } =>
        "no joint state {}; is the robot process running?", silence_text(age_ns, limit_ns);
    JointCount = JOINTS_INVALID at NO_JOINT { count: u32 = value, expected: u32 = limit } =>
        "a joint state has {count} joints, the robot has {expected}; start robot process and \
         daemon with the same robot";
    JointsInvalid = JOINTS_INVALID {
        joint: usize = index, position: f64 = value, last: f64 = limit,
    } =>
        "joint {} reports {}, last valid position {}",
        joints.name(joint), joints.with_unit(position), joints.with_unit(last);
    FollowingError = FOLLOWING_ERROR {
        joint: usize = index, error: f64 = value, limit: f64 = limit,
    } =>
        "joint {} is {} off its command, allowed {}; is it blocked?",
        joints.name(joint), joints.with_unit(error), joints.with_unit(limit);
    CommandNotFinite = COMMAND_NOT_FINITE { joint: usize = index } =>
        "the command for joint {} was not finite", joints.name(joint);
    CommandStep = COMMAND_STEP { joint: usize = index, step: f64 = value, limit: f64 = limit } =>
        "the command for joint {} jumped by {}, allowed {}",
        joints.name(joint), joints.with_unit(step), joints.with_unit(limit);
    GripCeiling = GRIP_CEILING {
        side: usize = index, force_n: f64 = value, limit_n: f64 = limit,
    } =>
        "grip force {force_n:.2} N of grasp side {} exceeds its limit {limit_n:.2} N", number(side);
    RobotRestarted = ROBOT_RESTARTED =>
        "the robot process restarted; the goal has ended, the hands keep their grip";
    ForceImplausible = FORCE_IMPLAUSIBLE {
        hand: Hand = index, force_n: f64 = value, limit_n: f64 = limit,
    } =>
        "a fingertip of the {hand} hand reports {force_n:.2} N, the plausible maximum is \
         {limit_n:.2} N; check the sensor, or zero it with an empty hand (`atas zero`)";
    NotNow = NOT_NOW =>
        "not now: zeroing needs mode ready and an empty hand, a change of `[safety]` needs a \
         stopped robot (`atas estop`)";
    SenseOnly = SENSE_ONLY =>
        "sense-only mode: the daemon commands no robot because robot.joints_required is false";
    ModulePanicked = MODULE_PANICKED => "a module panicked; restart the daemon and report this";
    LoopStalled = LOOP_STALLED { stalled_ns: f64 = value, limit_ns: f64 = limit } =>
        "the loop stood still for {:.1} ms, allowed {:.1} ms", ms(stalled_ns), ms(limit_ns);
    Estop = ESTOP => "stopped by `atas estop`; `atas recover` re-arms";
    Shutdown = SHUTDOWN => "the daemon is shutting down";
    SupervisorSilent = SUPERVISOR_SILENT { silent_s: f64 = value, limit_s: f64 = limit } =>
        "the daemon's supervisor has not responded for {silent_s:.1} s, allowed {limit_s:.1} s";
    ElementStuck = ELEMENT_STUCK {
        hand: Hand = index, fingertip: usize = limit, element: u32 = value,
    } =>
        "element {element} of finger {} of the {hand} hand is stuck: its reading is constant; it \
         is masked until the reading changes", number(fingertip);
    ForceAgainstJoints = FORCE_AGAINST_JOINTS {
        hand: Hand = index, tactile_n: f64 = value, joint_estimated_n: f64 = limit,
    } =>
        "tactile force {tactile_n:.2} N and joint-estimated force {joint_estimated_n:.2} N of the \
         {hand} hand disagree; does the zero drift? The hand keeps its grip; take the object, then \
         `atas estop`, `atas recover`, `atas zero`";
    ForceAgainstOpening = FORCE_AGAINST_OPENING {
        hand: Hand = index, force_n: f64 = value, lift_force_n: f64 = limit,
    } =>
        "the {hand} hand reports a grip force of {force_n:.2} N, after {lift_force_n:.2} N at the \
         lift; its opening does not explain the difference; does the zero drift? Take the object, \
         then `atas zero`";
    TooSoft = TOO_SOFT { force_n: f64 = value, limit_n: f64 = limit, module: ModuleId = module } =>
        "object too heavy for its stiffness: not held with {force_n:.2} N, the limit F_2 is \
         {limit_n:.2} N";
    GripFound = GRIP_FOUND { hand: Hand = index, force_n: f64 = value, limit_n: f64 = limit } =>
        "the {hand} hand was gripping with {force_n:.2} N when the daemon started; it keeps its \
         grip with up to {limit_n:.2} N; `atas release --hand {hand}` opens it";
    TurnedInHand = TURNED_IN_HAND { lever_m: f64 = value, lever_before_m: f64 = limit } =>
        "the object turned in the hand: lever arm of its weight {:.1} mm, before {:.1} mm; grasp \
         nearer to its centre of mass", mm(lever_m), mm(lever_before_m);
    SlippedInHand = SLIPPED_IN_HAND { slip_m: f64 = value, limit_m: f64 = limit } =>
        "the object slipped in the hand by about {:.1} mm, allowed {:.1} mm; the hand keeps its \
         grip", mm(slip_m), mm(limit_m);
    AboveMaxForce = ABOVE_MAX_FORCE {
        force_n: f64 = value, limit_n: f64 = limit, module: ModuleId = module,
    } =>
        "object not held with {force_n:.2} N, the goal allows {limit_n:.2} N (`--max-force`)";
    TaskTooLong = TASK_TOO_LONG { postures: u32 = value, limit: u32 = limit } =>
        "the paths of the task are too long to check: more than {limit} postures; add meeting \
         points of the hands, or split the task";
    NoHand = NO_HAND { hand: Hand = index } => "the robot has no {hand} hand; use the other one";
    CannotTurn = CANNOT_TURN { hand: Hand = index } =>
        "the {hand} hand cannot turn a cap: its fingertips cannot pass each other; `atas robot \
         list` shows what each robot can do";
    NoWorkspace = NO_WORKSPACE { hand: Hand = index } =>
        "teleoperation of the {hand} hand needs a workspace in its robot file; `atas robot check` \
         prints one";
    HandEmpty = HAND_EMPTY { hand: Hand = index } =>
        "the {hand} hand holds no object; grasp one first with `atas grasp`";
    FingertipsMisaligned = FINGERTIPS_MISALIGNED {
        place: GoalField = index, error_rad: f64 = value, limit_rad: f64 = limit,
    } =>
        "at the place {:?} with this width a fingertip would be misaligned by {:.1}°, the limit is \
         {:.1}°; grasp at another object width, see `atas robot check`",
        place.place(), error_rad.to_degrees(), limit_rad.to_degrees();
    TargetsStopped = TARGETS_STOPPED { hand: Hand = index } =>
        "the last target of the {hand} hand has expired; the hand stops and keeps its grip until \
         the next one";
    TargetCorrupt = TARGET_CORRUPT => "a target failed its checksum; compute the checksum last";
    TargetForeign = TARGET_FOREIGN =>
        "a target comes from a writer other than the client of the goal; send the writer epoch of \
         the goal request";
    TargetStale = TARGET_STALE { late_ns: f64 = value } =>
        "a target came {:.1} ms too late, or out of order; stamp it with CLOCK_MONOTONIC, increase \
         its sequence, and set valid_until_ns in the future", ms(late_ns);
    TargetUnknown = TARGET_UNKNOWN { code: u32 = value } =>
        "a target names a hand or a grip command ({code}) that its goal does not have; check the \
         goal's kind and hand";
    TargetNotFinite = TARGET_NOT_FINITE { field: TargetField = index } =>
        "{field} of a target is not finite; send finite numbers";
    TargetOutOfRange = TARGET_OUT_OF_RANGE {
        field: TargetField = index, value: f64 = value, limit: f64 = limit,
    } =>
        "{field} of a target is {}, the limit is {}; the hand keeps its previous target",
        field.with_unit(value), field.with_unit(limit);
    AcrossTheMiddle = ACROSS_THE_MIDDLE {
        hand: Hand = index, gap_m: f64 = value, limit_m: f64 = limit,
    } =>
        "the {hand} arm comes within {:.1} mm of the middle plane, needs {:.1} mm during \
         teleoperation; move it home with `atas release --hand {hand}`", mm(gap_m), mm(limit_m);
}

/// Index of a reason that concerns no single joint.
const NO_JOINT: u32 = u32::MAX;

/// Without a limit, no single value is wrong: the arm has no posture for all of them together. A
/// yaw always has a limit, which may be zero.
fn is_posture_error(record: &ReasonRecord) -> bool {
    record.limit == 0.0 && !GoalField(record.index).is_yaw()
}

impl Reason {
    /// Returns true unless there is no reason.
    #[must_use]
    pub fn is_some(&self) -> bool {
        !matches!(self, Self::None)
    }

    /// Returns the code of the reason on the wire.
    #[must_use]
    pub fn cause(&self) -> Cause {
        ReasonRecord::from(*self).cause
    }

    /// Returns the index of the joint that the reason concerns, if it concerns one.
    #[must_use]
    pub fn joint(&self) -> Option<usize> {
        match *self {
            Self::JointsInvalid { joint, .. }
            | Self::FollowingError { joint, .. }
            | Self::CommandNotFinite { joint }
            | Self::CommandStep { joint, .. } => Some(joint),
            _ => None,
        }
    }
}
