//! Pilot: guides one robot through the course, from the state of its base and hand.
//!
//! **In:** [`BaseState`] and ground truth of the object per frame, the daemon's reports and goal
//! updates. **Out:** a [`BaseCommand`] per frame, and goals. Runs unchanged in process and on the
//! bus.

use atas_client::GoalProgress;
use atas_client::goal::{HOLD_S, LIFT_M};
use atas_core::modules::Selection;
use atas_core::tasks::{FETCH, Name, Step, StepSequence, Task, Transition};
use robot_model::{GRASP_SIDES, GraspSides, RobotModel};
use serde::Serialize;
use shm_schemas::{
    BaseCommand, BaseState, ControlOwner, GoalKind, GoalRequest, GoalState, GoalUpdate, Light,
    Mishap, ModuleId, Reason, Stamp, Text, TickReport, WorldTruth,
};
use sim_backend::GraspHint;
use sim_backend::course::{self, FRAME_S, RobotSetup, SIDE};
use sim_backend::random::Random;

use super::coordinator::{self, Conditions, Coordinator, Ended, HandState, HandTask};
use crate::goals::{grasp_goal, set_down_goal};
use crate::judge::Placing;

/// Random stream of the camera errors.
const CAMERA_STREAM: u64 = 0x63_616d;
/// Half widths of the camera errors: position (m), yaw (rad), as in every family (±2 mm, ±5°).
const CAMERA_ERROR_M: f64 = 0.002;
const CAMERA_ERROR_RAD: f64 = 5.0 * core::f64::consts::PI / 180.0;
/// Normal force of a grasp side in contact, N; as for the grasp.
const CONTACT_N: f64 = 0.03;
/// Custom task: grasp and lift, then Module 3 only.
const FETCH_FROZEN: &str = "fetch-frozen";

/// Reflex modules during the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reflexes {
    /// Modules 2 and 3 react to disturbances.
    On,
    /// Fingers keep their positions after the lift.
    Frozen,
}

impl Reflexes {
    fn task(self) -> Name {
        match self {
            Self::On => FETCH.name,
            Self::Frozen => Name::new(FETCH_FROZEN),
        }
    }

    /// Returns the custom task for the controller; `None` if the task is built in.
    pub(super) fn custom_task(self) -> Option<Task> {
        let freeze = |step: &Step| Step {
            modules: match step.transition {
                Transition::Held => Selection::from_modules(&[ModuleId::FORCE_LIMIT]),
                _ => step.modules,
            },
            ..*step
        };
        let steps: Vec<Step> = FETCH.acting.iter().map(freeze).collect();
        let frozen = Task {
            name: self.task(),
            // The number of steps is unchanged: never rejected.
            acting: StepSequence::validated(&steps).unwrap_or(FETCH.acting),
            ..FETCH
        };
        (self == Self::Frozen).then_some(frozen)
    }
}

/// Time of a robot in one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseTime {
    /// Name of the phase.
    pub phase: &'static str,
    /// Start time, s.
    pub began_s: f64,
    /// Duration, s.
    pub took_s: f64,
}

/// Pilot of one robot.
pub struct Pilot {
    coordinator: Coordinator,
    camera: Random,
    reflexes: Reflexes,
    sides: GraspSides,
    nominal: GraspHint,
    measured: Option<GraspHint>,
    goal: Option<GoalRequest>,
    progress: GoalProgress,
    hand: HandState,
    holds: bool,
    times: Vec<PhaseTime>,
}

/// Output of one frame.
#[derive(Clone, Copy, Debug)]
pub struct Decision {
    /// Command for the base.
    pub command: BaseCommand,
    /// New goal of the hand, if any; must be requested before the next tick.
    pub goal: Option<GoalRequest>,
    /// Phase that has begun, if any.
    pub began: Option<&'static str>,
}

impl Pilot {
    /// Creates the pilot of a robot at its start, with the robot's model.
    #[must_use]
    pub fn new(player: &RobotSetup, robot: &RobotModel, reflexes: Reflexes) -> Self {
        Self {
            coordinator: Coordinator::default(),
            camera: Random::new(player.seed, CAMERA_STREAM),
            reflexes,
            sides: robot.hand(SIDE).grasp_sides(),
            nominal: player.hint,
            measured: None,
            goal: None,
            progress: GoalProgress::default(),
            hand: HandState::default(),
            holds: false,
            times: Vec::new(),
        }
    }

