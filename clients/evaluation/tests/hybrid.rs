//! Tests of the hybrid demonstration: a hand-written table drives, modules grasp, the same seed
//! gives the same bits.

use std::sync::atomic::AtomicBool;

use atas_evaluation::hybrid::{HybridPlan, HybridReport, HybridTrial, PHASES, Reflexes};
use sim_backend::Object;
use sim_backend::course::{Responses, Wheels};

/// Hand-written table: turns away from obstacles, else towards the light, else straight on. Slow,
/// because bumps at high speed shake the load.
fn by_hand() -> Responses {
    let wheels = |left, right| Wheels { left, right };
    Responses::from_fn(|row| match (row & 7, row >> 3) {
        (0, 1) => wheels(0, 1),
        (0, 2) => wheels(1, 0),
        (0, _) => wheels(1, 1),
        (4 | 6, _) => wheels(0, 1),
        _ => wheels(1, 0),
    })
}

fn run(robots: usize, table: Responses) -> (HybridReport, Vec<HybridTrial>) {
    let plan = HybridPlan {
        robots,
        trials: 1,
        first_seed: 2,
        table,
        reflexes: Reflexes::On,
        objects: vec![Object::built_in("wood").expect("built in")],
        threads: 0,
        settings: atas_core::Settings::default(),
    };
    let run = plan.run(&AtomicBool::new(false), || ());
    run.expect("it runs").expect("not stopped")
}

#[test]
fn course_enters_all_phases_and_is_deterministic() {
    let (report, trials) = run(1, by_hand());
    assert_eq!((report.clone(), trials.clone()), run(1, by_hand()));
    assert_eq!(report.success, 1.0, "{:?}", trials[0].robots);
    let phases: Vec<&str> = trials[0].robots[0].phases.iter().map(|p| p.phase).collect();
    for phase in PHASES.iter().filter(|phase| phase.name != "give way") {
        assert!(phases.contains(&phase.name), "{phases:?}");
    }
    assert_eq!(
        (phases.first(), phases.last()),
        (Some(&"search"), Some(&"set down"))
    );
    let drive = trials[0].robots[0].drive.expect("it drove");
    assert!(
        drive.took_s > 1.0 && drive.shake.horizontal_m_s2 > 0.1,
        "{drive:?}"
    );
    let output = serde_json::to_value(&report).expect("JSON");
    for field in ["trials", "success"] {
        assert!(output[field].is_number(), "{field}: {output}");
    }
    assert!(
        output["failures"].is_object() && output["drive"]["slip_mm"].is_array(),
        "{output}"
    );
}

/// Regression: a robot waited for ever for another one whose course was over.
#[test]
fn failures_are_counted_per_robot_and_course_ends() {
    let straight = Responses::from_fn(|_| Wheels { left: 2, right: 2 });
    let (report, trials) = run(2, straight);
    assert_eq!(report.success, 0.0);
    let failures: Vec<Option<&str>> = trials[0]
        .robots
        .iter()
        .map(|robot| robot.failure.as_deref())
        .collect();
    assert_eq!(failures, [Some("object not found"); 2]);
    assert_eq!(report.failures["object not found"], 1, "once per trial");
    assert_eq!(report.objects["wood"], [2, 2]);
}
