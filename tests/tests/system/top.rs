//! `atas top` in a real terminal, and `atas topic` beside it.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};

use rustix::process::{Pid, Signal};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};
use serde_json::Value;
use shm_bus::{FreshBus, STREAMS};
use system_tests::{Process, alone, binary, wait_for};

/// A terminal with a program in it.
pub(crate) struct Terminal {
    program: Child,
    master: File,
    screen: Arc<Mutex<vt100::Parser>>,
    /// Everything that was written, as it was.
    raw: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    fn start(arguments: &[&str], no_color: bool) -> Self {
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
    pub(crate) fn with(command: Command) -> Self {
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

    pub(crate) fn resize(&self, rows: u16, columns: u16) {
        self.screen
            .lock()
            .expect("whole")
            .screen_mut()
            .set_size(rows, columns);
        tcsetwinsize(&self.master, size(rows, columns)).expect("sized");
    }

    fn text(&self) -> String {
        self.screen.lock().expect("whole").screen().contents()
    }

    pub(crate) fn wait_for(&self, part: &str) {
        wait_for(&format!("{part:?} on the screen"), || {
            self.text().contains(part).then_some(())
        });
    }

    pub(crate) fn has_written(&self, bytes: &str) -> bool {
        let raw = self.raw.lock().expect("whole");
        raw.windows(bytes.len())
            .any(|window| window == bytes.as_bytes())
    }

    /// Types q; the terminal is given back.
    pub(crate) fn quit(mut self) {
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
    pub(crate) fn modes(&self) -> LocalModes {
        tcgetattr(&self.master).expect("a terminal").local_modes
    }

    /// The program's process.
    pub(crate) fn pid(&self) -> Pid {
        Pid::from_child(&self.program)
    }

    /// The program's exit code, when it has ended by itself.
    pub(crate) fn code(&mut self) -> Option<i32> {
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
fn in_terminal(mut command: Command) -> (Child, File) {
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

/// Exit code, and each line of standard output as JSON.
fn atas(arguments: &[&str]) -> (Option<i32>, Vec<Value>) {
    let output = Command::new(binary("atas"))
        .args(arguments)
        .args(["--format", "json"])
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let lines = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"));
    (output.status.code(), lines.collect())
}

#[test]
fn a_running_robot_on_one_screen() {
    let _alone = alone();
    let bus = FreshBus::new("top");
    let name = bus.as_str();
    let _robot = Process::start(
        "atas-sim",
        &["run", "--lockstep", "--object", "wood", "--bus", name],
    );
    let mut daemon = Process::start(
        "atasd",
        &["--lockstep", "--config", "/dev/null", "--bus", name],
    );
    wait_for("the daemon", || {
        (atas(&["status", "--bus", name]).0 == Some(0)).then_some(())
    });
    let terminal = Terminal::start(&["top", "--bus", name], false);
    for part in [
        "READY",
        "left",
        "right",
        "F_1",
        "wake-up late",
        "joints",
        "no goal yet",
    ] {
        terminal.wait_for(part);
    }
    let goal = [
        "grasp",
        "--at",
        "0.32,-0.15,0.0345",
        "--width",
        "50",
        "--hold",
        "3600",
        "--bus",
        name,
    ];
    let _goal = Process::start("atas", &goal);
    // What stays on the screen: in lock-step the steps pass faster than it is drawn. A lane stays for 20 s, which a busy machine may
    // need from the first touch to the hold.
    for part in [
        "RUN",
        "1, first touch",
        "goal grasp running, step hold",
        "step lift",
    ] {
        terminal.wait_for(part);
    }
    // In lock-step time goes on only while there is a goal.
    topics(name);
    assert!(terminal.has_written("\x1b[38;5;"), "colours on a terminal");
    terminal.resize(12, 60);
    terminal.wait_for("needs 80 × 24 characters, has 60 × 12");
    terminal.resize(40, 120);
    terminal.wait_for("RUN");
    daemon.signal(Signal::TERM);
    daemon.wait();
    terminal.wait_for("no daemon reports");
    terminal.quit();
    let plain = Terminal::start(&["top", "--bus", name], true);
    plain.wait_for("no daemon reports");
    assert!(
        !plain.has_written("\x1b[38;5;"),
        "no colours under NO_COLOR"
    );
    plain.quit();
}

/// Regression: it read a terminal that was gone for ever, with a core of its own.
#[test]
fn it_ends_with_its_terminal() {
    let bus = FreshBus::new("topgone");
    let name = bus.as_str();
    let _robot = Process::start("atas-sim", &["run", "--lockstep", "--bus", name]);
    let _daemon = Process::start(
        "atasd",
        &["--lockstep", "--config", "/dev/null", "--bus", name],
    );
    wait_for("the daemon", || {
        (atas(&["status", "--bus", name]).0 == Some(0)).then_some(())
    });
    let mut command = Command::new(binary("atas"));
    command
        .args(["top", "--bus", name])
        .env("TERM", "xterm-256color");
    let (mut program, mut master) = in_terminal(command);
    let mut bytes = [0; 64];
    let _drawn = master.read(&mut bytes).expect("it draws");
    drop(master);
    wait_for("the end of the program", || {
        program.try_wait().expect("waitable")
    });
}

/// Beside the screen: the bus itself.
fn topics(bus: &str) {
    let (code, services) = atas(&["topic", "list", "--bus", bus]);
    assert_eq!((code, services.len()), (Some(0), STREAMS.len()));
    let of = |name: &str| {
        let is_it = |service: &&Value| {
            service["service"]
                .as_str()
                .is_some_and(|s| s.ends_with(name))
        };
        services.iter().find(is_it).expect(name).clone()
    };
    assert_eq!(
        (&of("/view")["writers"], &of("/view")["readable"]),
        (&1.into(), &true.into())
    );
    assert!(
        of("/view")["readers"].as_u64() >= Some(1),
        "the screen reads it"
    );
    assert_eq!(of("hand-frame/left")["readable"], false);
    // Nobody opened these, and looking made nothing.
    assert_eq!(of("agent-sensors")["writers"], 0);
    let (code, rate) = atas(&["topic", "hz", "view", "--seconds", "1", "--bus", bus]);
    assert_eq!(code, Some(0));
    assert!(rate[0]["payloads"].as_u64() > Some(5), "{rate:?}");
    let (code, views) = atas(&["topic", "echo", "view", "--count", "2", "--bus", bus]);
    assert_eq!((code, views.len()), (Some(0), 2));
    let joints = views[1]["joints"]["position_rad"].as_array().map(Vec::len);
    let elements = views[1]["frames"][1]["force_n"][0].as_array().map(Vec::len);
    assert_eq!((joints, elements), (Some(22), Some(41)));
    assert_eq!(
        atas(&["topic", "echo", "hand-frame/left", "--bus", bus]).0,
        Some(2)
    );
    assert_eq!(atas(&["topic", "hz", "nothing", "--bus", bus]).0, Some(2));
    assert_eq!(
        atas(&["top", "--bus", bus]).0,
        Some(2),
        "a pipe is no terminal"
    );
}
