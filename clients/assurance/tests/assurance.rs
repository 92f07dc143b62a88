//! Tests of the assurance case and of its check: each defect is found and named.

use std::path::Path;

use atas_assurance::{
    Assessment, Case, Evidence, Extent, NotClaimed, Origin, Outcome, Results, SourceTree,
    compare_page, from_report, from_tests, page,
};
use serde_json::json;

const VERSION: &str = "1.2.3";

fn tree() -> SourceTree {
    SourceTree::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."))
}

fn case() -> Case {
    Case::built_in().expect("valid")
}

/// Returns a passed result of an item at the required extent.
fn passed(item: &Evidence, extent: &Extent) -> Outcome {
    Outcome {
        evidence: item.key(),
        definition: item.fingerprint(&tree()).expect("it exists"),
        version: VERSION.to_owned(),
        cores: 2,
        conditions: String::new(),
        extent: item.extent(extent),
        tried: 7,
        passed: 7,
        worst: None,
        bound: None,
        skipped: None,
    }
}

/// Returns passed results of the whole case, except those that `change` rejects or changes.
fn results(case: &Case, change: impl Fn(Outcome) -> Option<Outcome>) -> Results {
    let mut results = Results::default();
    for claim in &case.claims {
        let items = case.evidence(claim);
        let items = items
            .iter()
            .filter(|item| item.fingerprint(&tree()).is_some());
        let outcomes = items.map(|item| passed(item, &case.extent));
        results.insert(outcomes.filter_map(&change));
    }
    results
}

fn assess(case: &Case, results: &Results) -> Assessment {
    Assessment::new(case, results, &tree(), VERSION)
}

/// Checks that there is one problem, of this subject and with these words.
fn check_problem(assessment: &Assessment, subject: &str, words: &str) {
    let texts: Vec<String> = assessment
        .problems
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(texts.len(), 1, "{subject} {words}: {texts:#?}");
    assert!(texts[0].starts_with(subject), "{subject}: {texts:?}");
    assert!(texts[0].contains(words), "{words}: {texts:?}");
    assert!(!assessment.is_shown);
}

#[test]
fn complete_case_has_no_problems() {
    let case = case();
    assert_eq!(case.defects(), []);
    let assessment = assess(&case, &results(&case, Some));
    assert_eq!(assessment.problems, []);
    assert!(assessment.is_shown && assessment.claims.iter().all(|claim| claim.is_shown));
    assert!((12..=20).contains(&case.claims.len()));
}

#[test]
fn unusable_result_is_a_problem_of_its_claim() {
    let case = case();
    let check = |change: fn(Outcome) -> Option<Outcome>, words: &str| {
        let results = results(&case, |outcome| match outcome.evidence.as_str() {
            "soak" => change(outcome),
            _ => Some(outcome),
        });
        let assessment = assess(&case, &results);
        check_problem(&assessment, "G01 command-limits: soak ", words);
        let shown = assessment.claims.iter().filter(|claim| claim.is_shown);
        assert_eq!(shown.count(), case.claims.len() - 1);
    };
    let again = "run `atas assure --run --missing G01`";
    check(|_| None, "has no result");
    check(|_| None, again);
    check(
        |old| Some(Outcome { passed: 6, ..old }),
        "6 of 7 ticks passed",
    );
    check(
        |old| {
            Some(Outcome {
                worst: Some(4),
                bound: Some(3),
                ..old
            })
        },
        "worst 4 of 3 violations",
    );
    check(
        |old| {
            Some(Outcome {
                version: "1.2.2".to_owned(),
                ..old
            })
        },
        "stale: its result is of version 1.2.2, not 1.2.3",
    );
    check(
        |old| {
            Some(Outcome {
                definition: "00000001".to_owned(),
                ..old
            })
        },
        "stale: its definition changed",
    );
    check(
        |old| Some(Outcome { extent: 1, ..old }),
        "too small: extent 1",
    );
    check(
        |old| {
            let skipped = Some("no control groups".to_owned());
            Some(Outcome {
                tried: 0,
                passed: 0,
                skipped,
                ..old
            })
        },
        "was skipped: no control groups",
    );
    check(
        |old| {
            Some(Outcome {
                tried: 0,
                passed: 0,
                ..old
            })
        },
        "0 of 0 ticks passed",
    );
}

