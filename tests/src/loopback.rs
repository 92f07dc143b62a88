//! The production tick and a simulated world in one thread, over a real bus: what costs nothing but itself.
//!
//! Sensors write, [`Loopback::tick`] runs one tick of the daemon in lock-step, the robot takes the command. Nothing
//! waits, so a grasp of eight simulated seconds takes a fraction of one. With a recorder, the input_log is drained by a thread
//! beside it, as the daemon's supervisor does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use atas_core::goal::Goal;
use atas_core::{Controller, Order, Settings, Wiring};
use atas_evaluation::offline::grasp_goal;
use atasd::input_log::LogReader;
use atasd::link::{SupervisorEnd, TickRecord, link};
use atasd::pacer::{LockStep, Pacer};
use atasd::tick::TickLoop;
use robot_model::RobotModel;
use shm_bus::{Bus, BusName, FreshBus, Publisher, Realtime, Subscriber};
use shm_schemas::{HandFrame, JointCommand, JointState, TickInputs, service};
use sim_backend::{Object, Scene, Sensed, World};

/// How long the object is held, s: longer than any measurement.
const HOLD_S: f64 = 100_000.0;
/// How far it is lifted, m.
const LIFT_M: f64 = 0.05;
/// Pause of the drain; shorter than the supervisor's, because ticks come faster here.
const ROUND: Duration = Duration::from_micros(500);

/// A grasp of wood by the hand that acts.
#[derive(Debug)]
pub struct Loopback {
    world: World,
    sensed: Sensed,
    command: JointCommand,
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    ticks: TickLoop,
    link: SupervisorEnd,
    _drain: Option<Drain>,
    _buses: [Bus; 2],
    _name: FreshBus,
}

impl Loopback {
    /// The scene before the two-hand arm; with `recording`, every tick is recorded.
    ///
    /// # Panics
    /// If the bus cannot be opened.
    #[must_use]
    pub fn new(recording: bool) -> Self {
        Self::of(&RobotModel::two_hand_arm().expect("built in"), recording)
    }

    /// The same before another robot.
    ///
    /// # Panics
    /// If the bus cannot be opened, or the robot has no home.
    #[must_use]
    pub fn of(robot: &RobotModel, recording: bool) -> Self {
        let side = robot.acting_side();
        let scene = Scene::grasp(Object::built_in("wood").expect("built in"), side);
        let scene = scene.before(robot.hand(side));
        let hint = scene.grasp_hint(0).expect("an object");
        let name = FreshBus::new("loop");
        let open = |role| Bus::open(&name, role, Realtime::Yes).expect("a bus");
        let (robot_side, daemon_side) = (open("robot"), open("daemon"));
        let controller = Controller::new(robot, Wiring::of(robot), Settings::default());
        let (tick_end, mut link) = link(recording, Arc::default());
        let goal = grasp_goal(&hint, side, LIFT_M, HOLD_S);
        let goal = Goal::resolve(&goal, &[]).expect("built in");
        link.order(Order::Start(goal)).expect("room for an order");
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

    /// The sensors write what they sense now.
    ///
    /// # Panics
    /// If the bus refuses.
    pub fn sense(&mut self) {
        self.world.sense(&mut self.sensed);
        for (port, frame) in self.frames.iter().zip(&self.sensed.frames) {
            // A hand that the robot has not got feels nothing.
            if let Some(frame) = frame {
                port.send(frame).expect("sent");
            }
        }
        self.joints.send(&self.sensed.joints).expect("sent");
    }

    /// One tick of the daemon.
    pub fn tick(&mut self) {
        production_tick(&mut self.ticks);
    }

    /// The supervisor and the robot take what the tick left.
    ///
    /// # Panics
    /// If the tick left nothing.
    pub fn act(&mut self) -> TickRecord {
        let record = self
            .link
            .next_record()
            .expect("every tick leaves its record");
        while self.link.next_event().is_some() {}
        let _snapshot = self.link.newest_snapshot();
        self.commands.newest(&mut self.command).expect("readable");
        self.world.advance(Some(&self.command));
        record
    }

    /// Parts of ticks that found no room.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.link.dropped()
    }
}

/// By this name a profiler knows what belongs to the tick.
#[inline(never)]
fn production_tick(ticks: &mut TickLoop) {
    assert!(ticks.run_once(), "nobody asked it to end");
}

/// Publishes the input_log until it is dropped.
#[derive(Debug)]
struct Drain {
    thread: Option<JoinHandle<()>>,
    ends: Arc<AtomicBool>,
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
                    log.give_back(part);
                }
                std::thread::sleep(ROUND);
            }
        });
        Self {
            thread: Some(thread),
            ends,
        }
    }
}

impl Drop for Drain {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        // A panic of the drain was printed when it happened.
        let _joined = self.thread.take().map(JoinHandle::join);
    }
}
