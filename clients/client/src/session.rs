//! This process's place on the bus of a daemon.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use shm_bus::{Bus, BusName, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::{
    ControlOp, ControlOutcome, ControlReply, ControlRequest, Mode, Stamp, Status, Text, service,
};

use crate::{ClientError, Stopped};

/// How often a waiting client looks (ours: imperceptible to a person).
pub const POLL: Duration = Duration::from_millis(5);
/// How long to wait for a sign of the daemon, which publishes its status 50 times a second (ours: 40 of them).
const SIGN_OF_LIFE: Duration = Duration::from_millis(800);
/// How long the daemon may take to answer a request (ours: it looks 50 times a second).
const ANSWER: Duration = Duration::from_millis(900);
/// How long a goal waits for a daemon that begins or re-arms (ours: on a busy machine the first frames take a tenth of it).
const ARMING: Duration = Duration::from_secs(2);

/// This process's place on the bus of a daemon.
pub struct Session {
    bus: Bus,
    epoch: u64,
    sequence: Cell<u64>,
}

impl Session {
    /// Joins a bus that is there. A name that nobody has made a bus of leaves nothing behind.
    ///
    /// # Errors
    /// There is no such bus, or it cannot be joined.
    pub fn existing(name: &BusName) -> Result<Self, ClientError> {
        Ok(Self::of(Bus::join(name, "atas", Realtime::No)?))
    }

    /// Joins a bus, and makes it where it is not: for those who may come before the daemon.
    ///
    /// # Errors
    /// The bus cannot be joined.
    pub fn join(name: &BusName) -> Result<Self, ClientError> {
        Ok(Self::of(Bus::open(name, "atas", Realtime::No)?))
    }

    /// On a bus that this process has joined.
    #[must_use]
    pub fn of(bus: Bus) -> Self {
        Self {
            bus,
            epoch: writer_epoch(),
            sequence: Cell::new(0),
        }
    }

    /// The bus, to open ports on.
    #[must_use]
    pub fn bus(&self) -> &Bus {
        &self.bus
    }

    /// The timestamp of the next request.
    pub fn stamp(&self) -> Stamp {
        let sequence = self.sequence.get();
        self.sequence.set(sequence + 1);
        Stamp {
            sequence,
            captured_ns: now_ns(),
            writer_epoch: self.epoch,
        }
    }

    /// Begins to read the daemon's status, and waits for the first one: proof that a daemon lives.
    ///
    /// # Errors
    /// [`ClientError::NoDaemon`] if none comes.
    pub fn watch_status(&self) -> Result<(Subscriber<Status>, Status), ClientError> {
        let mut statuses = self.bus.subscriber::<Status>(service::STATUS)?;
        let mut status = Status::default();
        let begin = Instant::now();
        while !statuses.newest(&mut status)? {
            if begin.elapsed() > SIGN_OF_LIFE {
                return Err(self.no_daemon());
            }
            std::thread::sleep(POLL);
        }
        Ok((statuses, status))
    }

    /// Waits while the daemon begins or re-arms after a hold, in which it takes no goal, so that what starts or recovers it may send
    /// one at once. Where that lasts, or `stop` is set, the daemon shall say itself why it takes none.
    ///
    /// # Errors
    /// [`ClientError::NoDaemon`] if no status comes.
    pub fn wait_until_armed(&self, stop: &AtomicBool) -> Result<(), ClientError> {
        let (mut statuses, mut status) = self.watch_status()?;
        let begin = Instant::now();
        while matches!(status.mode, Mode::INIT | Mode::HOLD)
            && begin.elapsed() < ARMING
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
        }
    }

    /// Asks once and waits for the answer, whatever it is.
    ///
    /// # Errors
    /// Nobody answers.
    pub fn ask(&self, op: ControlOp, value: f64, name: &str) -> Result<ControlReply, ClientError> {
        let request = ControlRequest {
            stamp: self.stamp(),
            op,
            value,
            name: Text::new(name),
            ..ControlRequest::default()
        };
        Ok(self.bus.control_client()?.call(&request, ANSWER)?)
    }

    /// Asks for something that must be done.
    ///
    /// # Errors
    /// Nobody answers, or the daemon refuses, with its reason.
    pub fn demand(
        &self,
        op: ControlOp,
        value: f64,
        name: &str,
    ) -> Result<ControlReply, ClientError> {
        let reply = self.ask(op, value, name)?;
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

    /// Waits beside a daemon that reports these modes one after the other, the last one for ever; which it had got to.
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
    fn a_daemon_that_begins_or_re_arms_is_waited_for_and_no_other() {
        let check = |modes: &[Mode], stop: bool, expected: Mode| {
            assert_eq!(waited(modes, stop), expected, "{modes:?}, stop {stop}");
        };
        const BEGINS: [Mode; 60] = [Mode::INIT; 60];
        let then = |mode| [&BEGINS[..], &[Mode::HOLD, mode]].concat();
        check(&then(Mode::READY), false, Mode::READY);
        check(&then(Mode::RUN), false, Mode::RUN);
        check(&then(Mode::SAFE_STOP), false, Mode::SAFE_STOP);
        // It does not come to be ready: that is its own to say. Told to stop: nothing is waited for.
        check(&BEGINS, false, Mode::INIT);
        check(&then(Mode::READY), true, Mode::INIT);
        check(&[Mode::FAULT], false, Mode::FAULT);
    }
}
