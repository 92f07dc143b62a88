//! The systemd unit: accepted by systemd, closed to everything it does not need, and true to the daemon.
//!
//! `systemd-analyze` is in the Debian package `systemd`. Where it is not installed, the two tests that need it say so
//! and check nothing.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::process::{Command, Output};

use tempfile::TempDir;

const UNIT: &str = include_str!("../../systemd/atasd.service");
const USERS: &str = include_str!("../../systemd/atas.sysusers.conf");
/// Highest exposure that is accepted, in tenths: 1.0 of 10.
const EXPOSURE_TENTHS: &str = "10";

/// What `systemd-analyze` says about the unit, with the daemon that was built in place of the installed one.
fn analyze(arguments: &[&str]) -> Option<Output> {
    let folder = TempDir::new().expect("a temporary folder");
    let file = folder.path().join("atasd.service");
    let unit = UNIT.replace("/usr/bin/atasd", env!("CARGO_BIN_EXE_atasd"));
    fs::write(&file, unit).expect("writable");
    let mut command = Command::new("systemd-analyze");
    match command.args(arguments).arg(&file).output() {
        Ok(output) => Some(output),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let line = "SKIPPED: systemd-analyze is not installed (Debian package systemd); the unit was not checked";
            // A closed standard error is no reason to fail.
            let _ = writeln!(std::io::stderr(), "{line}");
            None
        }
        Err(error) => panic!("systemd-analyze does not start: {error}"),
    }
}

fn check(arguments: &[&str]) {
    if let Some(output) = analyze(arguments) {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let (said, wrong) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{said}{wrong}");
        // Keys that this systemd does not know are warnings, and would be ignored.
        assert!(!wrong.contains("atasd.service:"), "{wrong}");
    }
}

#[test]
fn systemd_accepts_the_unit() {
    check(&["verify"]);
}

#[test]
fn the_unit_is_exposed_to_next_to_nothing() {
    let threshold = format!("--threshold={EXPOSURE_TENTHS}");
    check(&["security", "--offline=true", &threshold]);
}

/// The value of a key that stands once in the unit.
fn value(key: &str) -> &'static str {
    let mut values = UNIT
        .lines()
        .filter_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    let value = values.next().unwrap_or_else(|| panic!("{key} is missing"));
    assert_eq!(values.next(), None, "{key} stands twice");
    value
}

#[test]
fn the_unit_gives_the_daemon_what_it_asks_for() {
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
