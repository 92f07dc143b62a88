//! `run`: the robot on the bus, its ports on threads of their own.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, PoisonError};
use std::thread;
use std::time::Duration;

use shm_bus::{Bus, BusName, Publisher, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::service::{JOINT_COMMAND, JOINT_STATE};
use shm_schemas::{JointCommand, JointState};

use super::{say, stop_on_signal};
use crate::failure::Failure;
use crate::map::{self, Check, Map};
use crate::port::{self, Report, Shared};
use crate::robot::{Change, Robot};

/// How long to wait for a report before commands are looked for again: the daemon's tick.
const LOOK_EVERY: Duration = Duration::from_millis(1);

/// Drives the servos of a map.
pub(super) fn run(path: &Path, bus: &BusName, wait: bool) -> Result<(), Failure> {
    let map = map::load(path, Check::Whole)?;
    let stop = stop_on_signal()?;
    let node = Bus::open(bus, "robot", Realtime::No).map_err(Failure::Bus)?;
    let mut line = Line::open(&node)?;
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
        say(&format!(
            "{} {}: {figures}",
            port.driver.name(),
            port.device
        ));
    }
    outcome.inspect(|()| say("the servos go on holding; to let them go: atas-robot relax"))
}

/// The robot's two streams.
struct Line {
    states: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    command: JointCommand,
}

impl Line {
    fn open(node: &Bus) -> Result<Self, Failure> {
        let mut line = Self {
            states: node.publisher(JOINT_STATE).map_err(Failure::Bus)?,
            commands: node.subscriber(JOINT_COMMAND).map_err(Failure::Bus)?,
            command: JointCommand::default(),
        };
        // A command from before this robot answers nothing of it.
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

/// Passes reports, commands and states on until all ports have ended.
fn drive(
    map: &Map,
    line: &mut Line,
    ports: &[Shared],
    from: &Receiver<(usize, Report)>,
    wait: bool,
) -> Result<(), Failure> {
    let mut robot = Robot::new(map.joints.clone(), ports.len(), writer_epoch);
    let mut was_whole = false;
    loop {
        match from.recv_timeout(LOOK_EVERY) {
            Ok((index, report)) => match robot.report(index, report) {
                Change::None => {}
                Change::Whole => {
                    let again = if was_whole { " again" } else { "" };
                    was_whole = true;
                    tracing::info!("all {} joints hold{again}; states begin", map.joints.len());
                }
                Change::StillBroken(why) if !was_whole && !wait => {
                    return Err(Failure::Servos(format!(
                        "could not take the servos over: {why}"
                    )));
                }
                Change::Broken(why) | Change::StillBroken(why) => {
                    tracing::error!("no joint states, what can hold holds: {why}");
                }
            },
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if let Some(command) = line.newest()?
            && robot.command(command, now_ns())
        {
            for (index, shared) in ports.iter().enumerate() {
                if let Some((life, position_rad)) = robot.orders(index) {
                    shared.order(life, position_rad);
                }
            }
        }
        if let Some(state) = robot.state() {
            line.states.send(&state).map_err(Failure::Bus)?;
        }
    }
    say(&format!("{} commands refused", robot.refused()));
    Ok(())
}
