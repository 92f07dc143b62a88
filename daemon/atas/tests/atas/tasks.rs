//! Tasks as data, and thresholds of the grasp force.

use crate::world::{World, grasp};
use atas_core::modules::IDS;
use atas_core::tasks::{
    ASSEMBLE, GRASP, HOLD_AFTER_GOAL, HOLD_AFTER_TELEOP, Motion, Name, PICK_PLACE, PUT_BACK, RAISE,
    REGRASP, RELEASE, SCREW, Step, TELEOP, Task, Transition, WITHDRAW, Waypoint,
};
use atas_core::thresholds::{ForceLimitSource, Thresholds};
use atas_core::{Goal, OperatorRequest, Settings};
use shm_schemas::{Cause, EventKind, GoalKind, GoalRequest, ModuleId, Text};

/// Modules that set the hand's pose.
const MOVERS: [ModuleId; 4] = [
    ModuleId::CARRY,
    ModuleId::TRANSFER,
    ModuleId::TRAJECTORY,
    ModuleId::TELEOP,
];

fn tracks() -> Vec<(&'static str, Vec<Step>)> {
    vec![
        ("grasp", GRASP.acting.to_vec()),
        ("pick and place", PICK_PLACE.acting.to_vec()),
        ("screw", SCREW.acting.to_vec()),
        ("assemble", ASSEMBLE.acting.to_vec()),
        ("assist in assembly", ASSEMBLE.helping.unwrap().to_vec()),
        ("release", RELEASE.acting.to_vec()),
        ("withdrawal", PUT_BACK.to_vec()),
        ("second approach", REGRASP.to_vec()),
        ("raise", RAISE.to_vec()),
        ("withdraw", WITHDRAW.to_vec()),
        ("stand", HOLD_AFTER_GOAL.to_vec()),
        ("teleop", TELEOP.acting.to_vec()),
        ("stand, teleoperated before", HOLD_AFTER_TELEOP.to_vec()),
    ]
}

fn modules_of(step: &Step) -> Vec<ModuleId> {
    IDS.into_iter()
        .filter(|id| step.modules.contains(*id))
        .collect()
}

#[test]
fn stiffness_is_reported_once_whatever_the_steps_are_called() {
    for name in ["grip", "squeeze"] {
        let renamed = |step: &Step| match step.name.as_str() {
            "grip" => Step::new(
                name,
                step.motion,
                step.modules,
                step.transition,
                step.timeout_s,
            ),
            _ => *step,
        };
        let steps: Vec<Step> = GRASP.acting.iter().map(renamed).collect();
        let task = Task::validated("own", &steps, None).expect("a valid task");
        let request = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new("own"),
            ..grasp()
        };
        let goal = Goal::resolve(&request, &[task]).expect("a known task");
        let mut world = World::ready();
        world.has_object = true;
        world.request(OperatorRequest::Start(goal));
        let mut reports = 0;
        while !world.controller.goal().expect("a goal").state.is_final() {
            let outputs = world.tick();
            let events = outputs.events.as_slice().iter();
            reports += events
                .filter(|event| event.kind == EventKind::STIFFNESS)
                .count();
            assert!(world.ms < 100_000, "the goal has no end");
        }
        assert_eq!(reports, 1, "step {name:?}");
    }
}

#[test]
fn every_task_can_be_completed() {
    for (task, steps) in tracks() {
        for step in steps {
            assert!(
                !step.name.is_empty() && step.name.len() < Name::MAX,
                "{task}: truncated name"
            );
            assert!(step.timeout_s > 0.0);
            let has = |id| step.modules.contains(id);
            let movers = MOVERS.into_iter().filter(|id| has(*id)).count();
            assert_eq!(
                usize::from(step.motion != Motion::Stay),
                movers,
                "{task}, {}: a moving step needs exactly one mover, a still one none",
                step.name
            );
            match step.transition {
                Transition::Arrived => assert_eq!(movers, 1, "{task}, {}", step.name),
                Transition::AllTouched => {
                    assert!(has(ModuleId::FIRST_TOUCH), "{task}, {}", step.name)
                }
                Transition::StiffnessKnown => {
                    assert!(has(ModuleId::PROBE), "{task}, {}", step.name)
                }
                Transition::Gripped => assert!(has(ModuleId::FIRST_TOUCH), "{task}, {}", step.name),
                Transition::Concluded => {
                    assert!(
                        has(ModuleId::RELEASE_PLACED) || has(ModuleId::TERMINATE_SCREW),
                        "{task}, {}",
                        step.name
                    );
                }
                Transition::Met(_)
                | Transition::Held
                | Transition::GripRequested
                | Transition::OpeningRequested => {
                    assert!(step.timeout_s.is_infinite(), "{task}, {}", step.name)
                }
            }
        }
    }
}

