//! Start, end and rejected start of the daemon.

use std::os::unix::process::ExitStatusExt;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use shm_bus::{End, FreshBus};
use shm_schemas::{Cause, ControlOp, ControlOutcome, Mode, StatusFlags, TickReport, service};

use crate::support::{Daemon, TOLERANT, World, wait_for};

fn check_rejected(config: &str, flags: &[&str], code: i32, message: &str) {
    let bus = FreshBus::new("refused");
    let mut daemon = Daemon::start_with(&bus, config, flags, |_| ());
    assert_eq!(daemon.wait().code(), Some(code));
    assert!(daemon.log().contains(message), "{}", daemon.log());
}

#[test]
fn invalid_configuration_is_rejected_with_location() {
    check_rejected(
        "\ngrasp.dr_n = 99\n",
        &[],
        7,
        "atas.toml:2: grasp.dr_n is 99, needs a number from 0.005 to 10",
    );
    check_rejected(
        "",
        &["--set", "grasp.dr=1"],
        7,
        "--set: grasp.dr is not a key; did you mean grasp.dr_n?",
    );
    check_rejected("", &["--set", "robot.model=/nowhere"], 7, "/nowhere");
    check_rejected("", &["--nonsense"], 2, "--nonsense");
}

#[test]
fn second_daemon_is_rejected_naming_the_first() {
    let bus = FreshBus::new("second");
    let mut world = World::open(&bus);
    let first = Daemon::start(&bus, &[]);
    world.until("the first daemon", |status| status.pid == first.pid());
    let mut second = Daemon::start(&bus, &[]);
    assert_eq!(second.wait().code(), Some(8));
    assert!(
        second.log().contains(&format!("process {}", first.pid())),
        "{}",
        second.log()
    );
    world.receive();
    assert_eq!(world.newest.pid, first.pid());
}

#[test]
fn signal_stops_daemon_and_next_can_start() {
    for signal in [Signal::TERM, Signal::INT] {
        let bus = FreshBus::new("signal");
        let mut world = World::open(&bus);
        for _ in 0..2 {
            let mut daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
            world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
            daemon.signal(signal);
            let ended = daemon.wait();
            assert!(ended.success(), "{ended}");
            world.receive();
            assert_eq!(
                world.command.mode,
                Mode::SAFE_STOP,
                "the last command is a stop"
            );
        }
    }
}

/// A fatal signal ends the daemon as usual; log, next start and clients name it.
#[test]
fn each_end_leaves_its_cause() {
    let bus = FreshBus::new("ends");
    let mut world = World::open(&bus);
    let ready = |world: &mut World, daemon: &Daemon| {
        world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
    };
    let ends = [
        (Signal::ABORT, "ended by SIGABRT"),
        (Signal::BUS, "ended by SIGBUS"),
        (Signal::FPE, "ended by SIGFPE"),
        (Signal::ILL, "ended by SIGILL"),
        (Signal::SEGV, "ended by SIGSEGV"),
        (Signal::SYS, "ended by SIGSYS"),
        (Signal::XCPU, "ended by SIGXCPU"),
        (Signal::XFSZ, "ended by SIGXFSZ"),
        (Signal::QUIT, "ended by SIGQUIT"),
        (Signal::KILL, "ended without a recorded cause"),
    ];
    // A test in the background of a shell ignores SIGQUIT, and so would the daemon.
    let usual_signals = ["env", "--default-signal"];
    for (signal, words) in ends {
        let mut daemon = Daemon::start_under(&usual_signals, &bus, TOLERANT, &[], |_| ());
        ready(&mut world, &daemon);
        daemon.signal(signal);
        assert_eq!(daemon.wait().signal(), Some(signal.as_raw()), "{words}");
        let is_logged = daemon.log().contains(words);
        assert_eq!(is_logged, signal != Signal::KILL, "{}", daemon.log());
        let expected = format!("atasd (process {}) {words}", daemon.pid());
        let check = |end: Option<End>| {
            let end = end.map_or(String::new(), |end| end.to_string());
            assert!(end.contains(&expected), "{end:?}, not {expected:?}");
        };
        check(End::last(&bus));
        let mut next = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
        ready(&mut world, &next);
        // A thread of its own writes the log.
        wait_for("the end in the log of the next daemon", || {
            next.log().contains(&expected).then_some(())
        });
        check(End::before(&bus, next.pid()));
        assert_eq!(End::last(&bus), None, "the next one runs");
        next.signal(Signal::TERM);
        assert!(next.wait().success());
        assert_eq!(End::last(&bus), None, "the next one ended orderly");
    }
}

