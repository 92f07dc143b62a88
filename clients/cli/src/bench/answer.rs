//! From sensors to the command across processes, both polling, against a bare ping-pong of the same words.

use std::time::Instant;

use robot_model::{RobotModel, Side};
use shm_bus::{Bus, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::{HandFrame, JointCommand, JointState, Mode, Percentiles, TickReport, service};
use sim_backend::{Object, Scene, Sensed, World};

use super::Plan;
use super::pair::NO_CONFIGURATION;
use super::punctual::body_ns;
use super::site::Site;
use super::transport::{ANSWER_WITHIN, poll, rounds, start_echo};
use crate::arguments::{HOLD_S, LIFT_MM};
use crate::client::Session;
use crate::demo::child::Child;
use crate::figures;
use crate::rehearsal::grasp_goal;

/// Ticks of a grasp that are measured: from the approach into the lift.
const TICKS: usize = 5_000;
/// Most ticks until the goal begins.
const PATIENCE_TICKS: usize = 2_000;
/// Most reports taken in one look: all that can wait.
const AT_ONCE: usize = 256;
/// Ticks between two looks at the reports.
const LOOK_EVERY: usize = 64;

/// Durations of one repeat.
pub(super) struct Answer {
    /// From before the frames are written to the command's arrival.
    pub(super) daemon: Percentiles,
    /// The tick's body meanwhile.
    pub(super) body: Percentiles,
    /// The same words there and back with nothing in between.
    pub(super) ping_pong: Percentiles,
}

impl Answer {
    /// How much longer the daemon takes than the bare words and the body of a tick.
    pub(super) fn ratio(&self) -> f64 {
        self.daemon.p50_ns as f64 / (self.ping_pong.p50_ns + self.body.p50_ns) as f64
    }
}

pub(super) fn measure(plan: &Plan<'_>) -> anyhow::Result<Answer> {
    let ping_pong = ping_pong(plan)?;
    let (daemon, body) = daemon(plan)?;
    Ok(Answer {
        daemon,
        body,
        ping_pong,
    })
}

/// The sensors' end of the bus.
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

    /// Whether the command that answers this joint state is there.
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
        // The command of no tick answers 0.
        joints.stamp.sequence = sequence + 1;
        sensors.send([&frame, &frame], &joints)?;
        poll(limit, || sensors.is_answered(sequence + 1))
    })
}

/// A daemon in lock-step polls its sensors, which are played by this thread.
fn daemon(plan: &Plan<'_>) -> anyhow::Result<(Percentiles, Percentiles)> {
    let robot = RobotModel::two_hand_arm()?;
    let scene = Scene::grasp(Object::built_in("wood")?, Side::Right);
    let hint = scene
        .grasp_hint(0)
        .ok_or_else(|| anyhow::anyhow!("the scene has no object"))?;
    let goal = grasp_goal(&hint, Side::Right, LIFT_MM * 1e-3, HOLD_S);
    let mut world = World::new(&robot, &scene, 1)?;
    let site = Site::new()?;
    let session = Session::join(site.bus())?;
    let mut sensors = Sensors::open(session.bus())?;
    let mut reports = session
        .bus()
        .subscriber::<TickReport>(service::TICK_REPORT)?;
    let control = [
        &["--bus", site.bus().as_str(), "--lockstep"],
        &NO_CONFIGURATION[..],
    ]
    .concat();
    let mut daemon = Child::start("atasd", &control, site.folder())?;
    let client = session.bus().goal_client()?;
    let mut pending = None;
    let mut sensed = Sensed::default();
    let (mut durations_ns, mut bodies_ns) = (Vec::new(), Vec::new());
    for tick in 0..TICKS + PATIENCE_TICKS {
        if pending.is_none() {
            // Refused as long as the daemon has not opened its door.
            pending = client.send(&goal).ok();
        }
        world.sense(&mut sensed);
        let [Some(left), Some(right)] = &sensed.frames else {
            anyhow::bail!("a sensor at full rate sends a frame in every tick");
        };
        let sequence = sensed.joints.stamp.sequence;
        let (begin_ns, begin) = (now_ns(), Instant::now());
        sensors.send([left, right], &sensed.joints)?;
        while !poll(super::transport::ANSWER_WITHIN / 100, || {
            sensors.is_answered(sequence)
        })? {
            plan.interrupt.check("the bench waited for the daemon")?;
            daemon.check()?;
            if pending.is_none() {
                pending = client.send(&goal).ok();
            }
            // What was sent before the daemon was there, it has not heard.
            sensors.frames.iter().try_for_each(Publisher::greet)?;
            sensors.joints.greet()?;
            anyhow::ensure!(
                begin.elapsed() < 3 * ANSWER_WITHIN,
                "the daemon does not answer"
            );
        }
        let duration_ns = now_ns() - begin_ns;
        let command = sensors.command;
        if command.mode == Mode::RUN {
            durations_ns.push(duration_ns);
        }
        world.advance(Some(&command));
        if tick % LOOK_EVERY == 0 {
            reports.drain(AT_ONCE, |report| {
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
        "the daemon did not run the goal"
    );
    Ok((figures::of(durations_ns), figures::of(bodies_ns)))
}
