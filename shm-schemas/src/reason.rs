//! Reasons: why something was refused, held or stopped, in a form that prints as one clear sentence.

use crate::ModuleId;
use crate::code::code;
use crate::service::word;
use core::fmt::{self, Formatter};
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
        /// The object needs more force than its hardness allows.
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
        /// A module panicked.
        MODULE_PANICKED = 40, "module-panicked";
        /// The loop stood still for a while.
        LOOP_STALLED = 41, "loop-stalled";
        /// Stopped by a person: `atas estop`.
        ESTOP = 42, "estop";
        /// The daemon is shutting down.
        SHUTDOWN = 43, "shutdown";
    }
}

word! {
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

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.cause.0 {
            0..=9 | 19 => self.tell_goal(f),
            10..=19 | 29 => self.tell_task(f),
            20..=29 => self.tell_frames(f),
            30..=39 => self.tell_joints(f),
            _ => self.tell_daemon(f),
        }?;
        if self.module != ModuleId::NONE {
            write!(f, " ({})", self.module)
        } else {
            Ok(())
        }
    }
}

/// The sentences, by tens of the cause's number.
impl Reason {
    /// Why a goal was not begun.
    fn tell_goal(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            value,
            limit,
            index,
            ..
        } = *self;
        match self.cause {
            Cause::NONE => f.write_str("nothing to report"),
            Cause::NOT_FINITE => write!(
                f,
                "{} of the goal is not finite; send finite numbers",
                goal_value(index)
            ),
            Cause::OUT_OF_RANGE => {
                write!(
                    f,
                    "{} of the goal is {value:.4}, the limit is {limit:.4}; choose a value within it",
                    goal_value(index)
                )
            }
            // No limit of one number is at fault: the arm has no posture for all of them together.
            Cause::UNREACHABLE if limit == 0.0 => write!(
                f,
                "the arm has no posture for the place {:?} with this yaw, width and lift: the fingertips stay {:.1} mm off; move \
                 the place or turn the closing axis",
                goal_place(index),
                value * 1e3
            ),
            Cause::UNREACHABLE if goal_value(index) == "lift" => write!(
                f,
                "the hand cannot lift it so high: the place and the lift together are {value:.4} m high, the limit is {limit:.4} m; \
                 lift less"
            ),
            Cause::UNREACHABLE => write!(
                f,
                "the hand cannot reach it: {} is {value:.4}, the limit is {limit:.4}; {}",
                goal_value(index),
                if goal_place(index).is_empty() {
                    "choose a value within it"
                } else {
                    "move the object nearer"
                }
            ),
            Cause::UNKNOWN_GOAL => write!(
                f,
                "field {index} of the goal has the unknown code {value}; update the client"
            ),
            Cause::BUSY => f.write_str("another goal is active; wait for it or cancel it"),
            Cause::NOT_READY => write!(
                f,
                "the daemon is in mode {}, needs ready; see `atas status`",
                crate::Mode(value as u32)
            ),
            Cause::HAND_FULL => {
                write!(
                    f,
                    "the {0} hand still holds an object; release it first with `atas release --hand {0}`",
                    crate::Hand(index)
                )
            }
            Cause::ARMS_COLLIDE if index != 0 => {
                let [ours, theirs] = crate::BodyPair::read(index).0;
                let (value_mm, limit_mm) = (value * 1e3, limit * 1e3);
                write!(
                    f,
                    "the {ours} would come within {value_mm:.1} mm of the {theirs}, needs {limit_mm:.1} mm; move the places apart, \
                     or the other arm away"
                )
            }
            Cause::ARMS_COLLIDE => write!(
                f,
                "the arms would come within {:.1} mm of each other, needs {:.1} mm; move the places apart",
                value * 1e3,
                limit * 1e3
            ),
            Cause::NO_SENSOR => {
                write!(
                    f,
                    "the {} hand has no tactile sensor in the configuration; use the other hand",
                    crate::Hand(index)
                )
            }
            Cause::UNKNOWN_TASK => f.write_str(
                "the daemon's configuration has no task of this name; `atasd --check-config` prints those that it has",
            ),
            _ => self.tell_unknown(f),
        }
    }

    /// Why a task ended.
    fn tell_task(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { value, limit, .. } = *self;
        match self.cause {
            Cause::NOTHING_TOUCHED => {
                write!(
                    f,
                    "closed to {:.1} mm and touched nothing; is the object there?",
                    value * 1e3
                )
            }
            Cause::TOO_HEAVY => {
                write!(
                    f,
                    "needs more than {value:.2} N, F_2 is {limit:.2} N: object too heavy for its hardness"
                )
            }
            Cause::LOST_OBJECT => write!(
                f,
                "the object slipped out: normal force {value:.2} N, needs {limit:.2} N"
            ),
            Cause::OUT_OF_FORCE => {
                write!(
                    f,
                    "still slipping at {value:.2} N, F_2 is {limit:.2} N: the load grew beyond what the object bears"
                )
            }
            Cause::TIMED_OUT => write!(f, "took {value:.1} s, allowed {limit:.1} s"),
            Cause::CANCELLED => f.write_str("cancelled by the client"),
            Cause::CLIENT_GONE => f.write_str("the client of this attached goal went away"),
            Cause::NO_SUPPORT => write!(
                f,
                "lowered to {:.1} mm and felt no support, expected it at {:.1} mm; the hand keeps the object",
                value * 1e3,
                limit * 1e3
            ),
            Cause::SLIDING => write!(
                f,
                "the object slides through the fingers, for {value:.2} s by now, allowed {limit:.2} s"
            ),
            Cause::OBSTRUCTED => write!(
                f,
                "finger {} touched something at {value:.2} N on its way, the limit is {limit:.2} N; clear the way or grasp \
                 nearer to the object's top",
                self.index + 1
            ),
            _ => self.tell_unknown(f),
        }
    }

    /// What is wrong with the tactile frames.
    fn tell_frames(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            value,
            limit,
            index,
            ..
        } = *self;
        match self.cause {
            Cause::FRAMES_STOPPED if !value.is_finite() => {
                let hand = crate::Hand(index);
                write!(
                    f,
                    "no tactile frame of hand {hand} yet; is the sensor process running?"
                )
            }
            Cause::FRAMES_STOPPED => write!(
                f,
                "no tactile frame of hand {} for {:.1} ms, allowed {:.1} ms; is the sensor process running?",
                crate::Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAME_STALE => write!(
                f,
                "the newest frame of hand {} is {:.1} ms old, allowed {:.1} ms",
                crate::Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAME_FUTURE => write!(
                f,
                "a frame of hand {} is stamped {:.1} ms ahead, allowed {:.1} ms; use CLOCK_MONOTONIC of this machine",
                crate::Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAMES_LOST => write!(
                f,
                "{value} frames of hand {} lost in a row, allowed {limit}",
                crate::Hand(index)
            ),
            Cause::FRAME_CORRUPT => write!(
                f,
                "{value} frames of hand {} failed their checksum",
                crate::Hand(index)
            ),
            Cause::FRAME_FOREIGN => write!(
                f,
                "a frame of hand {} comes from another writer or follows another layout than configured",
                crate::Hand(index)
            ),
            Cause::ELEMENTS_INVALID => write!(
                f,
                "{:.0} % of the elements of hand {} are invalid, allowed {:.0} %",
                value * 100.0,
                crate::Hand(index),
                limit * 100.0
            ),
            Cause::FRAMES_FROZEN => write!(
                f,
                "the readings of hand {} have not changed for {value} frames, allowed {limit}",
                crate::Hand(index)
            ),
            Cause::SENSOR_RESTARTED => write!(
                f,
                "the sensor process of hand {} restarted",
                crate::Hand(index)
            ),
            _ => self.tell_unknown(f),
        }
    }

    /// What is wrong with joints and commands.
    fn tell_joints(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            value,
            limit,
            index,
            ..
        } = *self;
        match self.cause {
            Cause::JOINTS_STOPPED if !value.is_finite() => {
                f.write_str("no joint state yet; is the robot process running?")
            }
            Cause::JOINTS_STOPPED => write!(
                f,
                "no joint state for {:.1} ms, allowed {:.1} ms; is the robot process running?",
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::JOINTS_INVALID => {
                write!(
                    f,
                    "joint {index} reports {value:.4} rad, last trusted position {limit:.4} rad"
                )
            }
            Cause::FOLLOWING_ERROR => {
                write!(
                    f,
                    "joint {index} is {value:.4} rad off its command, allowed {limit:.4} rad; is it blocked?"
                )
            }
            Cause::COMMAND_NOT_FINITE => write!(f, "the command for joint {index} was not finite"),
            Cause::COMMAND_STEP => {
                write!(
                    f,
                    "the command for joint {index} jumped by {value:.4} rad, allowed {limit:.4} rad"
                )
            }
            Cause::GRIP_CEILING => {
                write!(
                    f,
                    "grip force {value:.2} N of finger {index} is above its ceiling {limit:.2} N"
                )
            }
            _ => self.tell_unknown(f),
        }
    }

    /// What became of the daemon.
    fn tell_daemon(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { value, limit, .. } = *self;
        match self.cause {
            Cause::MODULE_PANICKED => {
                f.write_str("a module panicked; restart the daemon and report this")
            }
            Cause::LOOP_STALLED => {
                write!(
                    f,
                    "the loop stood still for {:.1} ms, allowed {:.1} ms",
                    value * 1e-6,
                    limit * 1e-6
                )
            }
            Cause::ESTOP => f.write_str("stopped by `atas estop`; `atas recover` re-arms"),
            Cause::SHUTDOWN => f.write_str("the daemon is shutting down"),
            _ => self.tell_unknown(f),
        }
    }

    fn tell_unknown(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            cause,
            value,
            limit,
            ..
        } = *self;
        write!(f, "{cause}: value {value}, limit {limit}")
    }
}

/// The place that a value of the goal belongs to; empty if it is no place's.
fn goal_place(index: u32) -> &'static str {
    match goal_value(index).split_once(' ') {
        Some((place @ ("from" | "to"), _)) => place,
        _ => "",
    }
}

fn goal_value(index: u32) -> &'static str {
    crate::GoalRequest::VALUE_NAMES
        .get(index as usize)
        .copied()
        .unwrap_or("a value")
}
