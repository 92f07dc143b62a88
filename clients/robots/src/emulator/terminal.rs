//! A pseudo-terminal that emulates a serial port.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};

/// The pseudo-terminal.
#[derive(Debug)]
pub(super) struct Terminal {
    master: File,
    path: PathBuf,
    /// Kept open to preserve the raw mode and early data.
    slave: OwnedFd,
}

impl Terminal {
    pub(super) fn open() -> io::Result<Self> {
        // Not inherited: dropping the master must close the line for the host.
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(&path, flags, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        Ok(Self {
            master: File::from(master),
            path,
            slave,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Appends the bytes received before the timeout.
    pub(super) fn receive(&self, bytes: &mut Vec<u8>, within: Duration) -> io::Result<()> {
        let within = Timespec {
            tv_sec: within.as_secs().cast_signed(),
            tv_nsec: within.subsec_nanos().into(),
        };
        if poll(
            &mut [PollFd::new(&self.master, PollFlags::IN)],
            Some(&within),
        )? == 0
        {
            // A killed host leaves the terminal in exclusive mode; a real port resets it on close.
            ioctl_tiocnxcl(&self.slave)?;
            return Ok(());
        }
        let mut chunk = [0; 4096];
        let length = (&self.master).read(&mut chunk)?;
        bytes.extend(&chunk[..length]);
        Ok(())
    }

    pub(super) fn send(&self, bytes: &[u8]) -> io::Result<()> {
        (&self.master).write_all(bytes)
    }
}