#[test]
fn daemon_opens_files_up_to_the_hard_limit() {
    let bus = FreshBus::new("files");
    let mut world = World::open(&bus);
    let limited = ["prlimit", "--nofile=32:4096"];
    let daemon = Daemon::start_under(&limited, &bus, TOLERANT, &[], |_| ());
    world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
    let reply = world.control(ControlOp::ESTOP, "", 0.0);
    assert_eq!(reply.outcome, ControlOutcome::DONE);
}

#[test]
fn daemon_starts_after_a_killed_one() {
    let bus = FreshBus::new("killed");
    let mut world = World::open(&bus);
    for _ in 0..3 {
        let mut daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
        world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
        daemon.signal(Signal::KILL);
        assert!(!daemon.wait().success());
    }
}

#[test]
fn printed_configuration_reads_back() {
    let print = |flags: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_atasd"));
        let output = command
            .arg("--check-config")
            .args(flags)
            .output()
            .expect("atasd starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        String::from_utf8(output.stdout).expect("text")
    };
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let file = folder.path().join("printed.toml").display().to_string();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/atas.example.toml");
    let printed = print(&["--config", example, "--set", "grasp.dr_n=0.08"]);
    assert!(printed.contains("\ndr_n = 0.08\n"), "{printed}");
    std::fs::write(&file, &printed).expect("writable");
    assert_eq!(print(&["--config", &file]), printed);
}

#[test]
fn daemon_without_sensors_reports_missing_frames() {
    let bus = FreshBus::new("nosense");
    let mut world = World::open(&bus);
    let _daemon = Daemon::start(&bus, &[]);
    let status = wait_for("a status", || {
        world.receive();
        (world.newest.ticks > 50).then_some(world.newest)
    });
    assert_eq!(
        (status.mode, status.reason.cause),
        (Mode::INIT, Cause::FRAMES_STOPPED)
    );
    assert_eq!(world.command.joint_count, 0, "no joint is commanded");
    assert!(world.command.is_intact());
}

#[test]
fn robot_holds_while_frames_are_missing() {
    let bus = FreshBus::new("frames");
    let mut world = World::open(&bus);
    let _daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    let status = world.until_mode(Mode::READY);
    assert_ne!(status.config_hash, 0);
    assert_eq!((status.rate_hz, status.hands[0].lost), (1000, 0));
    world.sends_frames = false;
    let status = world.until_mode(Mode::HOLD);
    assert_eq!(status.reason.cause, Cause::FRAMES_STOPPED);
    world.sends_frames = true;
    world.until_mode(Mode::READY);
}

#[test]
fn first_tick_after_a_stall_holds() {
    let bus = FreshBus::new("stall");
    let mut world = World::open(&bus);
    let daemon = Daemon::start_with(&bus, TOLERANT, &["--set", "safety.stall_s=0.2"], |_| ());
    world.until_mode(Mode::READY);
    let mut reports = world
        .bus
        .subscriber::<TickReport>(service::TICK_REPORT)
        .expect("there is room");
    let mut before = TickReport::default();
    wait_for("a report", || {
        reports.newest(&mut before).expect("readable").then_some(())
    });
    daemon.signal(Signal::STOP);
    let stopped = Instant::now();
    while stopped.elapsed() < Duration::from_millis(400) {
        world.publish(shm_bus::now_ns());
        std::thread::sleep(Duration::from_millis(1));
    }
    daemon.signal(Signal::CONT);
    let first_back = wait_for("the first tick back", || {
        world.publish(shm_bus::now_ns());
        let mut first_back = None;
        let mut see = |report: &TickReport| {
            let still_ns = report.stamp.captured_ns - before.stamp.captured_ns;
            if still_ns > 200_000_000 && first_back.is_none() {
                first_back = Some(*report);
            }
            before = *report;
        };
        reports.drain(256, &mut see).expect("readable");
        first_back
    });
    assert_eq!(first_back.mode, Mode::HOLD);
    wait_for("a line in the log", || {
        let log = daemon.log();
        log.contains("the loop stood still for").then_some(())
    });
    world.until_mode(Mode::READY);
}

