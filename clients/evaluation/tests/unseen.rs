//! Regression tests with objects outside all families: whole tasks in process.

use atas_core::Settings;
use atas_evaluation::goals::{grasp_goal, pick_place_goal};
use atas_evaluation::judge::Outcome;
use atas_evaluation::offline::{OfflineRun, Trial};
use robot_model::{HandSide, RobotModel};
use shm_schemas::{Cause, GoalState};
use sim_backend::{Object, Scene};

const SIDE: HandSide = HandSide::Right;
const LIFT_M: f64 = 0.04;
const LIMIT_S: f64 = 120.0;

fn object(properties: &str) -> Object {
    Object::parse(&format!("name = \"unseen\"\n{properties}"), "a test").unwrap()
}

fn run_offline(scene: &Scene, seed: u64) -> Trial {
    let robot = RobotModel::two_hand_arm().unwrap();
    let hint = scene.grasp_hint(0).unwrap();
    let goal = match &scene.place {
        Some(place) => pick_place_goal(&hint, SIDE, place, LIFT_M),
        None => grasp_goal(&hint, SIDE, LIFT_M, 1.0),
    };
    let mut run = OfflineRun::new(&robot, scene, seed, Settings::default()).unwrap();
    run.run(&goal, LIMIT_S, |_, _| {})
}

fn grasped(properties: &str, seed: u64) -> Outcome {
    let trial = run_offline(&Scene::grasp(object(properties), SIDE).varied(seed), seed);
    outcome(&trial)
}

fn outcome(trial: &Trial) -> Outcome {
    let robot = RobotModel::two_hand_arm().unwrap();
    Outcome::evaluate(&trial.end, &trial.truth, robot.hand(SIDE), LIFT_M)
}

/// Regression: the hand approached below the object's top and pushed it over. One of 16 objects
/// slid uniformly after lift-off and was reported as held: the lift verification compared
/// magnitudes of the load, not its direction.
#[test]
fn approach_does_not_tip_a_tall_object() {
    let tall = "mass_kg = 0.03\nfriction = 0.29\nstiffness_n_m = 6000.0\n\
                shape = { kind = \"box\", size_m = [0.0364, 0.0232, 0.135] }";
    let scene = |seed| Scene::grasp(object(tall), SIDE).varied(seed);
    let ended = (1000..1016).map(|seed| (seed, run_offline(&scene(seed), seed)));
    let mut held = 0;
    for (seed, trial) in ended {
        let tilt_rad = trial.truth.objects[0].tilt_rad;
        assert!(tilt_rad < 0.1, "seed {seed}: tilted by {tilt_rad} rad");
        held += u32::from(outcome(&trial) == Outcome::Held);
    }
    assert_eq!(held, 16, "{held} of 16 held");
}

/// Regression: an object that slipped uniformly loaded the fingertips steadily and counted as held.
#[test]
fn uniformly_sliding_object_is_refused() {
    let heavy = "mass_kg = 0.119\nfriction = 0.27\nstiffness_n_m = 300.0\n\
                 shape = { kind = \"cylinder\", radius_m = 0.0213, height_m = 0.144 }";
    for seed in [1002, 1003] {
        let outcome = grasped(heavy, seed);
        assert_eq!(outcome, Outcome::Refused(Cause::TOO_SOFT), "seed {seed}");
    }
}

/// Regression: the compliance correction of the grip amplified the object's sway between the
/// fingertips until it was dropped.
#[test]
fn soft_heavy_object_does_not_sway_loose() {
    let swaying = "mass_kg = 0.225\nfriction = 0.46\nstiffness_n_m = 5000.0\n\
                   shape = { kind = \"box\", size_m = [0.0278, 0.0589, 0.079] }";
    let scene = Scene::pick_place(object(swaying), SIDE).varied(1001);
    let trial = run_offline(&scene, 1001);
    assert_eq!(
        (trial.end.state, trial.truth.objects[0].dropped),
        (GoalState::SUCCEEDED, 0),
        "{}",
        trial.end.reason
    );
}