/// Checks that a changed case with passed evidence has this problem.
fn check_change(change: fn(&mut Case), subject: &str, words: &str) {
    let mut case = case();
    change(&mut case);
    let results = results(&case, Some);
    check_problem(&assess(&case, &results), subject, words);
}

#[test]
fn unknown_names_are_problems() {
    check_change(
        |case| case.claims[0].faults.push("F99".to_owned()),
        "G01",
        "the fault F99 does not exist",
    );
    check_change(
        |case| {
            case.claims[0]
                .tests
                .push("tests/tests/system/faults.rs::gone".to_owned())
        },
        "G01",
        "tests/tests/system/faults.rs::gone does not exist",
    );
    check_change(
        |case| {
            case.claims[0]
                .tests
                .push("tests/gone.rs::also_gone".to_owned())
        },
        "G01",
        "does not exist",
    );
    check_change(
        |case| case.claims[0].strategy = "S9".to_owned(),
        "G01",
        "the strategy S9 is unknown",
    );
    check_change(
        |case| case.claims[1].name = case.claims[0].name.clone(),
        "G02",
        "appears twice",
    );
    check_change(
        |case| case.claims[2].tests.clear(),
        "G03",
        "the claim has no evidence",
    );
}

#[test]
fn each_catalogue_row_is_claimed_or_listed() {
    check_change(
        |case| case.claims[5].faults.retain(|fault| fault != "F01"),
        "F01",
        "no claim cites the fault",
    );
    check_change(
        |case| case.not_claimed.clear(),
        "F37",
        "no claim cites the fault",
    );
    check_change(
        |case| {
            let reason = "as a test".to_owned();
            let fault = "F01".to_owned();
            case.not_claimed.push(NotClaimed { fault, reason });
        },
        "F01",
        "claimed and listed as not claimed",
    );
}

#[test]
fn changed_page_is_a_problem() {
    let (case, folder) = (case(), tempfile::tempdir().expect("a folder"));
    let file = folder.path().join("assurance.md");
    let mut assessment = assess(&case, &results(&case, Some));
    let text = page(&assessment);
    std::fs::write(&file, &text).expect("writable");
    compare_page(&mut assessment, &file).expect("readable");
    assert_eq!(assessment.problems, []);
    std::fs::write(&file, text.replacen("Assurance", "Insurance", 1)).expect("writable");
    compare_page(&mut assessment, &file).expect("readable");
    check_problem(&assessment, "page", "assurance.md:1 is not up to date");
}

#[test]
fn unknown_command_is_a_problem() {
    let case = case();
    let mut assessment = assess(&case, &results(&case, Some));
    assessment.add_invalid_commands(|command| match command.contains("bench stop") {
        true => Err("unknown".to_owned()),
        false => Ok(()),
    });
    check_problem(
        &assessment,
        "G15 stop",
        "the command `atas bench stop --count",
    );
}

