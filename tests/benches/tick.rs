//! The body of the tick on a real bus: frames and joint state are taken in, the controller steps, the command is
//! published. Prints percentiles of the body and of its stages, and the speed of the rehearsal.
//!
//! `cargo bench -p system-tests --bench tick -- [TICKS]`

#![expect(clippy::print_stdout, reason = "figures are the product of a bench")]

use atas::{Controller, Goal, Inputs, Order, Settings, Stage, Tick, Wiring};
use atas_cli::rehearsal::{Rehearsal, grasp_goal};
use hdrhistogram::Histogram;
use robot_model::{RobotModel, Side};
use shm_bus::{Bus, FreshBus, Realtime, now_ns};
use shm_schemas::{HandFrame, JointCommand, JointState, service};
use sim_backend::{Object, Scene, Sensed, World};

const STAGES: [&str; 7] = [
    "intake",
    "perception",
    "modules",
    "kinematics",
    "safety",
    "publish",
    "body",
];

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
    println!(
        "rehearsal: {:.0} x real time on one core",
        realtime_factor()
    );
}

/// World, bus and controller in one thread, so that nothing but the body is timed.
fn run(ticks: u64, histograms: &mut [Histogram<u64>]) {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let scene = Scene::grasp(Object::built_in("wood").expect("built in"), Side::Right);
    let goal = grasp_goal(
        &scene.grasp_hint(0).expect("an object"),
        Side::Right,
        0.05,
        3600.0,
    );
    let mut world = World::new(&robot, &scene, 1).expect("a world");
    let mut controller = Box::new(Controller::new(
        &robot,
        Wiring::default(),
        Settings::default(),
    ));
    let bus = FreshBus::new("bench");
    let (robot_side, daemon_side) = (open(&bus, "robot"), open(&bus, "daemon"));
    let frame_out =
        service::HAND_FRAME.map(|s| robot_side.publisher::<HandFrame>(s).expect("a port"));
    let joints_out = robot_side
        .publisher::<JointState>(service::JOINT_STATE)
        .expect("a port");
    let mut commands_in = robot_side
        .subscriber::<JointCommand>(service::JOINT_COMMAND)
        .expect("a port");
    let mut frames_in =
        service::HAND_FRAME.map(|s| daemon_side.subscriber::<HandFrame>(s).expect("a port"));
    let mut joints_in = daemon_side
        .subscriber::<JointState>(service::JOINT_STATE)
        .expect("a port");
    let command_out = daemon_side
        .publisher::<JointCommand>(service::JOINT_COMMAND)
        .expect("a port");
    let (mut sensed, mut command) = (Sensed::default(), JointCommand::default());
    let (mut frames, mut joints) = ([HandFrame::default(); 2], JointState::default());
    for index in 0..ticks {
        world.sense(&mut sensed);
        for (port, frame) in frame_out.iter().zip(&sensed.frames) {
            port.send(frame.as_ref().expect("a full-rate sensor"))
                .expect("sent");
        }
        joints_out.send(&sensed.joints).expect("sent");
        let order =
            (index == 100).then_some(Order::Start(Goal::resolve(&goal, &[]).expect("built in")));
        let mut marks = [now_ns(); 7];
        for (port, frame) in frames_in.iter_mut().zip(&mut frames) {
            port.newest(frame).expect("readable");
        }
        joints_in.newest(&mut joints).expect("readable");
        let inputs = Inputs {
            tick: Tick {
                index,
                now_ns: world.now_ns(),
            },
            frames: [&frames[..1], &frames[1..]],
            joints: Some(&joints),
            order: order.as_ref(),
        };
        let outputs = controller.step_timed(&inputs, |stage| marks[1 + position(stage)] = now_ns());
        command_out.send(&outputs.command).expect("sent");
        marks[6] = now_ns();
        for (stage, pair) in marks.windows(2).enumerate() {
            histograms[stage].saturating_record(pair[1] - pair[0]);
        }
        histograms[6].saturating_record(marks[6] - marks[0]);
        commands_in.newest(&mut command).expect("readable");
        world.advance(Some(&command));
    }
}

fn open(bus: &FreshBus, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::Yes).expect("a bus")
}

fn position(stage: Stage) -> usize {
    match stage {
        Stage::Intake => 0,
        Stage::Perception => 1,
        Stage::Modules => 2,
        Stage::Kinematics => 3,
        Stage::Safety => 4,
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
    let mut rehearsal = Rehearsal::new(&robot, &scene, 1, Settings::default()).expect("a world");
    let trial = rehearsal.run(&goal, 60.0, |_, _| ());
    trial.simulated_s / begin.elapsed().as_secs_f64()
}
