//! A pseudo-terminal with a program in it, and the contents of its screen.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};

use rustix::process::Pid;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

use crate::{binary, wait_for};

/// A terminal with a running program.
pub struct Terminal {
    program: Child,
    master: File,
    screen: Arc<Mutex<vt100::Parser>>,
    /// All bytes that the program wrote.
    raw: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    /// Starts `atas` with these arguments, with or without colours.
    ///
    /// # Panics
    /// If it does not start.
    #[must_use]
    pub fn start(arguments: &[&str], no_color: bool) -> Self {
        let mut command = Command::new(binary("atas"));
        command
            .args(arguments)
            .env("TERM", "xterm-256color")
            .env_remove("NO_COLOR");
        if no_color {
            command.env("NO_COLOR", "1");
        }
        Self::from_command(command)
    }

    /// Starts a program in a terminal of 80 × 24.
    pub fn from_command(command: Command) -> Self {
        let (program, master) = in_terminal(command);
        let terminal = Self {
            program,
            master,
            screen: Arc::new(Mutex::new(vt100::Parser::new(24, 80, 0))),
            raw: Arc::default(),
        };
        terminal.start_reader();
        terminal
    }

    fn start_reader(&self) {
        let mut master = self.master.try_clone().expect("another handle");
        let (screen, raw) = (Arc::clone(&self.screen), Arc::clone(&self.raw));
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            // A read error means that the program has ended.
            while let Ok(count) = master.read(&mut bytes) {
                raw.lock()
                    .expect("whole")
                    .extend_from_slice(&bytes[..count]);
                screen.lock().expect("whole").process(&bytes[..count]);
            }
        });
    }

    /// Sets the size of the terminal.
    ///
    /// # Panics
    /// If the terminal is closed.
    pub fn resize(&self, rows: u16, columns: u16) {
        self.screen
            .lock()
            .expect("whole")
            .screen_mut()
            .set_size(rows, columns);
        tcsetwinsize(&self.master, size(rows, columns)).expect("sized");
    }

    /// Returns the text on the screen.
    ///
    /// # Panics
    /// If the reader thread panicked.
    #[must_use]
    pub fn text(&self) -> String {
        self.screen.lock().expect("whole").screen().contents()
    }

    /// Waits until this text is on the screen.
    ///
    /// # Panics
    /// On timeout.
    pub fn wait_for(&self, part: &str) {
        wait_for(&format!("{part:?} on the screen"), || {
            self.text().contains(part).then_some(())
        });
    }

    /// Returns whether the program ever wrote these bytes.
    ///
    /// # Panics
    /// If the reader thread panicked.
    #[must_use]
    pub fn has_written(&self, bytes: &str) -> bool {
        let raw = self.raw.lock().expect("whole");
        raw.windows(bytes.len())
            .any(|window| window == bytes.as_bytes())
    }

    /// Types q and waits until the program has restored the terminal and ended.
    pub fn quit(mut self) {
        self.master.write_all(b"q").expect("typed");
        let code = wait_for("the end of the program", || {
            self.program.try_wait().expect("waitable")
        });
        assert_eq!(code.code(), Some(0));
        wait_for("the restored terminal", || {
            self.has_written("\x1b[?1049l").then_some(())
        });
    }
}

impl Terminal {
    /// Returns the local modes of the terminal.
    pub fn modes(&self) -> LocalModes {
        tcgetattr(&self.master).expect("a terminal").local_modes
    }

    /// Returns the process id of the program.
    pub fn pid(&self) -> Pid {
        Pid::from_child(&self.program)
    }

    /// Waits for the program to end and returns its exit code.
    pub fn exit_code(&mut self) -> Option<i32> {
        let ended = wait_for("the end of the program", || {
            self.program.try_wait().expect("waitable")
        });
        ended.code()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // Both calls fail harmlessly if the program has already ended.
        let _ended = self.program.kill();
        let _status = self.program.wait();
    }
}

/// Starts a program in a terminal of 80 × 24; returns it and the master end.
///
/// # Panics
/// If no terminal is available or the program does not start.
#[must_use]
pub fn in_terminal(mut command: Command) -> (Child, File) {
    let master =
        openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a terminal");
    grantpt(&master).expect("granted");
    unlockpt(&master).expect("unlocked");
    tcsetwinsize(&master, size(24, 80)).expect("sized");
    let name = ptsname(&master, Vec::new()).expect("a name");
    let path = name.to_str().expect("UTF-8");
    let slave = File::options()
        .read(true)
        .write(true)
        .open(path)
        .expect("opened");
    let again = || Stdio::from(slave.try_clone().expect("another handle"));
    let program = command
        .stdin(again())
        .stdout(again())
        .stderr(again())
        .spawn();
    (program.expect("started"), File::from(master))
}

fn size(rows: u16, columns: u16) -> Winsize {
    Winsize {
        ws_row: rows,
        ws_col: columns,
        ws_xpixel: 0,
        ws_ypixel: 0,
    }
}
