//! Clearance check: rejects a goal whose planned arm paths come too close to each other.
//!
//! Samples every path in the step order of the task executor. A hand at a meeting point keeps its
//! posture. If both hands can move, every pair of postures is compared.
//!
//! Between two samples, a body is at most half their distance from the nearer one; the gap is
//! reduced by that amount. Not covered: objects, the table, and recovery motions, which retrace the
//! paths.

use super::context::GoalContext;
use crate::goal::Goal;
use crate::kinematics::grasp_pose;
use crate::path::{Path, blend, with_height};
use crate::planning::{Waypoints, path_of};
use crate::settings::Settings;
use crate::tasks::{Motion, Step, StepSequence, Transition, Waypoint};
use core::cell::Cell;
use core::ops::Range;
use robot_model::{
    Capsules, GraspPose, GraspSide, HandModel, HandSide, HandVector, Nearest, PerSide, RobotVector,
    farthest_move_m, nearest,
};
use shm_schemas::{Body, BodyPair, GoalField, Reason};

/// Minimum planned distance between the arms, m. Must exceed the combined tracking error of both
/// arms: up to 7.5 mm from joint lag, servo compliance and link length errors of 1 mm
/// (`sim-backend/tests/closed_loop/apart.rs`, 70 seeds).
pub const CLEARANCE_M: f64 = 0.008;
/// Upper limit of the reported clearance margin, m (design choice: exceeds any lateral shift).
/// Applies to one-handed robots.
const CLEARANCE_MARGIN_MAX_M: f64 = 1.0;
/// Maximum translation, m, and rotation, rad, between two samples (design choice: bodies move about
/// 8 mm).
const SAMPLE_M: f64 = 0.004;
const SAMPLE_RAD: f64 = 0.02;
/// Maximum number of postures per check (design choice). Built-in tasks need a few thousand; the
/// limit takes one to two seconds.
const SAMPLES_MAX: u32 = 100_000;
/// Inverse kinematics iterations per sample (design choice: fingertip error below 1 µm).
const ITERATIONS: usize = 6;
/// Inverse kinematics iterations at the end of a path, where the arm stops.
const ITERATIONS_AT_REST: usize = 30;
/// Maximum fingertip error along the path, m (design choice: below the resolution of the contact
/// guard), and axis error at its end, rad (design choice: 5°, within the 33° sensing cone of a
/// fingertip).
const PATH_ERROR_MAX_M: f64 = 0.001;
const AXIS_ERROR_MAX_RAD: f64 = 0.087;

/// Checks the paths of a goal whose values are already validated.
///
/// Returns the permitted deviation of each hand from its commanded grasp:
/// [`Goal::clearance_margin_m`].
///
/// # Errors
/// [`Reason::NoPosture`] if the arm has no posture, [`Reason::ArmsCollide`] with the two closest
/// bodies, [`Reason::TaskTooLong`] if the task needs too many postures.
pub(super) fn check_paths(
    goal: &Goal,
    now: &GoalContext<'_>,
    q: &RobotVector,
) -> Result<f64, Reason> {
    let other = HandSide::BOTH[1 - goal.side().index()];
    let samples_left = Cell::new(SAMPLES_MAX);
    let mut acting = PathWalker::new(goal, goal.side(), (now, q), &samples_left);
    let mut helping = PathWalker::new(goal, other, (now, q), &samples_left);
    let gap = Gap::new(goal, &acting, &helping);
    loop {
        let reached = [helping.reached, acting.reached];
        let rounds = [
            acting.runnable_steps(reached[0]),
            helping.runnable_steps(reached[1]),
        ];
        if rounds.iter().all(Range::is_empty) {
            return Ok(gap.clearance_margin_m());
        }
        let (mut after, from) = (helping.clone(), helping.clone());
        after.run_steps(rounds[1].clone(), &mut |theirs| {
            gap.check(&acting.sample(), theirs)
        })?;
        if rounds[1].is_empty() {
            let standing = after.sample();
            acting.run_steps(rounds[0].clone(), &mut |ours| gap.check(ours, &standing))?;
        } else {
            acting.run_steps(rounds[0].clone(), &mut |ours| {
                let mut theirs = from.clone();
                theirs.run_steps(rounds[1].clone(), &mut |theirs| gap.check(ours, theirs))
            })?;
        }
        helping = after;
    }
}

/// Bodies at a sample, and their maximum distance from it until the next one.
struct Sample {
    bodies: Capsules,
    uncertainty_m: f64,
    /// The hand has reached the target.
    at_target: bool,
}

/// Gap between the arms and its required minimum.
struct Gap {
    hands: [usize; 2],
    /// Required gap until the arms are first [`CLEARANCE_M`] apart, m. Lets arms that start too
    /// close separate.
    initial_limit_m: Cell<Option<f64>>,
    both_hands: bool,
    /// Smallest gap so far that depends on object positions, m.
    narrowest_m: Cell<f64>,
}