#[test]
fn nan_joint_feedback_stops_until_recovery() {
    let bus = FreshBus::new("nan");
    let mut world = World::open(&bus);
    let _daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    world.until_mode(Mode::READY);
    let reply = world.control(ControlOp::RECOVER, "", 0.0);
    assert_eq!(reply.outcome, ControlOutcome::REFUSED);
    world.until_mode(Mode::READY);
    world.injected_position = Some(f64::NAN);
    let status = world.until_mode(Mode::SAFE_STOP);
    assert_eq!(status.reason.cause, Cause::JOINTS_INVALID);
    world.injected_position = None;
    (0..50).for_each(|_| world.publish(shm_bus::now_ns()));
    world.receive();
    assert_eq!(world.newest.mode, Mode::SAFE_STOP, "latched");
    assert_eq!(
        world.control(ControlOp::RECOVER, "", 0.0).outcome,
        ControlOutcome::DONE
    );
    world.until_mode(Mode::READY);
    assert_eq!(
        world.control(ControlOp::ESTOP, "", 0.0).outcome,
        ControlOutcome::DONE
    );
    assert_eq!(world.until_mode(Mode::SAFE_STOP).reason.cause, Cause::ESTOP);
}

#[test]
fn missing_real_time_is_reported() {
    let bus = FreshBus::new("rt");
    let mut world = World::open(&bus);
    let daemon = Daemon::start_with(&bus, "realtime.mode = \"try\"", &[], |_| ());
    let status = world.until("a status", |s| s.pid == daemon.pid() && s.ticks > 0);
    let has = |flag| status.flags & flag != 0;
    let granted = has(StatusFlags::REALTIME) && has(StatusFlags::MEMORY_LOCKED);
    assert_eq!(has(StatusFlags::DEGRADED), !granted);
    drop(daemon);
    // No machine has this core.
    check_rejected(
        "realtime.mode = \"require\"\nrealtime.cpu = 1023",
        &[],
        10,
        "could not",
    );
    let daemon = Daemon::start_with(&bus, "realtime.cpu = 1023", &[], |_| ());
    world.until("degraded", |s| {
        s.pid == daemon.pid() && s.flags & StatusFlags::DEGRADED != 0
    });
    assert!(
        daemon
            .log()
            .contains("could not pin the tick thread to core 1023"),
        "{}",
        daemon.log()
    );
}

#[test]
fn ticks_before_a_fault_are_saved() {
    let bus = FreshBus::new("flight");
    let mut world = World::open(&bus);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let daemon = Daemon::start_with(&bus, TOLERANT, &[], |command| {
        command.env("STATE_DIRECTORY", folder.path());
    });
    world.until_mode(Mode::READY);
    world.control(ControlOp::ESTOP, "", 0.0);
    world.until_mode(Mode::SAFE_STOP);
    let text = wait_for("a file", || {
        let mut files = std::fs::read_dir(folder.path().join("flight")).ok()?;
        let file =
            files.find_map(|file| Some(file.ok()?.path()).filter(|p| p.extension().is_some()))?;
        std::fs::read_to_string(file).ok()
    });
    assert!(text.starts_with("# atasd "), "{text}");
    assert!(text.contains("stopped by `atas estop`"), "{text}");
    assert!(text.lines().count() > 2, "{text}");
    // A folder that cannot be written is logged, and has no other effect.
    drop(daemon);
    let nowhere = ["--set", "recording.flight_folder=/proc/nowhere"];
    let daemon = Daemon::start_with(&bus, TOLERANT, &nowhere, |_| ());
    world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
    world.control(ControlOp::ESTOP, "", 0.0);
    world.until_mode(Mode::SAFE_STOP);
    wait_for("a line in the log", || {
        let log = daemon.log();
        log.contains("could not write the last ticks").then_some(())
    });
    assert_eq!(
        world.control(ControlOp::RECOVER, "", 0.0).outcome,
        ControlOutcome::DONE
    );
}
