//! Latency from sensor messages to the command across processes, both polling, compared with a bare
//! echo of the same messages.

use std::time::Duration;

use anyhow::Context;
use atas_client::Session;
use atas_client::goal::{HOLD_S, LIFT_M};
use atas_client::percentiles;
use atas_evaluation::goals::grasp_goal;
use robot_model::{HandSide, RobotModel};
use shm_bus::{Bus, GoalClient, PendingGoal, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::{
    GoalRequest, HandFrame, JointCommand, JointState, Mode, Percentiles, TickReport, service,
};
use sim_backend::{Object, Scene, Sensed, World};

use super::Plan;
use super::body::body_ns;
use super::pair::NO_CONFIGURATION;
use super::site::Site;
use super::transport::{poll, rounds, start_echo};
use atas_processes::child::Child;

/// Number of measured ticks of a grasp, from approach into lift.
const TICKS: usize = 5_000;
const PATIENCE_TICKS: usize = 2_000;
/// Most reports read at once: the queue length.
const AT_ONCE: usize = 256;
/// Time without a reply after which the sensor messages are sent again.
const RESEND_INTERVAL: Duration = Duration::from_millis(50);
/// Longest time for the daemon to start and to reply.
const DAEMON_TIMEOUT: Duration = Duration::from_secs(15);
/// Ticks between two reads of the reports.
const POLL_EVERY: usize = 64;

pub(super) struct ResponseTimes {
    /// Time from before the frames are written to arrival of the command.
    pub(super) daemon: Percentiles,
    pub(super) body: Percentiles,
    /// Round trip of the same messages with a bare echo.
    pub(super) ping_pong: Percentiles,
}

impl ResponseTimes {
    /// Returns the daemon's time relative to echo plus tick duration.
    pub(super) fn ratio(&self) -> f64 {
        self.daemon.p50_ns as f64 / (self.ping_pong.p50_ns + self.body.p50_ns) as f64
    }
}

pub(super) fn measure(plan: &Plan<'_>) -> anyhow::Result<ResponseTimes> {
    let ping_pong = ping_pong(plan)?;
    let (daemon, body) = daemon(plan)?;
    Ok(ResponseTimes {
        daemon,
        body,
        ping_pong,
    })
}

/// Sensor side of the bus.
struct Sensors {
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    command: JointCommand,
}

impl Sensors {
    fn open(bus: &Bus) -> anyhow::Result<Self> {
        let [left, right] = service::HAND_FRAME;
        Ok(Self {
            frames: [bus.publisher(left)?, bus.publisher(right)?],
            joints: bus.publisher(service::JOINT_STATE)?,
            commands: bus.subscriber(service::JOINT_COMMAND)?,
            command: JointCommand::default(),
        })
    }

    fn send(&self, frames: [&HandFrame; 2], joints: &JointState) -> anyhow::Result<()> {
        for (port, frame) in self.frames.iter().zip(frames) {
            port.send(frame)?;
        }
        Ok(self.joints.send(joints)?)
    }

    /// Connects new readers: messages sent before the daemon joined are lost.
    fn connect_readers(&self) -> anyhow::Result<()> {
        self.frames
            .iter()
            .try_for_each(Publisher::connect_readers)?;
        Ok(self.joints.connect_readers()?)
    }

    fn is_answered(&mut self, sequence: u64) -> anyhow::Result<bool> {
        let news = self.commands.newest(&mut self.command)?;
        Ok(news && self.command.answers_sequence == sequence)
    }
}

fn ping_pong(plan: &Plan<'_>) -> anyhow::Result<Percentiles> {
    let site = Site::new()?;
    let mut echo = start_echo(&site, "words")?;
    let bus = Bus::open(site.bus(), "bench", Realtime::Yes)?;
    let mut sensors = Sensors::open(&bus)?;
    let (frame, mut joints) = (HandFrame::default(), JointState::default());
    rounds(plan, &mut echo, |sequence, limit| {
        // Sequence 0 stands for a command without a tick.
        joints.stamp.sequence = sequence + 1;
        sensors.send([&frame, &frame], &joints)?;
        poll(limit, || sensors.is_answered(sequence + 1))
    })
}

/// Measures a daemon in lock-step that polls the sensors simulated by this thread.
fn daemon(plan: &Plan<'_>) -> anyhow::Result<(Percentiles, Percentiles)> {
    let mut scene = PolledDaemon::start()?;
    let (mut durations_ns, mut bodies_ns) = (Vec::new(), Vec::new());
    for tick in 0..TICKS + PATIENCE_TICKS {
        let duration_ns = scene.exchange(plan)?;
        if scene.sensors.command.mode == Mode::RUN {
            durations_ns.push(duration_ns);
        }
        if tick % POLL_EVERY == 0 {
            scene.reports.drain(AT_ONCE, |report| {
                if report.mode == Mode::RUN {
                    bodies_ns.push(body_ns(report));
                }
            })?;
        }
        if durations_ns.len() >= TICKS {
            break;
        }
    }
    anyhow::ensure!(
        durations_ns.len() >= TICKS / 2,
        "the daemon did not run the goal: too few ticks in mode RUN"
    );
    Ok((
        percentiles::from_unsorted(durations_ns),
        percentiles::from_unsorted(bodies_ns),
    ))
}

/// Simulated world in this process, connected to a daemon in lock-step. Fields are dropped in this
/// order.
struct PolledDaemon {
    world: World,
    sensed: Sensed,
    sensors: Sensors,
    reports: Subscriber<TickReport>,
    pending: Option<PendingGoal>,
    client: GoalClient,
    goal: GoalRequest,
    _session: Session,
    daemon: Child,
    _site: Site,
}

impl PolledDaemon {
    fn start() -> anyhow::Result<Self> {
        let robot = RobotModel::two_hand_arm()?;
        let scene = Scene::grasp(Object::built_in("wood")?, HandSide::Right);
        let hint = scene.grasp_hint(0).context("the scene has no object")?;
        let site = Site::new()?;
        let session = Session::join(site.bus())?;
        let sensors = Sensors::open(session.bus())?;
        let reports = session.bus().subscriber(service::TICK_REPORT)?;
        let name = ["--bus", site.bus().as_str(), "--lockstep"];
        let control = [&name, &NO_CONFIGURATION[..]].concat();
        Ok(Self {
            world: World::new(&robot, &scene, 1)?,
            sensed: Sensed::default(),
            sensors,
            reports,
            pending: None,
            client: session.bus().goal_client()?,
            goal: grasp_goal(&hint, HandSide::Right, LIFT_M, HOLD_S),
            daemon: Child::start("atasd", &control, site.folder())?,
            _session: session,
            _site: site,
        })
    }

    /// Runs one tick; returns the time from before the sensor messages to arrival of the command,
    /// ns.
    fn exchange(&mut self, plan: &Plan<'_>) -> anyhow::Result<u64> {
        self.send_goal();
        self.world.sense(&mut self.sensed);
        let [Some(left), Some(right)] = self.sensed.frames else {
            anyhow::bail!(
                "invalid simulated sensors: a sensor at full rate must send a frame in \
                every tick"
            );
        };
        let sequence = self.sensed.joints.stamp.sequence;
        let begin_ns = now_ns();
        self.sensors.send([&left, &right], &self.sensed.joints)?;
        while !poll(RESEND_INTERVAL, || self.sensors.is_answered(sequence))? {
            plan.interrupt
                .check("the bench was waiting for the daemon")?;
            self.daemon.check()?;
            anyhow::ensure!(
                u128::from(now_ns() - begin_ns) < DAEMON_TIMEOUT.as_nanos(),
                "the daemon did not reply within {DAEMON_TIMEOUT:?}"
            );
            self.send_goal();
            self.sensors.connect_readers()?;
        }
        let duration_ns = now_ns() - begin_ns;
        self.world.advance(Some(&self.sensors.command));
        Ok(duration_ns)
    }

    /// Sends the goal; retried until the daemon accepts goals.
    fn send_goal(&mut self) {
        if self.pending.is_none() {
            self.pending = self.client.send(&self.goal).ok();
        }
    }
}
