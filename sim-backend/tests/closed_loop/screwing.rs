//! Threads of both directions.

use crate::rig::{Rig, goal, object};
use robot_model::Side;
use shm_schemas::GoalKind;
use sim_backend::{Scene, Turn};

#[test]
fn caps_are_closed_whichever_way_their_thread_turns() {
    for (turn, told, side) in [
        (Turn::Clockwise, shm_schemas::Turn::CLOCKWISE, Side::Left),
        (
            Turn::Anticlockwise,
            shm_schemas::Turn::ANTICLOCKWISE,
            Side::Right,
        ),
    ] {
        let mut cap = object("cap");
        cap.thread.as_mut().expect("a thread").closes = turn;
        let scene = Scene::screw(cap, object("open-bottle"), side);
        let mut rig = Rig::new(&scene);
        let mut goal = goal(GoalKind::SCREW, &scene, side);
        goal.turn = told;
        rig.achieve(&goal);
        let cap = rig.object();
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        assert!((1.3..=2.5).contains(&tightness), "{turn:?}: {tightness}");
        assert_eq!((cap.cap_closed, cap.crushed), (1, 0), "{turn:?}");
    }
}
