//! Clearance check: rejects a goal whose planned arm paths come too close to each other.
//!
//! Samples every path in the step order of the task executor. A hand at a meeting point keeps its
//! posture. If both hands can move, every pair of postures is compared.
//!
//! Between two samples, a body is at most half their distance from the nearer one; the gap is
//! reduced by that amount. Not covered: objects, the table, and recovery motions, which retrace the
//! paths.

use super::circumstances::Circumstances;
use super::fields::{FROM_X, TO_X};
use crate::goal::Goal;
use crate::kinematics::frame_of;
use crate::path::{Path, at_height, blend};
use crate::planning::{Waypoints, path_of};
use crate::settings::Settings;
use crate::tasks::{Motion, Step, Track, Transition, Waypoint};
use core::cell::Cell;
use core::ops::Range;
use robot_model::{
    Capsules, GraspFrame, HandModel, HandVector, Nearest, RobotVector, Side, VIRTUAL_FINGERS,
    farthest_move_m, nearest,
};
use shm_schemas::{Body, BodyPair, Cause, Reason};

/// Minimum planned distance between the arms, m. Must exceed the combined tracking error of both
/// arms: up to 7.5 mm from joint lag, servo compliance and link length errors of 1 mm
/// (`sim-backend/tests/closed_loop/apart.rs`, 70 seeds).
pub const CLEARANCE_M: f64 = 0.008;
/// Upper limit of the reported clearance margin, m (design choice: exceeds any lateral shift).
/// Applies to one-handed robots.
const SPARE_MAX_M: f64 = 1.0;
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
const OFF_PATH_M: f64 = 0.001;
const OFF_AXIS_RAD: f64 = 0.087;

/// Checks the paths of a goal whose values are already validated.
///
/// Returns the permitted deviation of each hand from its commanded grasp: [`Goal::spare_m`].
///
/// # Errors
/// [`Cause::UNREACHABLE`] if the arm has no posture, [`Cause::ARMS_COLLIDE`] with the two closest
/// bodies, [`Cause::TASK_TOO_LONG`] if the task needs too many postures.
pub(super) fn check_paths(
    goal: &Goal,
    now: &Circumstances<'_>,
    q_rad: &RobotVector,
) -> Result<f64, Reason> {
    let other = Side::BOTH[1 - goal.side().index()];
    let samples_left = Cell::new(SAMPLES_MAX);
    let mut acting = Walk::new(goal, goal.side(), (now, q_rad), &samples_left);
    let mut helping = Walk::new(goal, other, (now, q_rad), &samples_left);
    let gap = Gap::new(goal, &acting, &helping);
    loop {
        let reached = [helping.reached, acting.reached];
        let rounds = [acting.round(reached[0]), helping.round(reached[1])];
        if rounds.iter().all(Range::is_empty) {
            return Ok(gap.spare_m());
        }
        let (mut after, from) = (helping.clone(), helping.clone());
        after.follow(rounds[1].clone(), &mut |theirs| {
            gap.judge(&acting.standing(), theirs)
        })?;
        if rounds[1].is_empty() {
            let standing = after.standing();
            acting.follow(rounds[0].clone(), &mut |ours| gap.judge(ours, &standing))?;
        } else {
            acting.follow(rounds[0].clone(), &mut |ours| {
                let mut theirs = from.clone();
                theirs.follow(rounds[1].clone(), &mut |theirs| gap.judge(ours, theirs))
            })?;
        }
        helping = after;
    }
}

/// Bodies at a sample, and their maximum distance from it until the next one.
struct Sample {
    bodies: Capsules,
    about_m: f64,
    /// The hand has reached the target.
    at_target: bool,
}

/// Gap between the arms and its required minimum.
struct Gap {
    hands: [usize; 2],
    /// Required gap until the arms are first [`CLEARANCE_M`] apart, m. Lets arms that start too
    /// close separate.
    before_clear_m: Cell<Option<f64>>,
    both: bool,
    /// Smallest gap so far that depends on object positions, m.
    narrowest_m: Cell<f64>,
}

