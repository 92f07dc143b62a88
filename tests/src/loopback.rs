//! The production tick and a simulated world in one thread, over a real bus.
//!
//! The sensors publish, [`Loopback::tick`] runs one daemon tick in lock-step, the robot executes
//! the command. No step waits, so eight simulated seconds of a grasp take less than a second. With
//! a recorder, a second thread drains the input log, as the daemon's supervisor does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use atas_core::goal::Goal;
use atas_core::{Controller, OperatorRequest, SensorSetup, Settings};
use atas_evaluation::goals::grasp_goal;
use atasd::input_log::LogReader;
use atasd::link::{SupervisorSide, TickRecord, link};
use atasd::pacer::{LockStep, Pacer};
use atasd::tick::TickLoop;
use robot_model::RobotModel;
use shm_bus::{Bus, BusName, FreshBus, Publisher, Realtime, Subscriber};
use shm_schemas::{HandFrame, JointCommand, JointState, TickInputs, service};
use sim_backend::{Object, Scene, Sensed, World};

/// Hold time of the object, s: longer than any measurement.
const HOLD_S: f64 = 100_000.0;
/// Lift height, m.
const LIFT_M: f64 = 0.05;
/// Interval of the drain thread. Shorter than the supervisor's, because the ticks run faster than
/// real time.
const DRAIN_INTERVAL: Duration = Duration::from_micros(500);

/// A grasp of the wood object with the acting hand.
#[derive(Debug)]
pub struct Loopback {
    world: World,
    sensed: Sensed,
    command: JointCommand,
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    ticks: TickLoop,
    link: SupervisorSide,
    _drain: Option<Drain>,
    _buses: [Bus; 2],
    _name: FreshBus,
}

impl Loopback {
    /// Sets up the scene with the two-hand arm; with `recording`, records every tick.
    ///
    /// # Panics
    /// If the bus does not open.
    #[must_use]
    pub fn new(recording: bool) -> Self {
        Self::from_robot(&RobotModel::two_hand_arm().expect("built in"), recording)
    }

    /// Sets up the scene with another robot.
    ///
    /// # Panics
    /// If the bus does not open or the robot has no home position.
    #[must_use]
    pub fn from_robot(robot: &RobotModel, recording: bool) -> Self {
        let side = robot.acting_side();
        let scene = Scene::grasp(Object::built_in("wood").expect("built in"), side);
        let scene = scene.moved_to_hand(robot.hand(side));
        let hint = scene.grasp_hint(0).expect("an object");
        let name = FreshBus::new("loop");
        let open = |role| Bus::open(&name, role, Realtime::Yes).expect("a bus");
        let (robot_side, daemon_side) = (open("robot"), open("daemon"));
        let controller =
            Controller::new(robot, SensorSetup::from_robot(robot), Settings::default());
        let (tick_end, mut link) = link(recording, Arc::default());
        let goal = grasp_goal(&hint, side, LIFT_M, HOLD_S);
        let goal = Goal::resolve(&goal, &[]).expect("built in");
        link.request(OperatorRequest::Start(goal))
            .expect("room for a request");
        let pacer = Pacer::LockStep(LockStep::new());
        let ticks = TickLoop::open(&daemon_side, Box::new(controller), pacer, tick_end, 1000);
        Self {
            world: World::new(robot, &scene, 1).expect("a world"),
            sensed: Sensed::default(),
            command: JointCommand::default(),
            frames: service::HAND_FRAME.map(|s| robot_side.publisher(s).expect("a port")),
            joints: robot_side.publisher(service::JOINT_STATE).expect("a port"),
            commands: robot_side
                .subscriber(service::JOINT_COMMAND)
                .expect("a port"),
            ticks: ticks.expect("the ports open"),
            _drain: link.take_input_log().map(|log| Drain::start(&name, log)),
            link,
            _buses: [robot_side, daemon_side],
            _name: name,
        }
    }

    /// Publishes the current sensor data.
    ///
    /// # Panics
    /// If publishing fails.
    pub fn sense(&mut self) {
        self.world.sense(&mut self.sensed);
        for (port, frame) in self.frames.iter().zip(&self.sensed.frames) {
            // A hand that the robot lacks has no frame.
            if let Some(frame) = frame {
                port.send(frame).expect("sent");
            }
        }
        self.joints.send(&self.sensed.joints).expect("sent");
    }

    /// Runs one daemon tick.
    pub fn tick(&mut self) {
        production_tick(&mut self.ticks);
    }

    /// Takes the outputs of the tick, as supervisor and robot do, and advances the world.
    ///
    /// # Panics
    /// If the tick has no record.
    pub fn act(&mut self) -> TickRecord {
        let record = self
            .link
            .next_record()
            .expect("every tick pushes its record");
        while self.link.next_event().is_some() {}
        let _snapshot = self.link.newest_snapshot();
        self.commands.newest(&mut self.command).expect("readable");
        self.world.advance(Some(&self.command));
        record
    }

    /// Returns the number of input-log parts dropped because the queue was full.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.link.dropped()
    }
}

/// Separate function, so that a profiler can attribute the tick's cost.
#[inline(never)]
fn production_tick(ticks: &mut TickLoop) {
    assert!(ticks.run_once(), "the loop ended without a request");
}

/// Thread that publishes the input log until it is dropped.
#[derive(Debug)]
struct Drain {
    thread: Option<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
}

impl Drain {
    fn start(name: &BusName, mut log: LogReader) -> Self {
        let (name, ends) = (name.clone(), Arc::new(AtomicBool::new(false)));
        let ended = Arc::clone(&ends);
        let thread = std::thread::spawn(move || {
            let bus = Bus::open(&name, "drain", Realtime::No).expect("a bus");
            let inputs = bus.publisher::<TickInputs>(service::TICK_INPUTS);
            let inputs = inputs.expect("a port");
            while !ended.load(Ordering::Relaxed) {
                while let Some(part) = log.next_part() {
                    inputs.send(&part).expect("sent");
                    log.recycle(part);
                }
                std::thread::sleep(DRAIN_INTERVAL);
            }
        });
        Self {
            thread: Some(thread),
            stop: ends,
        }
    }
}

impl Drop for Drain {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // A panic of the drain thread is already printed.
        let _joined = self.thread.take().map(JoinHandle::join);
    }
}
