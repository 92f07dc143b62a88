//! Tests of `atas top` in a real terminal and of `atas topic`.

use std::io::Read as _;
use std::process::Command;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::{FreshBus, STREAMS};
use system_tests::terminal::{Terminal, in_terminal};
use system_tests::{Process, binary, lock_exclusive, wait_for};

/// Runs `atas`; returns the exit code and each line of standard output as JSON.
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
fn top_shows_running_robot() {
    let _alone = lock_exclusive();
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
    // Texts that remain on the screen: in lock-step the steps pass faster than the screen is drawn.
    // A lane remains for 20 s, enough for a busy machine from first touch to hold.
    for part in [
        "RUN",
        "1, first touch",
        "goal grasp running, step hold",
        "step lift",
    ] {
        terminal.wait_for(part);
    }
    // In lock-step, time advances only while a goal is active.
    check_topics(name);
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

/// Regression test: `atas top` read from its closed terminal in an endless loop.
#[test]
fn top_ends_with_its_terminal() {
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

/// Checks `atas topic` while `top` runs.
fn check_topics(bus: &str) {
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
    // No process opened this service, and listing does not create it.
    assert_eq!(of("agent-sensors")["writers"], 0);
    let (code, rate) = atas(&["topic", "hz", "view", "--seconds", "1", "--bus", bus]);
    assert_eq!(code, Some(0));
    assert!(rate[0]["payloads"].as_u64() > Some(5), "{rate:?}");
    let (code, views) = atas(&["topic", "echo", "view", "--count", "2", "--bus", bus]);
    assert_eq!((code, views.len()), (Some(0), 2));
    let joints = views[1]["joints"]["position"].as_array().map(Vec::len);
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
        "a pipe is not a terminal"
    );
}
