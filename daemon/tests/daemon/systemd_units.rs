//! The systemd units: accepted by systemd, minimally exposed, consistent with the programs.
//!
//! `systemd-analyze` is in the Debian package `systemd`. Without it, the two tests that need it
//! report that they were skipped.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::process::{Command, Output, Stdio};

use atasd::args::Args;
use atasd::config::Source;
use clap::{CommandFactory as _, Parser as _};
use tempfile::TempDir;

const UNIT: &str = include_str!("../../systemd/atasd.service");
const USERS: &str = include_str!("../../systemd/atas.sysusers.conf");
const MANUAL: &str = include_str!("../../systemd/atasd.8");
/// Units with the maximum accepted exposure, in tenths. Sensors and servos use serial ports,
/// sensors and the server for other machines the network as well.
const UNITS: [(&str, &str, &str); 7] = [
    ("atasd.service", UNIT, "10"),
    (GATE.0, GATE.1, "10"),
    (
        "atas-record.service",
        include_str!("../../systemd/atas-record.service"),
        "15",
    ),
    (
        REMOTE,
        include_str!("../../systemd/atas-remote.service"),
        "20",
    ),
    (
        "atas-robot@.service",
        include_str!("../../systemd/atas-robot@.service"),
        "20",
    ),
    (
        "atas-sensor@.service",
        include_str!("../../systemd/atas-sensor@.service"),
        "25",
    ),
    (
        "atas-sim.service",
        include_str!("../../systemd/atas-sim.service"),
        "15",
    ),
];

const REMOTE: &str = "atas-remote.service";
const GATE: (&str, &str) = (
    "atas-gate.service",
    include_str!("../../systemd/atas-gate.service"),
);
const SOCKET: (&str, &str) = (
    "atas-gate.socket",
    include_str!("../../systemd/atas-gate.socket"),
);

/// Replaces the installed program of a unit by the built one.
fn with_built_program(unit: &str) -> String {
    let line = |line: &str| match line.strip_prefix("ExecStart=") {
        Some(command) => {
            let words = command.split_once(' ').map_or("", |(_, words)| words);
            format!("ExecStart={} {words}\n", env!("CARGO_BIN_EXE_atasd"))
        }
        None => format!("{line}\n"),
    };
    unit.lines().map(line).collect()
}

/// Runs `systemd-analyze` on a unit, with the gate's units beside it.
fn analyze(name: &str, unit: &str, arguments: &[&str]) -> Option<Output> {
    let folder = TempDir::new().expect("a temporary folder");
    let file = folder.path().join(name);
    for (name, unit) in [GATE, SOCKET, (name, unit)] {
        fs::write(folder.path().join(name), with_built_program(unit)).expect("writable");
    }
    let mut command = Command::new("systemd-analyze");
    match command.args(arguments).arg(&file).output() {
        Ok(output) => Some(output),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let line = "SKIPPED: systemd-analyze is not installed (Debian package systemd); the units were not checked";
            // A closed standard error is not a failure.
            let _ = writeln!(std::io::stderr(), "{line}");
            None
        }
        Err(error) => panic!("systemd-analyze does not start: {error}"),
    }
}

fn check(name: &str, unit: &str, arguments: &[&str]) {
    if let Some(output) = analyze(name, unit, arguments) {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (message, wrong) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{name}: {message}{wrong}");
        // Unknown keys are only warnings, and would be ignored.
        assert!(!wrong.contains(&format!("{name}:")), "{wrong}");
    }
}

#[test]
fn systemd_accepts_the_units() {
    for (name, unit, _) in UNITS {
        check(name, unit, &["verify"]);
    }
    let (name, unit) = SOCKET;
    check(name, unit, &["verify"]);
}

/// The group has access to the socket, other users do not, and the gate serves it.
#[test]
fn socket_is_accessible_to_the_group_only() {
    let (name, text) = SOCKET;
    let group = value("Group");
    for line in [&format!("SocketGroup={group}"), "SocketMode=0660"] {
        assert!(text.lines().any(|l| l == line), "{name} lacks {line}");
    }
    let wanted = format!("Wants={name}");
    assert!(
        UNIT.lines().any(|line| line == wanted),
        "atasd lacks {wanted}"
    );
    let gate = GATE.1;
    for line in [format!("Requires={name}").as_str(), "StandardInput=socket"] {
        assert!(gate.lines().any(|l| l == line), "the gate lacks {line}");
    }
    assert!(
        !gate.contains("\nPrivateUsers=true"),
        "the gate must know the peer's user"
    );
}

#[test]
fn units_stay_below_the_exposure_limit() {
    for (name, unit, most) in UNITS {
        let threshold = format!("--threshold={most}");
        check(name, unit, &["security", "--offline=true", &threshold]);
    }
}

