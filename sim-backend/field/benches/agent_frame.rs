//! Time per agent-frame of every engine: `cargo bench -p field`.
//!
//! Workload: 64 random tables with eight goals each, as in early generations. The final table gives
//! ns per agent-frame and the speed-up over the scalar reference.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput};
use field::{
    DrawnPosts, Engine, Model, Outcome, Preset, Responses, TRIAL_FRAMES, TeamSize, Trial, Wall,
};

const TABLES: u64 = 64;

fn trials(model: &Model) -> Vec<Trial> {
    let mut state = 7_u64;
    let mut word = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        u128::from(z ^ z >> 31)
    };
    let mut tables = Vec::new();
    for _ in 0..TABLES {
        let table = Responses::from_motor_bits(word() << 64 | word());
        tables.extend(model.training_goals().map(|goal| Trial {
            layout: model.training_layout(goal),
            tables: [table; 4],
        }));
    }
    tables
}

/// Preset N with two walls and four posts.
fn walled() -> Preset {
    let wall = |y_px: f32| Wall {
        from_px: [-120.0, y_px],
        to_px: [120.0, y_px],
    };
    Preset {
        name: "N walled".into(),
        walls: vec![wall(150.0), wall(-150.0)].into(),
        drawn_posts: Some(DrawnPosts {
            count: 4,
            radius_px: 20.0,
            seed: 1,
        }),
        ..Preset::N
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .configure_from_args()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .sample_size(10);
    let mut rows = Vec::new();
    for preset in [Preset::R3, Preset::N, Preset::LB, walled()] {
        let model = Model::new(preset).expect("a shipped preset");
        let trials = trials(&model);
        for team in TeamSize::ALL {
            let name = format!("{}/{} agents", model.preset().name, team.get());
            let agent_frames = trials.len() as u64 * u64::from(TRIAL_FRAMES) * team.get() as u64;
            let mut group = criterion.benchmark_group(&name);
            group.throughput(Throughput::Elements(agent_frames));
            let mut best_ns = Vec::new();
            for engine in Engine::all() {
                let mut outcomes: Vec<Outcome> = Vec::new();
                let mut best = Duration::MAX;
                group.bench_with_input(
                    BenchmarkId::from_parameter(engine.name()),
                    &trials,
                    |bencher, trials| {
                        bencher.iter(|| {
                            let start = Instant::now();
                            engine.run(&model, team, black_box(trials), &mut outcomes);
                            best = best.min(start.elapsed());
                        });
                    },
                );
                best_ns.push((engine.name(), best.as_nanos() as f64 / agent_frames as f64));
            }
            group.finish();
            rows.push((name, best_ns));
        }
    }
    criterion.final_summary();
    report(&rows);
}

#[expect(clippy::print_stdout, reason = "the table is the product of the bench")]
fn report(rows: &[(String, Vec<(&str, f64)>)]) {
    println!("\nbest ns per agent-frame (times faster than scalar)");
    for (name, engines) in rows {
        let scalar = engines[0].1;
        let cell = |(engine, ns): &(&str, f64)| format!("{engine} {ns:.2} ({:.1}×)", scalar / ns);
        println!(
            "{name:>14}: {}",
            engines.iter().map(cell).collect::<Vec<_>>().join("  ")
        );
    }
}
