//! The door: takes visitors in, each into a process of its own, and counts them by user.
//!
//! It reads nothing that a visitor says. The program is found anew for each visitor, so that after an upgrade what decides and
//! what it lets run are of one version.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, ensure};
use atas_gate::message::{self, Reply};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt::{socket_acceptconn, socket_peercred, socket_type};
use rustix::net::{SocketFlags, SocketType, accept_with};

/// Commands of one user at a time. A bus has 8 places for readers of its events and 16 for those of its status: one user must
/// not take them all. Ours.
pub(crate) const PLACES: usize = 6;
/// Commands of all users at a time: more than a bus has places for.
const PLACES_OF_ALL: usize = 48;
/// What is let in beyond either, to stop the robot.
const STOPS: usize = 8;
/// How often those that have gone are counted out while nobody knocks, s.
const SWEEP: Timespec = Timespec {
    tv_sec: 1,
    tv_nsec: 0,
};
/// Pause after a failure that is the machine's (no descriptors, no memory), which would be back at once.
const PAUSE: Duration = Duration::from_millis(50);

struct Visit {
    uid: u32,
    process: Child,
}

/// How a visitor is taken in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Room {
    Place,
    Stops,
    None,
}

impl Room {
    fn of(own: usize, all: usize) -> Self {
        if own < PLACES && all < PLACES_OF_ALL {
            Self::Place
        } else if own < PLACES + STOPS {
            Self::Stops
        } else {
            Self::None
        }
    }
}

/// Takes visitors in for as long as the process lives.
pub(crate) fn keep(config: &[PathBuf]) -> anyhow::Result<()> {
    let door = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .context("could not use standard input")?;
    ensure!(
        socket_acceptconn(&door).unwrap_or(false)
            && socket_type(&door).is_ok_and(|kind| kind == SocketType::SEQPACKET),
        "could not take visitors in because standard input is no listening socket of packets; start this by `atas-gate.socket`"
    );
    let program = std::env::current_exe().context("could not find this program")?;
    tracing::info!("takes visitors in");
    let mut visits: Vec<Visit> = Vec::new();
    loop {
        let timeout = (!visits.is_empty()).then_some(&SWEEP);
        let mut knock = [PollFd::new(&door, PollFlags::IN)];
        let knocks = match poll(&mut knock, timeout) {
            Err(rustix::io::Errno::INTR) => 0,
            waited => waited.context("could not wait for visitors")?,
        };
        // After the wait: whoever has gone meanwhile leaves a place for who knocks now.
        visits.retain_mut(|visit| matches!(visit.process.try_wait(), Ok(None)));
        if knocks == 0 {
            continue;
        }
        if let Err(error) = take_in(door.as_fd(), &program, config, &mut visits) {
            tracing::warn!("could not take a visitor in because of: {error:#}");
            std::thread::sleep(PAUSE);
        }
    }
}

fn take_in(
    door: BorrowedFd<'_>,
    program: &Path,
    config: &[PathBuf],
    visits: &mut Vec<Visit>,
) -> anyhow::Result<()> {
    let visitor = accept_with(door, SocketFlags::CLOEXEC).context("accepting")?;
    let uid = socket_peercred(&visitor)
        .context("asking who it is")?
        .uid
        .as_raw();
    let own = visits.iter().filter(|visit| visit.uid == uid).count();
    let room = Room::of(own, visits.len());
    if room == Room::None {
        tracing::warn!("uid {uid} was sent away: it has {own} visits at a time");
        // Whoever does not wait for it needs no answer.
        let _ = message::reply(&visitor, &Reply::Busy(PLACES));
        return Ok(());
    }
    let process = visit(program, config, visitor, room).context("starting its process")?;
    visits.push(Visit { uid, process });
    Ok(())
}

fn visit(program: &Path, config: &[PathBuf], visitor: OwnedFd, room: Room) -> io::Result<Child> {
    let mut command = Command::new(program);
    command.arg("--visit");
    if room == Room::Stops {
        command.arg("--full");
    }
    for file in config {
        command.arg("--config").arg(file);
    }
    command
        .stdin(Stdio::from(File::from(visitor)))
        .stdout(Stdio::null())
        .spawn()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_its_places_a_user_may_only_stop() {
        let check = |own, all, room| assert_eq!(Room::of(own, all), room, "{own} of {all}");
        check(0, 0, Room::Place);
        check(PLACES - 1, PLACES - 1, Room::Place);
        check(PLACES, PLACES, Room::Stops);
        check(0, PLACES_OF_ALL, Room::Stops);
        check(0, 10 * PLACES_OF_ALL, Room::Stops);
        check(PLACES + STOPS - 1, PLACES_OF_ALL, Room::Stops);
        check(PLACES + STOPS, PLACES + STOPS, Room::None);
    }
}
