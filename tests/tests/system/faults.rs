//! Tests of the fault catalogue: faults injected by the simulator, or ended processes, while the
//! hand holds an object.
//!
//! In lock-step every bound is exact: number of ticks from the first tick at which the fault is
//! visible.

use robot_model::HandSide;
use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime, Subscriber};
use shm_schemas::{Cause, GoalState, JointCommand, Mode, Status, TickReport, WorldTruth, service};
use sim_backend::{Object, Scene};
use system_tests::{Process, lock_exclusive, lock_shared, wait_for};

/// Simulated time of the fault, s: the object is being lifted.
const FAULT_AT_S: f64 = 8.0;

struct Rig {
    simulator: Process,
    daemon: Process,
    observer: Bus,
    _bus: FreshBus,
}

impl Rig {
    fn new(faults: &[&str], lockstep: bool) -> Self {
        let bus = FreshBus::new("fault");
        let mut simulate = vec!["run", "--bus", bus.as_str(), "--object", "wood"];
        let mut control = vec!["--bus", bus.as_str(), "--config", "/dev/null"];
        for fault in faults {
            simulate.extend(["--fault", fault]);
        }
        if lockstep {
            simulate.push("--lockstep");
            control.push("--lockstep");
        }
        let simulator = Process::start("atas-sim", &simulate);
        let daemon = Process::start("atasd", &control);
        let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
        Self {
            simulator,
            daemon,
            observer,
            _bus: bus,
        }
    }

    fn grasp(&self) -> shm_bus::PendingGoal {
        let scene = Scene::grasp(Object::built_in("wood").expect("built in"), HandSide::Right);
        let hint = scene.grasp_hint(0).expect("an object");
        let goal = atas_evaluation::goals::grasp_goal(&hint, HandSide::Right, 0.03, 20.0);
        let client = self.observer.goal_client().expect("a client");
        wait_for("a daemon that accepts", || {
            let mut pending = client.send(&goal).ok()?;
            let first = wait_for("an answer", || pending.next().ok().flatten());
            (first.state != GoalState::REJECTED).then_some(pending)
        })
    }

    fn subscribe<T: shm_bus::StreamPayload>(&self, service: &str) -> Subscriber<T> {
        self.observer
            .subscriber::<T>(service)
            .expect("a subscriber")
    }
}

/// Runs a grasp in lock-step with a fault at [`FAULT_AT_S`]. Returns the ticks until the first
/// HOLD; `None` without a HOLD within 100 ticks.
fn ticks_to_hold(fault: &str) -> Option<u64> {
    let stage = Rig::new(&[fault], true);
    let mut reports = stage.subscribe::<TickReport>(service::TICK_REPORT);
    let mut pending = stage.grasp();
    let mut onset = None;
    wait_for("the fault's consequence", || {
        let mut answer = None;
        reports
            .drain(usize::MAX, |report| {
                let now_s = report.stamp.captured_ns as f64 * 1e-9;
                if now_s < sim_start_s() + FAULT_AT_S || answer.is_some() {
                    return;
                }
                let begin = *onset.get_or_insert(report.tick);
                if report.mode == Mode::HOLD {
                    answer = Some(Some(report.tick - begin));
                } else if report.tick > begin + 100 {
                    answer = Some(None);
                }
            })
            .expect("readable");
        let _news = pending.next();
        answer
    })
}

/// Waits until the object is lifted, by ground truth.
fn wait_until_lifted(truth: &mut Subscriber<WorldTruth>, pending: &mut shm_bus::PendingGoal) {
    let mut world = WorldTruth::default();
    wait_for("the object to be lifted", || {
        truth.newest(&mut world).expect("readable");
        let _news = pending.next();
        (world.objects[0].lifted_m > 0.005).then_some(())
    });
}

fn sim_start_s() -> f64 {
    sim_backend::START_NS as f64 * 1e-9
}

