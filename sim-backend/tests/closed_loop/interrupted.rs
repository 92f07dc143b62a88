//! Interrupted motions: a hand resumes along its path without oscillation, with the same outcome.

use crate::rig::{Missing, Rig, goal, object, seeds};
use atas_core::OperatorRequest;
use robot_model::{HandSide, RobotModel};
use shm_schemas::{GoalKind, GoalRequest, GoalState, GoalUpdate, Mode, Reason};
use sim_backend::random::Random;
use sim_backend::{Object, Scene};

/// Largest ratio of the joint path to that of an undisturbed hand. Braking and catching up take up
/// to 10 %.
const PATH_RATIO_MAX: f64 = 1.1;

fn hold(rig: &mut Rig) {
    rig.send_request(&OperatorRequest::Hold(Reason::SupervisorSilent {
        silent_s: 0.0,
        limit_s: 0.0,
    }));
    assert_eq!(rig.mode(), Mode::HOLD);
}

/// Approaches an object, with a hold after `held_after` ticks; returns the joint path commanded
/// until the fingers close, rad.
fn reach_rad(robot: &RobotModel, scene: &Scene, held_after: Option<u64>) -> f64 {
    let mut rig = Rig::with_robot(robot.clone(), scene, 1);
    rig.begin(&goal(GoalKind::GRASP, scene, HandSide::Right));
    if let Some(ticks) = held_after {
        rig.ticks(ticks);
        hold(&mut rig);
    }
    rig.run_until("approach", 0.0);
    rig.travelled_rad
}

#[test]
fn held_hand_resumes_along_its_path() {
    for name in ["two-hand-arm", "arm7-gripper", "three-finger", "test-bench"] {
        let robot = RobotModel::find(name).expect("built-in robot");
        let scene = Scene::grasp(object("wood"), HandSide::Right)
            .moved_to_hand(robot.hand(HandSide::Right));
        let undisturbed_rad = reach_rad(&robot, &scene, None);
        for held_after in (10..1400).step_by(90) {
            let travelled_rad = reach_rad(&robot, &scene, Some(held_after));
            assert!(
                travelled_rad < PATH_RATIO_MAX * undisturbed_rad,
                "{name} held after {held_after} ms: joint path {travelled_rad} rad, undisturbed \
                 {undisturbed_rad}"
            );
        }
    }
}

/// Executes a goal with a hold every `held_every` ticks.
fn pursue(scene: &Scene, request: &GoalRequest, held_every: Option<u64>) -> (GoalUpdate, Rig) {
    let mut rig = Rig::new(scene);
    rig.begin(request);
    for tick in 1..400_000 {
        if let Some(end) = rig.end.filter(|end| end.goal_id == request.goal_id) {
            return (end, rig);
        }
        if held_every.is_some_and(|every| tick % every == 0) {
            hold(&mut rig);
        } else {
            rig.ticks(1);
        }
    }
    panic!("the goal does not end");
}

#[test]
fn tasks_succeed_despite_repeated_holds() {
    let check = |kind: GoalKind, scene: &Scene, held_every: u64, detour: f64| {
        let request = goal(kind, scene, HandSide::Right);
        let (end, undisturbed) = pursue(scene, &request, None);
        assert_eq!(end.state, GoalState::SUCCEEDED, "{kind}: {}", end.reason);
        let (end, held) = pursue(scene, &request, Some(held_every));
        let case = format!("{kind} held every {held_every} ms: {}", end.reason);
        assert_eq!(end.state, GoalState::SUCCEEDED, "{case}");
        let object = held.object();
        assert_eq!(
            (object.dropped, object.crushed, object.tipped),
            (0, 0, 0),
            "{case}"
        );
        assert!(
            held.travelled_rad < detour * undisturbed.travelled_rad,
            "{case}: joint path {} rad, undisturbed {}",
            held.travelled_rad,
            undisturbed.travelled_rad
        );
    };
    for held_every in [97, 310] {
        for name in ["wood", "sponge"] {
            let scene = Scene::grasp(object(name), HandSide::Right);
            check(GoalKind::GRASP, &scene, held_every, PATH_RATIO_MAX);
        }
        // A held turn may have to be repeated.
        let scene = Scene::screw(object("cap"), object("open-bottle"), HandSide::Right);
        check(GoalKind::SCREW, &scene, held_every, 2.0);
    }
    // Module 4 waits until the held object has settled, so placing needs longer intervals.
    let scene = Scene::pick_place(object("wood"), HandSide::Right);
    check(GoalKind::PICK_PLACE, &scene, 310, PATH_RATIO_MAX);
}

