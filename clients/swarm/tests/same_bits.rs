//! The bits of a run depend only on condition, settings and seed.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use ebts::checkpoint::Checkpoint;
use ebts::condition::{Condition, Setup, Sharing};
use ebts::evaluate::Evaluator;
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::rng::SplitMix64;
use ebts::run::{Record, Run, evolve};
use ebts::sensors::SensorOrder;
use ebts::training::choice_sets;
use ebts::workers::Workers;
use ebts::{genome::Genome, run};
use field::{
    DrawnPosts, Engine, FitnessRule, Noise, Places, Preset, Training, Trial, Wall, Weights,
    run_trial,
};

const GENERATIONS: u32 = 18;
const ISLANDS: IslandSettings = IslandSettings {
    islands: 3,
    migrate_every: 4,
};

/// Conditions that cover every path: presets, team sizes, sharing, scoring, sensor order, noise,
/// drawn trials, obstacles.
fn conditions() -> Vec<Condition> {
    let paper_team = |preset: Preset, agents| Setup {
        agents,
        sharing: Sharing::Shared,
        sensors: SensorOrder::default(),
        fitness_rule: FitnessRule::AntiAccident.into(),
        preset,
    };
    let mut setups: Vec<Setup> = [Preset::R3, Preset::N, Preset::LB]
        .into_iter()
        .flat_map(|p| (1..=4).map(move |n| paper_team(p.clone(), n)))
        .collect();
    setups.push(Setup {
        sharing: Sharing::PerAgent,
        ..paper_team(Preset::N, 3)
    });
    setups.push(Setup {
        fitness_rule: FitnessRule::Literal.into(),
        ..paper_team(Preset::PAPER, 2)
    });
    setups.push(Setup {
        fitness_rule: FitnessRule::Compared.into(),
        ..paper_team(Preset::LB3, 4)
    });
    let sensors = "photo-right,ir-left,ir-front,photo-left,ir-right"
        .parse()
        .expect("an order");
    setups.push(Setup {
        sensors,
        ..paper_team(Preset::R3, 2)
    });
    let noise = Noise {
        sensor_flips_per_1024: 10,
        wheel_slips_per_1024: 20,
    };
    let drawn = |starts, goals, draws| {
        Some(Training {
            starts,
            goals,
            draws,
        })
    };
    for (agents, noise, training) in [
        (2, noise, None),
        (3, noise, drawn(Places::Drawn, Places::Drawn, 2)),
        (1, Noise::default(), drawn(Places::Drawn, Places::Preset, 1)),
    ] {
        let preset = Preset {
            noise,
            training,
            ..Preset::R3
        };
        setups.push(paper_team(preset, agents));
    }
    let walled = Preset {
        walls: vec![Wall {
            from_px: [-90.0, 120.0],
            to_px: [90.0, 120.0],
        }]
        .into(),
        drawn_posts: Some(DrawnPosts {
            count: 5,
            radius_px: 15.0,
            seed: 1,
        }),
        ..Preset::N
    };
    setups.push(paper_team(walled.clone(), 2));
    let training = drawn(Places::Drawn, Places::Drawn, 1);
    let weights = Weights {
        reached: 40.0,
        each_companion: 5.0,
        accuracy: 1.0,
        ..Weights::default()
    };
    setups.push(Setup {
        fitness_rule: FitnessRule::Weighted(weights).into(),
        ..paper_team(Preset { training, ..walled }, 3)
    });
    setups
        .into_iter()
        .map(|setup| setup.build().expect("a valid setup"))
        .collect()
}

fn start(condition: &Condition, islands: IslandSettings, seed: u64) -> Run {
    Run::new(condition, Settings::default(), islands, seed).expect("valid settings")
}

fn evolved(condition: &Condition, engine: Engine, mut runs: Vec<Run>) -> Vec<Record> {
    assert!(
        evolve(condition, engine, &mut runs, GENERATIONS, |_| {
            ControlFlow::Continue(())
        })
        .is_continue()
    );
    runs.iter()
        .map(|run| run.record(condition).expect("an evolved run"))
        .collect()
}

#[test]
fn runs_match_on_every_engine_and_batch() {
    for condition in conditions() {
        let runs = || {
            (1..=3)
                .map(|seed| start(&condition, IslandSettings::default(), seed))
                .collect::<Vec<_>>()
        };
        let alone: Vec<Record> = runs()
            .into_iter()
            .flat_map(|run| evolved(&condition, Engine::fastest(), vec![run]))
            .collect();
        for engine in Engine::all() {
            let together = evolved(&condition, engine, runs());
            let setup = Setup::from(&condition);
            assert_eq!(
                together,
                alone,
                "{} {:?}",
                engine.name(),
                (setup.preset.name, setup.agents, setup.sharing)
            );
        }
    }
}