#[test]
fn sensor_faults_cause_hold_within_bounds() {
    let _shared = lock_shared();
    let check = |name: &str, fault: &str, bound: Option<u64>| {
        let ticks = ticks_to_hold(fault);
        match bound {
            Some(bound) => assert!(
                ticks.is_some_and(|t| t <= bound),
                "{name}: {fault}: {ticks:?}, allowed {bound}"
            ),
            None => assert_eq!(ticks, None, "{name}: {fault}"),
        }
    };
    let at = |fault: &str| format!("{fault}@{FAULT_AT_S}");
    // A frame is 1 ms old when the next is due. Frame loss of 5 ms is detected 5 to 6 ticks after
    // the last frame.
    check(
        "F01 frame loss",
        &format!("{}:right", at("drop=1")),
        Some(6),
    );
    check(
        "F03 stale stamps",
        &format!("{}:right", at("stale=0.05")),
        Some(6),
    );
    check(
        "F04 future stamps",
        &format!("{}:right", at("future=0.05")),
        Some(6),
    );
    check(
        "F05 gap of three",
        &format!("drop=1@{FAULT_AT_S}+0.003:right"),
        None,
    );
    check(
        "F06 gap of eight",
        &format!("drop=1@{FAULT_AT_S}+0.008:right"),
        Some(10),
    );
    check(
        "F07 duplicates",
        &format!("{}:right", at("duplicate")),
        None,
    );
    check("F08 reorder", &format!("{}:right", at("reorder")), None);
    check("F02 frozen", &format!("{}:right", at("freeze")), Some(50));
    check(
        "F10 a few bit flips",
        &format!("{}:right", at("corrupt=0.1")),
        None,
    );
    check("F12 one NaN", &format!("{}:right", at("nan=1")), None);
    check("F12 many NaN", &format!("{}:right", at("nan=20")), Some(1));
    check(
        "F14 one huge reading",
        &format!("{}:right", at("huge")),
        None,
    );
}

#[test]
fn grip_persists_after_sensor_loss() {
    let _alone = lock_exclusive();
    let mut stage = Rig::new(&[], false);
    let mut truth = stage.subscribe::<WorldTruth>(service::WORLD_TRUTH);
    let mut statuses = stage.subscribe::<Status>(service::STATUS);
    let mut commands = stage.subscribe::<JointCommand>(service::JOINT_COMMAND);
    let mut pending = stage.grasp();
    wait_until_lifted(&mut truth, &mut pending);
    stage.simulator.signal(Signal::KILL);
    stage.simulator.wait();
    let mut status = Status::default();
    wait_for("HOLD", || {
        statuses.newest(&mut status).expect("readable");
        (status.mode == Mode::HOLD).then_some(())
    });
    assert!(
        matches!(
            status.reason.cause,
            Cause::FRAMES_STOPPED | Cause::FRAME_STALE | Cause::JOINTS_STOPPED
        ),
        "{}",
        status.reason
    );
    let end = wait_for("the goal to fail", || {
        pending
            .next()
            .expect("an update")
            .filter(|u| u.state.is_final())
    });
    assert_eq!(end.state, GoalState::FAILED, "{}", end.reason);
    let (mut early, mut late) = (JointCommand::default(), JointCommand::default());
    wait_for("a command", || {
        commands.newest(&mut early).expect("readable").then_some(())
    });
    std::thread::sleep(std::time::Duration::from_millis(300));
    wait_for("a command", || {
        commands.newest(&mut late).expect("readable").then_some(())
    });
    assert_eq!(
        early.position, late.position,
        "HOLD keeps position and grip"
    );
    assert_eq!(late.velocity, [0.0; 32]);
    assert!(late.is_intact() && late.mode == Mode::HOLD);
}

#[test]
fn sigterm_during_grasp_keeps_the_grip() {
    let _alone = lock_exclusive();
    let mut stage = Rig::new(&[], false);
    let mut truth = stage.subscribe::<WorldTruth>(service::WORLD_TRUTH);
    let mut pending = stage.grasp();
    wait_until_lifted(&mut truth, &mut pending);
    let mut world = WorldTruth::default();
    stage.daemon.signal(Signal::TERM);
    assert_eq!(stage.daemon.wait().code(), Some(0));
    // Without a daemon the simulated robot lets its last command expire and keeps the grip.
    std::thread::sleep(std::time::Duration::from_millis(500));
    wait_for("ground truth after the end", || {
        truth.newest(&mut world).expect("readable").then_some(())
    });
    assert_eq!(world.objects[0].dropped, 0, "the object stays in the hand");
    assert!(
        world.objects[0].lifted_m > 0.004,
        "lifted {} m",
        world.objects[0].lifted_m
    );
}
