//! Clearance between the arms: the goal check's margin covers the real deviations.
//!
//! Before a motion, the check simulates the planned paths of both arms and keeps `CLEARANCE_M`
//! between them. A real arm lags behind its command and differs from its model; this test measures
//! both effects.

use crate::rig::{Rig, goal, object, seeds};
use atas_core::check::CLEARANCE_M;
use robot_model::HandSide;
use shm_schemas::{GoalKind, GoalState};
use sim_backend::{Errors, Scene};

/// Ticks between two measurements: an arm moves by less than a millimetre.
const LOOK_TICKS: u64 = 4;

#[test]
fn arm_deviations_stay_below_the_planned_clearance() {
    // Model errors of an arm, see `atas-sim errors`.
    let errors = Errors {
        link_m: Errors::ALL.link_m,
        servo_stiffness: Errors::ALL.servo_stiffness,
        ..Errors::NONE
    };
    for seed in seeds(3) {
        let side = HandSide::BOTH[seed as usize % 2];
        let scene = Scene::assembly(object("cap"), object("open-bottle"), side);
        let scene = scene.varied(seed).with_errors(&errors, seed);
        let mut rig = Rig::seeded(&scene, seed);
        rig.begin(&goal(GoalKind::ASSEMBLE, &scene, side));
        let (mut strays_m, mut gap_m) = ([0.0_f64; 2], f64::INFINITY);
        while rig.end.is_none() {
            rig.ticks(LOOK_TICKS);
            let now_m = rig.deviations_m();
            strays_m = [0, 1].map(|hand| strays_m[hand].max(now_m[hand]));
            gap_m = gap_m.min(rig.gap_m());
        }
        let state = rig.end.map(|end| end.state);
        let what = format!("seed {seed}: deviations {strays_m:?} m, smallest gap {gap_m} m");
        assert_eq!(state, Some(GoalState::SUCCEEDED), "{what}");
        assert!(strays_m[0] + strays_m[1] < CLEARANCE_M, "{what}");
        assert!(gap_m > 0.0, "{what}");
    }
}
