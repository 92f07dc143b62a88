//! Tools of `atas-sensor`: list, probe, echo, hz, completions, manual pages, help.

mod common;
#[path = "common/peers.rs"]
mod peers;
#[path = "common/process.rs"]
mod process;

use std::fs::{self, File};
use std::net::UdpSocket;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use atas_sensors::cli;
use atas_sensors::wire::SENSORS;
use process::{Pty, Sensor};
use rustix::process::Signal;
use serde_json::Value;
use shm_bus::{Bus, FreshBus};

fn json_of(arguments: &str) -> Value {
    let (code, stdout, stderr) = Sensor::start_line(arguments).finish();
    assert_eq!(code, Some(0), "{arguments}: {stderr}");
    serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{arguments}: {error}: {stdout}"))
}

/// Help and manual pages begin with the description of the program, not of its argument types.
#[test]
fn help_and_manual_begin_with_a_description() {
    let folder = tempfile::tempdir().unwrap();
    clap_mangen::generate_to(cli::command(), folder.path()).unwrap();
    let check = |words: &str, about: &str| {
        let mut line: Vec<&str> = words.split(' ').collect();
        line.push("--help");
        let help = cli::command().try_get_matches_from(line).unwrap_err();
        let help = help.render().to_string();
        assert_eq!(help.lines().next(), Some(about), "{words}");
        let page = folder.path().join(words.replace(' ', "-") + ".1");
        let page = fs::read_to_string(page).unwrap();
        let page = page.replace(r"\*(Aq", "'").replace('\\', "");
        assert!(page.contains(about), "{words}: {page}");
        assert!(
            !page.contains("Options of every subcommand"),
            "{words}: {page}"
        );
    };
    check(
        "atas-sensor",
        "Reads real tactile sensors and publishes their frames",
    );
    for sensor in &SENSORS {
        check(&format!("atas-sensor {}", sensor.name), sensor.about);
    }
}

#[test]
fn definition_is_valid_and_help_has_examples() {
    cli::command().debug_assert();
    let mut command = cli::command();
    assert!(command.render_help().to_string().contains("Example"));
    for sub in command.get_subcommands_mut() {
        let name = sub.get_name().to_owned();
        if name != "help" {
            let help = sub.render_help().to_string();
            assert!(
                help.contains(&format!("atas-sensor {name}")),
                "{name}: {help}"
            );
        }
    }
}

#[test]
fn example_of_every_sensor_parses() {
    for sensor in &SENSORS {
        let line = format!("atas-sensor {} {}", sensor.name, sensor.example);
        let parsed = cli::command().try_get_matches_from(line.split_whitespace());
        let matches = parsed.unwrap_or_else(|error| panic!("{line}: {error}"));
        let (_, matches) = matches.subcommand().unwrap();
        atas_sensors::plan::Plan::from_sensor(
            SENSORS
                .iter()
                .find(|other| other.name == sensor.name)
                .unwrap(),
            matches,
        )
        .unwrap_or_else(|error| panic!("{line}: {error}"));
    }
}

#[test]
fn list_names_every_sensor() {
    let list = json_of("list --format json");
    let rows = list["sensors"].as_array().unwrap();
    let names: Vec<&str> = rows
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, SENSORS.map(|sensor| sensor.name));
    for row in rows {
        assert!(row["wire"].is_string() && row["taxels"].is_u64(), "{row}");
    }
    let (_, text, _) = Sensor::start_line("list").finish();
    assert!(names.iter().all(|name| text.contains(name)), "{text}");
}

#[test]
fn probe_recognises_every_sensor() {
    let done = AtomicBool::new(false);
    for sensor in [
        "optoforce",
        "anyskin",
        "papillarray",
        "paxini",
        "paxini-hand",
    ] {
        let pty = Pty::new();
        done.store(false, Ordering::Relaxed);
        let found = thread::scope(|scope| {
            scope.spawn(|| {
                for n in 0.. {
                    if done.load(Ordering::Relaxed) {
                        break;
                    }
                    // The driver only reads the board's answers, so the emulated board sends them
                    // unasked.
                    pty.send(&peers::frame(sensor, n));
                    thread::sleep(Duration::from_millis(4));
                }
            });
            let found = json_of(&format!("probe {} --format json", pty.path.display()));
            done.store(true, Ordering::Relaxed);
            found
        });
        assert_eq!(found["found"][0]["name"], sensor, "{found}");
        assert_eq!(found["found"].as_array().unwrap().len(), 1, "{found}");
    }
    let silent = Pty::new();
    let nothing = json_of(&format!("probe {} --format json", silent.path.display()));
    assert_eq!(nothing["found"], Value::Array(Vec::new()));
}

#[test]
fn probe_queries_a_box_and_reports_failures() {
    let peer = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = peer.local_addr().unwrap();
    let found = thread::scope(|scope| {
        scope.spawn(|| {
            let (_, from) = peer.recv_from(&mut [0; 16]).unwrap();
            for n in 1..20 {
                peer.send_to(&peers::netft_record(n), from).unwrap();
            }
        });
        json_of(&format!("probe {address} --format json"))
    });
    assert_eq!(found["found"][0]["name"], "netft", "{found}");
    let (code, stdout, stderr) = Sensor::start_line("probe /dev/none --format json").finish();
    assert_eq!(code, Some(11), "{stderr}");
    let message: Value = serde_json::from_str(&stdout).unwrap();
    assert!(
        message["error"]
            .as_str()
            .unwrap()
            .contains("check the path"),
        "{message}"
    );
}

