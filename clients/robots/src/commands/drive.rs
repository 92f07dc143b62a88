//! `run`: connects the robot to the bus, with one thread per port.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, PoisonError};
use std::thread;
use std::time::Duration;

use shm_bus::{Bus, BusName, Publisher, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::service::{JOINT_COMMAND, JOINT_STATE};
use shm_schemas::{JointCommand, JointState};

use super::{print_message, stop_on_signal};
use crate::failure::Failure;
use crate::map::{self, Check, Map};
use crate::port::{self, Report, Shared};
use crate::robot::{Change, Robot};

/// Maximum time between checks for commands: the daemon's tick.
const COMMAND_POLL: Duration = Duration::from_millis(1);

/// Drives the servos of a map.
pub(super) fn run(path: &Path, bus: &BusName, wait: bool) -> Result<(), Failure> {
    let map = map::load(path, Check::Whole)?;
    let stop = stop_on_signal()?;
    let node = Bus::open(bus, "robot", Realtime::No).map_err(Failure::Bus)?;
    let mut line = BusPorts::open(&node)?;
    let ports: Vec<Shared> = map
        .ports
        .iter()
        .map(|_| Shared::new(Arc::clone(&stop)))
        .collect();
    let (to, from) = channel();
    let outcome = thread::scope(|scope| {
        for (index, (port, shared)) in map.ports.iter().zip(&ports).enumerate() {
            let to = to.clone();
            scope.spawn(move || port::run(port, index, &to, shared));
        }
        drop(to);
        let outcome = drive(&map, &mut line, &ports, &from, wait);
        stop.store(true, Ordering::Relaxed);
        outcome
    });
    for (port, shared) in map.ports.iter().zip(&ports) {
        let figures = shared
            .figures
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        print_message(&format!(
            "{} {}: {figures}",
            port.driver.name(),
            port.device
        ));
    }
    outcome.inspect(|()| {
        print_message("the servos keep holding; to switch their torque off: atas-robot relax")
    })
}

/// The robot's two bus services.
struct BusPorts {
    states: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    command: JointCommand,
}

impl BusPorts {
    fn open(node: &Bus) -> Result<Self, Failure> {
        let mut line = Self {
            states: node.publisher(JOINT_STATE).map_err(Failure::Bus)?,
            commands: node.subscriber(JOINT_COMMAND).map_err(Failure::Bus)?,
            command: JointCommand::default(),
        };
        // Discards a command sent before this robot started.
        line.newest()?;
        Ok(line)
    }

    fn newest(&mut self) -> Result<Option<&JointCommand>, Failure> {
        let came = self
            .commands
            .newest(&mut self.command)
            .map_err(Failure::Bus)?;
        Ok(came.then_some(&self.command))
    }
}

/// Processes reports and commands and publishes states until all ports have ended.
fn drive(
    map: &Map,
    line: &mut BusPorts,
    ports: &[Shared],
    from: &Receiver<(usize, Report)>,
    wait: bool,
) -> Result<(), Failure> {
    let mut robot = Robot::new(map.joints.clone(), ports.len(), writer_epoch);
    let mut was_whole = false;
    loop {
        match from.recv_timeout(COMMAND_POLL) {
            Ok((index, report)) => match robot.report(index, report) {
                Change::None => {}
                Change::Ready => {
                    let again = if was_whole { " again" } else { "" };
                    was_whole = true;
                    tracing::info!("all {} joints hold{again}; states begin", map.joints.len());
                }
                Change::TakeOverFailed(why) if !was_whole && !wait => {
                    return Err(Failure::Servos(format!(
                        "could not take over the servos: {why}"
                    )));
                }
                Change::Failed(why) | Change::TakeOverFailed(why) => {
                    tracing::error!("joint states stopped, working servos keep holding: {why}");
                }
            },
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if let Some(command) = line.newest()?
            && robot.command(command, now_ns())
        {
            for (index, shared) in ports.iter().enumerate() {
                if let Some((life, position)) = robot.setpoints(index) {
                    shared.set_goals(life, position);
                }
            }
        }
        if let Some(state) = robot.state() {
            line.states.send(&state).map_err(Failure::Bus)?;
        }
    }
    print_message(&format!("{} commands rejected", robot.rejected()));
    Ok(())
}
