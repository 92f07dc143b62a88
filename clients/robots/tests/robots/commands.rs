//! Tests of the other subcommands.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use atas_robots::map::file::MapFile;
use robot_model::RobotModel;
use serde_json::Value;
use shm_bus::{Bus, FreshBus};
use shm_schemas::{JointState, service};

use crate::rig::{HAND, Program, Rig, STEP_RAD, middle_rad, start_chains, two_hands, wait_until};

fn json(program: &Program) -> Value {
    serde_json::from_str(&program.printed())
        .unwrap_or_else(|e| panic!("{e}: {}", program.printed()))
}

#[test]
fn list_shows_models_and_limits() {
    let mut list = Program::start(&["list", "--format", "json"]);
    assert_eq!(list.finish(), Some(0));
    let drivers = json(&list);
    let names: Vec<&str> = (0..2)
        .filter_map(|n| drivers["drivers"][n]["name"].as_str())
        .collect();
    assert_eq!(names, ["dynamixel", "feetech"]);
    assert_eq!(
        drivers["drivers"][1]["models"][0]["limited_by"],
        "torque_limit_percent"
    );
    let mut list = Program::start(&["list"]);
    list.finish();
    assert!(
        list.printed()
            .contains("xm430-w350   current_limit_a up to 3.2 A")
    );
}

#[test]
fn probe_finds_connected_servos() {
    let chains = start_chains(&mut two_hands(), &middle_rad());
    chains[1].set_echo(true);
    for (chain, driver, model) in [
        (&chains[0], "dynamixel", "xm430-w350"),
        (&chains[1], "feetech", "sts3215"),
    ] {
        let device = chain.path().to_str().unwrap();
        let mut probe = Program::start(&["probe", device, "--baud", "1000000", "--format", "json"]);
        assert_eq!(probe.finish(), Some(0), "{}", probe.log());
        let found = &json(&probe)["found"];
        assert_eq!(
            (&found[0]["driver"], &found[1]),
            (&driver.into(), &Value::Null)
        );
        let servos = found[0]["servos"].as_array().unwrap();
        assert_eq!(servos.len(), HAND);
        assert!(servos.iter().all(|servo| servo["model"] == model));
        assert_eq!(found[0]["echoes"], chain.path() == chains[1].path());
    }
}

#[test]
fn hz_reports_the_state_rate() {
    let rig = Rig::start();
    let mut hz = Program::start(&[
        "hz",
        "--bus",
        rig.bus(),
        "--seconds",
        "2",
        "--format",
        "json",
    ]);
    assert_eq!(hz.finish(), Some(0));
    let last: Value = serde_json::from_str(hz.printed().lines().last().unwrap()).unwrap();
    assert!(last["states"].as_u64() > Some(5), "{last}");
    assert!(
        last["period_ms"]["mean"].as_f64() > Some(0.0)
            && last["age_ms"]["max"].as_f64() > Some(0.0)
    );
}

#[test]
fn hz_rejects_missing_bus() {
    for more in [&[][..], &["--seconds", "1", "--format", "json"]] {
        let bus = FreshBus::new("typo");
        let mut hz = Program::start(&[&["hz", "--bus", bus.as_str()], more].concat());
        assert_eq!(hz.finish(), Some(9), "{}", hz.log());
        assert!(hz.log().contains("could not find the bus"), "{}", hz.log());
        assert_eq!(hz.printed(), "");
        assert!(Bus::find(&bus).is_err());
    }
}

