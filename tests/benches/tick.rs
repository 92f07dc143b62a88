//! The production tick on a real bus: frames and joint state are taken in, the controller steps, the command is
//! published. Prints percentiles of the body and of its stages, and the speed of the run.
//!
//! `cargo bench -p system-tests --bench tick -- [TICKS]`

#![expect(clippy::print_stdout, reason = "figures are the product of a bench")]

use atas_core::Settings;
use atas_evaluation::offline::{OfflineRun, grasp_goal};
use hdrhistogram::Histogram;
use robot_model::{RobotModel, Side};
use sim_backend::{Object, Scene};
use system_tests::loopback::Loopback;

/// The stages of the body in the order of `TickReport::stage_ns`, and the body.
const STAGES: [&str; 8] = [
    "intake",
    "perception",
    "modules",
    "kinematics",
    "safety",
    "publish",
    "report",
    "body",
];
const BODY: usize = STAGES.len() - 1;

fn main() {
    let ticks: u64 = std::env::args()
        .skip(1)
        .find_map(|a| a.parse().ok())
        .unwrap_or(15_000);
    let mut histograms =
        STAGES.map(|_| Histogram::<u64>::new_with_bounds(1, 1_000_000_000, 3).expect("bounds"));
    run(ticks, &mut histograms);
    println!("tick body over {ticks} ticks of a grasp, both hands, 22 joints, µs");
    println!(
        "{:12} {:>8} {:>8} {:>8} {:>8}",
        "stage", "p50", "p99", "p99.9", "max"
    );
    for (name, h) in STAGES.iter().zip(&histograms) {
        let at = |q: f64| h.value_at_quantile(q) as f64 * 1e-3;
        println!(
            "{name:12} {:8.2} {:8.2} {:8.2} {:8.1}",
            at(0.5),
            at(0.99),
            at(0.999),
            h.max() as f64 * 1e-3
        );
    }
    println!("run: {:.0} x real time on one core", realtime_factor());
}

fn run(ticks: u64, histograms: &mut [Histogram<u64>]) {
    let mut loopback = Loopback::new(false);
    for _ in 0..ticks {
        loopback.sense();
        loopback.tick();
        let record = loopback.act();
        for (histogram, ns) in histograms[..BODY].iter_mut().zip(record.report.stage_ns) {
            histogram.saturating_record(ns.into());
        }
        histograms[BODY].saturating_record(record.body_ns.into());
    }
}

fn realtime_factor() -> f64 {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let scene = Scene::grasp(Object::built_in("wood").expect("built in"), Side::Right);
    let goal = grasp_goal(
        &scene.grasp_hint(0).expect("an object"),
        Side::Right,
        0.03,
        2.0,
    );
    let begin = std::time::Instant::now();
    let mut run = OfflineRun::new(&robot, &scene, 1, Settings::default()).expect("a world");
    let trial = run.run(&goal, 60.0, |_, _| ());
    trial.simulated_s / begin.elapsed().as_secs_f64()
}
