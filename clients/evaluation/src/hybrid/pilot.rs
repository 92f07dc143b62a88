//! Pilot: guides one robot through the course, from the state of its base and hand.
//!
//! **In:** [`BaseState`] and ground truth of the object per frame, the daemon's reports and goal
//! updates. **Out:** a [`BaseCommand`] per frame, and goals. Runs unchanged in process and on the
//! bus.

use atas_client::GoalProgress;
use atas_client::goal::{HOLD_S, LIFT_M};
use atas_core::modules::Selection;
use atas_core::tasks::{FETCH, Name, Step, Task, Track, Transition};
use robot_model::VIRTUAL_FINGERS;
use serde::Serialize;
use shm_schemas::{
    BaseCommand, BaseState, GoalKind, GoalRequest, GoalState, GoalUpdate, Light, Mishap, ModuleId,
    Reason, Say, Stamp, Text, TickReport, WorldTruth,
};
use sim_backend::GraspHint;
use sim_backend::course::{self, FRAME_S, Player, SIDE};
use sim_backend::random::Random;

use super::coordinator::{self, Coordinator, Ended, HandState, HandTask, Signs};
use crate::judge::Placing;
use crate::offline::{grasp_goal, set_down_goal};

/// Random stream of the camera errors.
const CAMERA: u64 = 0x63_616d;
/// Half widths of the camera errors: position (m), yaw (rad), as in every family (±2 mm, ±5°).
const ERROR_M: f64 = 0.002;
const ERROR_RAD: f64 = 5.0 * core::f64::consts::PI / 180.0;
/// Normal force of a fingertip in contact, N; as for the grasp.
const PRESSED_N: f32 = 0.03;
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
    pub(super) fn lesson(self) -> Option<Task> {
        let freeze = |step: &Step| Step {
            modules: match step.transition {
                Transition::Held => Selection::of(&[ModuleId::FORCE_LIMIT]),
                _ => step.modules,
            },
            ..*step
        };
        let steps: Vec<Step> = FETCH.acting.iter().map(freeze).collect();
        let frozen = Task {
            name: self.task(),
            // The number of steps is unchanged: never rejected.
            acting: Track::checked(&steps).unwrap_or(FETCH.acting),
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
    known: GraspHint,
    seen: Option<GraspHint>,
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
    /// Creates the pilot of a robot at its start.
    #[must_use]
    pub fn new(player: &Player, reflexes: Reflexes) -> Self {
        Self {
            coordinator: Coordinator::default(),
            camera: Random::new(player.seed, CAMERA),
            reflexes,
            known: player.known,
            seen: None,
            goal: None,
            progress: GoalProgress::default(),
            hand: HandState::default(),
            holds: false,
            times: Vec::new(),
        }
    }

    /// Runs one frame. `truth` is used only to simulate the camera measurement of the object.
    pub fn frame(&mut self, state: &BaseState, truth: &WorldTruth) -> Decision {
        let signs = Signs {
            light_m: light_m(state, self.light()),
            stands: state.stands != 0,
            hand: self.hand,
            holds: self.holds,
            first_m: state.first_m.is_finite().then_some(state.first_m),
        };
        if state.mishap != Mishap::NONE {
            self.coordinator.fail("mishap");
        }
        let began = self.coordinator.look(&signs, FRAME_S) || self.times.is_empty();
        let goal = if began {
            self.begin(state, truth)
        } else {
            None
        };
        self.note(state, began);
        let phase = self.coordinator.phase();
        let say = match (self.coordinator.ended(), phase.say) {
            (Some(_), _) => Say::OVER,
            (None, coordinator::Say::Table) => Say::TABLE,
            (None, coordinator::Say::Nobody) => Say::NOBODY,
            (None, coordinator::Say::Hand(_)) => Say::HAND,
        };
        Decision {
            command: BaseCommand {
                stamp: Stamp {
                    captured_ns: state.stamp.captured_ns,
                    ..Stamp::default()
                },
                frame: state.frame,
                say,
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
        let goal = match self.coordinator.phase().say {
            coordinator::Say::Hand(HandTask::Grasp) => {
                let seen = self.look_at(truth);
                self.seen = Some(seen);
                GoalRequest {
                    kind: GoalKind::CUSTOM,
                    task: Text::new(self.reflexes.task().as_str()),
                    ..grasp_goal(&seen, SIDE, LIFT_M, HOLD_S)
                }
            }
            coordinator::Say::Hand(HandTask::SetDown) => {
                let ([x_m, y_m], seen) = (light_m(state, self.light())?, self.seen?);
                let to_m = [x_m, y_m, seen.from_m[2]];
                GoalRequest {
                    goal_id: 2,
                    ..set_down_goal(&seen, SIDE, to_m, LIFT_M)
                }
            }
            coordinator::Say::Table | coordinator::Say::Nobody => return None,
        };
        self.progress = GoalProgress::default();
        (self.goal, self.hand) = (Some(goal), HandState::Busy);
        Some(goal)
    }

    fn look_at(&mut self, truth: &WorldTruth) -> GraspHint {
        let object = &truth.objects[0];
        let mut off = |half_width: f64| self.camera.between(-half_width, half_width);
        let [w, .., z] = object.orientation;
        let [x_m, y_m, _] = object.position_m;
        GraspHint {
            from_m: [x_m + off(ERROR_M), y_m + off(ERROR_M), self.known.from_m[2]],
            yaw_rad: half_turned(2.0 * libm::atan2(z, w)) + off(ERROR_RAD),
            ..self.known
        }
    }

    fn note(&mut self, state: &BaseState, began: bool) {
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
    pub fn hear_rejection(&mut self, reason: Reason) {
        self.hear_goal(&GoalUpdate {
            goal_id: self.goal.map_or(0, |goal| goal.goal_id),
            state: GoalState::REJECTED,
            reason,
            ..GoalUpdate::default()
        });
    }

    /// Processes a goal update; ignores other goals.
    pub fn hear_goal(&mut self, update: &GoalUpdate) {
        if self.goal.is_none_or(|goal| goal.goal_id != update.goal_id) {
            return;
        }
        self.progress.add(update);
        self.hand = match update.state {
            GoalState::SUCCEEDED => HandState::Done,
            state if state.is_final() => HandState::GaveUp,
            _ => HandState::Busy,
        };
    }

    /// Processes the report of the last tick before a frame.
    pub fn hear_report(&mut self, report: &TickReport) {
        let fingers = &report.hands[SIDE.index()].fingers[..VIRTUAL_FINGERS];
        self.holds = fingers.iter().all(|finger| finger.normal_n > PRESSED_N);
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

    pub(super) fn gave_up(&self) -> Option<String> {
        let last = self.progress.last();
        (self.hand == HandState::GaveUp).then(|| last.reason.cause.to_string())
    }

    pub(super) fn placing(&self, truth: &WorldTruth) -> Placing {
        let to_m = self
            .goal
            .map_or([0.0; 2], |goal| [goal.to_m[0], goal.to_m[1]]);
        let let_go_ns = self.progress.let_go_ns();
        Placing::of(self.progress.last(), truth, to_m, let_go_ns)
    }
}

fn light_m(state: &BaseState, light: course::Light) -> Option<[f64; 2]> {
    match light {
        course::Light::Object => (state.object_stands != 0).then_some(state.object_m),
        course::Light::Goal => Some(state.goal_m),
    }
}

/// Returns the yaw within a quarter turn of y. Half a turn gives the same grasp.
fn half_turned(yaw_rad: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    yaw_rad - PI * ((yaw_rad - FRAC_PI_2) / PI).round()
}