#[test]
fn calibrate_determines_zero_and_direction() {
    let mut rig = Rig::start();
    rig.program.signal(rustix::process::Signal::TERM);
    rig.program.finish();
    let text = std::fs::read_to_string(&rig.map).unwrap();
    let map: MapFile = toml::from_str(&text).unwrap();
    let (path, out) = (rig.map.clone(), rig.map.with_file_name("found.toml"));
    let chains = &rig.chains;
    let mut calibrate = Program::start(&[
        "calibrate",
        path.to_str().unwrap(),
        "--joint",
        "left_wrist_roll",
        "--out",
        out.to_str().unwrap(),
    ]);
    calibrate.wait_for("support it, then press Enter");
    calibrate.enter();
    calibrate.wait_for("move it to 0, then press Enter");
    assert!(
        !chains[0].servo(5, |servo| servo.holds()),
        "torque is off while the user moves the joint"
    );
    chains[0].servo(5, |servo| servo.turn_to(2.0));
    calibrate.enter();
    calibrate.wait_for("move it slightly in its positive direction");
    chains[0].servo(5, |servo| servo.turn_to(1.98));
    calibrate.enter();
    calibrate.wait_for("its shaft turned by -0.0");
    chains[0].servo(5, |servo| servo.turn_to(1.7));
    calibrate.enter();
    assert_eq!(calibrate.finish(), Some(0), "{}", calibrate.log());
    let found: MapFile = toml::from_str(&std::fs::read_to_string(out).unwrap()).unwrap();
    let servo = &found.ports[0].servos[4];
    assert_eq!(
        (servo.direction, (servo.zero_rad - 2.0).abs() <= STEP_RAD),
        (-1, true)
    );
    assert_eq!(found.ports[0].servos[3], map.ports[0].servos[3]);
}

#[test]
fn relax_switches_only_requested_servos_off() {
    let mut rig = Rig::start();
    let map = rig.map.to_str().unwrap().to_owned();
    let mut relax = Program::start(&["relax", &map, "--yes"]);
    assert_eq!(
        relax.finish(),
        Some(11),
        "another process uses the port: {}",
        relax.log()
    );
    rig.program.signal(rustix::process::Signal::TERM);
    assert_eq!(rig.program.finish(), Some(0));
    let mut relax = Program::start(&["relax", &map]);
    assert_eq!(relax.finish(), Some(2), "no confirmation");
    assert!((0..22).all(|joint| rig.servo(joint, |servo| servo.holds())));
    let mut relax = Program::start(&["relax", &map, "--yes", "--joint", "right_wrist_roll"]);
    assert_eq!(relax.finish(), Some(0), "{}", relax.log());
    let loose: Vec<usize> = (0..22)
        .filter(|joint| !rig.servo(*joint, |servo| servo.holds()))
        .collect();
    assert_eq!(loose, [HAND + 4]);
}

