//! Commanded motion of all joints, with the positions from which it may begin.

use shm_schemas::{JointCommand, Mode};

use crate::bounds::JointBounds;
use crate::findings::{Findings, ViolationKind};
use crate::joint_motion::{JointMotion, is_within};
use crate::rest::{RestCheck, Sample};

/// Tolerance of the first position after a restart, rad or m. Design choice: rounding in a servo
/// protocol; a thousandth of the motion that changes a grip force noticeably.
pub const RESTART_MARGIN: f64 = 1e-6;

/// Modes in which a controller without known positions may command no joints.
const WITHOUT_POSITIONS: [Mode; 4] = [Mode::INIT, Mode::HOLD, Mode::SAFE_STOP, Mode::FAULT];

/// Relation of the next positions to the last ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// They continue the motion.
    Motion,
    /// They may be any, at rest: the controller measured them.
    Measured,
    /// They are those last in force, at rest: the controller was restarted.
    InForce,
}

/// Check of the motion.
#[derive(Clone, Debug)]
pub(crate) struct MotionCheck {
    joints: Vec<(JointMotion, RestCheck)>,
    origin: Origin,
    /// Positions were commanded since the start, restart or motion of the robot.
    has_positions: bool,
    /// The robot moved without command; one discontinuity is permitted.
    robot_moved: bool,
    mode: Mode,
}

impl MotionCheck {
    pub(crate) fn new(bounds: Vec<JointBounds>, step_s: f64) -> Self {
        let joint = |bounds| (JointMotion::new(bounds, step_s), RestCheck::default());
        Self {
            joints: bounds.into_iter().map(joint).collect(),
            origin: Origin::Motion,
            has_positions: false,
            robot_moved: false,
            mode: Mode::INIT,
        }
    }

    /// Permits one discontinuity of the positions.
    pub(crate) fn robot_moved(&mut self) {
        self.robot_moved = true;
    }

    /// Expects the motion to continue from rest: the robot has stopped.
    pub(crate) fn halt(&mut self) {
        for (joint, _) in &mut self.joints {
            if let Some(position) = joint.position() {
                joint.rest_at(position);
            }
        }
    }

    /// Expects a new controller to begin at the positions last in force.
    pub(crate) fn new_writer(&mut self) {
        let is_known = self
            .joints
            .iter()
            .all(|(joint, _)| joint.position().is_some());
        self.has_positions = false;
        self.origin = if is_known {
            Origin::InForce
        } else {
            Origin::Measured
        };
    }

    /// Forgets the motion after commands whose positions are unknown.
    pub(crate) fn forget(&mut self) {
        for (joint, rest) in &mut self.joints {
            joint.forget();
            *rest = RestCheck::default();
        }
    }

    /// Checks the positions of a command whose values are finite.
    pub(crate) fn check(&mut self, command: &JointCommand, findings: &mut Findings) {
        let (count, expected) = (command.joint_count as usize, self.joints.len());
        if count == expected {
            self.check_joints(command, findings);
        } else if count == 0 && self.may_be_without_positions(command.mode) {
            self.has_positions = false;
            if self.robot_moved || self.origin == Origin::Motion {
                self.origin = Origin::Measured;
            }
        } else {
            findings.report(
                ViolationKind::JointCount,
                format_args!("{count} joints in {}; expected {expected}", command.mode),
            );
            self.forget();
        }
        self.mode = command.mode;
    }

    fn may_be_without_positions(&self, mode: Mode) -> bool {
        (!self.has_positions || self.robot_moved) && WITHOUT_POSITIONS.contains(&mode)
    }

    fn check_joints(&mut self, command: &JointCommand, findings: &mut Findings) {
        self.has_positions = true;
        for ((joint, _), position) in self.joints.iter().zip(&command.position) {
            joint.check_position(*position, findings);
        }
        let origin = std::mem::replace(&mut self.origin, Origin::Motion);
        let breaks = self.robot_moved && (origin != Origin::Motion || !self.continues(command));
        if breaks {
            self.robot_moved = false;
            self.begin(command, findings);
        } else if origin == Origin::InForce {
            self.check_in_force(command, findings);
            self.begin(command, findings);
        } else if origin == Origin::Measured {
            self.begin(command, findings);
        } else if command.mode == Mode::FAULT && self.mode != Mode::FAULT {
            self.freeze(command, findings);
        } else {
            self.follow(command, findings);
        }
    }

    /// Returns whether all differences up to the new positions are within their limits.
    fn continues(&self, command: &JointCommand) -> bool {
        let mut joints = self.joints.iter().zip(&command.position);
        joints.all(|((joint, _), position)| joint.is_within(&joint.differences(*position)))
    }

    /// Checks that the positions lie between the last two commands: the robot may have missed the
    /// very last one.
    fn check_in_force(&self, command: &JointCommand, findings: &mut Findings) {
        for ((joint, _), position) in self.joints.iter().zip(&command.position) {
            let Some(last) = joint.position() else {
                continue;
            };
            let before = last - joint.last_step();
            let (low, high) = (last.min(before), last.max(before));
            if !(low - RESTART_MARGIN..=high + RESTART_MARGIN).contains(position) {
                let (name, symbol) = (&joint.bounds.name, joint.bounds.unit.symbol());
                findings.report(
                    ViolationKind::Restart,
                    format_args!(
                        "joint {name} restarts at {position} {symbol}; in force was {last} {symbol}"
                    ),
                );
            }
        }
    }

    /// Begins a motion at rest.
    fn begin(&mut self, command: &JointCommand, findings: &mut Findings) {
        let values = command.position.iter().zip(&command.velocity);
        for ((joint, rest), (position, feed_forward)) in self.joints.iter_mut().zip(values) {
            if *feed_forward != 0.0 {
                let (name, symbol) = (&joint.bounds.name, joint.bounds.unit.symbol());
                findings.report(
                    ViolationKind::Restart,
                    format_args!(
                        "joint {name} begins with feed-forward {feed_forward} {symbol}/s; it must \
                         be 0"
                    ),
                );
            }
            joint.rest_at(*position);
            *rest = RestCheck::Resting {
                position: *position,
            };
        }
    }

    /// Checks the first command of FAULT. It repeats the last positions with zero feed-forward, as
    /// the robot does when a command expires; deceleration and jerk are not limited.
    fn freeze(&mut self, command: &JointCommand, findings: &mut Findings) {
        for ((joint, rest), position) in self.joints.iter_mut().zip(&command.position) {
            let Some(last) = joint.position() else {
                continue;
            };
            *rest = RestCheck::Resting { position: last };
            if is_within(*position - last, joint.tolerance.position) {
                joint.rest_at(last);
            }
        }
        self.follow(command, findings);
    }

    fn follow(&mut self, command: &JointCommand, findings: &mut Findings) {
        let values = command.position.iter().zip(&command.velocity);
        for ((joint, rest), (position, feed_forward)) in self.joints.iter_mut().zip(values) {
            let differences = joint.differences(*position);
            joint.check_differences(&differences, findings);
            joint.check_feed_forward(*feed_forward, &differences, findings);
            let sample = Sample {
                position: *position,
                feed_forward: *feed_forward,
                differences,
            };
            rest.check(command.mode, joint, &sample, findings);
            joint.follow(*position, differences);
        }
    }
}