    /// Runs one frame. `truth` is used only to simulate the camera measurement of the object.
    pub fn frame(&mut self, state: &BaseState, truth: &WorldTruth) -> Decision {
        let signs = Conditions {
            light_m: light_m(state, self.light()),
            stands: state.wheels_stopped != 0,
            hand: self.hand,
            holds: self.holds,
            first_m: state
                .right_of_way_m
                .is_finite()
                .then_some(state.right_of_way_m),
        };
        if state.mishap != Mishap::NONE {
            self.coordinator.fail("mishap");
        }
        let began = self.coordinator.update(&signs, FRAME_S) || self.times.is_empty();
        let goal = if began {
            self.begin(state, truth)
        } else {
            None
        };
        self.record_time(state, began);
        let phase = self.coordinator.phase();
        let owner = match (self.coordinator.ended(), phase.owner) {
            (Some(_), _) => ControlOwner::OVER,
            (None, coordinator::ControlOwner::Table) => ControlOwner::TABLE,
            (None, coordinator::ControlOwner::Brake) => ControlOwner::NONE,
            (None, coordinator::ControlOwner::Hand(_)) => ControlOwner::HAND,
        };
        Decision {
            command: BaseCommand {
                stamp: Stamp {
                    captured_ns: state.stamp.captured_ns,
                    ..Stamp::default()
                },
                frame: state.frame,
                owner,
                light: match self.light() {
                    course::Light::Object => Light::OBJECT,
                    course::Light::Goal => Light::GOAL,
                },
            },
            goal,
            began: began.then_some(phase.name),
        }
    }

    fn light(&self) -> course::Light {
        self.coordinator.phase().light
    }

    fn begin(&mut self, state: &BaseState, truth: &WorldTruth) -> Option<GoalRequest> {
        let goal = match self.coordinator.phase().owner {
            coordinator::ControlOwner::Hand(HandTask::Grasp) => {
                let seen = self.measure_object(truth);
                self.measured = Some(seen);
                GoalRequest {
                    kind: GoalKind::CUSTOM,
                    task: Text::new(self.reflexes.task().as_str()),
                    ..grasp_goal(&seen, SIDE, LIFT_M, HOLD_S)
                }
            }
            coordinator::ControlOwner::Hand(HandTask::SetDown) => {
                let ([x_m, y_m], seen) = (light_m(state, self.light())?, self.measured?);
                let to_m = [x_m, y_m, seen.from_m[2]];
                GoalRequest {
                    goal_id: 2,
                    ..set_down_goal(&seen, SIDE, to_m, LIFT_M)
                }
            }
            coordinator::ControlOwner::Table | coordinator::ControlOwner::Brake => return None,
        };
        self.progress = GoalProgress::default();
        (self.goal, self.hand) = (Some(goal), HandState::Busy);
        Some(goal)
    }

    fn measure_object(&mut self, truth: &WorldTruth) -> GraspHint {
        let object = &truth.objects[0];
        let mut off = |half_width: f64| self.camera.between(-half_width, half_width);
        let [w, .., z] = object.orientation;
        let [x_m, y_m, _] = object.position_m;
        GraspHint {
            from_m: [
                x_m + off(CAMERA_ERROR_M),
                y_m + off(CAMERA_ERROR_M),
                self.nominal.from_m[2],
            ],
            yaw_rad: wrap_half_turn(2.0 * libm::atan2(z, w)) + off(CAMERA_ERROR_RAD),
            ..self.nominal
        }
    }

    fn record_time(&mut self, state: &BaseState, began: bool) {
        let now_s = (state.frame * course::FRAME_TICKS) as f64 * 1e-3;
        if began {
            self.times.push(PhaseTime {
                phase: self.coordinator.phase().name,
                began_s: now_s,
                took_s: 0.0,
            });
        }
        if let Some(last) = self.times.last_mut() {
            last.took_s = now_s - last.began_s;
        }
    }

