//! Custom fitness: the example evolves the same table again, and files store the name of the rule.

#[path = "../examples/own_fitness.rs"]
#[expect(dead_code, reason = "the example's main")]
mod example;

use ebts::evaluate::Evaluator;
use ebts::scoring::{Fitness, Scoring, TrialResult};
use ebts::table_file::{Hash, TableFile};
use field::{FitnessRule, GOAL_POINTS, Outcome, Preset, TeamSize, Weights};

#[test]
fn example_is_deterministic_and_file_names_rule() {
    let file = example::evolved(1).expect("a table");
    assert_eq!(file.hash(), example::evolved(1).expect("a table").hash());
    let fitness = file.individual.fitness();
    // An object that is not moved earns about 30.
    assert!(fitness > 100.0, "no improvement by evolution: {fitness}");
    let points = Evaluator::points_of(&file.condition, &file.individual.genome);
    assert_eq!(points, file.individual.points);

    let text = file.to_text();
    assert!(
        text.contains("fitness_rule = { own = \"Quick\" }"),
        "{text}"
    );
    let read = TableFile::parse(&text, Hash::Required).expect("an intact file");
    assert_eq!(read.individual, file.individual);
    assert_eq!(
        read.condition.fitness,
        Scoring::Unavailable("Quick".to_owned())
    );
    assert_eq!(read.to_text(), text);
}

#[test]
fn scorings_round_trip_with_their_names() {
    let weights = Weights {
        delivered: 60.0,
        efficiency: 2.0,
        ..Weights::default()
    };
    let rows = [
        (
            FitnessRule::AntiAccident.into(),
            "anti-accident",
            "\"anti-accident\"",
        ),
        (FitnessRule::Literal.into(), "literal", "\"literal\""),
        (FitnessRule::Compared.into(), "compared", "\"compared\""),
        (
            FitnessRule::Weighted(weights).into(),
            "weighted (60 delivered + 2 efficiency)",
            "{\"weighted\":{\"delivered\":60.0,\"reached\":0.0,\"accompanied\":0.0,\"each_companion\":0.0,\"accuracy\":0.0,\"efficiency\":2.0}}",
        ),
        (
            Scoring::Unavailable("Mine".to_owned()),
            "Mine",
            "{\"own\":\"Mine\"}",
        ),
    ];
    for (scoring, name, text) in rows {
        assert_eq!(scoring.to_string(), name);
        assert_eq!(serde_json::to_string(&scoring).expect("text"), text);
        assert_eq!(serde_json::from_str::<Scoring>(text).expect(name), scoring);
    }
}

#[test]
fn custom_points_are_clamped() {
    #[derive(Debug)]
    struct Constant(f32);
    impl Fitness for Constant {
        fn points(&self, _: &TrialResult<'_>) -> f32 {
            self.0
        }
        fn name(&self) -> String {
            format!("says {}", self.0)
        }
    }
    let outcome = Outcome::default();
    let trial = TrialResult {
        preset: &Preset::R3,
        team: TeamSize::ALL[0],
        outcome: &outcome,
    };
    let rows = [
        (f32::NAN, 0.0),
        (f32::NEG_INFINITY, 0.0),
        (-1.0, 0.0),
        (7.5, 7.5),
        (f32::INFINITY, GOAL_POINTS),
    ];
    for (message, expected) in rows {
        let own = Scoring::Custom(std::sync::Arc::new(Constant(message)));
        assert_eq!(own.points(&trial), expected, "{message}");
        assert_eq!(own.to_string(), format!("says {message}"));
    }
}
