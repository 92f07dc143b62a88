//! Threads of both directions.

use crate::rig::{Rig, goal, object};
use robot_model::HandSide;
use shm_schemas::GoalKind;
use sim_backend::{ClosingDirection, Scene};

#[test]
fn caps_with_either_thread_direction_are_closed() {
    for (turn, output, side) in [
        (
            ClosingDirection::Clockwise,
            shm_schemas::Turn::CLOCKWISE,
            HandSide::Left,
        ),
        (
            ClosingDirection::Anticlockwise,
            shm_schemas::Turn::ANTICLOCKWISE,
            HandSide::Right,
        ),
    ] {
        let mut cap = object("cap");
        cap.thread.as_mut().expect("cap has a thread").closes = turn;
        let scene = Scene::screw(cap, object("open-bottle"), side);
        let mut rig = Rig::new(&scene);
        let mut goal = goal(GoalKind::SCREW, &scene, side);
        goal.turn = output;
        rig.execute_successfully(&goal);
        let cap = rig.object();
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        assert!((1.3..=2.5).contains(&tightness), "{turn:?}: {tightness}");
        assert_eq!((cap.cap_closed, cap.crushed), (1, 0), "{turn:?}");
    }
}