#[test]
fn resumed_run_gives_the_same_bits() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run.checkpoint");
    for condition in conditions() {
        for islands in [IslandSettings::default(), ISLANDS] {
            let straight = evolved(
                &condition,
                Engine::fastest(),
                vec![start(&condition, islands, 5)],
            );
            for stop_at in [0, 7, 16] {
                let mut runs = [start(&condition, islands, 5)];
                let watch = |runs: &[Run]| match runs[0].generation() {
                    Some(generation) if generation == stop_at => ControlFlow::Break(()),
                    _ => ControlFlow::Continue(()),
                };
                assert!(
                    evolve(&condition, Engine::fastest(), &mut runs, GENERATIONS, watch).is_break()
                );
                let [run] = runs;
                let saved = Checkpoint {
                    condition: condition.clone(),
                    settings: Settings::default(),
                    islands,
                    generations: GENERATIONS,
                    run,
                };
                saved.write(&path).expect("a writable folder");
                let resumed = Checkpoint::read(&path).expect("an intact checkpoint");
                assert_eq!(resumed.run, saved.run, "stopped at {stop_at}");
                assert_eq!(
                    evolved(&resumed.condition, Engine::fastest(), vec![resumed.run]),
                    straight,
                    "stopped at {stop_at}"
                );
            }
        }
    }
}

/// A population so large that its trials are distributed over threads and interrupted within a
/// generation.
#[test]
fn threads_and_interruption_give_the_same_bits() {
    let condition = conditions().remove(7);
    let settings = Settings {
        population: 4000,
        ..Settings::default()
    };
    let begin =
        || Run::new(&condition, settings, IslandSettings::default(), 3).expect("valid settings");
    let go_on = |_: &[Run]| ControlFlow::Continue(());
    let mut straight = [begin()];
    assert!(evolve(&condition, Engine::fastest(), &mut straight, 2, go_on).is_continue());

    let stop = Arc::new(AtomicBool::new(false));
    let workers = Workers::new(Engine::fastest(), 3, Arc::clone(&stop)).expect("three threads");
    let mut runs = [begin()];
    let after_the_first = |runs: &[Run]| {
        stop.store(runs[0].generation() == Some(1), Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    assert!(evolve(&condition, workers.clone(), &mut runs, 2, after_the_first).is_break());
    assert_eq!(
        runs[0].generation(),
        Some(1),
        "the state after the last complete generation"
    );
    stop.store(false, Ordering::Relaxed);
    assert!(evolve(&condition, workers, &mut runs, 2, go_on).is_continue());
    assert_eq!(runs, straight);
}

#[test]
fn the_memo_changes_no_points() {
    for condition in conditions() {
        let (mut rng, mut sets) = (SplitMix64::stream(&[4]), choice_sets(&condition));
        sets.truncate(4);
        let mut evaluator = Evaluator::new(condition.clone(), Engine::fastest(), 1);
        evaluator.set_trials(0, sets.clone());
        let rate = ebts::rng::Probability::new(0.01).expect("a probability");
        let mut genome = Genome::random(condition.genome_bits(), &mut rng);
        for _ in 0..60 {
            genome.mutate(rate, &mut rng);
            let evaluated = evaluator
                .evaluate(vec![vec![genome.clone(); 2]])
                .expect("not stopped")
                .remove(0)
                .remove(1);
            let tables = condition.responses(&genome);
            let points = |layout| {
                let trial = Trial { layout, tables };
                condition.points(&run_trial(&condition.model, condition.team, &trial))
            };
            let mean = |goal| {
                let of_goal = sets.iter().map(|set| points(set[goal]));
                of_goal.fold(0.0, |sum, points| sum + points) / sets.len() as f32
            };
            assert_eq!(evaluated.points, std::array::from_fn(mean));
        }
    }
}

#[test]
fn fitness_never_falls_and_islands_keep_size() {
    let condition = conditions().remove(1);
    let mut runs = [start(&condition, ISLANDS, 9)];
    let watch = |runs: &[Run]| {
        for island in runs[0].archipelago().islands() {
            let fitness: Vec<f32> = island
                .members()
                .iter()
                .map(|member| member.fitness())
                .collect();
            assert_eq!(fitness.len(), Settings::default().population);
            assert!(fitness.is_sorted_by(|a, b| a >= b), "{fitness:?}");
        }
        ControlFlow::Continue(())
    };
    assert!(evolve(&condition, Engine::fastest(), &mut runs, GENERATIONS, watch).is_continue());
    let rises: &[run::Rise] = runs[0].rises();
    assert!(
        rises.windows(2).all(
            |pair| pair[0].fitness < pair[1].fitness && pair[0].generation < pair[1].generation
        )
    );
}
