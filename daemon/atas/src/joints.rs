//! Joint intake: validation of joint states.

use crate::limits::{FEEDBACK_JUMP_FACTOR, FEEDBACK_MARGIN_RAD, WRITER_SILENT_NS};
use crate::settings::Intake as Limits;
use crate::tick::Tick;
use crate::tick::seconds_between;
use robot_model::{Joint, ROBOT_JOINTS_MAX, RobotModel, RobotVector};
use shm_schemas::capacity::HANDS;
use shm_schemas::{JointState, JointStatus, Reason};

/// Validates joint states and keeps the newest valid one.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct JointIntake {
    joints: [Joint; ROBOT_JOINTS_MAX],
    joint_count: usize,
    required: bool,
    newest: Option<Newest>,
    /// Newest sequence number, valid or not; lock-step waits for it.
    latest_sequence: u64,
    /// True if this tick's state comes from a new process.
    restarted: bool,
    fault: Reason,
    status: JointStatus,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Newest {
    sequence: u64,
    epoch: u64,
    captured_ns: u64,
    received_ns: u64,
    position: RobotVector,
    commanded_position: Option<RobotVector>,
    grip_limit_n: [f64; HANDS],
    effort: Option<RobotVector>,
}

impl JointIntake {
    /// Creates an intake for this robot.
    #[must_use]
    pub fn new(robot: &RobotModel, required: bool) -> Self {
        Self {
            joints: core::array::from_fn(|joint| robot.joint(joint).copied().unwrap_or_default()),
            joint_count: robot.joint_count(),
            required,
            newest: None,
            latest_sequence: 0,
            restarted: false,
            fault: Reason::None,
            status: JointStatus::default(),
        }
    }

    /// Processes a new state, if any.
    pub fn update(&mut self, state: Option<&JointState>, tick: Tick, limits: &Limits) {
        self.fault = Reason::None;
        self.restarted = false;
        let Some(state) = state else { return };
        self.latest_sequence = state.stamp.sequence;
        match self.admit(state, tick, limits) {
            Ok(lost) => {
                self.status.states += 1;
                self.status.lost = self.status.lost.saturating_add(lost);
                let position = RobotVector::from_slice(&state.position[..self.joint_count]);
                let epoch = state.stamp.writer_epoch;
                self.restarted = self.newest.is_some_and(|newest| newest.epoch != epoch);
                self.newest = Some(Newest {
                    sequence: state.stamp.sequence,
                    epoch: state.stamp.writer_epoch,
                    captured_ns: state.stamp.captured_ns,
                    received_ns: tick.now_ns,
                    position,
                    commanded_position: self.valid_commanded_position(state),
                    grip_limit_n: state.grip_limit_n,
                    effort: self.valid_effort(state),
                });
            }
            Err(fault) => {
                self.status.rejected += 1;
                self.fault = fault;
            }
        }
    }

    /// Returns the measured positions, rad or m.
    #[must_use]
    pub fn position(&self) -> Option<&RobotVector> {
        self.newest.as_ref().map(|n| &n.position)
    }

    /// Returns the measured positions unless they are too old to compare with a command, rad or m.
    #[must_use]
    pub fn fresh_position(&self, tick: Tick, limits: &Limits) -> Option<&RobotVector> {
        let stopped = self.hold_reason(tick, limits).is_some();
        self.position().filter(|_| !stopped)
    }

    /// Returns the reported servo commands, rad or m, if within the joint limits.
    #[must_use]
    pub fn commanded_position(&self) -> Option<&RobotVector> {
        self.newest.as_ref()?.commanded_position.as_ref()
    }

    /// Returns the reported F_2 per hand, N, unchecked; zero if none.
    #[must_use]
    pub fn grip_limit_n(&self) -> [f64; HANDS] {
        self.newest
            .map_or([0.0; HANDS], |newest| newest.grip_limit_n)
    }

    /// Returns the servo torques, N·m or N, if measured.
    #[must_use]
    pub fn effort(&self) -> Option<&RobotVector> {
        self.newest.as_ref()?.effort.as_ref()
    }

    /// Returns whether this tick's state comes from a new process, which makes the robot's position
    /// unknown.
    #[must_use]
    pub fn restarted(&self) -> bool {
        self.restarted
    }

    fn joints(&self) -> &[Joint] {
        &self.joints[..self.joint_count]
    }

