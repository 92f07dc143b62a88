//! Tests determinism: one seed gives bit-identical commands in two runs over the bus and in
//! process.

use atas_core::Settings;
use atas_evaluation::goals::grasp_goal;
use atas_evaluation::offline::OfflineRun;
use robot_model::{HandSide, RobotModel};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{GoalRequest, GoalState, TickReport, service};
use sim_backend::{Errors, Object, Scene};
use std::collections::BTreeMap;
use system_tests::{Process, lock_shared, wait_for};

const SEED: u64 = 7;
/// Ticks of the lock-step daemon before it accepts the first goal.
const WARM_UP_TICKS: u64 = 100;

/// Yaw error of the object. The hand regrasps, within the clearance that the goal check found.
const YAW_ERROR: &str = "yaw=15";

fn scene() -> Scene {
    let object = Object::built_in("slippery-50").expect("built in");
    let misaligned: Errors = YAW_ERROR.parse().expect("errors");
    Scene::grasp(object, HandSide::Right).with_errors(&misaligned, SEED)
}

fn goal() -> GoalRequest {
    let hint = scene().grasp_hint(0).expect("an object");
    grasp_goal(&hint, HandSide::Right, 0.01, 0.2)
}

/// Runs the goal over the bus; returns the command checksums by tick.
fn over_the_bus() -> BTreeMap<u64, u32> {
    let bus = FreshBus::new("same");
    let name = bus.as_str();
    let seed = SEED.to_string();
    let simulate = [
        "run",
        "--bus",
        name,
        "--object",
        "slippery-50",
        "--errors",
        YAW_ERROR,
        "--seed",
        &seed,
        "--lockstep",
    ];
    let _simulator = Process::start("atas-sim", &simulate);
    let _daemon = Process::start(
        "atasd",
        &["--bus", name, "--config", "/dev/null", "--lockstep"],
    );
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let mut reports = observer
        .subscriber::<TickReport>(service::TICK_REPORT)
        .expect("a subscriber");
    let client = observer.goal_client().expect("a client");
    let mut pending = wait_for("the daemon", || client.send(&goal()).ok());
    let mut sums = BTreeMap::new();
    wait_for("the goal's end", || {
        let mut note = |report: &TickReport| {
            sums.insert(report.tick, report.command_crc32);
        };
        reports.drain(usize::MAX, &mut note).expect("readable");
        let update = pending.next().expect("an update")?;
        update
            .state
            .is_final()
            .then(|| assert_eq!(update.state, GoalState::SUCCEEDED, "{}", update.reason))
    });
    sums
}

/// Runs the goal in process.
fn in_process() -> BTreeMap<u64, u32> {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let mut run =
        OfflineRun::without_tick(&robot, &scene(), SEED, Settings::default()).expect("a world");
    let mut sums = BTreeMap::new();
    loop {
        let tick = sums.len() as u64;
        let order = (tick == WARM_UP_TICKS).then(|| run.request(&goal()).expect("within reach"));
        let outputs = run.step(order.as_ref());
        sums.insert(outputs.report.tick, outputs.report.command_crc32);
        if outputs.goal_update.is_some_and(|u| u.state.is_final()) {
            return sums;
        }
    }
}

/// Compares the checksums of common ticks. Reports that the observer missed are tolerated.
fn compare(what: &str, a: &BTreeMap<u64, u32>, b: &BTreeMap<u64, u32>) {
    let common = a.keys().filter(|tick| b.contains_key(tick)).count();
    assert!(
        common * 10 > a.len().max(b.len()) * 9,
        "{what}: only {common} ticks seen by both"
    );
    for (tick, sum) in a {
        assert!(
            b.get(tick).is_none_or(|other| other == sum),
            "{what}: commands differ first at tick {tick}"
        );
    }
}

#[test]
fn same_seed_gives_same_commands() {
    let _shared = lock_shared();
    let (first, second, offline) = (over_the_bus(), over_the_bus(), in_process());
    compare("two runs over the bus", &first, &second);
    compare("the bus and in process", &first, &offline);
}
