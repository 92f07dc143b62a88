//! Added load during a hold: compensated or reported.

use crate::rig::{Rig, goal, object};
use robot_model::HandSide;
use shm_schemas::{Cause, GoalKind};
use sim_backend::Scene;

/// Returns a hand that holds an object 50 mm above the table without warnings.
fn holding(name: &str) -> Rig {
    let scene = Scene::grasp(object(name), HandSide::Right);
    let mut rig = Rig::new(&scene);
    rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
    assert_eq!(rig.warnings, []);
    rig
}

fn force_n(rig: &Rig) -> f64 {
    let [first_n, second_n, ..] = rig.world.truth().normal_n[HandSide::Right.index()];
    first_n.min(second_n)
}

#[test]
fn slowly_growing_load_raises_the_grip() {
    let check = |name: &str, load_n: f64| {
        let mut rig = holding(name);
        let (before, before_n) = (rig.object(), force_n(&rig));
        rig.load(load_n, 0.5);
        rig.ticks(3000);
        let after = rig.object();
        let sunk_m = before.lifted_m - after.lifted_m;
        assert!(sunk_m < 0.002, "{name} sank by {sunk_m} m");
        assert!(
            force_n(&rig) > before_n + 0.3,
            "{name}: {} N",
            force_n(&rig)
        );
        assert_eq!((after.dropped, after.crushed), (0, 0), "{name}");
        assert_eq!(rig.warnings, [], "{name}");
    };
    check("wood", 2.0);
    check("slippery-50", 1.0);
}

#[test]
fn force_limit_is_reported_and_object_set_down() {
    let mut rig = holding("slippery-200");
    rig.load(2.5, 0.5);
    rig.ticks(10_000);
    assert!(
        rig.warnings.contains(&Cause::OUT_OF_FORCE),
        "{:?}",
        rig.warnings
    );
    let object = rig.object();
    assert!(object.lifted_m < 0.001, "{object:?}");
}

#[test]
fn sudden_load_is_held_or_reported() {
    let check = |name: &str, load_n: f64| {
        let mut rig = holding(name);
        let before = rig.object();
        rig.load(load_n, 1000.0);
        rig.ticks(1000);
        let after = rig.object();
        let sunk_m = before.lifted_m - after.lifted_m;
        let output = [Cause::SLIDING, Cause::LOST_OBJECT, Cause::OUT_OF_FORCE];
        let reported = rig.warnings.iter().any(|cause| output.contains(cause));
        assert!(
            reported || sunk_m < 0.005,
            "{name} sank by {sunk_m} m, warnings {:?}",
            rig.warnings
        );
    };
    for name in ["wood", "slippery-200", "slippery-50", "bottle", "paper-box"] {
        check(name, 0.2);
        check(name, 2.0);
    }
    // 0.2 N exceed the sponge's weight, and 0.1 N on a fingertip pressing with 0.3 N are within the
    // noise: the sponge sinks by a centimetre first.
    check("sponge", 2.0);
}
