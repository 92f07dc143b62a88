//! Server socket: accepts connections, starts a process for each and counts them by user.
//!
//! It reads no data of the client. The program is looked up again for each connection, so that
//! after an upgrade the gate and the command it runs have the same version.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context, ensure};
use atas_gate::message::{self, Reply};
use nix::sys::socket::{getsockopt, sockopt::PeerCredentials};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::sockopt::{socket_acceptconn, socket_type};
use rustix::net::{SocketFlags, SocketType, accept_with};

/// Connections per user. A bus has 8 reader slots for events and 16 for the status; one user must
/// not take them all. Design choice.
pub(crate) const CONNECTIONS_PER_USER: usize = 6;
/// Connections of all users: more than a bus has reader slots.
const CONNECTIONS: usize = 48;
/// Additional connections, only for stopping the robot.
const STOPS: usize = 8;
/// Interval at which ended connections are removed while no client connects, s.
const SWEEP: Timespec = Timespec {
    tv_sec: 1,
    tv_nsec: 0,
};
/// Pause after a failure of the machine (no descriptors, no memory), which would repeat at once.
const PAUSE: Duration = Duration::from_millis(50);

struct Visit {
    uid: u32,
    process: Child,
}

/// Kind of admission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Admission {
    Place,
    Stops,
    None,
}

impl Admission {
    fn of(own: usize, all: usize) -> Self {
        if own < CONNECTIONS_PER_USER && all < CONNECTIONS {
            Self::Place
        } else if own < CONNECTIONS_PER_USER + STOPS {
            Self::Stops
        } else {
            Self::None
        }
    }
}

/// Accepts connections for the lifetime of the process.
pub(crate) fn serve(config: &[PathBuf]) -> anyhow::Result<()> {
    let door = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .context("could not use standard input")?;
    ensure!(
        socket_acceptconn(&door).unwrap_or(false)
            && socket_type(&door).is_ok_and(|kind| kind == SocketType::SEQPACKET),
        "could not accept connections because standard input is no listening packet socket; start \
         this program by `atas-gate.socket`"
    );
    let program = std::env::current_exe().context("could not find this program")?;
    tracing::info!("accepts connections");
    let mut visits: Vec<Visit> = Vec::new();
    loop {
        let timeout = (!visits.is_empty()).then_some(&SWEEP);
        let mut knock = [PollFd::new(&door, PollFlags::IN)];
        let knocks = match poll(&mut knock, timeout) {
            Err(rustix::io::Errno::INTR) => 0,
            waited => waited.context("could not wait for connections")?,
        };
        // After the wait, so that connections that ended meanwhile leave a slot.
        visits.retain_mut(|visit| matches!(visit.process.try_wait(), Ok(None)));
        if knocks == 0 {
            continue;
        }
        if let Err(error) = accept(door.as_fd(), &program, config, &mut visits) {
            tracing::warn!("could not accept a connection because of: {error:#}");
            std::thread::sleep(PAUSE);
        }
    }
}

fn accept(
    door: BorrowedFd<'_>,
    program: &Path,
    config: &[PathBuf],
    visits: &mut Vec<Visit>,
) -> anyhow::Result<()> {
    let visitor = accept_with(door, SocketFlags::CLOEXEC).context("accepting")?;
    let uid = getsockopt(&visitor, PeerCredentials)
        .context("reading its user")?
        .uid();
    let own = visits.iter().filter(|visit| visit.uid == uid).count();
    let room = Admission::of(own, visits.len());
    if room == Admission::None {
        tracing::warn!("uid {uid} was rejected: it has {own} connections already");
        // The client may be gone.
        let _ = message::reply(&visitor, &Reply::Busy(CONNECTIONS_PER_USER));
        return Ok(());
    }
    let process =
        start_connection(program, config, visitor, room).context("starting its process")?;
    visits.push(Visit { uid, process });
    Ok(())
}

fn start_connection(
    program: &Path,
    config: &[PathBuf],
    visitor: OwnedFd,
    room: Admission,
) -> io::Result<Child> {
    let mut command = Command::new(program);
    command.arg("--visit");
    if room == Admission::Stops {
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
    fn user_beyond_its_limit_may_only_stop() {
        let check = |own, all, room| assert_eq!(Admission::of(own, all), room, "{own} of {all}");
        check(0, 0, Admission::Place);
        check(
            CONNECTIONS_PER_USER - 1,
            CONNECTIONS_PER_USER - 1,
            Admission::Place,
        );
        check(CONNECTIONS_PER_USER, CONNECTIONS_PER_USER, Admission::Stops);
        check(0, CONNECTIONS, Admission::Stops);
        check(0, 10 * CONNECTIONS, Admission::Stops);
        check(
            CONNECTIONS_PER_USER + STOPS - 1,
            CONNECTIONS,
            Admission::Stops,
        );
        check(
            CONNECTIONS_PER_USER + STOPS,
            CONNECTIONS_PER_USER + STOPS,
            Admission::None,
        );
    }
}
