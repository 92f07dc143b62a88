//! One robot of a course: its hand's world and controller, its coordinator, and what it was told and did.

use anyhow::Context;
use atas_client::GoalProgress;
use atas_client::goal::{HOLD_S, LIFT_M};
use atas_core::modules::Selection;
use atas_core::tasks::{GRASP, Name, PICK_PLACE, SECURE, Step, Task, Track, Transition};
use atas_core::{Order, Outputs, Settings};
use robot_model::{RobotModel, VIRTUAL_FINGERS};
use shm_schemas::{GoalKind, GoalRequest, GoalState, ModuleId, Reason, Text, WorldTruth};
use sim_backend::course::{Course, Lane, Place, Responses, Wheels};
use sim_backend::random::Random;
use sim_backend::{GraspHint, Object, Ride, Scene};

use super::coordinator::{Coordinator, HandState, HandTask, Say, Signs};
use super::drive::{Drive, Reflexes};
use crate::judge::Placing;
use crate::offline::{OfflineRun, grasp_goal, set_down_goal};
use crate::task::SIDE;

/// The stream of what a robot is told wrongly.
const CAMERA: u64 = 0x63_616d;
/// Half widths of it: places, m, and directions, rad (as in every family: ±2 mm, ±5°).
const ERROR_M: f64 = 0.002;
const ERROR_RAD: f64 = 5.0 * core::f64::consts::PI / 180.0;
/// Normal force of a finger that presses, N (as for the grasp).
const PRESSED_N: f32 = 0.03;
/// The task that grasps and lifts.
const FETCH: &str = "fetch";

/// One robot.
pub(super) struct Robot {
    index: usize,
    /// On the heap: a controller and a world are large.
    run: Box<OfflineRun>,
    pub(super) coordinator: Coordinator,
    camera: Random,
    /// What a client knows of its object without seeing it.
    known: GraspHint,
    /// What it saw of it when it was within reach.
    seen: Option<GraspHint>,
    goal: Option<GoalRequest>,
    order: Option<Order>,
    pub(super) progress: GoalProgress,
    hand: HandState,
    holds: bool,
    pub(super) drive: Option<Drive>,
}

impl Robot {
    /// A robot at its start, whose controller is ready.
    pub(super) fn new(
        model: &RobotModel,
        (index, lane): (usize, &Lane),
        object: &Object,
        (seed, reflexes): (u64, Reflexes),
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let mut scene = Scene::grasp(object.clone(), SIDE).varied(seed);
        let known = scene.grasp_hint(0).context("a grasp has its object")?;
        let placed = &mut scene.objects[0];
        placed.position_m = lane.start.sees(lane.object.at_m);
        placed.yaw_rad = lane.object.yaw_rad - lane.start.yaw_rad;
        let mut run = Box::new(OfflineRun::new(model, &scene, seed, *settings)?);
        run.teach(Some(fetch(reflexes)));
        Ok(Self {
            index,
            run,
            coordinator: Coordinator::default(),
            camera: Random::new(seed, CAMERA),
            known,
            seen: None,
            goal: None,
            order: None,
            progress: GoalProgress::default(),
            hand: HandState::default(),
            holds: false,
            drive: None,
        })
    }

    /// A frame: tells the course where the object is, looks at the signs, and steers. Whether another phase has begun.
    pub(super) fn frame(&mut self, course: &mut Course, table: Responses, frame_s: f64) -> bool {
        let truth = self.run.world().truth();
        let place = course.place(self.index);
        let [x_m, y_m, _] = truth.objects[0].position_m;
        let stands = truth.objects[0].table_n > 0.0;
        course.set_object(self.index, stands.then(|| place.point_m([x_m, y_m])));
        let light = self.coordinator.phase().light;
        let signs = Signs {
            light_m: course.sees(self.index, light),
            stands: course.stands(self.index),
            hand: self.hand,
            holds: self.holds,
            first_m: course.to_first_m(self.index),
        };
        if course.mishap(self.index).is_some() {
            self.coordinator.fail("mishap");
        }
        let began = self.coordinator.look(&signs, frame_s);
        if began {
            self.begin(&truth, course);
        }
        if self.coordinator.ended().is_some() {
            course.rest(self.index);
            return began;
        }
        let phase = self.coordinator.phase();
        let drives = phase.say == Say::Table;
        let wheels = match drives {
            true => table.get(course.sense(self.index, phase.light)),
            false => Wheels::STOP,
        };
        course.steer(self.index, wheels, phase.pace());
        began
    }