/// Paper II.b (1): modules 1, 2 and 3 work while the object is carried and held.
#[test]
fn the_grasp_consists_of_modules_1_2_and_3() {
    for name in ["lift", "hold"] {
        let step = GRASP.acting.iter().find(|s| s.name == name).unwrap();
        for id in [ModuleId::FIRST_TOUCH, ModuleId::SLIP, ModuleId::FORCE_LIMIT] {
            assert!(modules_of(step).contains(&id), "{id} in {name}");
        }
    }
    let names: Vec<_> = GRASP.acting.iter().map(|s| s.name).collect();
    assert_eq!(
        names,
        [
            "reach", "descend", "approach", "probe", "grip", "lift", "hold"
        ]
    );
    assert_eq!(
        PUT_BACK[0].motion,
        Motion::Carry(Waypoint::Source),
        "a refused object is set down before the hand opens"
    );
}

/// Paper II.b (3): "modules 0 and 4 are replaced by new modules 0' and 4".
#[test]
fn placing_consists_of_modules_0_1_2_3_and_4() {
    let step = PICK_PLACE
        .acting
        .iter()
        .find(|s| s.name == "place")
        .unwrap();
    let expected = [
        ModuleId::FIRST_TOUCH,
        ModuleId::PROBE,
        ModuleId::SLIP,
        ModuleId::FORCE_LIMIT,
        ModuleId::TRANSFER,
        ModuleId::RELEASE_PLACED,
    ];
    assert_eq!(modules_of(step), expected);
}

/// A waiting hand needs the other to reach the same or a later meeting point.
#[test]
fn both_hands_reach_the_last_meeting_point() {
    let points = |steps: &[Step]| -> Vec<u8> {
        let point = |step: &Step| match step.transition {
            Transition::Met(point) => Some(point),
            _ => None,
        };
        steps.iter().filter_map(point).collect()
    };
    let acting = points(&ASSEMBLE.acting);
    let helping = points(&ASSEMBLE.helping.unwrap());
    assert!(acting.is_sorted() && helping.is_sorted());
    assert_eq!(acting.last(), helping.last());
}

#[test]
fn names_are_truncated_at_a_character_boundary() {
    let check = |text: &str, expected: &str| assert_eq!(Name::new(text), expected);
    check("", "");
    check("lift", "lift");
    check("exactly sixteen!", "exactly sixteen!");
    check("a little too long", "a little too lon");
    check("fünfzehn Zeicheä", "fünfzehn Zeiche");
}

#[test]
fn thresholds_depend_on_stiffness() {
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
        Thresholds::for_unknown_object(&grasp),
        Thresholds::for_stiffness(0.0, &grasp)
    );
}

#[test]
fn goal_force_limit_replaces_f2() {
    let grasp = Settings::default().grasp;
    for (stiffness_n_m, told_n, f2_n, exceeded) in [
        (100.0, 0.0, 0.7, Cause::TOO_SOFT),
        (1e6, 0.0, 8.0, Cause::TOO_HEAVY),
        (100.0, 4.0, 4.0, Cause::ABOVE_MAX_FORCE),
        (1e6, 0.3, 0.3, Cause::ABOVE_MAX_FORCE),
        (1e6, 50.0, 8.0, Cause::ABOVE_MAX_FORCE),
        (1e6, f64::NAN, 8.0, Cause::TOO_HEAVY),
    ] {
        let thresholds =
            Thresholds::for_stiffness(stiffness_n_m, &grasp).with_force_limit(told_n, &grasp);
        let case = format!("{stiffness_n_m} N/m, force limit {told_n} N: {thresholds:?}");
        assert_eq!(
            (
                thresholds.f2_n,
                thresholds.refusal(9.0, ModuleId::FORCE_LIMIT).cause()
            ),
            (f2_n, exceeded),
            "{case}"
        );
        assert!(thresholds.f1_n <= 0.8 * f2_n, "{case}");
    }
}

/// Modules 1 and 3 must not contradict each other, for any settings.
#[test]
fn f1_stays_below_f2() {
    let mut grasp = Settings::default().grasp;
    grasp.f1_min_n = 10.0;
    grasp.f1_max_n = 10.0;
    for stiffness_n_m in [0.0, 1e3, 1e4, 1e5, f64::INFINITY] {
        let thresholds = Thresholds::for_stiffness(stiffness_n_m, &grasp);
        assert!(thresholds.f1_n <= 0.8 * thresholds.f2_n, "{thresholds:?}");
    }
    // Valid alone, contradictory together: the gentler value wins without a panic.
    (
        grasp.f2_min_n,
        grasp.f2_max_n,
        grasp.f1_min_n,
        grasp.f1_max_n,
    ) = (50.0, 5.0, 3.0, 1.0);
    assert_eq!(
        Thresholds::for_unknown_object(&grasp),
        Thresholds {
            f1_n: 1.0,
            f2_n: 5.0,
            source: ForceLimitSource::Hand
        }
    );
}