impl Gap {
    fn new(goal: &Goal, acting: &Walk<'_>, helping: &Walk<'_>) -> Self {
        let gap_m = nearest(&acting.bodies(), &helping.bodies()).gap_m;
        // Bodies are modelled slightly too large, so an overlap gives no usable gap.
        let half_m = if gap_m > 0.0 {
            gap_m / 2.0
        } else {
            f64::NEG_INFINITY
        };
        Self {
            hands: [goal.side().index(), 1 - goal.side().index()],
            before_clear_m: Cell::new((gap_m < CLEARANCE_M).then_some(half_m)),
            both: goal.demands().both_hands,
            narrowest_m: Cell::new(gap_m),
        }
    }

    /// Returns the permitted deviation of each hand, m: half the spare gap each if both take part.
    fn spare_m(&self) -> f64 {
        let beyond_m = (self.narrowest_m.get() - CLEARANCE_M).clamp(0.0, SPARE_MAX_M);
        if self.both { beyond_m / 2.0 } else { beyond_m }
    }

    fn judge(&self, ours: &Sample, theirs: &Sample) -> Result<(), Reason> {
        let Nearest { gap_m, joints } = nearest(&ours.bodies, &theirs.bodies);
        let gap_m = gap_m - ours.about_m - theirs.about_m;
        if !(self.both && ours.at_target) && gap_m < self.narrowest_m.get() {
            self.narrowest_m.set(gap_m);
        }
        if gap_m >= CLEARANCE_M {
            self.before_clear_m.set(None);
            return Ok(());
        }
        let needs_m = self.before_clear_m.get().unwrap_or(CLEARANCE_M);
        // A gap of minus infinity marks a NaN posture.
        if gap_m >= needs_m && gap_m.is_finite() {
            return Ok(());
        }
        let body = |i: usize| Body {
            hand: self.hands[i],
            joint: joints[i],
        };
        let bodies = BodyPair([body(0), body(1)]);
        Err(Reason::limit(Cause::ARMS_COLLIDE, gap_m, needs_m).about(bodies.index()))
    }
}

/// Simulated motion of one hand through its step sequence.
#[derive(Clone)]
struct Walk<'a> {
    hand: &'a HandModel,
    settings: &'a Settings,
    samples_left: &'a Cell<u32>,
    track: Option<Track>,
    waypoints: Waypoints,
    width_m: f64,
    next: usize,
    reached: u8,
    at: GraspFrame,
    q_rad: HandVector,
    /// Index of the goal value that defines the current place.
    place: usize,
    at_target: bool,
}

