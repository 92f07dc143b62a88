//! `ebts agents` as a process: rejected starts and status lines.

use std::io::{BufRead, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Output, Stdio};

use shm_bus::{BusName, FreshBus};

const TABLE: &str = "r3-two-agents";

fn agents(bus: &BusName, tables: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ebts"));
    command.args(["agents", "--format", "json", "--bus", bus.as_str()]);
    for table in tables {
        command.args(["--table", table]);
    }
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

struct Running {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Running {
    fn start(bus: &BusName, tables: &[&str]) -> Self {
        let mut child = agents(bus, tables).spawn().expect("ebts starts");
        let message = BufReader::new(child.stdout.take().expect("piped")).lines();
        Self {
            child,
            lines: message,
        }
    }

    fn next(&mut self) -> serde_json::Value {
        let line = self.lines.next().expect("another line").expect("text");
        serde_json::from_str(&line).expect("JSON")
    }

    fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("a running process");
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn refused(bus: &BusName, tables: &[&str], code: i32) -> String {
    let output: Output = agents(bus, tables).output().expect("ebts starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{tables:?}: {message}");
    message
}

#[test]
fn agents_reject_invalid_tables() {
    let (bus, folder) = (
        FreshBus::new("agents"),
        tempfile::tempdir().expect("a folder"),
    );
    let spoilt = folder.path().join("spoilt.toml");
    std::fs::write(&spoilt, "format = \"ebts-table-1\"").expect("writable");
    let message = refused(&bus, &[TABLE, spoilt.to_str().expect("UTF-8")], 7);
    assert!(message.contains("spoilt.toml"), "{message}");
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/table.toml");
    let other = folder.path().join("other.toml");
    let evolve = ["evolve", "--preset", "N", "--generations", "2", "--out"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_ebts"));
    assert!(
        command
            .args(evolve)
            .arg(&other)
            .output()
            .expect("ebts starts")
            .status
            .success()
    );
    let message = refused(&bus, &[golden, other.to_str().expect("UTF-8")], 7);
    assert!(
        message.contains("its preset N is another field"),
        "{message}"
    );
    let message = refused(&bus, &["no/such.toml"], 7);
    assert!(
        message.contains(TABLE) && message.contains("--table"),
        "{message}"
    );
    let message = refused(&bus, &[], 2);
    assert!(message.contains("--table"), "{message}");
}

#[test]
fn second_agents_process_is_rejected() {
    let bus = FreshBus::new("agents");
    let mut first = Running::start(&bus, &[TABLE]);
    assert_eq!(first.next()["event"], "ready");
    let message = refused(&bus, &[TABLE], 8);
    assert!(
        message.contains(&first.child.id().to_string()),
        "the error contains the process id of the owner: {message}"
    );
}

#[test]
fn sighup_reloads_tables_and_sigterm_ends() {
    let (bus, folder) = (
        FreshBus::new("agents"),
        tempfile::tempdir().expect("a folder"),
    );
    let path = folder.path().join("table.toml");
    let intact = include_str!("../tables/r3-two-agents.toml");
    std::fs::write(&path, intact).expect("writable");
    let mut running = Running::start(&bus, &[path.to_str().expect("UTF-8"), TABLE]);
    let ready = running.next();
    assert_eq!(
        (&ready["event"], &ready["tables"]),
        (&"ready".into(), &2.into())
    );
    std::fs::write(&path, &intact[..1000]).expect("writable");
    running.signal(rustix::process::Signal::HUP);
    let refused = running.next();
    assert_eq!(refused["event"], "refused");
    assert!(
        refused["why"]
            .as_str()
            .is_some_and(|why| why.contains("table.toml")),
        "{refused}"
    );
    std::fs::write(&path, intact).expect("writable");
    running.signal(rustix::process::Signal::HUP);
    let exchanged = running.next();
    assert_eq!(
        (&exchanged["event"], &exchanged["hash"]),
        (&"exchanged".into(), &ready["hash"])
    );
    running.signal(rustix::process::Signal::TERM);
    assert_eq!(running.next()["event"], "ended");
    assert!(running.child.wait().expect("a finished process").success());
}