#[test]
fn page_states_claims_results_and_limits() {
    let case = case();
    let text = page(&assess(
        &case,
        &results(&case, |outcome| match outcome.evidence.as_str() {
            "F01" => Some(Outcome {
                worst: Some(6),
                bound: Some(6),
                ..outcome
            }),
            "stops" => None,
            _ => Some(outcome),
        }),
    ));
    for part in [
        "├─ S1 ",
        "| G06 missing-frames |",
        "| F01 frames-lost | HOLD within 6 ticks | 7 runs | 7 | 6 ticks | 6 ticks |",
        "| stops under load | within 3 ticks | no result |",
        "**not shown**",
        "not a certified safety function",
        "- F37: ",
        "## Problems",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn results_are_stored_and_skips_keep_earlier_ones() {
    let (case, folder) = (case(), tempfile::tempdir().expect("a folder"));
    let mut stored = results(&case, Some);
    let skipped = Outcome {
        tried: 0,
        skipped: Some("no rights".to_owned()),
        ..passed(&Evidence::Process("F52"), &case.extent)
    };
    stored.insert([skipped]);
    assert_eq!(stored.get("F52").map(|outcome| outcome.tried), Some(7));
    stored.save(folder.path(), &case).expect("writable");
    assert_eq!(Results::load(folder.path()).expect("readable"), stored);

    std::fs::write(folder.path().join("soak.json"), "[{}]").expect("writable");
    let error = Results::load(folder.path()).expect_err("malformed");
    assert!(format!("{error:#}").contains("soak.json"), "{error:#}");
}

#[test]
fn outputs_of_commands_become_results() {
    let tree = tree();
    let origin = Origin {
        version: VERSION,
        cores: 2,
        tree: &tree,
    };
    let items = [Evidence::Process("F25b"), Evidence::Process("F26")];
    let report = json!({
        "robot": "two-hand-arm", "tasks": ["grasp", "screw"],
        "faults": [
            { "id": "F25b", "seeds": 4, "runs": 8, "passed_runs": 7, "worst_ticks": 90, "bound_ticks": 500 },
            { "id": "F26", "seeds": 0, "runs": 0, "passed_runs": 0, "skipped": "no control groups" },
        ],
    });
    let found = from_report(&report, &items, &origin).expect("complete");
    assert_eq!(
        (found[0].tried, found[0].passed, found[0].worst),
        (8, 7, Some(90))
    );
    assert_eq!(
        (found[0].extent, found[0].bound, found[0].has_passed()),
        (4, Some(500), false)
    );
    assert_eq!(found[0].conditions, "two-hand-arm; grasp, screw");
    assert_eq!(found[1].skipped.as_deref(), Some("no control groups"));

    let soak = json!({ "ticks": 90, "violations": 0, "episodes": 3, "seed": 1 });
    let soak = from_report(&soak, &[], &origin).expect("complete");
    assert!(soak[0].has_passed() && soak[0].extent == 90);
    let stops = json!({ "stops": 9, "within_3_ticks": 8, "goals": 5, "ticks": { "max": 4 } });
    let stops = from_report(&stops, &[], &origin).expect("complete");
    assert_eq!((stops[0].worst, stops[0].has_passed()), (Some(4), false));
    assert!(from_report(&json!({}), &[], &origin).is_err());

    let file = "daemon/atas/tests/atas/gate.rs";
    let test = |name: &str| Evidence::Test(format!("{file}::{name}"));
    let items = [
        test("gate_rejects_jumps_as_a_whole"),
        test("only_run_allows_motion"),
        test("random_walks_stay_within_limits"),
    ];
    let lines = [
        "test gate::gate_rejects_jumps_as_a_whole ... ok",
        "test gate::only_run_allows_motion ... FAILED",
        "test gate::unrelated ... ok",
    ];
    let found = from_tests(&lines.map(str::to_owned), &items, &origin);
    let passed: Vec<bool> = found.iter().map(Outcome::has_passed).collect();
    assert_eq!(passed, [true, false], "a test without a line has no result");
}

#[test]
fn commands_name_all_items() {
    let extent = Extent {
        seeds: 2,
        process_seeds: 1,
        ticks: 100,
        stops: 30,
    };
    let test = |name: &str| Evidence::Test(name.to_owned());
    let items = [
        Evidence::Injection("F01"),
        Evidence::Process("F21"),
        Evidence::Injection("F02"),
        Evidence::Soak,
        Evidence::Stops,
        test("tests/judge/tests/judge/broken.rs::one"),
        test("shm-schemas/bus/tests/stop.rs::two"),
        test("daemon/src/panic_guard.rs::three"),
    ];
    let expected = [
        "atas fault run F01 F02 --seeds 4",
        "atas fault run F21 --seeds 2",
        "atas soak --ticks 200",
        "atas bench stop --count 60",
        "cargo test --workspace --no-fail-fast --test judge --test stop --lib -- one two three",
    ];
    assert_eq!(Evidence::commands(&items, &extent.times(2)), expected);
}

#[test]
fn changed_test_changes_its_fingerprint() {
    let folder = tempfile::tempdir().expect("a folder");
    let tree = SourceTree::new(folder.path());
    let fingerprint = |body: &str| {
        let text = format!(
            "    #[test]\n    fn holds() {{\n        {body}\n    }}\n\n    fn next() {{}}\n"
        );
        std::fs::write(folder.path().join("some.rs"), text).expect("writable");
        Evidence::Test("some.rs::holds".to_owned()).fingerprint(&tree)
    };
    let first = fingerprint("assert!(true);");
    assert!(first.is_some());
    assert_eq!(first, fingerprint("assert!(true);"));
    assert_ne!(first, fingerprint("assert!(false);"));
}
