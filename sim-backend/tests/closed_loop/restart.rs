//! The grip survives interruptions of the daemon: the object stays in the hand.

use crate::rig::{Rig, goal, object, seeds};

use atas_core::{Order, Settings};
use robot_model::Side;
use shm_schemas::{Cause, GoalKind, Mode, Reason};
use sim_backend::Scene;

/// Interruption of a daemon.
type Interruption = fn(&mut Rig);

const INTERRUPTIONS: [(&str, Interruption); 5] = [
    ("killed", |rig| rig.restart(120)),
    ("killed and started at once", |rig| rig.restart(6)),
    ("ended by SIGTERM", |rig| {
        rig.order(&Order::Stop(Reason::of(Cause::SHUTDOWN)));
        rig.ticks(20);
        rig.restart(500);
    }),
    ("stopped and recovered", |rig| {
        rig.order(&Order::Stop(Reason::of(Cause::ESTOP)));
        rig.ticks(300);
        rig.order(&Order::Recover);
    }),
    ("reloaded", |rig| {
        rig.order(&Order::Configure(Settings::default()))
    }),
];

/// Objects of all stiffnesses, and the most slippery.
const OBJECTS: [&str; 5] = ["wood", "slippery-200", "bottle", "paper-box", "sponge"];
fn assert_kept(rig: &mut Rig, what: &str) {
    let before = rig.object();
    rig.ticks(600);
    let after = rig.object();
    let sunk_mm = (before.lifted_m - after.lifted_m) * 1e3;
    assert_eq!((after.dropped, after.crushed), (0, 0), "{what}");
    assert!(
        sunk_mm < 2.0 && after.lifted_m > 0.01,
        "{what}: sank by {sunk_mm} mm"
    );
    assert_eq!(rig.mode(), Mode::RUN, "{what}: watched");
}

#[test]
fn a_held_object_is_kept_whatever_happens_to_the_daemon() {
    for name in OBJECTS {
        for seed in seeds(1) {
            let scene = Scene::grasp(object(name), Side::Right);
            let mut rig = Rig::seeded(&scene, seed);
            rig.achieve(&goal(GoalKind::GRASP, &scene, Side::Right));
            // All interruptions in sequence, on one grip.
            for (how, interrupt) in INTERRUPTIONS {
                interrupt(&mut rig);
                assert_kept(
                    &mut rig,
                    &format!("{name}, seed {seed}, {how} while it holds"),
                );
            }
            assert_eq!(rig.step_name(), "keep grip", "says what it does");
            assert!(rig.warnings.contains(&Cause::GRIP_FOUND), "and why");
            rig.achieve(&goal(GoalKind::RELEASE, &scene, Side::Right));
        }
    }
}

#[test]
fn a_lifted_object_is_kept_whatever_happens_to_the_daemon() {
    for (how, interrupt) in INTERRUPTIONS {
        for (name, base) in OBJECTS.into_iter().zip(0..) {
            for seed in seeds(1).map(|seed| base + seed) {
                let scene = Scene::grasp(object(name), Side::Right);
                let mut rig = Rig::seeded(&scene, seed);
                rig.pursue_until(&goal(GoalKind::GRASP, &scene, Side::Right), "lift", 0.015);
                interrupt(&mut rig);
                assert_kept(
                    &mut rig,
                    &format!("{name}, seed {seed}, {how} while it lifts"),
                );
            }
        }
    }
}
