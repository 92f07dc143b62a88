//! One robot's pilot: walks it through the course, from what its base sees and what its hand says.
//!
//! **In:** a [`BaseState`] and the object's true place per frame, the daemon's reports and goal updates. **Out:** a
//! [`BaseCommand`] per frame, and goals. The same in process and on the bus.

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

/// The stream of what a robot is told wrongly.
const CAMERA: u64 = 0x63_616d;
/// Half widths of it: places, m, and directions, rad (as in every family: ±2 mm, ±5°).
const ERROR_M: f64 = 0.002;
const ERROR_RAD: f64 = 5.0 * core::f64::consts::PI / 180.0;
/// Normal force of a finger that presses, N (as for the grasp).
const PRESSED_N: f32 = 0.03;
/// The task that fetches with fingers that feel nothing once the object is lifted.
const FETCH_FROZEN: &str = "fetch-frozen";

/// Whether the hand feels on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reflexes {
    /// Modules 2 and 3 answer what the drive does.
    On,
    /// The fingers stand as they did when the object was lifted.
    Frozen,
}

impl Reflexes {
    /// The task that fetches an object.
    fn task(self) -> Name {
        match self {
            Self::On => FETCH.name,
            Self::Frozen => Name::new(FETCH_FROZEN),
        }
    }

    /// What a controller has to be taught for it, if it is not built in.
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
            // It has as many steps as before.
            acting: Track::checked(&steps).unwrap_or(FETCH.acting),
            ..FETCH
        };
        (self == Self::Frozen).then_some(frozen)
    }
}

/// How long a robot was in one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseTime {
    /// Its name.
    pub phase: &'static str,
    /// When it began, s.
    pub began_s: f64,
    /// How long it took, s.
    pub took_s: f64,
}

/// A robot's pilot.
pub struct Pilot {
    coordinator: Coordinator,
    camera: Random,
    reflexes: Reflexes,
    /// What a client knows of its object without seeing it.
    known: GraspHint,
    /// What it saw of it when it was within reach.
    seen: Option<GraspHint>,
    goal: Option<GoalRequest>,
    progress: GoalProgress,
    hand: HandState,
    holds: bool,
    times: Vec<PhaseTime>,
}

/// What a frame came to.
#[derive(Clone, Copy, Debug)]
pub struct Decision {
    /// What the base is told.
    pub command: BaseCommand,
    /// What the hand shall do from now on, if that is new. It must be ordered before time goes on.
    pub goal: Option<GoalRequest>,
    /// The phase that has begun, if one has.
    pub began: Option<&'static str>,
}

impl Pilot {
    /// The pilot of a robot at its start.
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

    /// One frame: looks at the signs, and says what base and hand shall do. `truth` is of the same moment: of it the pilot is told
    /// where its object is when that is within reach, with errors, as by a camera.
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

    /// What the new phase asks of the hand.
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

    /// Where the object is, as it is told: within reach, with errors.
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

    /// Keeps account of the phases.
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

    /// Hears that the goal was not begun.
    pub fn hear_rejection(&mut self, reason: Reason) {
        self.hear_goal(&GoalUpdate {
            goal_id: self.goal.map_or(0, |goal| goal.goal_id),
            state: GoalState::REJECTED,
            reason,
            ..GoalUpdate::default()
        });
    }

    /// Hears how a goal goes on; of another one it takes no notice.
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

    /// Hears what the hand felt in the last tick before a frame.
    pub fn hear_report(&mut self, report: &TickReport) {
        let fingers = &report.hands[SIDE.index()].fingers[..VIRTUAL_FINGERS];
        self.holds = fingers.iter().all(|finger| finger.normal_n > PRESSED_N);
    }

    /// How the course has ended, if it has.
    #[must_use]
    pub fn ended(&self) -> Option<Ended> {
        self.coordinator.ended()
    }

    /// The phases so far, and how long each was.
    #[must_use]
    pub fn times(&self) -> &[PhaseTime] {
        &self.times
    }

    /// The hand's last goal.
    #[must_use]
    pub fn progress(&self) -> &GoalProgress {
        &self.progress
    }

    /// Why the hand has given up, if it has.
    pub(super) fn gave_up(&self) -> Option<String> {
        let last = self.progress.last();
        (self.hand == HandState::GaveUp).then(|| last.reason.cause.to_string())
    }

    /// The judgement of pick and place.
    pub(super) fn placing(&self, truth: &WorldTruth) -> Placing {
        let to_m = self
            .goal
            .map_or([0.0; 2], |goal| [goal.to_m[0], goal.to_m[1]]);
        let let_go_ns = self.progress.let_go_ns();
        Placing::of(self.progress.last(), truth, to_m, let_go_ns)
    }
}

/// Where a light is; `None` while the hand has it.
fn light_m(state: &BaseState, light: course::Light) -> Option<[f64; 2]> {
    match light {
        course::Light::Object => (state.object_stands != 0).then_some(state.object_m),
        course::Light::Goal => Some(state.goal_m),
    }
}

/// The same direction within a quarter turn of y: half a turn more or less is the same grasp.
fn half_turned(yaw_rad: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    yaw_rad - PI * ((yaw_rad - FRAC_PI_2) / PI).round()
}
