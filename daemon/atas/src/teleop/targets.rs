//! Target intake: validation of teleoperation targets.

use super::bounds::TeleopWorkspace;
use crate::goal::ActiveGoal;
use crate::tick::{Tick, nanoseconds};
use core::f64::consts::TAU;
use robot_model::{HandSide, RobotModel};
use shm_schemas::capacity::HANDS;
use shm_schemas::{GraspTarget, GripOrder, Hand, Reason, TargetField};

/// Longest validity of a target, s. Design choice: twice the period of the slowest stream, 1 Hz.
const VALID_MAX_S: f64 = 2.0;
/// Largest lead of a target's stamp over the tick, s. Design choice: clients paced by daemon
/// reports run late, never early; clocks are shared.
const STAMP_LEAD_MAX_S: f64 = 0.01;
/// Shortest time between warnings, s. Design choice: a bad 1 kHz stream must not fill the event
/// log.
const WARNING_PERIOD_S: f64 = 1.0;

/// Target that passed all checks; created by the intake only.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ValidatedTarget {
    target: GraspTarget,
    valid_until_ns: u64,
}

impl ValidatedTarget {
    /// Returns the point between the fingertips, m.
    #[must_use]
    pub fn centre_m(&self) -> [f64; 3] {
        self.target.centre_m
    }

    /// Returns the yaw of the closing axis, rad.
    #[must_use]
    pub fn closing_yaw_rad(&self) -> f64 {
        self.target.closing_yaw_rad
    }

    /// Returns the distance between the fingertips, m; ignored for grip command HOLD.
    #[must_use]
    pub fn opening_m(&self) -> f64 {
        self.target.opening_m
    }

    /// Returns the grip command.
    #[must_use]
    pub fn grip(&self) -> GripOrder {
        self.target.grip
    }
}

/// Target stream of the active teleoperation goal.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TargetIntake {
    /// Workspace per hand; `None` for a hand that cannot be teleoperated.
    workspaces: [Option<TeleopWorkspace>; HANDS],
    stream: Option<Stream>,
    newest: [Option<ValidatedTarget>; HANDS],
    last_warning_ns: Option<u64>,
}

/// Accepted stream.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Stream {
    writer_epoch: u64,
    opened_ns: u64,
    teleoperated: [bool; HANDS],
    next_sequence: u64,
}

impl TargetIntake {
    /// Creates an intake without a stream.
    #[must_use]
    pub fn new(robot: &RobotModel) -> Self {
        Self {
            workspaces: HandSide::BOTH.map(|side| TeleopWorkspace::new(robot, side)),
            stream: None,
            newest: [None; HANDS],
            last_warning_ns: None,
        }
    }

    /// Accepts this goal's stream from now on, or none.
    pub fn set_goal(&mut self, goal: Option<&ActiveGoal>, tick: Tick) {
        let stream = goal.filter(|goal| goal.request.kind.is_stream());
        self.newest = [None; HANDS];
        self.last_warning_ns = None;
        self.stream = stream.map(|goal| Stream {
            writer_epoch: goal.request.stamp.writer_epoch,
            opened_ns: tick.now_ns,
            teleoperated: HandSide::BOTH.map(|side| goal.involves(side)),
            next_sequence: 0,
        });
    }

    /// Processes new targets, oldest first; returns a warning, if any.
    pub fn update(&mut self, targets: &[GraspTarget], tick: Tick) -> Reason {
        let mut finding = Reason::None;
        let Some(stream) = self.stream.as_mut() else {
            // A goal that has just ended may leave targets behind.
            return finding;
        };
        for target in targets {
            match stream.check(target, &self.workspaces, tick) {
                Ok((hand, checked)) => self.newest[hand] = Some(checked),
                Err(reason) => finding = reason,
            }
        }
        for (hand, newest) in self.newest.iter_mut().enumerate() {
            if newest.is_some_and(|target| target.valid_until_ns < tick.now_ns) {
                *newest = None;
                let hand = Hand::BOTH[hand];
                finding = Reason::TargetsStopped { hand };
            }
        }
        self.rate_limit(finding, tick)
    }