impl<'a> Walk<'a> {
    fn new(
        goal: &Goal,
        side: Side,
        (now, q_rad): (&Circumstances<'a>, &RobotVector),
        samples_left: &'a Cell<u32>,
    ) -> Self {
        let hand = now.robot.hand(side);
        let q_rad = now.hand_rad(q_rad, side);
        let at = frame_of(hand, &hand.forward(&q_rad));
        let (waypoints, width_m) = Waypoints::of(hand, &at, goal, now.settings);
        let acts = side == goal.side();
        let mut walk = Self {
            hand,
            settings: now.settings,
            samples_left,
            track: if acts {
                Some(goal.task().acting)
            } else {
                goal.task().helping
            },
            waypoints,
            width_m,
            next: 0,
            reached: 0,
            at,
            q_rad,
            place: if acts { FROM_X } else { TO_X },
            at_target: false,
        };
        walk.arrive();
        walk
    }

    fn bodies(&self) -> Capsules {
        self.hand.capsules(&self.hand.forward(&self.q_rad))
    }

    fn standing(&self) -> Sample {
        Sample {
            bodies: self.bodies(),
            about_m: 0.0,
            at_target: self.at_target,
        }
    }

    fn steps(&self) -> &[Step] {
        self.track.as_ref().map_or(&[], |track| track)
    }

    /// Returns the steps that need no meeting point beyond `peer_reached`.
    fn round(&self, peer_reached: u8) -> Range<usize> {
        let waits =
            |step: &Step| matches!(step.transition, Transition::Met(point) if point > peer_reached);
        let free = self.steps()[self.next..].iter().position(waits);
        self.next..free.map_or(self.steps().len(), |free| self.next + free)
    }

    /// Records the meeting point of the next step as reached.
    fn arrive(&mut self) {
        if let Some(Transition::Met(point)) =
            self.steps().get(self.next).map(|step| step.transition)
        {
            self.reached = point;
        }
    }

    /// Executes steps and visits every sample.
    fn follow(
        &mut self,
        steps: Range<usize>,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        for index in steps {
            let step = self.steps()[index];
            if step.motion.waypoint() == Some(Waypoint::OverTarget) {
                self.place = TO_X;
            }
            let path = path_of(
                step.motion,
                &self.at,
                &self.waypoints,
                &Path::stay(self.at),
                self.settings,
            );
            for end in path.ends() {
                self.go(end, visit)?;
            }
            self.at_target |= step.motion.waypoint() == Some(Waypoint::OverTarget);
            self.finish(&step, visit)?;
            self.next = index + 1;
            self.arrive();
        }
        Ok(())
    }

    /// Executes the motion that follows the path of a step: close, lower or turn.
    fn finish(
        &mut self,
        step: &Step,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let at = self.at;
        match (step.motion, step.transition) {
            (Motion::Lower, _) => {
                let lowest_m = at.centre_m.z - self.waypoints.lowering_m();
                self.go(at_height(&at, lowest_m), visit)?;
                self.go(at_height(&at, self.waypoints.expected_m()), visit)
            }
            (Motion::Square, _) => self.square(visit),
            (_, Transition::AllTouched | Transition::Gripped) => {
                let half_opening_m = [self.width_m / 2.0; VIRTUAL_FINGERS];
                let closed = GraspFrame {
                    half_opening_m,
                    ..at
                };
                self.go(closed, visit)
            }
            _ => Ok(()),
        }
    }

    /// Moves once around the square; further turns repeat the same postures.
    fn square(
        &mut self,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let (screw, at) = (&self.settings.screw, self.at);
        let travel_m = self.waypoints.turning() * screw.travel_m;
        let corners = [
            (travel_m, 0.0),
            (travel_m, screw.clearance_m),
            (-travel_m, screw.clearance_m),
            (-travel_m, 0.0),
        ];
        for (turned_m, away_m) in corners {
            let corner = GraspFrame {
                tangential_m: [turned_m, -turned_m],
                half_opening_m: at.half_opening_m.map(|half_m| half_m + away_m),
                ..at
            };
            self.go(corner, visit)?;
        }
        Ok(())
    }

    fn go(
        &mut self,
        to: GraspFrame,
        visit: &mut dyn FnMut(&Sample) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        let from = self.at;
        let samples = samples(&self.at, &to);
        let mut before = self.bodies();
        for sample in 1..=samples {
            let left = self.samples_left.get().checked_sub(1).ok_or(too_long())?;
            self.samples_left.set(left);
            let frame = blend(&from, &to, f64::from(sample) / f64::from(samples));
            self.bend(&frame, sample == samples)?;
            let bodies = self.bodies();
            let about_m = farthest_move_m(&before, &bodies) / 2.0;
            before.clone_from(&bodies);
            visit(&Sample {
                bodies,
                about_m,
                at_target: self.at_target,
            })?;
        }
        self.at = to;
        Ok(())
    }

    fn bend(&mut self, frame: &GraspFrame, rests: bool) -> Result<(), Reason> {
        // Fingertips tilt with the opening on some hands; their contact angle is checked at the
        // grasp.
        let iterations = if rests {
            ITERATIONS_AT_REST
        } else {
            ITERATIONS
        };
        let off_axis_rad = if rests && !self.hand.domes_tilt() {
            OFF_AXIS_RAD
        } else {
            f64::INFINITY
        };
        let target = frame.target(self.hand);
        let posture = self.hand.solve(&self.q_rad, &target, iterations);
        // False for NaN.
        if posture.tip_error_m <= OFF_PATH_M && posture.dome_error_rad <= off_axis_rad {
            self.q_rad = posture.q_rad;
            return Ok(());
        }
        let error_m = posture.tip_error_m;
        Err(Reason::limit(Cause::UNREACHABLE, error_m, 0.0).about(self.place))
    }
}

fn too_long() -> Reason {
    let most = f64::from(SAMPLES_MAX);
    Reason::limit(Cause::TASK_TOO_LONG, most, most)
}

/// Returns the number of samples for a motion.
fn samples(from: &GraspFrame, to: &GraspFrame) -> u32 {
    let turns = [
        to.closing_yaw_rad - from.closing_yaw_rad,
        to.hand_azimuth_rad - from.hand_azimuth_rad,
        to.hand_pitch_rad - from.hand_pitch_rad,
        to.root_rad - from.root_rad,
    ];
    let fingers = (0..VIRTUAL_FINGERS).flat_map(|f| {
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
