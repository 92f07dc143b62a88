//! Regression against chatter: limits how often slip and grip relaxation become active in one lift,
//! over the families of all objects. Slip closes in steps while the load grows, with pauses in
//! between as in the paper.

use atas_core::Settings;
use atas_evaluation::Task;
use atas_evaluation::goals::grasp_goal;
use atas_evaluation::offline::OfflineRun;
use robot_model::{HandSide, RobotModel};
use shm_schemas::ModuleId;
use sim_backend::{Object, Scene};

const SIDE: HandSide = HandSide::Right;
const LIFT_M: f64 = 0.04;
const HOLD_S: f64 = 1.0;
const LIMIT_S: f64 = 120.0;
/// Modules that alternate when the grip force is near its limits.
const MODULES: [ModuleId; 2] = [ModuleId::SLIP, ModuleId::RELAX];
/// Tuning seeds tested per family.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=4;
/// Maximum activations per lift. Design choice: a fifth above the largest count of these trials.
const MOST: [u32; 2] = [33, 5];

/// Counts the activations of each of [`MODULES`] from first touch to the end of the hold.
fn switches(robot: &RobotModel, object: &Object, seed: u64) -> [u32; 2] {
    let scene = Scene::grasp(object.clone(), SIDE).varied(seed);
    let hint = scene.grasp_hint(0).expect("an object");
    let goal = grasp_goal(&hint, SIDE, LIFT_M, HOLD_S);
    let run = OfflineRun::new(robot, &scene, seed, Settings::default());
    let (mut count, mut before) = ([0; 2], 0);
    run.expect("a scene").run(&goal, LIMIT_S, |outputs, _| {
        let active = outputs.report.hands[SIDE.index()].modules_active;
        let begun = active & !before;
        for (count, module) in count.iter_mut().zip(MODULES) {
            *count += begun >> module.0 & 1;
        }
        before = active;
    });
    count
}

#[test]
fn slip_and_relax_do_not_chatter() {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let mut most = [0; 2];
    for object in Task::Grasp.objects().expect("built in") {
        for seed in SEEDS {
            let switched = switches(&robot, &object, seed);
            for index in 0..2 {
                most[index] = switched[index].max(most[index]);
                assert!(
                    switched[index] <= MOST[index],
                    "{} became active {} times in a lift of {}, seed {seed}, limit {}",
                    MODULES[index],
                    switched[index],
                    object.name,
                    MOST[index]
                );
            }
        }
    }
    // Limits far above the measured counts detect no regression.
    let close = most
        .iter()
        .zip(MOST)
        .all(|(most, allowed)| 2 * most >= allowed);
    assert!(close, "{most:?} of {MOST:?}: lower the limits");
}
