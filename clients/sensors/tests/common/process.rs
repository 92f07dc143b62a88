//! Test harness: the program on a pseudo-terminal and a new bus.
#![allow(dead_code, reason = "each test program uses its own part")]

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Timeout of waits; a test fails instead of hanging.
const PATIENCE: Duration = Duration::from_secs(30);

/// Pseudo-terminal that emulates the device.
pub(crate) struct Pty {
    master: File,
    pub(crate) path: PathBuf,
    /// Held open to keep the raw mode and all bytes until the program opens it.
    _slave: OwnedFd,
}

impl Pty {
    pub(crate) fn new() -> Self {
        // Not inherited, so that dropping the master ends the stream for the program.
        let master =
            openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let path = PathBuf::from(ptsname(&master, Vec::new()).unwrap().into_string().unwrap());
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let slave = rustix::fs::open(&path, flags, rustix::fs::Mode::empty()).unwrap();
        let mut settings = tcgetattr(&slave).unwrap();
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings).unwrap();
        Self {
            master: File::from(master),
            path,
            _slave: slave,
        }
    }

    pub(crate) fn send(&self, bytes: &[u8]) {
        (&self.master).write_all(bytes).unwrap();
    }

    /// Returns the next nine bytes from the program.
    pub(crate) fn receive_command(&self) -> [u8; 9] {
        self.receive()
    }

    /// Returns the next bytes from the program.
    pub(crate) fn receive<const N: usize>(&self) -> [u8; N] {
        let mut bytes = [0; N];
        let mut filled = 0;
        while filled < N {
            let patience = Timespec {
                tv_sec: PATIENCE.as_secs().cast_signed(),
                tv_nsec: 0,
            };
            let ready = poll(
                &mut [PollFd::new(&self.master, PollFlags::IN)],
                Some(&patience),
            );
            assert_eq!(ready, Ok(1), "the program sent only {filled} of {N} bytes");
            filled += (&self.master).read(&mut bytes[filled..]).unwrap();
        }
        bytes
    }
}

/// Running program; killed on drop.
pub(crate) struct Sensor(Option<Child>);

impl Sensor {
    /// Starts `atas-sensor optoforce --device DEVICE` with further arguments, split at spaces.
    pub(crate) fn start(device: &Path, arguments: &str) -> Self {
        let device = device.display();
        Self::start_line(&format!("optoforce --device {device} {arguments}"))
    }

    /// Starts `atas-sensor` with these arguments, split at spaces.
    pub(crate) fn start_line(arguments: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_atas-sensor"));
        command.args(arguments.split_whitespace());
        command.env("RUST_LOG", "info").env_remove("ATAS_BUS");
        Self(Some(
            command
                .stdin(Stdio::null())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap(),
        ))
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(self.0.as_ref().unwrap()), signal).unwrap();
    }

    /// Waits for the end: exit code, standard output, standard error.
    pub(crate) fn finish(mut self) -> (Option<i32>, String, String) {
        let mut child = self.0.take().unwrap();
        let deadline = Instant::now() + PATIENCE;
        let running = |child: &mut Child| child.try_wait().unwrap().is_none();
        // Small outputs only: a full pipe would block the program.
        while running(&mut child) {
            if Instant::now() > deadline {
                child.kill().unwrap();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let Output {
            status,
            stdout,
            stderr,
        } = child.wait_with_output().unwrap();
        (
            status.code(),
            String::from_utf8(stdout).unwrap(),
            String::from_utf8(stderr).unwrap(),
        )
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Waits until a condition holds.
pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < deadline, "{what} never came");
        std::thread::sleep(Duration::from_millis(1));
    }
}