    /// Begins what the new phase asks of the hand.
    fn begin(&mut self, truth: &WorldTruth, course: &Course) {
        match self.coordinator.phase().say {
            Say::Hand(HandTask::Grasp) => {
                let seen = self.look_at(truth);
                self.seen = Some(seen);
                let goal = grasp_goal(&seen, SIDE, LIFT_M, HOLD_S);
                self.pursue(GoalRequest {
                    kind: GoalKind::CUSTOM,
                    task: Text::new(FETCH),
                    ..goal
                });
            }
            Say::Hand(HandTask::SetDown) => {
                let light_m = course.sees(self.index, self.coordinator.phase().light);
                if let (Some(seen), Some([x_m, y_m])) = (self.seen, light_m) {
                    let to_m = [x_m, y_m, seen.from_m[2]];
                    self.pursue(GoalRequest {
                        goal_id: 2,
                        ..set_down_goal(&seen, SIDE, to_m, LIFT_M)
                    });
                }
            }
            Say::Table if self.seen.is_some() && self.drive.is_none() => {
                self.drive = Some(Drive::begin(truth));
            }
            Say::Table | Say::Nobody => {}
        }
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

    fn pursue(&mut self, goal: GoalRequest) {
        self.progress = GoalProgress::default();
        (self.goal, self.hand) = (Some(goal), HandState::Busy);
        match self.run.order(&goal) {
            Ok(order) => self.order = Some(order),
            Err(reason) => self.rejected(&goal, reason),
        }
    }

    fn rejected(&mut self, goal: &GoalRequest, reason: Reason) {
        self.hand = HandState::GaveUp;
        self.progress.add(&shm_schemas::GoalUpdate {
            goal_id: goal.goal_id,
            state: GoalState::REJECTED,
            reason,
            ..Default::default()
        });
    }

    /// One millisecond on a base that moves like this.
    pub(super) fn tick(&mut self, ride: &Ride) -> anyhow::Result<()> {
        self.run.ride(ride)?;
        let outputs = *self.run.step(self.order.take().as_ref());
        self.hear(&outputs);
        let drives = !matches!(self.coordinator.phase().say, Say::Hand(_));
        if let Some(drive) = self.drive.as_mut().filter(|_| drives) {
            drive.watch(&self.run.world().truth(), ride);
        }
        Ok(())
    }

    fn hear(&mut self, outputs: &Outputs) {
        let fingers = &outputs.report.hands[SIDE.index()].fingers[..VIRTUAL_FINGERS];
        self.holds = fingers.iter().all(|finger| finger.normal_n > PRESSED_N);
        let id = self.goal.map(|goal| goal.goal_id);
        let update = outputs.goal_update.filter(|u| Some(u.goal_id) == id);
        if let Some(update) = update {
            self.progress.add(&update);
            self.hand = match update.state {
                GoalState::SUCCEEDED => HandState::Done,
                state if state.is_final() => HandState::GaveUp,
                _ => HandState::Busy,
            };
        }
    }

    /// What went wrong in its world, if the world could not go on.
    pub(super) fn fault(&self) -> Option<sim_backend::WorldFault> {
        self.run.world().fault()
    }

    /// Why the hand has given up, if it has.
    pub(super) fn gave_up(&self) -> Option<String> {
        let last = self.progress.last();
        (self.hand == HandState::GaveUp).then(|| last.reason.cause.to_string())
    }

    /// The judgement of pick and place.
    pub(super) fn placing(&self) -> Placing {
        let to_m = self
            .goal
            .map_or([0.0; 2], |goal| [goal.to_m[0], goal.to_m[1]]);
        let truth = self.run.world().truth();
        let let_go_ns = self.progress.let_go_ns();
        Placing::of(self.progress.last(), &truth, to_m, let_go_ns)
    }

    /// How far the object truly is from the goal, m.
    pub(super) fn off_goal_m(&self, base: &Place, goal_m: [f64; 2]) -> f64 {
        let [x_m, y_m, _] = self.run.world().truth().objects[0].position_m;
        let [goal_x_m, goal_y_m] = base.sees(goal_m);
        libm::hypot(x_m - goal_x_m, y_m - goal_y_m)
    }
}

/// The same direction within a quarter turn of y: half a turn more or less is the same grasp.
fn half_turned(yaw_rad: f64) -> f64 {
    use core::f64::consts::{FRAC_PI_2, PI};
    yaw_rad - PI * ((yaw_rad - FRAC_PI_2) / PI).round()
}

/// The built-in grasp for a robot that drives off with what it has: lifted as for conveying, and held by modules that give no
/// force back, because what a drive will ask for is not felt before it.
fn fetch(reflexes: Reflexes) -> Task {
    let hold = match reflexes {
        Reflexes::On => SECURE,
        Reflexes::Frozen => Selection::of(&[ModuleId::FORCE_LIMIT]),
    };
    let step = |(step, conveyed): (&Step, &Step)| Step {
        modules: match step.transition {
            Transition::Held => hold,
            _ => conveyed.modules,
        },
        ..*step
    };
    let steps = GRASP.acting.iter().zip(PICK_PLACE.acting.iter());
    let steps: Vec<Step> = steps.map(step).collect();
    Task {
        name: Name::new(FETCH),
        // It has as many steps as before.
        acting: Track::checked(&steps).unwrap_or(GRASP.acting),
        ..GRASP
    }
}
