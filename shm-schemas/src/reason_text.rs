//! Formats a [`Reason`] as one sentence: what failed, value and limit, what to do.

use crate::body::BodyPair;
use crate::goal::{GoalKind, GoalRequest};
use crate::joints::Mode;
use crate::module::ModuleId;
use crate::reason::{Cause, Reason};
use crate::stamp::Hand;
use crate::units::goal_value_with_unit;
use core::fmt::{self, Formatter};

/// Name and unit of the joint that a reason concerns, for programs that know the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointLabel<'a> {
    /// Name of the joint in the robot's URDF.
    pub name: &'a str,
    /// Unit of its position: `rad` or `m`.
    pub unit: &'a str,
}

/// Text of a reason, with the label of its joint if known; otherwise with the joint's index.
#[derive(Clone, Copy, Debug)]
pub struct ReasonText<'a> {
    reason: Reason,
    joint: Option<JointLabel<'a>>,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.text(None).fmt(f)
    }
}

impl fmt::Display for ReasonText<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let reason = &self.reason;
        match reason.cause.0 {
            0..=9 | 19 | 60..=69 => reason.write_goal(f),
            10..=19 | 29 | 50..=59 => reason.write_task(f),
            20..=29 | 45 => reason.write_frames(f),
            30..=39 | 46..=47 => reason.write_joints(f, self.joint),
            70..=79 => reason.write_target(f),
            _ => reason.write_daemon(f),
        }?;
        if reason.module != ModuleId::NONE {
            write!(f, " ({})", reason.module)
        } else {
            Ok(())
        }
    }
}

impl Reason {
    /// Returns the index of the joint that the reason concerns, if it concerns one.
    #[must_use]
    pub fn joint(&self) -> Option<usize> {
        let names_joint = matches!(
            self.cause,
            Cause::JOINTS_INVALID
                | Cause::FOLLOWING_ERROR
                | Cause::COMMAND_NOT_FINITE
                | Cause::COMMAND_STEP
        );
        names_joint.then_some(self.index as usize)
    }

    /// Returns the text of the reason; `joint` labels the joint of [`Reason::joint`].
    #[must_use]
    pub fn text<'a>(&self, joint: Option<JointLabel<'a>>) -> ReasonText<'a> {
        ReasonText {
            reason: *self,
            joint,
        }
    }
}

/// Writes the name of a joint, or its index.
struct JointName<'a>(u32, Option<JointLabel<'a>>);

impl fmt::Display for JointName<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.1 {
            Some(label) => f.write_str(label.name),
            None => write!(f, "{}", self.0),
        }
    }
}