    /// Returns the valid target of a hand.
    #[must_use]
    pub fn target(&self, side: HandSide) -> Option<&ValidatedTarget> {
        self.newest[side.index()].as_ref()
    }

    /// Suppresses warnings that follow too soon.
    fn rate_limit(&mut self, finding: Reason, tick: Tick) -> Reason {
        let again_ns = self.last_warning_ns.map_or(0, |warned_ns| {
            warned_ns.saturating_add(nanoseconds(WARNING_PERIOD_S))
        });
        if !finding.is_some() || tick.now_ns < again_ns {
            return Reason::None;
        }
        self.last_warning_ns = Some(tick.now_ns);
        finding
    }
}

impl Stream {
    /// Validates a target; returns it with its hand. Ownership is checked before values.
    fn check(
        &mut self,
        target: &GraspTarget,
        spaces: &[Option<TeleopWorkspace>; HANDS],
        tick: Tick,
    ) -> Result<(usize, ValidatedTarget), Reason> {
        if !target.is_intact() {
            return Err(Reason::TargetCorrupt);
        }
        if target.stamp.writer_epoch != self.writer_epoch {
            return Err(Reason::TargetForeign);
        }
        let valid_until_ns = self.check_time(target, tick)?;
        let unknown = |code: u32| Reason::TargetUnknown { code };
        let hand = target.hand.index().filter(|hand| self.teleoperated[*hand]);
        let hand = hand.ok_or(unknown(target.hand.0))?;
        if !target.grip.is_known() {
            return Err(unknown(target.grip.0));
        }
        let space = spaces[hand].ok_or(unknown(target.hand.0))?;
        check_values(target, &space)?;
        self.next_sequence = target.stamp.sequence.saturating_add(1);
        let target = *target;
        Ok((
            hand,
            ValidatedTarget {
                target,
                valid_until_ns,
            },
        ))
    }

    /// Returns the end of validity, ns.
    fn check_time(&self, target: &GraspTarget, tick: Tick) -> Result<u64, Reason> {
        let (made_ns, until_ns) = (target.stamp.captured_ns, target.valid_until_ns);
        let late_ns = tick.now_ns.saturating_sub(until_ns);
        let ahead = made_ns > tick.now_ns.saturating_add(nanoseconds(STAMP_LEAD_MAX_S));
        let before_goal = made_ns.saturating_add(nanoseconds(STAMP_LEAD_MAX_S)) < self.opened_ns;
        let out_of_turn = target.stamp.sequence < self.next_sequence;
        if late_ns > 0 || ahead || before_goal || out_of_turn {
            let late_ns = late_ns as f64;
            return Err(Reason::TargetStale { late_ns });
        }
        Ok(until_ns.min(tick.now_ns.saturating_add(nanoseconds(VALID_MAX_S))))
    }
}

fn check_values(target: &GraspTarget, space: &TeleopWorkspace) -> Result<(), Reason> {
    let values = target.values();
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        let field = TargetField(index as u32);
        return Err(Reason::TargetNotFinite { field });
    }
    let [x_m, y_m, z_m] = space.centre_m;
    let opening_m = match target.grip {
        GripOrder::HOLD => [f64::NEG_INFINITY, f64::INFINITY],
        _ => space.opening_m,
    };
    let ranges = [x_m, y_m, z_m, [-TAU, TAU], opening_m];
    for (index, (value, [lower, upper])) in values.into_iter().zip(ranges).enumerate() {
        if value < lower || value > upper {
            let limit = if value < lower { lower } else { upper };
            return Err(Reason::TargetOutOfRange {
                field: TargetField(index as u32),
                value,
                limit,
            });
        }
    }
    Ok(())
}
