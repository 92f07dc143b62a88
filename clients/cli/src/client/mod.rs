//! A client of a running daemon: joins its bus, asks, waits for the answer.

mod control;
mod events;
mod goals;
mod latency;
mod pursuit;
mod status;

pub(crate) use control::{estop, get, list, recover, set};
pub(crate) use events::events;
pub(crate) use goals::{assemble, grasp, pick_place, release, screw, task};
pub(crate) use latency::latency;
pub(crate) use pursuit::{Cancelled, Pursuit};
pub(crate) use status::status;

use std::cell::Cell;
use std::time::{Duration, Instant};

use shm_bus::{Bus, BusName, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::{Stamp, Status, service};

use crate::exit::{Ended, Exit};

/// How often a waiting client looks (ours: imperceptible to a person).
pub(crate) const POLL: Duration = Duration::from_millis(5);
/// How long to wait for a sign of the daemon, which publishes its status 50 times a second (ours: 40 of them).
const SIGN_OF_LIFE: Duration = Duration::from_millis(800);

/// This process's place on the bus of a daemon.
pub(crate) struct Session {
    bus: Bus,
    epoch: u64,
    sequence: Cell<u64>,
}

impl Session {
    /// Joins a bus.
    pub(crate) fn join(name: &BusName) -> anyhow::Result<Self> {
        Ok(Self {
            bus: Bus::open(name, "atas", Realtime::No)?,
            epoch: writer_epoch(),
            sequence: Cell::new(0),
        })
    }

    /// The bus, to open ports on.
    pub(crate) fn bus(&self) -> &Bus {
        &self.bus
    }

    /// The stamp of the next request.
    fn stamp(&self) -> Stamp {
        let sequence = self.sequence.get();
        self.sequence.set(sequence + 1);
        Stamp {
            sequence,
            captured_ns: now_ns(),
            writer_epoch: self.epoch,
        }
    }

    /// Begins to read the daemon's status, and waits for the first one: proof that a daemon lives.
    pub(crate) fn watch_status(&self) -> anyhow::Result<(Subscriber<Status>, Status)> {
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

    fn no_daemon(&self) -> anyhow::Error {
        Ended::with(
            Exit::NoDaemon,
            format!(
                "could not find a daemon because nothing on bus {:?} (folder {}) reports its status; \
                 start `atasd`, or name its bus with --bus or {}",
                self.bus.name().as_str(),
                self.bus.folder().display(),
                BusName::ENV
            ),
        )
    }
}
