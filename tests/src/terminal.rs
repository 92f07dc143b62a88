//! A real terminal (a pty) with a program in it, and what stands on its screen.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};

use rustix::process::Pid;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};

use crate::{binary, wait_for};

/// A terminal with a program in it.
pub struct Terminal {
    program: Child,
    master: File,
    screen: Arc<Mutex<vt100::Parser>>,
    /// Everything that was written, as it was.
    raw: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    /// Starts `atas` with these arguments, with colours or without.
    ///
    /// # Panics
    /// If it cannot be started.
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
        Self::with(command)
    }

    /// A terminal of 80 × 24 with this program in it.
    pub fn with(command: Command) -> Self {
        let (program, master) = in_terminal(command);
        let terminal = Self {
            program,
            master,
            screen: Arc::new(Mutex::new(vt100::Parser::new(24, 80, 0))),
            raw: Arc::default(),
        };
        terminal.listen();
        terminal
    }

    fn listen(&self) {
        let mut master = self.master.try_clone().expect("another handle");
        let (screen, raw) = (Arc::clone(&self.screen), Arc::clone(&self.raw));
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            // An error is the program's end.
            while let Ok(count) = master.read(&mut bytes) {
                raw.lock()
                    .expect("whole")
                    .extend_from_slice(&bytes[..count]);
                screen.lock().expect("whole").process(&bytes[..count]);
            }
        });
    }

    /// Makes the terminal as large.
    ///
    /// # Panics
    /// If it is gone.
    pub fn resize(&self, rows: u16, columns: u16) {
        self.screen
            .lock()
            .expect("whole")
            .screen_mut()
            .set_size(rows, columns);
        tcsetwinsize(&self.master, size(rows, columns)).expect("sized");
    }

    /// What stands on the screen.
    ///
    /// # Panics
    /// If its reader panicked.
    #[must_use]
    pub fn text(&self) -> String {
        self.screen.lock().expect("whole").screen().contents()
    }

    /// Waits until this stands on the screen.
    ///
    /// # Panics
    /// If it does not for too long.
    pub fn wait_for(&self, part: &str) {
        wait_for(&format!("{part:?} on the screen"), || {
            self.text().contains(part).then_some(())
        });
    }

    /// Whether these bytes were ever written.
    ///
    /// # Panics
    /// If its reader panicked.
    #[must_use]
    pub fn has_written(&self, bytes: &str) -> bool {
        let raw = self.raw.lock().expect("whole");
        raw.windows(bytes.len())
            .any(|window| window == bytes.as_bytes())
    }

    /// Types q; the terminal is given back.
    pub fn quit(mut self) {
        self.master.write_all(b"q").expect("typed");
        let code = wait_for("the end of the program", || {
            self.program.try_wait().expect("waitable")
        });
        assert_eq!(code.code(), Some(0));
        wait_for("the terminal as it was", || {
            self.has_written("\x1b[?1049l").then_some(())
        });
    }
}

impl Terminal {
    /// How the terminal takes what is typed.
    pub fn modes(&self) -> LocalModes {
        tcgetattr(&self.master).expect("a terminal").local_modes
    }

    /// The program's process.
    pub fn pid(&self) -> Pid {
        Pid::from_child(&self.program)
    }

    /// The program's exit code, when it has ended by itself.
    pub fn code(&mut self) -> Option<i32> {
        let ended = wait_for("the end of the program", || {
            self.program.try_wait().expect("waitable")
        });
        ended.code()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // It may have ended already; both calls then have nothing to do.
        let _ended = self.program.kill();
        let _status = self.program.wait();
    }
}

/// A program in a terminal of 80 × 24, and the terminal's other end.
///
/// # Panics
/// If there is none to be had, or the program cannot be started.
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