/// Formatting by groups of cause numbers.
impl Reason {
    /// Formats the reason of a rejected goal.
    fn write_goal(&self, f: &mut Formatter<'_>) -> fmt::Result {
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
                    "{} of the goal is {}, the limit is {}; choose a value within it",
                    goal_value(index),
                    goal_value_with_unit(index, value),
                    goal_value_with_unit(index, limit)
                )
            }
            Cause::TASK_TOO_LONG => write!(
                f,
                "the paths of the task are too long to check: more than {limit:.0} postures; add \
                 meeting points of the hands, or split the task"
            ),
            Cause::UNREACHABLE if goal_value(index).ends_with("yaw") => write!(
                f,
                "closing direction out of reach: {} is {}, the nearest possible is {}; turn the \
                 closing axis or move the place",
                goal_value(index),
                goal_value_with_unit(index, value),
                goal_value_with_unit(index, limit)
            ),
            Cause::FINGERTIPS_MISALIGNED => write!(
                f,
                "at the place {:?} with this width a fingertip would be misaligned by {:.1}°, the \
                 limit is {:.1}°; grasp at another object width, see `atas robot check`",
                goal_place(index),
                value.to_degrees(),
                limit.to_degrees()
            ),
            // No single limit is violated: the arm has no posture for all values together.
            Cause::UNREACHABLE if limit == 0.0 => write!(
                f,
                "no arm posture for the place {:?} with this yaw, width and lift: the fingertips \
                 stay {:.1} mm off; move the place or turn the closing axis",
                goal_place(index),
                value * 1e3
            ),
            Cause::UNREACHABLE if goal_value(index) == "lift" => write!(
                f,
                "lift too high: place and lift together are {} high, the limit is {}; lift less",
                goal_value_with_unit(index, value),
                goal_value_with_unit(index, limit)
            ),
            Cause::UNREACHABLE => write!(
                f,
                "goal out of reach: {} is {1}, the limit is {2}; use at {3} {2}",
                goal_value(index),
                goal_value_with_unit(index, value),
                goal_value_with_unit(index, limit),
                if value < limit { "least" } else { "most" }
            ),
            Cause::UNKNOWN_GOAL => write!(
                f,
                "field {index} of the goal has the unknown code {value}; update the client"
            ),
            Cause::BUSY if GoalKind(value as u32).is_known() => write!(
                f,
                "the goal `{}` is active; wait for it or cancel it",
                GoalKind(value as u32)
            ),
            Cause::BUSY => f.write_str("another goal is active; wait for it or cancel it"),
            Cause::NOT_READY => write!(
                f,
                "the daemon is in mode {}, needs ready; see `atas status`",
                Mode(value as u32)
            ),
            Cause::HAND_FULL => {
                write!(
                    f,
                    "the {0} hand still holds an object; release it first with `atas release --hand {0}`",
                    Hand(index)
                )
            }
            Cause::HAND_EMPTY => write!(
                f,
                "the {} hand holds no object; grasp one first with `atas grasp`",
                Hand(index)
            ),
            Cause::ARMS_COLLIDE if index != 0 => {
                let [ours, theirs] = BodyPair::from_index(index).0;
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
                    Hand(index)
                )
            }
            Cause::NO_HAND => write!(
                f,
                "the robot has no {} hand; use the other one",
                Hand(index)
            ),
            Cause::CANNOT_TURN => write!(
                f,
                "the {} hand cannot turn a cap: its fingertips cannot pass each other; `atas robot list` shows what each robot can \
                 do",
                Hand(index)
            ),
            Cause::NO_WORKSPACE => write!(
                f,
                "teleoperation of the {} hand needs a workspace in its robot file; `atas robot \
                 check` prints one",
                Hand(index)
            ),
            Cause::UNKNOWN_TASK => f.write_str(
                "the daemon's configuration has no task of this name; `atasd --check-config` lists \
                 the configured tasks",
            ),
            _ => self.write_unknown(f),
        }
    }

    /// Formats the reason why a task ended.
    fn write_task(&self, f: &mut Formatter<'_>) -> fmt::Result {
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
                    "object too heavy: not held with {value:.2} N, the limit is {limit:.2} N \
                     (`grasp.f2_max_n`)"
                )
            }
            Cause::TOO_SOFT => {
                write!(
                    f,
                    "object too heavy for its stiffness: not held with {value:.2} N, the limit F_2 \
                     is {limit:.2} N"
                )
            }
            Cause::ABOVE_MAX_FORCE => {
                write!(
                    f,
                    "object not held with {value:.2} N, the goal allows {limit:.2} N \
                     (`--max-force`)"
                )
            }
            Cause::LOST_OBJECT => write!(
                f,
                "the hand no longer feels the object: force {value:.2} N, needs {limit:.2} N"
            ),
            Cause::TURNED_IN_HAND => write!(
                f,
                "the object turned in the hand: lever arm of its weight {:.1} mm, before {:.1} mm; \
                 grasp nearer to its centre of mass",
                value * 1e3,
                limit * 1e3
            ),
            Cause::SLIPPED_IN_HAND => write!(
                f,
                "the object slipped in the hand by about {:.1} mm, allowed {:.1} mm; the hand \
                 keeps its grip",
                value * 1e3,
                limit * 1e3
            ),
            Cause::OUT_OF_FORCE => {
                write!(
                    f,
                    "still slipping at {value:.2} N, the force limit F_2 is {limit:.2} N: the load \
                     is too high"
                )
            }
            Cause::TIMED_OUT => write!(f, "took {value:.1} s, allowed {limit:.1} s"),
            Cause::CANCELLED => f.write_str("cancelled by the client"),
            Cause::CLIENT_GONE => f.write_str("the client of this attached goal disconnected"),
            Cause::NO_SUPPORT => write!(
                f,
                "no support found down to {:.1} mm, expected at {:.1} mm; the hand keeps the object",
                value * 1e3,
                limit * 1e3
            ),
            Cause::SLIDING => write!(
                f,
                "the object has been sliding between the fingertips for {value:.2} s, allowed \
                 {limit:.2} s"
            ),
            Cause::GRIP_FOUND => write!(
                f,
                "the {} hand was gripping with {value:.2} N when the daemon started; it keeps its \
                 grip with up to {limit:.2} N; `atas release --hand {0}` opens it",
                Hand(self.index)
            ),
            Cause::OBSTRUCTED => write!(
                f,
                "finger {} touched an obstacle at {value:.2} N, the limit is {limit:.2} N; clear \
                 the path or grasp nearer to the object's top",
                self.index + 1
            ),
            _ => self.write_unknown(f),
        }
    }

    /// Formats a fault of the tactile frames.
    fn write_frames(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            value,
            limit,
            index,
            ..
        } = *self;
        match self.cause {
            Cause::FRAMES_STOPPED if !value.is_finite() => {
                let hand = Hand(index);
                write!(
                    f,
                    "no tactile frame of hand {hand} yet; is the sensor process running?"
                )
            }
            Cause::FRAMES_STOPPED => write!(
                f,
                "no tactile frame of hand {} for {:.1} ms, allowed {:.1} ms; is the sensor process running?",
                Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAME_STALE => write!(
                f,
                "the newest frame of hand {} is {:.1} ms old, allowed {:.1} ms",
                Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAME_FUTURE => write!(
                f,
                "a frame of hand {} is stamped {:.1} ms ahead, allowed {:.1} ms; use CLOCK_MONOTONIC of this machine",
                Hand(index),
                value * 1e-6,
                limit * 1e-6
            ),
            Cause::FRAMES_LOST => write!(
                f,
                "{value} frames of hand {} lost in a row, allowed {limit}",
                Hand(index)
            ),
            Cause::FRAME_CORRUPT => write!(
                f,
                "{value} frames of hand {} failed their checksum",
                Hand(index)
            ),
            Cause::FRAME_FOREIGN => write!(
                f,
                "a frame of hand {} comes from another writer or follows another layout than configured",
                Hand(index)
            ),
            Cause::ELEMENTS_INVALID => write!(
                f,
                "{:.0} % of the elements of hand {} are invalid, allowed {:.0} %",
                value * 100.0,
                Hand(index),
                limit * 100.0
            ),
            Cause::FRAMES_FROZEN => write!(
                f,
                "the readings of hand {} have not changed for {value} frames, allowed {limit}",
                Hand(index)
            ),
            Cause::ELEMENT_STUCK => write!(
                f,
                "element {value} of finger {} of the {} hand is stuck: its reading is constant; it \
                 is masked until the reading changes",
                limit + 1.0,
                Hand(index)
            ),
            Cause::SENSOR_RESTARTED => {
                write!(f, "the sensor process of hand {} restarted", Hand(index))
            }
            _ => self.write_unknown(f),
        }
    }

    /// Formats a fault of joints or commands.
    fn write_joints(&self, f: &mut Formatter<'_>, label: Option<JointLabel<'_>>) -> fmt::Result {
        let (joint, unit) = (
            JointName(self.index, label),
            label.map_or("rad or m", |label| label.unit),
        );
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
            Cause::SENSE_ONLY => f.write_str(
                "sense-only mode: the daemon commands no robot because robot.joints_required is \
                 false",
            ),
            Cause::JOINTS_INVALID => {
                write!(
                    f,
                    "joint {joint} reports {value:.4} {unit}, last valid position {limit:.4} {unit}"
                )
            }
            Cause::FOLLOWING_ERROR => {
                write!(
                    f,
                    "joint {joint} is {value:.4} {unit} off its command, allowed {limit:.4} {unit}; is \
                     it blocked?"
                )
            }
            Cause::COMMAND_NOT_FINITE => write!(f, "the command for joint {joint} was not finite"),
            Cause::COMMAND_STEP => {
                write!(
                    f,
                    "the command for joint {joint} jumped by {value:.4} {unit}, allowed {limit:.4} \
                     {unit}"
                )
            }
            Cause::GRIP_CEILING => {
                write!(
                    f,
                    "grip force {value:.2} N of grasp side {} exceeds its limit {limit:.2} N",
                    index.saturating_add(1)
                )
            }
            Cause::ROBOT_RESTARTED => f.write_str(
                "the robot process restarted; the goal has ended, the hands keep their \
                    grip",
            ),
            Cause::FORCE_IMPLAUSIBLE => write!(
                f,
                "a fingertip of the {} hand reports {value:.2} N, the plausible maximum is \
                 {limit:.2} N; check the sensor, or zero it with an empty hand (`atas zero`)",
                Hand(index)
            ),
            Cause::FORCE_AGAINST_OPENING => write!(
                f,
                "the {} hand reports a grip force of {value:.2} N, after {limit:.2} N at the lift; \
                 its opening does not explain the difference; does the zero drift? Take the object, \
                 then `atas zero`",
                Hand(index)
            ),
            Cause::FORCE_AGAINST_JOINTS => write!(
                f,
                "tactile force {value:.2} N and joint-estimated force {limit:.2} N of the {} hand \
                 disagree; does the zero drift? The hand keeps its grip; take the object, then \
                 `atas estop`, `atas recover`, `atas zero`",
                Hand(index)
            ),
            Cause::NOT_NOW => f.write_str(
                "not now: zeroing needs mode ready and an empty hand, a change of `[safety]` needs \
                 a stopped robot (`atas estop`)",
            ),
            _ => self.write_unknown(f),
        }
    }

    /// Formats a fault of the daemon.
    fn write_daemon(&self, f: &mut Formatter<'_>) -> fmt::Result {
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
            Cause::SUPERVISOR_SILENT => write!(
                f,
                "the daemon's supervisor has not responded for {value:.1} s, allowed {limit:.1} s"
            ),
            _ => self.write_unknown(f),
        }
    }

    pub(crate) fn write_unknown(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self {
            cause,
            value,
            limit,
            ..
        } = *self;
        write!(f, "{cause}: value {value}, limit {limit}")
    }
}

/// Returns the place (`from` or `to`) that a goal value belongs to, or an empty string.
fn goal_place(index: u32) -> &'static str {
    match goal_value(index).split_once(' ') {
        Some((place @ ("from" | "to"), _)) => place,
        _ => "",
    }
}

fn goal_value(index: u32) -> &'static str {
    GoalRequest::VALUE_NAMES
        .get(index as usize)
        .copied()
        .unwrap_or("a value")
}
