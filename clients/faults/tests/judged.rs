//! The controller under the independent judge, from its first command on.

use atas_core::{OperatorRequest, Settings};
use atas_evaluation::goals::grasp_goal;
use atas_evaluation::offline::OfflineRun;
use atas_faults::joint_bounds;
use atas_judge::{Allowance, Judge, Promise};
use robot_model::{HandSide, RobotModel};
use shm_schemas::{GoalState, GoalUpdate, Mode, ObjectTruth, Reason};
use sim_backend::faults::FaultPipeline;
use sim_backend::{Object, Scene, TICK_NS};

const ROBOTS: [&str; 2] = ["two-hand-arm", "arm7-gripper"];
/// Validity of a command, ns: `safety.valid_s`.
const VALID_NS: u64 = 5_000_000;
/// Ticks of a grasp with hold: at most 60 s.
const TICKS_MAX: u64 = 60_000;

/// Controller, world and judge.
struct Judged {
    run: OfflineRun,
    judge: Judge,
    end: Option<GoalUpdate>,
}

impl Judged {
    /// Begins before the first tick, and starts a grasp when the controller is ready.
    fn grasping(name: &str) -> Self {
        let robot = RobotModel::find(name).expect("built-in robot");
        let wood = Object::built_in("wood").expect("built-in object");
        let hand = robot.hand(HandSide::Right);
        let scene = Scene::grasp(wood, HandSide::Right).moved_to_hand(hand);
        let run = OfflineRun::without_tick(&robot, &scene, 1, Settings::default());
        let mut judged = Self {
            run: run.expect("valid scene"),
            judge: Judge::new(joint_bounds(&robot), TICK_NS, VALID_NS).expect("valid bounds"),
            end: None,
        };
        judged.ticks(100);
        let hint = scene.grasp_hint(0).expect("an object");
        let goal = grasp_goal(&hint, HandSide::Right, 0.05, 1.0);
        let start = judged.run.request(&goal).expect("accepted goal");
        judged.step(Some(&start));
        judged
    }

    fn step(&mut self, request: Option<&OperatorRequest>) {
        let outputs = *self.run.step(request);
        let truth = self.run.world().truth();
        self.judge.observe(&outputs.command, &truth);
        self.end = outputs
            .goal_update
            .filter(|update| update.state.is_final())
            .or(self.end);
    }

    fn ticks(&mut self, count: u64) {
        (0..count).for_each(|_| self.step(None));
    }

    /// Runs until a condition of the object holds; returns whether it does.
    fn run_until(&mut self, condition: impl Fn(&ObjectTruth) -> bool) -> bool {
        (0..TICKS_MAX).any(|_| {
            self.step(None);
            condition(&self.object()) || self.end.is_some()
        }) && condition(&self.object())
    }

    fn object(&self) -> ObjectTruth {
        self.run.world().truth().objects[0]
    }

    /// Sends a request that must lead to a mode in the same tick.
    fn request(&mut self, request: &OperatorRequest, modes: &'static [Mode]) {
        self.judge.promise(Promise::reach(modes, 0));
        self.step(Some(request));
    }

    fn passes(mut self, name: &str) {
        self.judge.finish();
        assert_eq!(self.judge.violations(), [], "{name}");
    }
}

fn is_lifted(object: &ObjectTruth) -> bool {
    object.lifted_m > 0.02 && object.pressed == 1
}

#[test]
fn grasp_passes_the_judge() {
    for name in ROBOTS {
        let mut judged = Judged::grasping(name);
        judged
            .judge
            .promise(Promise::avoid(&[Mode::HOLD], u64::MAX));
        assert!(judged.run_until(is_lifted), "{name}: {:?}", judged.end);
        judged.judge.expect_grip_kept(0).expect("a lifted object");
        judged.run_until(|_| false);
        let state = judged.end.map(|end| end.state);
        assert_eq!(state, Some(GoalState::SUCCEEDED), "{name}");
        judged.passes(name);
    }
}

/// Hold while the arm moves, then stop and recovery with the object in the hand.
#[test]
fn interrupted_grasp_passes_the_judge() {
    for name in ROBOTS {
        let mut judged = Judged::grasping(name);
        judged.ticks(300);
        let hold = OperatorRequest::Hold(Reason::SupervisorSilent {
            silent_s: 0.0,
            limit_s: 0.0,
        });
        judged.request(&hold, &[Mode::HOLD]);
        judged.judge.promise(Promise::reach(&[Mode::RUN], 25));
        assert!(judged.run_until(is_lifted), "{name}: {:?}", judged.end);
        judged.judge.expect_grip_kept(0).expect("a lifted object");
        let stop = OperatorRequest::Stop(Reason::Estop);
        judged.request(&stop, &[Mode::SAFE_STOP]);
        judged.ticks(500);
        judged.judge.recover_requested();
        judged.request(&OperatorRequest::Recover, &[Mode::HOLD]);
        judged.ticks(500);
        judged.passes(name);
    }
}

/// Regression: a recovery ended the braking within one tick. It also moved the joints to the last
/// known positions, however old.
#[test]
fn recovery_during_motion_passes_the_judge() {
    for name in ROBOTS {
        for (pause, joints_stop) in [(1, false), (3, false), (10, false), (100, false), (1, true)] {
            let mut judged = Judged::grasping(name);
            judged.ticks(300);
            if joints_stop {
                let first = judged.run.ticks() as f64 * 1e-3;
                let fault = format!("drop=1@{first}+0.3:joints")
                    .parse()
                    .expect("a fault");
                judged.run.inject(FaultPipeline::new(&[fault], 1));
                judged.ticks(60);
            }
            let stop = OperatorRequest::Stop(Reason::Estop);
            judged.request(&stop, &[Mode::SAFE_STOP]);
            judged.ticks(pause);
            judged.judge.recover_requested();
            judged.request(&OperatorRequest::Recover, &[Mode::HOLD]);
            judged.judge.promise(Promise::reach(&[Mode::READY], 500));
            judged.ticks(600);
            judged.passes(&format!(
                "{name}, {pause} ticks, joint states stop: {joints_stop}"
            ));
        }
    }
}

/// Regression: after a pause, the first command continued at the speed from before it.
#[test]
fn motion_after_a_pause_passes_the_judge() {
    for name in ROBOTS {
        for pause in [3, 6, 10, 100] {
            let mut judged = Judged::grasping(name);
            judged.ticks(300);
            judged.judge = judged.judge.clone().allowing(Allowance::MissedTicks);
            judged.run.pause_controller(pause);
            judged.ticks(600);
            judged.passes(&format!("{name}, {pause} ticks"));
        }
    }
}