    /// Processes the rejection of the requested goal.
    pub fn process_rejection(&mut self, reason: Reason) {
        self.process_goal_update(&GoalUpdate {
            goal_id: self.goal.map_or(0, |goal| goal.goal_id),
            state: GoalState::REJECTED,
            reason: reason.into(),
            ..GoalUpdate::default()
        });
    }

    /// Processes a goal update; ignores other goals.
    pub fn process_goal_update(&mut self, update: &GoalUpdate) {
        if self.goal.is_none_or(|goal| goal.goal_id != update.goal_id) {
            return;
        }
        self.progress.add(update);
        self.hand = match update.state {
            GoalState::SUCCEEDED => HandState::Done,
            state if state.is_final() => HandState::Failed,
            _ => HandState::Busy,
        };
    }

    /// Processes the report of the last tick before a frame.
    pub fn process_report(&mut self, report: &TickReport) {
        let fingers = &report.hands[SIDE.index()].fingers;
        let normal_n = |fingertip: usize| f64::from(fingers[fingertip].normal_n);
        self.holds = self.sides.both_exceed(CONTACT_N, normal_n);
    }

    /// Returns the result once the course has ended.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.coordinator.ended()
    }

    /// Returns the phases so far with their times.
    #[must_use]
    pub fn times(&self) -> &[PhaseTime] {
        &self.times
    }

    /// Returns the progress of the hand's last goal.
    #[must_use]
    pub fn progress(&self) -> &GoalProgress {
        &self.progress
    }

    /// Returns the measured normal force per grasp side of the hand's last goal, N.
    pub(super) fn grip_n(&self) -> [f32; GRASP_SIDES] {
        let normal_n = &self.progress.figures().normal_n;
        let sums_n = self.sides.sums(|fingertip| normal_n[fingertip].into());
        sums_n.map(|sum_n| sum_n as f32).into_array()
    }

    pub(super) fn hand_failure(&self) -> Option<String> {
        let last = self.progress.last();
        (self.hand == HandState::Failed).then(|| last.reason.cause.to_string())
    }

    pub(super) fn placing(&self, truth: &WorldTruth) -> Placing {
        let to_m = self
            .goal
            .map_or([0.0; 2], |goal| [goal.to_m[0], goal.to_m[1]]);
        let let_go_ns = self.progress.released_ns();
        Placing::evaluate(self.progress.last(), truth, to_m, let_go_ns)
    }
}

fn light_m(state: &BaseState, light: course::Light) -> Option<[f64; 2]> {
    match light {
        course::Light::Object => (state.object_stands != 0).then_some(state.object_m),
        course::Light::Goal => Some(state.goal_m),
    }
}

/// Returns the yaw within a quarter turn of y. Half a turn gives the same grasp.
fn wrap_half_turn(yaw_rad: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    yaw_rad - PI * ((yaw_rad - FRAC_PI_2) / PI).round()
}

#[cfg(test)]
mod tests {
    use sim_backend::Object;
    use sim_backend::course::Scenario;

    use super::*;

    /// Regression: the pilot looked at the first two fingertips only, both on side 1 of this hand.
    #[test]
    fn grip_without_thumb_is_no_grip() {
        let objects = [Object::built_in("wood").expect("built in")];
        let cast = Scenario::random(1, &objects).expect("a course");
        let check = |robot: &str, normal_n: [f32; 3], expected| {
            let robot = RobotModel::find(robot).expect("built-in robot");
            let mut pilot = Pilot::new(&cast.robots[0], &robot, Reflexes::On);
            let mut report = TickReport::default();
            let fingers = &mut report.hands[SIDE.index()].fingers;
            for (finger, force_n) in fingers.iter_mut().zip(normal_n) {
                finger.normal_n = force_n;
            }
            pilot.process_report(&report);
            assert_eq!(pilot.holds, expected, "{normal_n:?}");
        };
        check("three-finger", [1.0, 1.0, 0.0], false);
        check("three-finger", [1.0, 0.0, 1.0], true);
        check("two-hand-arm", [1.0, 1.0, 0.0], true);
    }
}