/// All processes of the bus run as one user, and the bus folder outlives them.
#[test]
fn units_share_user_and_bus_folder() {
    for (name, unit, _) in UNITS {
        let same = [
            "User=atas",
            "Group=atas",
            "RuntimeDirectory=atas",
            "RuntimeDirectoryPreserve=yes",
            "RemoveIPC=false",
            "ReadWritePaths=/dev/shm",
        ];
        for line in same {
            assert!(unit.lines().any(|l| l == line), "{name} lacks {line}");
        }
        // Gate and server may start before or after the bus exists.
        let late = ["atasd.service", GATE.0, REMOTE].contains(&name);
        let first = late || unit.contains("Before=atasd.service");
        assert!(first, "{name} must start before the daemon");
    }
}

#[test]
fn manual_lists_every_flag() {
    let help = Command::new(env!("CARGO_BIN_EXE_atasd"))
        .arg("--help")
        .output()
        .expect("atasd starts");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let is_flag = |word: &&str| word.starts_with("--") && word.len() > 3;
    let mut flags = 0;
    for line in help.lines().map(str::trim_start) {
        let Some(flag) = line
            .split([' ', ','])
            .find(is_flag)
            .filter(|_| line.starts_with('-'))
        else {
            continue;
        };
        assert!(
            MANUAL.contains(&flag.replace('-', "\\-")),
            "the manual lacks {flag}"
        );
        flags += 1;
    }
    assert!(flags > 6, "{help}");
    assert!(help.contains("\n  completions "), "{help}");
    assert!(MANUAL.contains("\\fBcompletions\\fR"));
}

/// The package contains the completions.
#[test]
fn completions_exist_for_every_shell() {
    for shell in ["bash", "fish", "zsh"] {
        let output = Command::new(env!("CARGO_BIN_EXE_atasd"))
            .args(["completions", shell])
            .output()
            .expect("atasd starts");
        let script = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{shell}: {output:?}");
        assert!(script.contains("check-config"), "{shell}: {script}");
    }
}

#[test]
fn examples_in_help_are_valid() {
    let help = Args::command().render_help().to_string();
    let (_, examples) = help.split_once("Examples:\n").expect("examples");
    let lines: Vec<&str> = examples.lines().take_while(|l| !l.is_empty()).collect();
    for line in &lines {
        let parsed = Args::try_parse_from(line.split_whitespace());
        let args = parsed.unwrap_or_else(|error| panic!("{line}: {error}"));
        let written = args
            .config
            .iter()
            .chain(&args.robot.map(Into::into))
            .count();
        // Examples without files are loaded as well.
        if written == 0 {
            let source = Source {
                files: vec!["/dev/null".into()],
                flags: args.set,
            };
            source.load().unwrap_or_else(|e| panic!("{line}: {e}"));
        }
    }
    assert!(lines.len() > 3, "{help}");
}

/// Truncated output must be reported.
#[test]
fn full_disk_fails_and_closed_pipe_succeeds() {
    for line in ["--help", "--version", "completions bash", "--print-tasks"] {
        let reported = |sink: Stdio| {
            let output = Command::new(env!("CARGO_BIN_EXE_atasd"))
                .args(line.split_whitespace())
                .stdout(sink)
                .output()
                .expect("atasd starts");
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            (output.status.code(), stderr)
        };
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        assert_eq!(reported(writer.into()), (Some(0), String::new()), "{line}");
        let full = fs::File::options().write(true).open("/dev/full");
        let (code, stderr) = reported(full.expect("Linux has it").into());
        assert_eq!(code, Some(1), "{line}: {stderr}");
        assert!(stderr.contains("No space left"), "{line}: {stderr}");
    }
}

/// Value of a key that occurs once in the unit.
fn value(key: &str) -> &'static str {
    let mut values = UNIT
        .lines()
        .filter_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    let value = values.next().unwrap_or_else(|| panic!("{key} is missing"));
    assert_eq!(values.next(), None, "{key} occurs twice");
    value
}

#[test]
fn unit_limits_match_the_daemon() {
    let realtime = atasd::config::Config::default().realtime;
    assert_eq!(value("LimitRTPRIO"), realtime.priority.to_string());
    assert_eq!(value("Type"), "notify");
    assert_eq!(value("RemoveIPC"), "false");
    assert_eq!(value("ReadWritePaths"), "/dev/shm");
    assert_eq!(value("RuntimeDirectoryMode"), "0750");
    assert_eq!(value("RuntimeDirectoryPreserve"), "yes");
    assert!(!value("WatchdogSec").is_empty());
    let user = format!("u {} ", value("User"));
    assert!(USERS.lines().any(|line| line.starts_with(&user)), "{USERS}");
    let (_, flags) = value("ExecStart").split_once(' ').expect("flags");
    let printed = Command::new(env!("CARGO_BIN_EXE_atasd"))
        .args(flags.split(' '))
        .args(["--check-config", "--config", "/dev/null"])
        .output()
        .expect("atasd starts");
    assert!(printed.status.success(), "{printed:?}");
    assert!(String::from_utf8_lossy(&printed.stdout).contains("mode = \"require\""));
}