#[test]
fn rate_and_frames_of_a_hand_are_shown() {
    let bus = FreshBus::new("sensor");
    let pty = Pty::new();
    let at = format!("--hand left --bus {}", *bus);
    let sensor = Sensor::start_line(&format!(
        "optoforce --device {} {at} --no-configure --newtons-per-count 1,1,1",
        pty.path.display()
    ));
    let made = (0..10_000).any(|_| {
        thread::sleep(Duration::from_millis(1));
        Bus::find(&bus).is_ok()
    });
    assert!(made, "the sensor process creates the bus");
    let echo = Sensor::start_line(&format!("echo {at} --frames 5 --format json"));
    let hz = Sensor::start_line(&format!("hz {at} --seconds 2 --format json"));
    let done = AtomicBool::new(false);
    let (echoed, rates) = thread::scope(|scope| {
        scope.spawn(|| {
            for n in 0_u16.. {
                if done.load(Ordering::Relaxed) {
                    break;
                }
                // Every tenth frame is lost.
                if n % 10 != 0 {
                    pty.send(&common::data_frame(n, 0, &[3, 4, -5]));
                }
                thread::sleep(Duration::from_millis(2));
            }
        });
        let message = (echo.finish(), hz.finish());
        done.store(true, Ordering::Relaxed);
        message
    });
    assert_eq!(
        (echoed.0, rates.0),
        (Some(0), Some(0)),
        "{}{}",
        echoed.2,
        rates.2
    );
    let frames: Vec<Value> = echoed
        .1
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(frames.len(), 5);
    assert_eq!(
        frames[4]["fingers"][0]["force_n"],
        serde_json::json!([5.0, 3.0, 4.0])
    );
    let second: Value = serde_json::from_str(rates.1.lines().last().unwrap()).unwrap();
    assert!(
        second["rate_hz"].as_u64().unwrap() > 0 && second["lost"].as_u64().unwrap() > 0,
        "{second}"
    );
    assert!(
        second["period_ms"]["max"].as_f64() >= second["period_ms"]["min"].as_f64(),
        "{second}"
    );
    sensor.signal(Signal::TERM);
    assert_eq!(sensor.finish().0, Some(0));
}

#[test]
fn missing_bus_is_reported_and_not_created() {
    for line in ["hz", "hz --seconds 1 --format json", "echo --frames 1"] {
        let bus = FreshBus::new("typo");
        let line = format!("{line} --hand left --bus {}", *bus);
        let (code, stdout, stderr) = Sensor::start_line(&line).finish();
        assert_eq!((code, stdout.as_str()), (Some(9), ""), "{line}: {stderr}");
        assert!(
            stderr.contains("could not find the bus"),
            "{line}: {stderr}"
        );
        assert!(Bus::find(&bus).is_err(), "{line}");
    }
}

#[test]
fn completions_and_manual_pages() {
    let (code, script, _) = Sensor::start_line("completions bash").finish();
    assert_eq!(code, Some(0));
    assert!(script.contains("papillarray") && script.contains("--newtons-per-count"));
    let folder = tempfile::tempdir().unwrap();
    let (code, _, stderr) =
        Sensor::start_line(&format!("man {}", folder.path().display())).finish();
    assert_eq!(code, Some(0), "{stderr}");
    let page = fs::read_to_string(folder.path().join("atas-sensor-optoforce.1")).unwrap();
    assert!(page.contains("latency_timer"), "{page}");
}

#[test]
fn closed_pipe_and_full_disk_cause_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("recording.bin");
    let frames: Vec<u8> = (0..20_000).flat_map(peers::optoforce_frame).collect();
    fs::write(&recording, frames).unwrap();
    let table = format!(
        "optoforce --dry-run --no-configure --device {}",
        recording.display()
    );
    for line in [
        table.as_str(),
        "list",
        "list --format json",
        "completions zsh",
        "--help",
        "optoforce --help",
    ] {
        for full in [true, false] {
            let sink = if full {
                Stdio::from(File::options().write(true).open("/dev/full").unwrap())
            } else {
                let (reader, writer) = std::io::pipe().unwrap();
                drop(reader);
                Stdio::from(writer)
            };
            let output = Command::new(env!("CARGO_BIN_EXE_atas-sensor"))
                .args(line.split_whitespace())
                .stdout(sink)
                .stderr(Stdio::piped())
                .output()
                .unwrap();
            let stderr = String::from_utf8(output.stderr).unwrap();
            let (code, complains) = if full { (1, true) } else { (0, false) };
            assert_eq!(output.status.code(), Some(code), "{line}: {stderr}");
            assert_eq!(
                stderr.contains("could not write"),
                complains,
                "{line}: {stderr}"
            );
            assert!(!stderr.contains("panicked"), "{line}: {stderr}");
        }
    }
}
