//! Grasp tables: agreement with the controller, deterministic runs, verification of files.

use std::ops::ControlFlow;

use atas_core::Settings;
use atas_core::thresholds::Thresholds;
use ebts::ga;
use ebts::genome::Genome;
use ebts::grasp::course::{GENOME_BITS, families, genome, table};
use ebts::grasp::description::{describe_row, match_modules};
use ebts::grasp::evolve::{Evaluator, Evolved, evaluate_table, evolve};
use ebts::grasp::rules::Rules;
use ebts::grasp::table_file::GraspFile;
use ebts::rng::SplitMix64;
use pinch::Engine;

#[test]
fn reduced_thresholds_match_the_controller() {
    let settings = Settings::default().grasp;
    for stiffness_n_m in [100.0, 412.0, 1620.0, 5000.0, 36_543.0, 1e6] {
        let law = Thresholds::for_stiffness(stiffness_n_m, &settings);
        let [f1_n, f2_n] = pinch::Object::thresholds_n(stiffness_n_m as f32);
        assert!((f64::from(f1_n) - law.f1_n).abs() < 1e-6, "{law:?}, {f1_n}");
        assert!((f64::from(f2_n) - law.f2_n).abs() < 1e-5, "{law:?}, {f2_n}");
    }
}

#[test]
fn genome_round_trips_through_a_table() {
    let mut rng = SplitMix64::stream(&[5]);
    for _ in 0..20 {
        let drawn = Genome::random(GENOME_BITS, &mut rng);
        assert_eq!(genome(&table(&drawn)), Some(drawn));
    }
}

fn run(seed: u64, engine: Engine) -> Evolved {
    let families = families().expect("built in");
    let mut evaluator = Evaluator::new(&families, engine, false);
    let go_on = |_, _| ControlFlow::Continue(());
    evolve(&mut evaluator, ga::Settings::default(), seed, 30, go_on).expect("not stopped")
}

#[test]
fn runs_match_on_every_engine_with_memo() {
    let families = families().expect("built in");
    let expected = run(3, Engine::fastest());
    for engine in Engine::all() {
        assert_eq!(run(3, engine), expected, "{}", engine.name());
    }
    assert_ne!(run(4, Engine::fastest()).best, expected.best);
    let (points, ..) = evaluate_table(&families, &expected.best.genome, false);
    assert_eq!(points, expected.best.points);
    assert!(
        expected.rises.len() > 3,
        "fitness rises: {:?}",
        expected.rises
    );
}

#[test]
fn paper_rules_score_high_and_match_modules() {
    let families = families().expect("built in");
    let rules = Rules::PAPER.table();
    let (points, read, _) =
        evaluate_table(&families, &genome(&rules).expect("of the course"), false);
    assert!(points.iter().all(|points| *points > 60.0), "{points:?}");
    let again = match_modules(&rules, read);
    for found in [
        again.module_1,
        again.module_2,
        again.module_3,
        again.refusing,
    ] {
        assert!(
            found.asked > 0 && found.answered == found.asked,
            "{again:?}"
        );
    }
    assert_eq!(again.giving_back.answered, 0);
    let row = 0b0_0111;
    let expected = "touching, above-f1, slipping: fingers close slowly, hand on slowly";
    assert_eq!(describe_row(&rules, row), expected);
    let nothing = Rules::all()
        .into_iter()
        .find(|rules| rules.name() == "nothing");
    let nothing = genome(&nothing.expect("one choice").table()).expect("of the course");
    let (without, ..) = evaluate_table(&families, &nothing, false);
    assert!(without.iter().sum::<f32>() < points.iter().sum::<f32>() / 2.0);
}

#[test]
fn changed_grasp_file_is_rejected() {
    let families = families().expect("built in");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("table.toml");
    let rules = Rules::PAPER.table();
    let (points, ..) = evaluate_table(&families, &genome(&rules).expect("of the course"), false);
    let file = GraspFile::new(&rules, (1, 0), false, points);
    file.write(&path).expect("written");
    assert_eq!(
        GraspFile::read(&path, &families).expect("whole"),
        (file, rules)
    );
    let text = std::fs::read_to_string(&path).expect("text");
    assert!(GraspFile::is_grasp_file(&text) && !GraspFile::is_grasp_file("kind = \"other\""));
    for (from, to, part) in [
        (
            "\"touching\"",
            "\"touchng\"",
            "\"touchng\" is no sensor bit",
        ),
        (
            "rows = \"20",
            "rows = \"21",
            "its hash does not match its rows",
        ),
        ("rows = \"20", "rows = \"2", "is no row of two digits"),
        ("rows = \"20 ", "rows = \"", "has 31 rows, needs 32"),
        ("points = [", "points = [0.5, ", "could not use"),
        ("seed = 1", "seeds = 1", "could not use"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
        let error = GraspFile::read(&path, &families)
            .expect_err(part)
            .to_string();
        assert!(error.contains(part), "{error}");
    }
}