    fn valid_commanded_position(&self, state: &JointState) -> Option<RobotVector> {
        let reported = &state.commanded_position[..self.joint_count];
        // The comparisons are false for NaN.
        let within = |(joint, q): (&Joint, &f64)| *q >= joint.lower && *q <= joint.upper;
        let believable = state.commanded_count as usize == self.joint_count
            && state.command_epoch != 0
            && self.joints().iter().zip(reported).all(within);
        believable.then(|| RobotVector::from_slice(reported))
    }

    /// A robot without torque measurement reports zeros.
    fn valid_effort(&self, state: &JointState) -> Option<RobotVector> {
        let told_n_m = &state.effort[..self.joint_count];
        let believable = told_n_m.iter().all(|effort| effort.is_finite());
        let measured = told_n_m.iter().any(|effort| *effort != 0.0);
        (believable && measured).then(|| RobotVector::from_slice(told_n_m))
    }

    /// Returns the newest sequence number, valid or not.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.latest_sequence
    }

    /// Returns the reason for SAFE_STOP: invalid feedback.
    #[must_use]
    pub fn fault(&self) -> Reason {
        self.fault
    }

    /// Returns the reason for HOLD: missing feedback.
    #[must_use]
    pub fn hold_reason(&self, tick: Tick, limits: &Limits) -> Reason {
        if !self.required {
            return Reason::None;
        }
        let age_s = self
            .newest
            .map(|n| seconds_between(n.captured_ns, tick.now_ns));
        if age_s.is_none_or(|age_s| age_s > limits.hold_age_s) {
            Reason::JointsStopped {
                age_ns: age_s.map(|age_s| age_s * 1e9),
                limit_ns: limits.hold_age_s * 1e9,
            }
        } else {
            Reason::None
        }
    }

    /// Returns counts and age for [`shm_schemas::Status`].
    #[must_use]
    pub fn status(&self, tick: Tick) -> JointStatus {
        let age_ns = self
            .newest
            .map_or(u64::MAX, |n| tick.now_ns.saturating_sub(n.captured_ns));
        JointStatus {
            age_ns,
            ..self.status
        }
    }

    /// Checks a state; returns the number of states lost before it. Old or repeated states are
    /// rejected without a fault; they show as age.
    fn admit(&self, state: &JointState, tick: Tick, limits: &Limits) -> Result<u64, Reason> {
        if !state.is_intact() {
            return Err(Reason::None);
        }
        if state.joint_count as usize != self.joint_count {
            return Err(Reason::JointCount {
                count: state.joint_count,
                expected: self.joint_count as u32,
            });
        }
        let positions = &state.position[..self.joint_count];
        // False for NaN, so a NaN is out of range.
        let believable = |(joint, &q): (&Joint, &f64)| {
            let margin = FEEDBACK_MARGIN_RAD * joint.radian();
            q >= joint.lower - margin && q <= joint.upper + margin
        };
        if let Some(joint) = self
            .joints()
            .iter()
            .zip(positions)
            .position(|j| !believable(j))
        {
            return Err(Reason::JointsInvalid {
                joint,
                position: positions[joint],
                last: self.newest.map_or(0.0, |n| n.position[joint]),
            });
        }
        let age_s = seconds_between(state.stamp.captured_ns, tick.now_ns);
        if age_s > limits.reject_age_s || -age_s > limits.future_s {
            return Err(Reason::None);
        }
        let Some(newest) = self.newest else {
            return Ok(0);
        };
        // Another writer or a restarted counter is accepted only after silence.
        let silent = tick.now_ns.saturating_sub(newest.received_ns) >= WRITER_SILENT_NS;
        if newest.epoch != state.stamp.writer_epoch {
            return if silent { Ok(0) } else { Err(Reason::None) };
        }
        // Wrapping: a counter overflow is not a gap.
        let ahead = state.stamp.sequence.wrapping_sub(newest.sequence);
        let rises = (1..=u64::MAX / 2).contains(&ahead);
        if (!rises && !silent) || state.stamp.captured_ns <= newest.captured_ns {
            return Err(Reason::None);
        }
        self.check_jump(state, &newest)?;
        Ok(if rises { ahead - 1 } else { 0 })
    }

    fn check_jump(&self, state: &JointState, newest: &Newest) -> Result<(), Reason> {
        let elapsed_s = seconds_between(newest.captured_ns, state.stamp.captured_ns);
        for joint in 0..self.joint_count {
            let (position, last) = (state.position[joint], newest.position[joint]);
            let allowed = FEEDBACK_JUMP_FACTOR * self.joints[joint].velocity_max * elapsed_s;
            if (position - last).abs() > allowed {
                return Err(Reason::JointsInvalid {
                    joint,
                    position,
                    last,
                });
            }
        }
        Ok(())
    }
}