impl Gap {
    fn new(goal: &Goal, acting: &PathWalker<'_>, helping: &PathWalker<'_>) -> Self {
        let gap_m = nearest(&acting.bodies(), &helping.bodies()).gap_m;
        // Bodies are modelled slightly too large, so an overlap gives no usable gap.
        let half_m = if gap_m > 0.0 {
            gap_m / 2.0
        } else {
            f64::NEG_INFINITY
        };
        Self {
            hands: [goal.side().index(), 1 - goal.side().index()],
            initial_limit_m: Cell::new((gap_m < CLEARANCE_M).then_some(half_m)),
            both_hands: goal.requirements().both_hands,
            narrowest_m: Cell::new(gap_m),
        }
    }

    /// Returns the permitted deviation of each hand, m: half the spare gap each if both take part.
    fn clearance_margin_m(&self) -> f64 {
        let beyond_m = (self.narrowest_m.get() - CLEARANCE_M).clamp(0.0, CLEARANCE_MARGIN_MAX_M);
        if self.both_hands {
            beyond_m / 2.0
        } else {
            beyond_m
        }
    }

    fn check(&self, ours: &Sample, theirs: &Sample) -> Result<(), Reason> {
        let Nearest { gap_m, joints } = nearest(&ours.bodies, &theirs.bodies);
        let gap_m = gap_m - ours.uncertainty_m - theirs.uncertainty_m;
        if !(self.both_hands && ours.at_target) && gap_m < self.narrowest_m.get() {
            self.narrowest_m.set(gap_m);
        }
        if gap_m >= CLEARANCE_M {
            self.initial_limit_m.set(None);
            return Ok(());
        }
        let needs_m = self.initial_limit_m.get().unwrap_or(CLEARANCE_M);
        // A gap of minus infinity marks a NaN posture.
        if gap_m >= needs_m && gap_m.is_finite() {
            return Ok(());
        }
        let body = |i: usize| Body {
            hand: self.hands[i],
            joint: joints[i],
        };
        Err(Reason::ArmsCollide {
            bodies: Some(BodyPair([body(0), body(1)])),
            gap_m,
            limit_m: needs_m,
        })
    }
}

/// Simulated motion of one hand through its step sequence.
#[derive(Clone)]
struct PathWalker<'a> {
    hand: &'a HandModel,
    settings: &'a Settings,
    samples_left: &'a Cell<u32>,
    sequence: Option<StepSequence>,
    waypoints: Waypoints,
    width_m: f64,
    next: usize,
    reached: u8,
    pose: GraspPose,
    q: HandVector,
    /// First field of the current place.
    place: GoalField,
    at_target: bool,
}

