//! `atas-sim course`: hosts a course on the bus in lock-step. Every robot has its own bus, like a
//! stationary robot.
//!
//! ```text
//!  every 100 ticks   BaseState ─▶ coordinator ─ BaseCommand ─▶ AgentSensors ─▶ table ─▶ bases
//!  every tick        bases ─ base motion ─▶ world ─▶ daemon ─ JointCommand ─▶ world
//! ```
//!
//! Time advances when all processes have answered, without a time limit. The table is read only if
//! it controls the base. A robot stands still once its coordinator ends its course; the process
//! ends after the last one.

mod args;
mod ports;
mod report;

use std::sync::atomic::{AtomicBool, Ordering};

use robot_model::RobotModel;
use shm_bus::{Bus, Realtime};
use shm_schemas::WorldTruth;
use sim_backend::World;
use sim_backend::course::{Host, RobotSetup, SETTLE_TICKS, Scenario};

use crate::failure::Failure;
use crate::lockstep::await_answer;
use crate::session::Session;
pub(crate) use args::CourseArgs;
use ports::Ports;

/// Hosts the course until it is over or a signal arrives.
pub(crate) fn run(args: &CourseArgs) -> Result<(), Failure> {
    let stop = crate::stop_on_signal()?;
    let robot = RobotModel::two_hand_arm()?;
    let cast = Scenario::random(args.seed, &args.objects()?)?;
    let buses = args.buses()?;
    let seats = cast.robots.iter().zip(&buses);
    let seats = seats.map(|(player, name)| {
        let bus = Bus::open(name, "atas-sim", Realtime::Yes)?;
        RobotSession::open(&bus, &robot, player)
    });
    let mut stage = CourseRun {
        robots: seats.collect::<Result<_, Failure>>()?,
        host: Host::new(&cast, &robot),
        stop: &stop,
    };
    let robots = stage.robots.len();
    tracing::info!(
        seed = args.seed,
        robots,
        "hosting the course; waiting for daemons, tables and coordinators"
    );
    stage.run()?;
    report::print(&stage.host, &stage.robots, args.format)
}

pub(crate) struct RobotSession {
    session: Session,
    ports: Ports,
}

impl RobotSession {
    fn open(bus: &Bus, robot: &RobotModel, player: &RobotSetup) -> Result<Self, Failure> {
        let world = World::new(robot, &player.scene, player.seed)?;
        Ok(Self {
            session: Session::open(bus, world, &[], player.seed)?,
            ports: Ports::open(bus)?,
        })
    }

    fn truth(&self) -> WorldTruth {
        self.session.world.truth()
    }
}

struct CourseRun<'a> {
    robots: Vec<RobotSession>,
    host: Host,
    stop: &'a AtomicBool,
}

impl CourseRun<'_> {
    fn run(&mut self) -> Result<(), Failure> {
        for seat in &mut self.robots {
            // Discards commands of an earlier world.
            seat.session.newest_command()?;
        }
        for _ in 0..SETTLE_TICKS {
            if !self.tick()? {
                return Ok(());
            }
        }
        loop {
            if self.host.frame_begins() && !self.frame()? {
                return Ok(());
            }
            self.host.step();
            for (index, seat) in self.robots.iter_mut().enumerate() {
                seat.session
                    .world
                    .set_base_motion(&self.host.base_motion(index))?;
            }
            if !self.tick()? {
                return Ok(());
            }
            for (index, seat) in self.robots.iter().enumerate() {
                if !self.host.is_over(index) {
                    self.host.measure(index, || seat.truth());
                }
            }
        }
    }

    /// Queries the coordinators in turn, and tables that control a base; returns false if the
    /// process must end.
    fn frame(&mut self) -> Result<bool, Failure> {
        for (index, seat) in self.robots.iter_mut().enumerate() {
            let truth = seat.truth();
            let state = self.host.base_state(index, &truth);
            if self.host.is_over(index) {
                continue;
            }
            seat.session.publish_truth()?;
            let Some(command) = seat
                .ports
                .request_command(state, &seat.session, self.stop)?
            else {
                return Ok(false);
            };
            let wheels = match self.host.row(index, &command) {
                None => None,
                Some(row) => match seat.ports.look_up(row, state.frame, self.stop)? {
                    None => return Ok(false),
                    wheels => wheels,
                },
            };
            self.host.execute(index, &command, wheels, &truth);
        }
        Ok(!(0..self.robots.len()).all(|index| self.host.is_over(index)))
    }

    /// Simulates one tick of all robots on course; returns false if the process must end.
    fn tick(&mut self) -> Result<bool, Failure> {
        let host = &self.host;
        let seats = self.robots.iter_mut().enumerate();
        let mut acting: Vec<_> = seats.filter(|(index, _)| !host.is_over(*index)).collect();
        let mut asked = Vec::with_capacity(acting.len());
        for (_, seat) in &mut acting {
            seat.session.publish_truth()?;
            asked.push(seat.session.publish()?);
        }
        for ((_, seat), sequence) in acting.iter_mut().zip(asked) {
            // Without faults every joint state reaches the daemon.
            let Some(sequence) = sequence else { continue };
            let Some(command) = await_answer(&mut seat.session, sequence, self.stop)? else {
                return Ok(false);
            };
            seat.session.advance(Some(&command))?;
        }
        Ok(!self.stop.load(Ordering::Relaxed))
    }
}