fn below(random: &mut Random, count: u64) -> u64 {
    random.bits() % count
}

/// Drops inputs or ticks for up to 60 ms.
fn disturb(rig: &mut Rig, random: &mut Random) {
    let ms = 1 + below(random, 60);
    let frames = |left, right| Missing {
        frames: [left, right],
        joints: false,
    };
    let joints = Missing {
        frames: [false; 2],
        joints: true,
    };
    match below(random, 5) {
        0 => rig.drop_inputs(frames(true, false), ms),
        1 => rig.drop_inputs(frames(false, true), ms),
        2 => rig.drop_inputs(frames(true, true), ms),
        3 => rig.drop_inputs(joints, ms),
        _ => rig.stall(ms),
    }
}

/// Draws a robot and a task that it can execute.
fn draw(random: &mut Random) -> (RobotModel, Scene, GoalRequest) {
    let things = ["wood", "sponge", "paper-box", "bottle", "slippery-200"];
    let thing = object(things[below(random, 5) as usize]);
    let screws = |scene: fn(Object, Object, HandSide) -> Scene| {
        scene(object("cap"), object("open-bottle"), HandSide::Right)
    };
    let robots = ["two-hand-arm", "arm7-gripper", "three-finger", "test-bench"];
    let name = robots[below(random, 4) as usize];
    let robot = RobotModel::find(name).expect("built-in robot");
    let (kind, scene) = match (name, below(random, 4)) {
        ("two-hand-arm", 0) => (
            GoalKind::PICK_PLACE,
            Scene::pick_place(thing, HandSide::Right),
        ),
        ("two-hand-arm", 1) => (GoalKind::SCREW, screws(Scene::screw)),
        ("two-hand-arm", 2) => (GoalKind::ASSEMBLE, screws(Scene::assembly)),
        _ => {
            let scene = Scene::grasp(thing, HandSide::Right);
            (
                GoalKind::GRASP,
                scene.moved_to_hand(robot.hand(HandSide::Right)),
            )
        }
    };
    let request = goal(kind, &scene, HandSide::Right);
    (robot, scene, request)
}

#[test]
fn short_input_losses_drop_no_object() {
    for seed in seeds(10) {
        let mut random = Random::new(seed, 0);
        let (robot, scene, request) = draw(&mut random);
        let mut rig = Rig::with_robot(robot, &scene, 1);
        rig.begin(&request);
        // Rarely enough that no step times out.
        let every = 400 + below(&mut random, 600);
        let mut disturbances = 0;
        let end = loop {
            if let Some(end) = rig.end {
                break end;
            }
            rig.ticks(1 + below(&mut random, every));
            disturb(&mut rig, &mut random);
            disturbances += 1;
            let (step, reason) = (rig.step_name(), rig.reason());
            assert!(
                disturbances < 1000,
                "seed {seed}, {}: goal does not end, {step}: {reason}",
                request.kind
            );
        };
        let case = format!(
            "seed {seed}, {}: {}: {}",
            request.kind, end.step, end.reason
        );
        assert_eq!(end.state, GoalState::SUCCEEDED, "{case}");
        let object = rig.object();
        let lost = (object.dropped, object.crushed, object.tipped);
        assert_eq!(lost, (0, 0, 0), "dropped, crushed, tipped: {case}");
    }
}
