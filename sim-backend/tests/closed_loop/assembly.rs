//! Two-hand assembly; either hand screws.

use crate::rig::{Rig, goal, object};
use robot_model::HandSide;
use shm_schemas::GoalKind;
use sim_backend::Scene;

#[test]
fn either_hand_screws_the_cap_on() {
    for side in HandSide::BOTH {
        let scene = Scene::assembly(object("cap"), object("open-bottle"), side);
        let mut rig = Rig::new(&scene);
        rig.execute_successfully(&goal(GoalKind::ASSEMBLE, &scene, side));
        let [cap, bottle, ..] = rig.world.truth().objects;
        assert_eq!(
            (cap.cap_engaged, cap.cap_closed),
            (1, 1),
            "{side:?}: {cap:?}"
        );
        assert!(bottle.tilt_rad < 0.02 && bottle.table_n > 0.0, "{side:?}");
        let harm = [
            cap.dropped,
            bottle.dropped,
            bottle.tipped,
            bottle.spilt,
            bottle.crushed,
        ];
        assert_eq!(harm, [0; 5], "{side:?}");
        assert_eq!(rig.warnings, [], "{side:?}");
    }
}
