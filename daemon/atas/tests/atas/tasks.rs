//! Tasks as data, and the thresholds of the grasping force.

use atas::Settings;
use atas::modules::IDS;
use atas::tasks::{BACK_OUT, GRASP, Motion, RELEASE, Site, Step, Thresholds, Until};
use shm_schemas::{ModuleId, Text};

const TASKS: [(&str, &[Step]); 3] = [
    ("grasp", GRASP),
    ("back out", BACK_OUT),
    ("release", RELEASE),
];

fn modules_of(step: &Step) -> Vec<ModuleId> {
    IDS.into_iter()
        .filter(|id| step.modules.contains(*id))
        .collect()
}

#[test]
fn every_task_can_be_followed_to_its_end() {
    for (task, steps) in TASKS {
        for step in steps {
            assert_eq!(
                Text::<16>::new(step.name).as_str(),
                step.name,
                "{task}: the name fits into an update"
            );
            assert!(step.timeout_s > 0.0);
            let has = |id| step.modules.contains(id);
            assert_eq!(
                step.motion != Motion::Stay,
                has(ModuleId::CARRY),
                "{task}, {}: who moves must carry",
                step.name
            );
            match step.until {
                Until::Arrived => assert!(has(ModuleId::CARRY), "{task}, {}", step.name),
                Until::AllTouched => assert!(has(ModuleId::FIRST_TOUCH), "{task}, {}", step.name),
                Until::HardnessKnown => assert!(has(ModuleId::PROBE), "{task}, {}", step.name),
                Until::Gripped => assert!(has(ModuleId::FIRST_TOUCH), "{task}, {}", step.name),
                Until::Held => assert!(step.timeout_s.is_infinite(), "{task}, {}", step.name),
            }
        }
    }
}

/// Paper II.b (1): modules 1, 2 and 3 work while the object is carried and held.
#[test]
fn the_grasp_consists_of_modules_1_2_and_3() {
    for name in ["lift", "hold"] {
        let step = GRASP.iter().find(|s| s.name == name).unwrap();
        for id in [ModuleId::FIRST_TOUCH, ModuleId::SLIP, ModuleId::FORCE_LIMIT] {
            assert!(modules_of(step).contains(&id), "{id} in {name}");
        }
    }
    let names: Vec<_> = GRASP.iter().map(|s| s.name).collect();
    assert_eq!(
        names,
        [
            "reach", "descend", "approach", "probe", "grip", "lift", "hold"
        ]
    );
    assert_eq!(
        BACK_OUT[0].motion,
        Motion::Carry(Site::Source),
        "a refused object is set down before the hand opens"
    );
}

#[test]
fn thresholds_follow_the_hardness() {
    let grasp = Settings::default().grasp;
    for (stiffness_n_m, f1_n, f2_n) in [
        (100.0, 0.35, 0.7),
        (3000.0, 0.35, 1.5),
        (6000.0, 0.5, 3.0),
        (12_000.0, 0.8, 6.0),
        (1e6, 1.0, 8.0),
    ] {
        let thresholds = Thresholds::for_stiffness(stiffness_n_m, &grasp);
        assert!(
            (thresholds.f1_n - f1_n).abs() < 1e-12 && (thresholds.f2_n - f2_n).abs() < 1e-12,
            "{stiffness_n_m}: {thresholds:?}"
        );
    }
    assert_eq!(
        Thresholds::unknown(&grasp),
        Thresholds::for_stiffness(0.0, &grasp)
    );
}

/// Modules 1 and 3 must never contradict each other, however the table is tuned.
#[test]
fn f1_stays_below_f2() {
    let mut grasp = Settings::default().grasp;
    grasp.f1_min_n = 10.0;
    grasp.f1_max_n = 10.0;
    for stiffness_n_m in [0.0, 1e3, 1e4, 1e5, f64::INFINITY] {
        let thresholds = Thresholds::for_stiffness(stiffness_n_m, &grasp);
        assert!(thresholds.f1_n <= 0.8 * thresholds.f2_n, "{thresholds:?}");
    }
    // Each within its own range, but contradicting each other: the gentler wins, and nothing panics.
    (
        grasp.f2_min_n,
        grasp.f2_max_n,
        grasp.f1_min_n,
        grasp.f1_max_n,
    ) = (50.0, 5.0, 3.0, 1.0);
    assert_eq!(
        Thresholds::unknown(&grasp),
        Thresholds {
            f1_n: 1.0,
            f2_n: 5.0
        }
    );
}
