//! The grip survives interruptions of the daemon: the object stays in the hand.

use crate::rig::{Rig, goal, object, seeds};

use atas_core::{OperatorRequest, Settings};
use robot_model::HandSide;
use shm_schemas::{Cause, GoalKind, Mode, Reason};
use sim_backend::Scene;

/// Interruption of a daemon.
type Interruption = fn(&mut Rig);

const INTERRUPTIONS: [(&str, Interruption); 5] = [
    ("killed", |rig| rig.restart(120)),
    ("killed and restarted at once", |rig| rig.restart(6)),
    ("ended by SIGTERM", |rig| {
        rig.send_request(&OperatorRequest::Stop(Reason::Shutdown));
        rig.ticks(20);
        rig.restart(500);
    }),
    ("stopped and recovered", |rig| {
        rig.send_request(&OperatorRequest::Stop(Reason::Estop));
        rig.ticks(300);
        rig.send_request(&OperatorRequest::Recover);
    }),
    ("reloaded", |rig| {
        rig.send_request(&OperatorRequest::Configure(Settings::default()))
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
    assert_eq!(rig.mode(), Mode::RUN, "{what}: mode after the interruption");
}

#[test]
fn held_object_survives_daemon_interruptions() {
    for name in OBJECTS {
        for seed in seeds(1) {
            let scene = Scene::grasp(object(name), HandSide::Right);
            let mut rig = Rig::seeded(&scene, seed);
            rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
            // All interruptions in sequence, on one grip.
            for (how, interrupt) in INTERRUPTIONS {
                interrupt(&mut rig);
                assert_kept(
                    &mut rig,
                    &format!("{name}, seed {seed}, {how} while it holds"),
                );
            }
            assert_eq!(rig.step_name(), "keep grip", "step of a held object");
            assert!(
                rig.warnings.contains(&Cause::GRIP_FOUND),
                "warning about a found grip"
            );
            rig.execute_successfully(&goal(GoalKind::RELEASE, &scene, HandSide::Right));
        }
    }
}

#[test]
fn object_being_lifted_survives_daemon_interruptions() {
    for (how, interrupt) in INTERRUPTIONS {
        for (name, base) in OBJECTS.into_iter().zip(0..) {
            for seed in seeds(1).map(|seed| base + seed) {
                let scene = Scene::grasp(object(name), HandSide::Right);
                let mut rig = Rig::seeded(&scene, seed);
                rig.execute_until(
                    &goal(GoalKind::GRASP, &scene, HandSide::Right),
                    "lift",
                    0.015,
                );
                interrupt(&mut rig);
                assert_kept(
                    &mut rig,
                    &format!("{name}, seed {seed}, {how} while it lifts"),
                );
            }
        }
    }
}

/// Regression: each restart of a killed daemon tightened the grip, from 3.8 to 6.7 N after ten.
#[test]
fn twenty_restarts_keep_the_grip_force() {
    for name in OBJECTS {
        for seed in seeds(1) {
            let scene = Scene::grasp(object(name), HandSide::Right);
            let mut rig = Rig::seeded(&scene, seed);
            rig.execute_successfully(&goal(GoalKind::GRASP, &scene, HandSide::Right));
            rig.ticks(500);
            let (before_n, before) = (rig.grip_n(), rig.object());
            for _ in 0..20 {
                rig.restart(120);
                rig.ticks(300);
            }
            let (after_n, after) = (rig.grip_n(), rig.object());
            let moved_mm = 1e3 * (after.lifted_m - before.lifted_m).abs();
            let case = format!("{name}, seed {seed}: {before_n} N, after restarts {after_n} N");
            assert!((after_n / before_n - 1.0).abs() < 0.05, "{case}");
            assert!(moved_mm < 0.2, "{case}, moved by {moved_mm} mm");
        }
    }
}