#[test]
fn run_drives_emulated_servos() {
    let folder = tempfile::TempDir::new().unwrap();
    let (path, out) = (
        folder.path().join("robot.toml"),
        folder.path().join("played.toml"),
    );
    let mut map = two_hands();
    map.ports
        .iter_mut()
        .for_each(|port| port.answer_within_ms = 1000.0);
    std::fs::write(&path, toml::to_string(&map).unwrap()).unwrap();
    let emulate = Program::start(&[
        "emulate",
        path.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    wait_until("the map", || emulate.printed().contains("atas-robot run"));
    let bus = shm_bus::FreshBus::new("robot");
    let mut run = Program::start(&["run", out.to_str().unwrap(), "--bus", bus.as_str()]);
    run.wait_for("all 22 joints hold; states begin");
    run.signal(rustix::process::Signal::INT);
    assert_eq!(run.finish(), Some(0));
}

/// The map of the SO-101 is valid, and its emulated servos begin at `rest_deg` and `rest_m`.
#[test]
fn emulated_so101_begins_in_its_reference_posture() {
    let folder = tempfile::TempDir::new().unwrap();
    let so101 = Path::new(env!("CARGO_MANIFEST_DIR")).join("so101");
    let robot_file = so101.join("robot.toml").display().to_string();
    let text = std::fs::read_to_string(so101.join("servos.toml")).unwrap();
    let mut map: MapFile = toml::from_str(&text).unwrap();
    map.robot.clone_from(&robot_file);
    map.ports[0].answer_within_ms = 1000.0;
    let [path, out] = ["map.toml", "played.toml"].map(|name| folder.path().join(name));
    std::fs::write(&path, toml::to_string(&map).unwrap()).unwrap();
    let [path, out] = [&path, &out].map(|path| path.to_str().unwrap());
    let emulate = Program::start(&["emulate", path, "--rest", "--out", out]);
    wait_until("the map", || emulate.printed().contains("atas-robot run"));
    let bus = FreshBus::new("so101");
    let node = Bus::open(&bus, "reader", shm_bus::Realtime::No).unwrap();
    let mut states = node.subscriber(service::JOINT_STATE).unwrap();
    let mut run = Program::start(&["run", out, "--bus", bus.as_str()]);
    let mut state = JointState::default();
    wait_until("a joint state", || states.newest(&mut state).unwrap());
    let robot = RobotModel::find(&robot_file).unwrap();
    let rest_rad = robot.hand(robot.acting_side()).reference();
    assert_eq!(state.joint_count as usize, rest_rad.len());
    for (measured, rest_rad) in state.position.iter().zip(rest_rad.iter()) {
        assert!(
            (measured - rest_rad).abs() < 2.0 * STEP_RAD,
            "{measured} {rest_rad}"
        );
    }
    run.signal(rustix::process::Signal::INT);
    assert_eq!(run.finish(), Some(0));
}

#[test]
fn invalid_map_is_rejected_with_all_errors() {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("robot.toml");
    let check = |text: &str, words: &[&str]| {
        std::fs::write(&path, text).unwrap();
        let mut run = Program::start(&["run", path.to_str().unwrap()]);
        assert_eq!(run.finish(), Some(7), "{}", run.log());
        for words in words {
            assert!(run.log().contains(words), "{}", run.log());
        }
    };
    check(
        "",
        &[
            "no port defined; a map needs at least one [[port]]",
            "no servo for left_shoulder_yaw",
        ],
    );
    check("prt = 1", &["unknown field `prt`"]);
    check("robot = \"nowhere.toml\"", &["nowhere.toml"]);
}

#[test]
fn completions_and_manual_pages_are_generated() {
    let mut completions = Program::start(&["completions", "bash"]);
    assert_eq!(completions.finish(), Some(0));
    assert!(completions.printed().contains("atas-robot"));
    let folder = tempfile::TempDir::new().unwrap();
    let mut man = Program::start(&["man", folder.path().to_str().unwrap()]);
    assert_eq!(man.finish(), Some(0));
    assert!(folder.path().join("atas-robot-run.1").exists());
}

/// As in `atas-robot list | head -1`.
#[test]
fn closed_pipe_succeeds_and_full_disk_fails() {
    for line in ["list", "list --format json", "completions zsh", "--help"] {
        let reported = |sink: Stdio| {
            let output = Command::new(env!("CARGO_BIN_EXE_atas-robot"))
                .args(line.split_whitespace())
                .stdout(sink)
                .output()
                .unwrap();
            let stderr = String::from_utf8(output.stderr).unwrap();
            (output.status.code(), stderr)
        };
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(reported(writer.into()), (Some(0), String::new()), "{line}");
        let full = File::options().write(true).open("/dev/full").unwrap();
        let (code, stderr) = reported(full.into());
        assert_eq!(code, Some(1), "{line}: {stderr}");
        assert!(stderr.contains("could not write to standard output"));
    }
}

#[test]
fn errors_are_json_with_json_format() {
    for (line, exit) in [
        ("probe /dev/none --format json", 11),
        ("hz --format=json --seconds soon", 2),
        ("emulate no.toml --out no.json --format json", 2),
        ("emulate no.toml --out out.toml --format json", 7),
    ] {
        let mut program = Program::start(&line.split(' ').collect::<Vec<_>>());
        assert_eq!(program.finish(), Some(exit), "{line}");
        let error: Value = serde_json::from_str(&program.log())
            .unwrap_or_else(|e| panic!("{line}: {e}: {}", program.log()));
        assert_eq!(error["exit"], exit, "{line}: {error}");
        assert!(error["error"].is_string(), "{line}: {error}");
    }
}
