//! Benchmark of the production tick on a real bus: intake of frames and joint state, controller
//! step, publication of the command.
//!
//! Prints percentiles of the tick body and of its stages, and the real-time factor. With several
//! robots it runs them alternately and compares the cost of each with the first.
//!
//! `cargo bench -p system-tests --bench tick -- [TICKS] [--robot NAME|FILE]... [--all-robots]`

#![expect(
    clippy::print_stdout,
    reason = "figures are the product of a benchmark"
)]

use atas_core::Settings;
use atas_evaluation::goals::grasp_goal;
use atas_evaluation::offline::OfflineRun;
use hdrhistogram::Histogram;
use robot_model::{RobotFiles, RobotModel, SHIPPED, TWO_HAND_ARM};
use sim_backend::{Object, Scene};
use system_tests::loopback::Loopback;

/// Stages of the tick body in the order of `TickReport::stage_ns`, then the whole body.
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

/// Consecutive ticks of one robot. Design choice: short, so that changes of the machine's speed
/// affect all robots alike.
const BLOCK_TICKS: u64 = 500;

/// One robot and the measured cost of its ticks.
struct Measured {
    name: String,
    robot: RobotModel,
    loopback: Loopback,
    histograms: [Histogram<u64>; STAGES.len()],
}

fn main() {
    let ticks: u64 = std::env::args()
        .skip(1)
        .find_map(|a| a.parse().ok())
        .unwrap_or(15_000);
    let mut all: Vec<Measured> = robots().into_iter().map(Measured::new).collect();
    for _ in 0..ticks.div_ceil(BLOCK_TICKS) {
        all.iter_mut().for_each(Measured::run_block);
    }
    all.iter().for_each(Measured::print);
    if all.len() > 1 {
        print_comparison(&all);
    }
}

/// Returns the two-hand arm and the robots requested on the command line.
fn robots() -> Vec<RobotFiles> {
    let mut robots = vec![TWO_HAND_ARM];
    let arguments: Vec<String> = std::env::args().collect();
    if arguments.iter().any(|a| a == "--all-robots") {
        robots = SHIPPED.into();
    }
    for pair in arguments.windows(2) {
        if let [option, robot] = pair
            && option == "--robot"
        {
            robots.push(RobotFiles::find(robot).unwrap_or_else(|error| panic!("{error}")));
        }
    }
    robots
}

impl Measured {
    fn new(files: RobotFiles) -> Self {
        let robot = files.load().unwrap_or_else(|error| panic!("{error}"));
        Self {
            name: files.name.into_owned(),
            loopback: Loopback::from_robot(&robot, false),
            robot,
            histograms: STAGES
                .map(|_| Histogram::new_with_bounds(1, 1_000_000_000, 3).expect("bounds")),
        }
    }

    fn run_block(&mut self) {
        for _ in 0..BLOCK_TICKS {
            self.loopback.sense();
            self.loopback.tick();
            let record = self.loopback.act();
            let stages = self.histograms[..BODY].iter_mut();
            for (histogram, ns) in stages.zip(record.report.stage_ns) {
                histogram.saturating_record(ns.into());
            }
            self.histograms[BODY].saturating_record(record.body_ns.into());
        }
    }

    fn print(&self) {
        let (ticks, joints) = (self.histograms[BODY].len(), self.robot.joint_count());
        let name = &self.name;
        println!("{name}: tick body over {ticks} ticks of a grasp, {joints} joints, µs");
        println!(
            "{:12} {:>8} {:>8} {:>8} {:>8}",
            "stage", "p50", "p99", "p99.9", "max"
        );
        for (stage, h) in STAGES.iter().zip(&self.histograms) {
            let at = |q: f64| h.value_at_quantile(q) as f64 * 1e-3;
            println!(
                "{stage:12} {:8.2} {:8.2} {:8.2} {:8.1}",
                at(0.5),
                at(0.99),
                at(0.999),
                h.max() as f64 * 1e-3
            );
        }
        let factor = realtime_factor(&self.robot);
        println!("run: {factor:.0} x real time on one core\n");
    }

    fn joints(&self) -> usize {
        self.robot.joint_count()
    }

    fn fingertips(&self) -> usize {
        let hands = self.robot.sides().map(|side| self.robot.hand(side));
        hands.map(|hand| hand.fingertip_count()).sum()
    }

    /// Returns the median duration of the tick body, µs.
    fn body_us(&self) -> f64 {
        self.histograms[BODY].value_at_quantile(0.5) as f64 * 1e-3
    }
}

/// Prints the cost per joint and per fingertip of each robot, and its ratio to the first robot.
fn print_comparison(all: &[Measured]) {
    println!(
        "{:14} {:>6} {:>10} {:>8} {:>12} {:>14}",
        "robot", "joints", "fingertips", "body p50", "per joint", "per fingertip"
    );
    for of in all {
        let shown = |count: fn(&Measured) -> usize| {
            let per = |of: &Measured| of.body_us() / count(of) as f64;
            format!("{:.2} x {:.2}", per(of), per(of) / per(&all[0]))
        };
        println!(
            "{:14} {:>6} {:>10} {:>8.2} {:>12} {:>14}",
            of.name,
            of.joints(),
            of.fingertips(),
            of.body_us(),
            shown(Measured::joints),
            shown(Measured::fingertips),
        );
    }
}

fn realtime_factor(robot: &RobotModel) -> f64 {
    let side = robot.acting_side();
    let scene = Scene::grasp(Object::built_in("wood").expect("built in"), side);
    let scene = scene.moved_to_hand(robot.hand(side));
    let goal = grasp_goal(&scene.grasp_hint(0).expect("an object"), side, 0.03, 2.0);
    let begin = std::time::Instant::now();
    let mut run = OfflineRun::new(robot, &scene, 1, Settings::default()).expect("a world");
    let trial = run.run(&goal, 60.0, |_, _| ());
    trial.simulated_s / begin.elapsed().as_secs_f64()
}
