//! Custom fitness: the example evolves the same table again, and files store the name of the rule.

#[path = "../examples/own_fitness.rs"]
#[expect(dead_code, reason = "the example's main")]
mod example;

use ebts::evaluate::Evaluator;
use ebts::scoring::{Fitness, Judged, Scoring};
use ebts::table_file::{Hash, TableFile};
use field::{FitnessRule, GOAL_POINTS, Outcome, Preset, TeamSize, Weights};

#[test]
fn the_example_evolves_the_same_table_again_and_its_file_names_the_rule() {
    let file = example::evolved(1).expect("a table");
    assert_eq!(file.hash(), example::evolved(1).expect("a table").hash());
    let fitness = file.individual.fitness();
    // An object that is not moved earns about 30.
    assert!(fitness > 100.0, "nothing was learned: {fitness}");
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
        Scoring::Elsewhere("Quick".to_owned())
    );
    assert_eq!(read.to_text(), text);
}

#[test]
fn scorings_read_back_and_are_called_what_they_are() {
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
            Scoring::Elsewhere("Mine".to_owned()),
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
fn points_stay_inside_their_range() {
    #[derive(Debug)]
    struct Says(f32);
    impl Fitness for Says {
        fn points(&self, _: &Judged<'_>) -> f32 {
            self.0
        }
        fn name(&self) -> String {
            format!("says {}", self.0)
        }
    }
    let outcome = Outcome::default();
    let trial = Judged {
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
    for (said, expected) in rows {
        let own = Scoring::Own(std::sync::Arc::new(Says(said)));
        assert_eq!(own.points(&trial), expected, "{said}");
        assert_eq!(own.to_string(), format!("says {said}"));
    }
}
