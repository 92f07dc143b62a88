//! Start, end and rejected start of the daemon.

use std::time::{Duration, Instant};

use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{Cause, ControlOp, ControlOutcome, Mode, StatusFlags, TickReport, service};

use crate::support::{Daemon, PATIENT, World, wait_for};

fn check_refused(config: &str, flags: &[&str], code: i32, said: &str) {
    let bus = FreshBus::new("refused");
    let mut daemon = Daemon::start_with(&bus, config, flags, |_| ());
    assert_eq!(daemon.wait().code(), Some(code));
    assert!(daemon.log().contains(said), "{}", daemon.log());
}

#[test]
fn a_wrong_configuration_is_refused_with_its_place() {
    check_refused(
        "\ngrasp.dr_n = 99\n",
        &[],
        3,
        "atas.toml:2: grasp.dr_n is 99, needs a number from 0.005 to 10",
    );
    check_refused(
        "",
        &["--set", "grasp.dr=1"],
        3,
        "--set: grasp.dr is not a key; did you mean grasp.dr_n?",
    );
    check_refused("", &["--set", "robot.model=/nowhere"], 3, "/nowhere");
    check_refused("", &["--nonsense"], 2, "--nonsense");
}

#[test]
fn a_second_daemon_is_refused_and_names_the_first() {
    let bus = FreshBus::new("second");
    let mut world = World::on(&bus);
    let first = Daemon::start(&bus, &[]);
    world.until("the first daemon", |status| status.pid == first.pid());
    let mut second = Daemon::start(&bus, &[]);
    assert_eq!(second.wait().code(), Some(4));
    assert!(
        second.log().contains(&format!("process {}", first.pid())),
        "{}",
        second.log()
    );
    world.listen();
    assert_eq!(world.newest.pid, first.pid());
}

#[test]
fn a_signal_stops_it_in_order_and_the_next_one_may_start() {
    for signal in [Signal::TERM, Signal::INT] {
        let bus = FreshBus::new("signal");
        let mut world = World::on(&bus);
        for _ in 0..2 {
            let mut daemon = Daemon::start_with(&bus, PATIENT, &[], |_| ());
            world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
            daemon.signal(signal);
            let ended = daemon.wait();
            assert!(ended.success(), "{ended}");
            world.listen();
            assert_eq!(
                world.command.mode,
                Mode::SAFE_STOP,
                "the last command is a stop"
            );
        }
    }
}

#[test]
fn a_killed_daemon_leaves_nothing_that_hinders_the_next_one() {
    let bus = FreshBus::new("killed");
    let mut world = World::on(&bus);
    for _ in 0..3 {
        let mut daemon = Daemon::start_with(&bus, PATIENT, &[], |_| ());
        world.until("ready", |s| s.pid == daemon.pid() && s.mode == Mode::READY);
        daemon.signal(Signal::KILL);
        assert!(!daemon.wait().success());
    }
}

#[test]
fn the_effective_configuration_is_printed_and_reads_back() {
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
fn without_sensors_it_waits_and_says_for_what() {
    let bus = FreshBus::new("nosense");
    let mut world = World::on(&bus);
    let _daemon = Daemon::start(&bus, &[]);
    let status = wait_for("a status", || {
        world.listen();
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
fn frames_that_stop_are_held_for_and_come_back() {
    let bus = FreshBus::new("frames");
    let mut world = World::on(&bus);
    let _daemon = Daemon::start_with(&bus, PATIENT, &[], |_| ());
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
fn the_first_tick_after_a_stall_holds() {
    let bus = FreshBus::new("stall");
    let mut world = World::on(&bus);
    let daemon = Daemon::start_with(&bus, PATIENT, &["--set", "safety.stall_s=0.2"], |_| ());
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
fn joint_feedback_that_is_no_number_stops_it_until_recovered() {
    let bus = FreshBus::new("nan");
    let mut world = World::on(&bus);
    let _daemon = Daemon::start_with(&bus, PATIENT, &[], |_| ());
    world.until_mode(Mode::READY);
    let reply = world.control(ControlOp::RECOVER, "", 0.0);
    assert_eq!(reply.outcome, ControlOutcome::REFUSED);
    world.until_mode(Mode::READY);
    world.odd_position_rad = Some(f64::NAN);
    let status = world.until_mode(Mode::SAFE_STOP);
    assert_eq!(status.reason.cause, Cause::JOINTS_INVALID);
    world.odd_position_rad = None;
    (0..50).for_each(|_| world.publish(shm_bus::now_ns()));
    world.listen();
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
fn real_time_is_granted_or_visibly_not() {
    let bus = FreshBus::new("rt");
    let mut world = World::on(&bus);
    let daemon = Daemon::start_with(&bus, "realtime.mode = \"try\"", &[], |_| ());
    let status = world.until("a status", |s| s.pid == daemon.pid() && s.ticks > 0);
    let has = |flag| status.flags & flag != 0;
    let granted = has(StatusFlags::REALTIME) && has(StatusFlags::MEMORY_LOCKED);
    assert_eq!(has(StatusFlags::DEGRADED), !granted);
    drop(daemon);
    // No machine has this core.
    check_refused(
        "realtime.mode = \"require\"\nrealtime.cpu = 1023",
        &[],
        6,
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
fn the_ticks_before_a_fault_go_into_a_file() {
    let bus = FreshBus::new("flight");
    let mut world = World::on(&bus);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let daemon = Daemon::start_with(&bus, PATIENT, &[], |command| {
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
    let daemon = Daemon::start_with(&bus, PATIENT, &nowhere, |_| ());
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
