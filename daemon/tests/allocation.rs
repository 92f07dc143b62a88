//! Allocations of a tick: one, inside iceoryx2 for the published command.
//!
//! `cargo test -p atasd --test allocation -- --nocapture` prints the durations of the ticks.

#[path = "daemon/support.rs"]
#[expect(dead_code, reason = "only the scripted world is used here")]
mod support;

use std::io::Write as _;
use std::sync::Arc;

use allocation_counter::measure;
use atas_core::{Controller, Goal, OperatorRequest, SensorSetup, Settings};
use atasd::link::link;
use atasd::pacer::{LockStep, Pacer};
use atasd::statistics::TickStatistics;
use atasd::tick::TickLoop;
use robot_model::RobotModel;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{GoalKind, GoalRequest, Hand, Mode, Status};
use support::World;

/// Counted ticks, all with an active goal.
const TICKS: u64 = 2_000;
/// Ticks before counting: settling, start of the goal, connections.
const WARM_UP: u64 = 200;
const PERIOD_NS: u64 = 1_000_000;
/// Index of the recording in [`shm_schemas::TickReport::stage_ns`].
const RECORDING: usize = 7;

fn grasp() -> OperatorRequest {
    let request = GoalRequest {
        goal_id: 1,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        from_m: [0.3, -0.1, 0.08],
        width_m: 0.05,
        lift_m: 0.03,
        ..GoalRequest::default()
    };
    OperatorRequest::Start(Goal::resolve(&request, &[]).expect("built in"))
}

#[test]
fn tick_allocates_once_per_command() {
    print_durations("not recording", &run_ticks(false));
}

#[test]
fn recording_allocates_nothing() {
    print_durations("recording", &run_ticks(true));
}

/// Runs ticks with an active goal, each of which must allocate once.
fn run_ticks(recording: bool) -> Durations {
    let name = FreshBus::new("alloc");
    let mut world = World::open(&name);
    let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
    let controller = Box::new(Controller::new(
        &robot,
        SensorSetup::default(),
        Settings::default(),
    ));
    let bus = Bus::open(&name, "atasd", Realtime::Yes).expect("the bus opens");
    let (tick_end, mut supervisor) = link(recording, Arc::default());
    let pacer = Pacer::LockStep(LockStep::new());
    let mut ticks =
        TickLoop::open(&bus, controller, pacer, tick_end, 1000).expect("the ports open");
    assert!(supervisor.request(grasp()).is_some());
    let mut costs = Durations {
        statistics: TickStatistics::new().expect("valid bounds"),
        recording_ns: Vec::new(),
    };
    for index in 0..WARM_UP + TICKS {
        world.publish((index + 1) * PERIOD_NS);
        let allocations = measure(|| assert!(ticks.run_once())).count_total;
        world.receive();
        let record = supervisor
            .next_record()
            .expect("every tick pushes a record");
        while supervisor.next_event().is_some() {}
        if let Some(input_log) = supervisor.input_log() {
            let part = input_log.next_part().expect("every tick pushes a part");
            assert_eq!(part.command.crc32, record.report.command_crc32);
            input_log.recycle(part);
        }
        if index >= WARM_UP {
            assert_eq!(
                (record.report.mode, allocations),
                (Mode::RUN, 1),
                "tick {index}"
            );
            costs.statistics.record(&record);
            costs.recording_ns.push(record.report.stage_ns[RECORDING]);
        }
    }
    costs
}

/// Durations of the ticks.
struct Durations {
    statistics: TickStatistics,
    recording_ns: Vec<u32>,
}

fn print_durations(what: &str, costs: &Durations) {
    let mut status = Status::default();
    costs.statistics.write(&mut status);
    let tick = status.tick;
    let us = |ns: u64| ns as f64 * 1e-3;
    let mut recording_ns = costs.recording_ns.clone();
    recording_ns.sort_unstable();
    let line = format!(
        "{what}: tick body over {} ticks in RUN: p50 {:.1} µs, p99 {:.1} µs, p99.9 {:.1} µs, max {:.1} µs; \
         recording after it: p50 {:.2} µs",
        tick.count,
        us(tick.p50_ns),
        us(tick.p99_ns),
        us(tick.p999_ns),
        us(tick.max_ns),
        us(u64::from(recording_ns[recording_ns.len() / 2])),
    );
    // A closed standard output is not a failure.
    let _ = writeln!(std::io::stdout(), "{line}");
}
