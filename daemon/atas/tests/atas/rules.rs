//! Task rules: the built-in tables keep them; each violation is named.

use atas_core::modules::Selection;
use atas_core::tasks::{
    BUILT_IN, GRASP, Motion, Name, PICK_PLACE, Part, Rule, RuleViolation, SCREW, STEPS_MAX, Step,
    Task, Transition, Waypoint,
};
use shm_schemas::ModuleId;

type Change = fn(&mut Vec<Step>);

fn fault(task: &Task, change: Change) -> Result<Task, RuleViolation> {
    let mut acting = task.acting.to_vec();
    change(&mut acting);
    Task::validated("own", &acting, None)
}

fn modules(ids: &[ModuleId]) -> Selection {
    Selection::from_modules(ids)
}

#[test]
fn built_in_tasks_keep_every_rule() {
    for task in BUILT_IN {
        let checked = Task::validated("own", &task.acting, task.helping.as_deref());
        if task.name == "teleop" || task.name == "teleop-both" {
            // Teleoperation steps are not allowed in a user's task.
            assert_eq!(
                checked.map_err(|fault| fault.rule),
                Err(Rule::OnlyTeleoperated)
            );
            continue;
        }
        let own = checked.unwrap_or_else(|fault| panic!("{}: {fault:?}", task.name));
        assert_eq!((own.acting, own.helping), (task.acting, task.helping));
    }
}

#[test]
fn task_names_are_plain_and_unique() {
    let check = |name: &str, rule: Option<Rule>| {
        let checked = Task::validated(name, &GRASP.acting, None);
        assert_eq!(checked.err().map(|fault| fault.rule), rule, "{name:?}");
    };
    check("own", None);
    check("exactly-sixteen-", None);
    for name in [
        "",
        "seventeen-letters",
        "Own",
        "own.task",
        "own task",
        "päron",
        "a\nb",
    ] {
        check(name, Some(Rule::TaskName));
    }
    for task in BUILT_IN {
        check(&task.name, Some(Rule::BuiltIn));
    }
}

#[test]
fn every_violation_names_rule_and_step() {
    let check = |task: &Task, change: Change, step: usize, rule: Rule| {
        let expected = RuleViolation {
            part: Part::Acting,
            step: Some(step),
            rule,
        };
        assert_eq!(fault(task, change).map(|_| ()), Err(expected));
    };
    // grasp: reach descend approach probe grip lift hold; pick-place continues: convey place open
    // leave home.
    check(
        &GRASP,
        |s| s[0].name = Name::new("Reach"),
        0,
        Rule::StepName,
    );
    check(&GRASP, |s| s[0].timeout_s = 0.0, 0, Rule::Timeout(0.0));
    check(&GRASP, |s| s[1].timeout_s = -1.0, 1, Rule::Timeout(-1.0));
    check(
        &GRASP,
        |s| s[1].timeout_s = 3601.0,
        1,
        Rule::Timeout(3601.0),
    );
    check(
        &GRASP,
        |s| s[2].timeout_s = f64::INFINITY,
        2,
        Rule::NoTimeout,
    );
    assert!(fault(&GRASP, |s| s[2].timeout_s = f64::NAN).is_err());
    check(
        &GRASP,
        |s| s[0].modules = Selection::NONE,
        0,
        Rule::NoMover(ModuleId::CARRY),
    );
    check(
        &GRASP,
        |s| s[2].modules = s[2].modules.union(modules(&[ModuleId::CARRY])),
        2,
        Rule::WrongMover(ModuleId::CARRY),
    );
    check(
        &PICK_PLACE,
        |s| s[6].modules = s[5].modules,
        6,
        Rule::NoMover(ModuleId::TRANSFER),
    );
    check(
        &GRASP,
        |s| s[4].modules = s[2].modules,
        4,
        Rule::NoForceLimit,
    );
    check(
        &GRASP,
        |s| s[5].modules = modules(&[ModuleId::CARRY]),
        5,
        Rule::NoForceLimit,
    );
    check(
        &GRASP,
        |s| s[2].modules = Selection::NONE,
        2,
        Rule::NoModule(ModuleId::FIRST_TOUCH),
    );
    check(
        &GRASP,
        |s| s[3].modules = Selection::NONE,
        3,
        Rule::NoModule(ModuleId::PROBE),
    );
    check(
        &GRASP,
        |s| (s[6].transition, s[6].timeout_s) = (Transition::Concluded, 9.0),
        6,
        Rule::NoModule(ModuleId::RELEASE_PLACED),
    );
    check(
        &PICK_PLACE,
        |s| s[7].modules = s[6].modules,
        7,
        Rule::NoEnd(ModuleId::RELEASE_PLACED),
    );
    check(
        &PICK_PLACE,
        |s| s[7].transition = Transition::Arrived,
        7,
        Rule::NoEnd(ModuleId::RELEASE_PLACED),
    );
    check(
        &SCREW,
        |s| s[5].transition = Transition::Held,
        5,
        Rule::NoEnd(ModuleId::TERMINATE_SCREW),
    );
    check(
        &GRASP,
        |s| s[2].transition = Transition::Arrived,
        2,
        Rule::NeverArrives,
    );
    check(
        &GRASP,
        |s| s.retain(|step| step.name != "grip"),
        4,
        Rule::NothingGripped,
    );
    check(
        &GRASP,
        |s| {
            s[5].motion = Motion::Reach(Waypoint::Home);
        },
        5,
        Rule::ReleasesObject,
    );
    check(
        &GRASP,
        |s| s[0].motion = Motion::Withdraw,
        0,
        Rule::OnlyInRecovery,
    );
    check(
        &GRASP,
        |s| s[6].transition = Transition::Met(1),
        6,
        Rule::NoOtherHand,
    );
}

