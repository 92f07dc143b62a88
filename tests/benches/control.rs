//! Benchmark of one simulated tick with the controller: grasp task, two-hand arm, 22 joints.

use atas_core::{Goal, OperatorRequest, Settings};
use atas_evaluation::goals::grasp_goal;
use atas_evaluation::offline::OfflineRun;
use criterion::{Criterion, criterion_group, criterion_main};
use robot_model::{HandSide, RobotModel};
use sim_backend::{Object, Scene};

/// Returns a simulation in which the hand has started the lift.
fn lifting() -> OfflineRun {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let scene = Scene::grasp(Object::built_in("wood").expect("built in"), HandSide::Right);
    let goal = grasp_goal(
        &scene.grasp_hint(0).expect("an object"),
        HandSide::Right,
        0.05,
        3600.0,
    );
    let mut run = OfflineRun::new(&robot, &scene, 1, Settings::default()).expect("a world");
    run.step(Some(&OperatorRequest::Start(
        Goal::resolve(&goal, &[]).expect("built in"),
    )));
    for _ in 0..6000 {
        run.step(None);
    }
    run
}

fn step(criterion: &mut Criterion) {
    let mut run = lifting();
    criterion.bench_function("world and controller, one tick", |b| {
        b.iter(|| run.step(None).command.crc32)
    });
}

criterion_group!(benches, step);
criterion_main!(benches);