impl<'a> PathWalker<'a> {
    fn new(
        goal: &Goal,
        side: HandSide,
        (now, q): (&GoalContext<'a>, &RobotVector),
        samples_left: &'a Cell<u32>,
    ) -> Self {
        let hand = now.robot.hand(side);
        let q = now.hand_position(q, side);
        let at = grasp_pose(hand, &hand.forward(&q));
        let (waypoints, width_m) = Waypoints::for_goal(hand, &at, goal, now.settings);
        let acts = side == goal.side();
        let mut walk = Self {
            hand,
            settings: now.settings,
            samples_left,
            sequence: if acts {
                Some(goal.task().acting)
            } else {
                goal.task().helping
            },
            waypoints,
            width_m,
            next: 0,
            reached: 0,
            pose: at,
            q,
            place: if acts {
                GoalField::FROM_X
            } else {
                GoalField::TO_X
            },
            at_target: false,
        };
        walk.reach_meeting_point();
        walk
    }

    fn bodies(&self) -> Capsules {
        self.hand.capsules(&self.hand.forward(&self.q))
    }

    fn sample(&self) -> Sample {
        Sample {
            bodies: self.bodies(),
            uncertainty_m: 0.0,
            at_target: self.at_target,
        }
    }

    fn steps(&self) -> &[Step] {
        self.sequence.as_ref().map_or(&[], |track| track)
    }

    /// Returns the steps that need no meeting point beyond `peer_reached`.
    fn runnable_steps(&self, peer_reached: u8) -> Range<usize> {
        let waits =
            |step: &Step| matches!(step.transition, Transition::Met(point) if point > peer_reached);
        let free = self.steps()[self.next..].iter().position(waits);
        self.next..free.map_or(self.steps().len(), |free| self.next + free)
    }

    /// Records the meeting point of the next step as reached.
    fn reach_meeting_point(&mut self) {
        if let Some(Transition::Met(point)) =
            self.steps().get(self.next).map(|step| step.transition)
        {
            self.reached = point;
        }
    }

    /// Executes steps and visits every sample.
    fn run_steps(
        &mut self,
        steps: Range<usize>,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        for index in steps {
            let step = self.steps()[index];
            if step.motion.waypoint() == Some(Waypoint::OverTarget) {
                self.place = GoalField::TO_X;
            }
            let path = path_of(
                step.motion,
                &self.pose,
                &self.waypoints,
                &Path::stationary(self.pose),
                self.settings,
            );
            for end in path.leg_ends() {
                self.move_to(end, visit)?;
            }
            self.at_target |= step.motion.waypoint() == Some(Waypoint::OverTarget);
            self.finish_step(&step, visit)?;
            self.next = index + 1;
            self.reach_meeting_point();
        }
        Ok(())
    }

    /// Executes the motion that follows the path of a step: close, lower or turn.
    fn finish_step(
        &mut self,
        step: &Step,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let at = self.pose;
        match (step.motion, step.transition) {
            (Motion::Lower, _) => {
                let lowest_m = at.centre_m.z - self.waypoints.lowering_m();
                self.move_to(with_height(&at, lowest_m), visit)?;
                self.move_to(with_height(&at, self.waypoints.expected_height_m()), visit)
            }
            (Motion::Square, _) => self.square(visit),
            (_, Transition::AllTouched | Transition::Gripped) => {
                let half_opening_m = PerSide::repeat(self.width_m / 2.0);
                let closed = GraspPose {
                    half_opening_m,
                    ..at
                };
                self.move_to(closed, visit)
            }
            _ => Ok(()),
        }
    }

    /// Moves once around the square; further turns repeat the same postures.
    fn square(
        &mut self,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let (screw, at) = (&self.settings.screw, self.pose);
        let travel_m = self.waypoints.turning() * screw.travel_m;
        let corners = [
            (travel_m, 0.0),
            (travel_m, screw.clearance_m),
            (-travel_m, screw.clearance_m),
            (-travel_m, 0.0),
        ];
        for (turned_m, away_m) in corners {
            let corner = GraspPose {
                tangential_m: PerSide::new(turned_m, -turned_m),
                half_opening_m: at.half_opening_m.map(|half_m| half_m + away_m),
                ..at
            };
            self.move_to(corner, visit)?;
        }
        Ok(())
    }

    fn move_to(
        &mut self,
        to: GraspPose,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let from = self.pose;
        let samples = sample_count(&self.pose, &to);
        let mut before = self.bodies();
        for sample in 1..=samples {
            let left = self
                .samples_left
                .get()
                .checked_sub(1)
                .ok_or(task_too_long())?;
            self.samples_left.set(left);
            let frame = blend(&from, &to, f64::from(sample) / f64::from(samples));
            self.solve_posture(&frame, sample == samples)?;
            let bodies = self.bodies();
            let about_m = farthest_move_m(&before, &bodies) / 2.0;
            before.clone_from(&bodies);
            visit(&Sample {
                bodies,
                uncertainty_m: about_m,
                at_target: self.at_target,
            })?;
        }
        self.pose = to;
        Ok(())
    }

    fn solve_posture(&mut self, frame: &GraspPose, rests: bool) -> Result<(), Reason> {
        // Fingertips tilt with the opening on some hands; their contact angle is checked at the
        // grasp.
        let iterations = if rests {
            ITERATIONS_AT_REST
        } else {
            ITERATIONS
        };
        let off_axis_rad = if rests && !self.hand.domes_tilt() {
            AXIS_ERROR_MAX_RAD
        } else {
            f64::INFINITY
        };
        let target = frame.target(self.hand);
        let posture = self.hand.solve(&self.q, &target, iterations);
        // False for NaN.
        if posture.tip_error_m <= PATH_ERROR_MAX_M && posture.dome_error_rad <= off_axis_rad {
            self.q = posture.q;
            return Ok(());
        }
        Err(Reason::NoPosture {
            place: self.place,
            error_m: posture.tip_error_m,
        })
    }
}

fn task_too_long() -> Reason {
    Reason::TaskTooLong {
        postures: SAMPLES_MAX,
        limit: SAMPLES_MAX,
    }
}

/// Returns the number of samples for a motion.
fn sample_count(from: &GraspPose, to: &GraspPose) -> u32 {
    let turns = [
        to.closing_yaw_rad - from.closing_yaw_rad,
        to.hand_azimuth_rad - from.hand_azimuth_rad,
        to.hand_pitch_rad - from.hand_pitch_rad,
        to.root_rad - from.root_rad,
    ];
    let fingers = GraspSide::BOTH.into_iter().flat_map(|f| {
        [
            to.half_opening_m[f] - from.half_opening_m[f],
            to.tangential_m[f] - from.tangential_m[f],
            to.up_m[f] - from.up_m[f],
        ]
    });
    let most = turns
        .into_iter()
        .map(|turn_rad| turn_rad.abs() / SAMPLE_RAD)
        .chain(fingers.map(|way_m| way_m.abs() / SAMPLE_M))
        .chain([(to.centre_m - from.centre_m).norm() / SAMPLE_M])
        .fold(1.0, f64::max);
    libm::ceil(most) as u32
}

#[cfg(test)]
mod gap_tests;
#[cfg(test)]
mod walk_tests;