#[test]
fn sequences_are_neither_empty_nor_too_long() {
    let rule = |steps: &[Step]| {
        let fault = Task::validated("own", steps, None).unwrap_err();
        (fault.step, fault.rule)
    };
    assert_eq!(rule(&[]), (None, Rule::NoSteps));
    let many = vec![GRASP.acting[0]; STEPS_MAX + 1];
    assert_eq!(rule(&many), (None, Rule::TooManySteps(STEPS_MAX + 1)));
}

#[test]
fn deadlocked_hands_are_rejected() {
    let track = |points: &[u8]| -> Vec<Step> {
        let meet = |point: &u8| {
            let until = Transition::Met(*point);
            Step::new("wait", Motion::Stay, Selection::NONE, until, f64::INFINITY)
        };
        points.iter().map(meet).chain([GRASP.acting[0]]).collect()
    };
    let check = |acting: &[u8], helping: &[u8], expected: Option<(Part, usize, Rule)>| {
        let found = Task::validated("own", &track(acting), Some(&track(helping)));
        let found = found
            .err()
            .map(|fault| (fault.part, fault.step.unwrap(), fault.rule));
        assert_eq!(found, expected, "{acting:?} {helping:?}");
    };
    check(&[], &[], None);
    check(&[1], &[1], None);
    check(&[1, 2], &[2], None);
    check(&[1, 3], &[2, 3], None);
    check(&[1], &[], Some((Part::Acting, 0, Rule::Deadlock(1))));
    check(&[], &[1, 2], Some((Part::Helping, 0, Rule::Deadlock(1))));
    check(&[1, 2], &[1], Some((Part::Acting, 1, Rule::Deadlock(2))));
    check(&[2], &[1, 3], Some((Part::Helping, 1, Rule::Deadlock(3))));
    check(&[2, 1], &[2], Some((Part::Acting, 1, Rule::PointOrder)));
    check(&[1, 1], &[1], Some((Part::Acting, 1, Rule::PointOrder)));
    check(&[0], &[1], Some((Part::Acting, 0, Rule::PointOrder)));
}
