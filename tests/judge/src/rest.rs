//! Rest in every mode but RUN: a joint brakes, then keeps its position with zero feed-forward.

use shm_schemas::Mode;

use crate::findings::{Findings, ViolationKind};
use crate::joint_motion::{Differences, JointMotion, is_within};

/// Ticks after the shortest braking time within which a joint must rest. Design choice: the end of
/// braking is exponential in a discrete controller; smaller values reject it, larger ones hide a
/// creeping joint.
pub const SETTLE_TICKS: u64 = 20;

/// Commanded state of a joint in one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) position: f64,
    pub(crate) feed_forward: f64,
    pub(crate) differences: Differences,
}

/// Check of one joint.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum RestCheck {
    /// RUN, or unknown.
    #[default]
    Moving,
    /// Braking: the speed must not exceed `speed_max`.
    Braking { speed_max: f64, ticks_left: u64 },
    /// Resting at a position.
    Resting { position: f64 },
}

impl RestCheck {
    /// Checks a command; `joint` still contains the differences of the command before.
    pub(crate) fn check(
        &mut self,
        mode: Mode,
        joint: &JointMotion,
        sample: &Sample,
        findings: &mut Findings,
    ) {
        if mode == Mode::RUN {
            *self = Self::Moving;
            return;
        }
        if matches!(self, Self::Moving) {
            *self = Self::braking(joint);
        }
        match *self {
            Self::Moving => {}
            Self::Braking {
                speed_max,
                ticks_left,
            } => {
                check_speed(mode, joint, sample, speed_max, findings);
                *self = Self::after(sample, speed_max, ticks_left);
            }
            Self::Resting { position } => {
                check_rest(mode, joint, sample, position, findings);
                // A further motion is a further violation.
                if !is_within(sample.position - position, joint.tolerance.position) {
                    *self = Self::at_rest(sample);
                }
            }
        }
    }

    fn at_rest(sample: &Sample) -> Self {
        Self::Resting {
            position: sample.position,
        }
    }

    /// Returns the state after a tick of braking.
    fn after(sample: &Sample, speed_max: f64, ticks_left: u64) -> Self {
        match ticks_left {
            0 => Self::at_rest(sample),
            _ => Self::Braking {
                speed_max,
                ticks_left: ticks_left - 1,
            },
        }
    }

    /// Returns the state at the first command after RUN. While the acceleration decays, the speed
    /// may increase by a² / 2J, and by one tick of a.
    fn braking(joint: &JointMotion) -> Self {
        let bounds = &joint.bounds;
        let (last, limit) = (joint.last(), bounds.acceleration_max);
        let speed = last.speed.map_or(bounds.speed_max, f64::abs);
        let acceleration = last.acceleration.map_or(limit, f64::abs);
        let step_s = joint.step_s();
        let increase =
            acceleration * acceleration / (2.0 * bounds.jerk_max) + acceleration * step_s;
        // The acceleration changes by up to 2A at the start, by A at the end.
        let braking_s = (speed + increase) / limit + 3.0 * limit / bounds.jerk_max;
        Self::Braking {
            speed_max: speed + increase + joint.tolerance.speed,
            ticks_left: (braking_s / step_s).ceil() as u64 + SETTLE_TICKS,
        }
    }
}

fn check_speed(
    mode: Mode,
    joint: &JointMotion,
    sample: &Sample,
    speed_max: f64,
    findings: &mut Findings,
) {
    let speed = sample.differences.speed.unwrap_or(0.0);
    if !is_within(speed, speed_max) {
        let (name, symbol) = (&joint.bounds.name, joint.bounds.unit.symbol());
        findings.report(
            ViolationKind::Motion,
            format_args!(
                "joint {name} does not brake in {mode}: {speed} {symbol}/s, limit {speed_max}"
            ),
        );
    }
}

fn check_rest(
    mode: Mode,
    joint: &JointMotion,
    sample: &Sample,
    rest: f64,
    findings: &mut Findings,
) {
    let (name, symbol) = (&joint.bounds.name, joint.bounds.unit.symbol());
    let distance = sample.position - rest;
    if !is_within(distance, joint.tolerance.position) {
        findings.report(
            ViolationKind::Motion,
            format_args!("joint {name} moves in {mode}: {distance} {symbol} from {rest} {symbol}"),
        );
    } else if sample.feed_forward != 0.0 {
        findings.report(
            ViolationKind::FeedForward,
            format_args!(
                "joint {name} rests in {mode} with feed-forward {} {symbol}/s; it must be 0",
                sample.feed_forward
            ),
        );
    }
}
