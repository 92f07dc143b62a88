//! Where the arms will go: every path of a goal's task is followed in thought before anything moves, and no body of one
//! arm may come too near to one of the other.
//!
//! Each hand walks through its steps as the runner will, posture by posture. A hand that waits at a meeting point stands
//! where it came to; hands that are free to move at the same time are compared at every pair of their postures. Between
//! two samples an arm is at most half of what it moved from the nearer one, and that much is taken off the gap. The number
//! of postures is bounded: a task that needs more is refused.
//!
//! Absent on purpose: objects, the table, and the retreats from what goes wrong, which lead back along the same ways.

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

/// Least distance between the arms as planned, m. Measured: how far both together are from where their commands would have
/// them, because joints lag in motion, servos give way to loads, and links are not as long as their model's, by up to 1 mm
/// each: up to 7.5 mm (`sim-backend/tests/closed_loop/apart.rs`, 70 seeds).
pub const CLEARANCE_M: f64 = 0.008;
/// Most that a goal is told to have to spare, m (ours: more than any hand goes aside; a robot of one hand has no other).
const SPARE_MAX_M: f64 = 1.0;
/// Longest way of the hand, m, and widest turn, rad, between two samples (ours: an arm's bodies then move some 8 mm).
const SAMPLE_M: f64 = 0.004;
const SAMPLE_RAD: f64 = 0.02;
/// Most postures of one check (ours: built-in tasks need a few thousand; this many take a second or two, off every clock).
const SAMPLES_MAX: u32 = 100_000;
/// Steps of inverse kinematics for each sample (ours: with them the tips are met within a micrometre).
const ITERATIONS: usize = 6;
/// The same where a way ends and the arm comes to rest.
const ITERATIONS_AT_REST: usize = 30;
/// Farthest that the tips may stay off their path, m (ours: what the contact guard would not notice), and their axes at its
/// end, rad (ours: 5°, well within the cone of 33° that a dome feels).
const OFF_PATH_M: f64 = 0.001;
const OFF_AXIS_RAD: f64 = 0.087;

/// Follows the task of a goal whose numbers were checked.
///
/// Returns how far each hand may grasp beside where it was told without coming too near to the other: [`Goal::spare_m`].
///
/// # Errors
/// [`Cause::UNREACHABLE`] where the arm has no posture, [`Cause::ARMS_COLLIDE`] with the two bodies that come too near.
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

/// Where a hand is, and how far its bodies may be from there.
struct Sample {
    bodies: Capsules,
    about_m: f64,
    /// The hand has come to where it sets down what it holds.
    at_target: bool,
}

/// The gap between the arms, and how wide it must be.
struct Gap {
    hands: [usize; 2],
    /// Arms that begin too near may go apart: until they have, this is what counts instead of [`CLEARANCE_M`], m.
    before_clear_m: Cell<Option<f64>>,
    /// Whether both hands take part.
    both: bool,
    /// The narrowest gap so far of those in which it matters where the objects stand, m.
    narrowest_m: Cell<f64>,
}

impl Gap {
    fn new(goal: &Goal, acting: &Walk<'_>, helping: &Walk<'_>) -> Self {
        let gap_m = nearest(&acting.bodies(), &helping.bodies()).gap_m;
        // Bodies are a little larger than what they stand for: where they overlap, nothing can be said.
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

    /// How far each hand may be beside its way, m. One that sets down onto what the other holds is displaced with that.
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
        // A gap that is minus infinite stands for what is not a number.
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

/// One hand on its way through its track.
#[derive(Clone)]
struct Walk<'a> {
    hand: &'a HandModel,
    settings: &'a Settings,
    /// Postures that this check may still look at.
    samples_left: &'a Cell<u32>,
    track: Option<Track>,
    waypoints: Waypoints,
    width_m: f64,
    /// The step to be done next.
    next: usize,
    /// The meeting point that it has come to.
    reached: u8,
    at: GraspFrame,
    q_rad: HandVector,
    /// Index of the goal's value that the present place belongs to.
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

    /// The steps that the hand can do before it has to wait for another that has come to this point.
    fn round(&self, peer_reached: u8) -> Range<usize> {
        let waits =
            |step: &Step| matches!(step.transition, Transition::Met(point) if point > peer_reached);
        let free = self.steps()[self.next..].iter().position(waits);
        self.next..free.map_or(self.steps().len(), |free| self.next + free)
    }

    /// Comes to the meeting point that the next step waits at.
    fn arrive(&mut self) {
        if let Some(Transition::Met(point)) =
            self.steps().get(self.next).map(|step| step.transition)
        {
            self.reached = point;
        }
    }

    /// Does some steps, telling every sample on the way.
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

    /// What a step does besides its path: closes on the object, lowers it, turns it.
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

    /// Once around the square, which does not move the hand any farther.
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

    /// Goes to a pose.
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

    /// Takes the posture of a pose.
    fn bend(&mut self, frame: &GraspFrame, rests: bool) -> Result<(), Reason> {
        // Domes that tilt do so the more the wider the hand is open; how they touch is checked at the grasp.
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
        // False for what is not a number.
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

/// How many samples a way needs.
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
