//! Session: connection of a client process to the bus of a daemon.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use shm_bus::{Bus, BusName, End, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::{
    ControlOp, ControlOutcome, ControlReply, ControlRequest, Mode, Stamp, Status, Text, service,
};

use crate::{ClientError, Stopped};

/// Poll interval of a waiting client. Design choice: not perceptible to a person.
pub const POLL: Duration = Duration::from_millis(5);
/// Longest wait for the daemon's status, which it publishes 50 times a second. Design choice: 40
/// statuses.
const STATUS_TIMEOUT: Duration = Duration::from_millis(800);
/// Longest wait for the answer to a request. Design choice: the daemon polls requests 50 times a
/// second.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(900);
/// Longest wait of a goal for a daemon that starts or re-arms. Design choice: ten times the delay
/// of the first frames on a busy machine.
const ARMING_TIMEOUT: Duration = Duration::from_secs(2);

/// Connection of this process to the bus of a daemon.
pub struct Session {
    bus: Bus,
    epoch: u64,
    sequence: Cell<u64>,
}

impl Session {
    /// Joins an existing bus. A missing bus is not created.
    ///
    /// # Errors
    /// The bus does not exist or cannot be joined.
    pub fn existing(name: &BusName) -> Result<Self, ClientError> {
        Ok(Self::from_bus(Bus::join(name, "atas", Realtime::No)?))
    }

    /// Joins a bus, and creates it if missing: for programs that may start before the daemon.
    ///
    /// # Errors
    /// The bus cannot be joined.
    pub fn join(name: &BusName) -> Result<Self, ClientError> {
        Ok(Self::from_bus(Bus::open(name, "atas", Realtime::No)?))
    }

    /// Creates a session on a bus that this process has joined.
    #[must_use]
    pub fn from_bus(bus: Bus) -> Self {
        Self {
            bus,
            epoch: writer_epoch(),
            sequence: Cell::new(0),
        }
    }

    /// Returns the bus.
    #[must_use]
    pub fn bus(&self) -> &Bus {
        &self.bus
    }

    /// Returns the stamp of the next request.
    pub fn stamp(&self) -> Stamp {
        let sequence = self.sequence.get();
        self.sequence.set(sequence + 1);
        Stamp {
            sequence,
            captured_ns: now_ns(),
            writer_epoch: self.epoch,
        }
    }

    /// Subscribes to the daemon's status and waits for the first one, which proves that a daemon
    /// runs.
    ///
    /// # Errors
    /// [`ClientError::NoDaemon`] if no status arrives.
    pub fn watch_status(&self) -> Result<(Subscriber<Status>, Status), ClientError> {
        let mut statuses = self.bus.subscriber::<Status>(service::STATUS)?;
        let mut status = Status::default();
        let begin = Instant::now();
        while !statuses.newest(&mut status)? {
            if begin.elapsed() > STATUS_TIMEOUT {
                return Err(self.no_daemon());
            }
            std::thread::sleep(POLL);
        }
        Ok((statuses, status))
    }

    /// Waits while the daemon starts or re-arms after a hold, so that a goal can be sent
    /// immediately afterwards. Returns early when `stop` is set or after two seconds; the daemon
    /// then rejects the goal with its reason.
    ///
    /// # Errors
    /// [`ClientError::NoDaemon`] if no status arrives.
    pub fn wait_until_armed(&self, stop: &AtomicBool) -> Result<(), ClientError> {
        let (mut statuses, mut status) = self.watch_status()?;
        let begin = Instant::now();
        while matches!(status.mode, Mode::INIT | Mode::HOLD)
            && begin.elapsed() < ARMING_TIMEOUT
            && !stop.load(Ordering::Relaxed)
        {
            std::thread::sleep(POLL);
            statuses.newest(&mut status)?;
        }
        Ok(())
    }

    fn no_daemon(&self) -> ClientError {
        if let Some(stopped) = Stopped::owner(self.bus.name()) {
            let bus = self.bus.name().as_str().to_owned();
            return ClientError::Stopped { bus, stopped };
        }
        ClientError::NoDaemon {
            bus: self.bus.name().as_str().to_owned(),
            folder: self.bus.folder().to_owned(),
            end: End::last(self.bus.name()),
        }
    }

    /// Sends a request and waits for any answer.
    ///
    /// # Errors
    /// No answer arrives.
    pub fn request(
        &self,
        op: ControlOp,
        value: f64,
        name: &str,
    ) -> Result<ControlReply, ClientError> {
        let request = ControlRequest {
            stamp: self.stamp(),
            op,
            value,
            name: Text::new(name),
            ..ControlRequest::default()
        };
        Ok(self.bus.control_client()?.call(&request, ANSWER_TIMEOUT)?)
    }

    /// Sends a request that must succeed.
    ///
    /// # Errors
    /// No answer arrives, or the daemon rejects the request with a reason.
    pub fn request_success(
        &self,
        op: ControlOp,
        value: f64,
        name: &str,
    ) -> Result<ControlReply, ClientError> {
        let reply = self.request(op, value, name)?;
        match reply.outcome {
            ControlOutcome::DONE => Ok(reply),
            outcome => Err(ClientError::Refused(format!("{outcome}: {}", reply.text))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_bus::FreshBus;

    /// Waits for a daemon that reports these modes in order and keeps the last one; returns the
    /// mode reached.
    fn waited(modes: &[Mode], stop: bool) -> Mode {
        let name = FreshBus::new("armed");
        let bus = Bus::open(&name, "atasd", Realtime::No).expect("a bus");
        let statuses = bus
            .publisher::<Status>(service::STATUS)
            .expect("a publisher");
        let client = BusName::clone(&name);
        let waiting = std::thread::spawn(move || {
            let session = Session::existing(&client).expect("a session");
            session.wait_until_armed(&AtomicBool::new(stop))
        });
        let mut reported = modes.iter().copied();
        let mut mode = Mode::default();
        while !waiting.is_finished() {
            mode = reported.next().unwrap_or(mode);
            let status = Status {
                mode,
                ..Status::default()
            };
            statuses.send(&status).expect("sent");
            std::thread::sleep(4 * POLL);
        }
        waiting.join().expect("it ran").expect("a status");
        mode
    }

    #[test]
    fn only_starting_and_rearming_daemons_are_awaited() {
        let check = |modes: &[Mode], stop: bool, expected: Mode| {
            assert_eq!(waited(modes, stop), expected, "{modes:?}, stop {stop}");
        };
        const BEGINS: [Mode; 10] = [Mode::INIT; 10];
        let then = |mode| [&BEGINS[..], &[Mode::HOLD, mode]].concat();
        check(&then(Mode::READY), false, Mode::READY);
        check(&then(Mode::RUN), false, Mode::RUN);
        check(&then(Mode::SAFE_STOP), false, Mode::SAFE_STOP);
        // A daemon that does not become ready answers the goal itself. A set stop flag ends the
        // wait.
        check(&BEGINS, false, Mode::INIT);
        check(&then(Mode::READY), true, Mode::INIT);
        check(&[Mode::FAULT], false, Mode::FAULT);
    }
}
