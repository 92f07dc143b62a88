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
    said: Lines<BufReader<ChildStdout>>,
}

impl Running {
    fn start(bus: &BusName, tables: &[&str]) -> Self {
        let mut child = agents(bus, tables).spawn().expect("ebts starts");
        let said = BufReader::new(child.stdout.take().expect("piped")).lines();
        Self { child, said }
    }

    fn next(&mut self) -> serde_json::Value {
        let line = self.said.next().expect("another line").expect("text");
        serde_json::from_str(&line).expect("JSON")
    }

    fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("it lives");
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
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{tables:?}: {said}");
    said
}

#[test]
fn it_does_not_begin_without_intact_tables() {
    let (bus, folder) = (
        FreshBus::new("agents"),
        tempfile::tempdir().expect("a folder"),
    );
    let spoilt = folder.path().join("spoilt.toml");
    std::fs::write(&spoilt, "format = \"ebts-table-1\"").expect("writable");
    let said = refused(&bus, &[TABLE, spoilt.to_str().expect("UTF-8")], 3);
    assert!(said.contains("spoilt.toml"), "{said}");
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
    let said = refused(&bus, &[golden, other.to_str().expect("UTF-8")], 3);
    assert!(said.contains("its preset N was another field"), "{said}");
    let said = refused(&bus, &["no/such.toml"], 3);
    assert!(said.contains(TABLE) && said.contains("--table"), "{said}");
    let said = refused(&bus, &[], 2);
    assert!(said.contains("--table"), "{said}");
}

#[test]
fn one_process_answers_on_a_bus() {
    let bus = FreshBus::new("agents");
    let mut first = Running::start(&bus, &[TABLE]);
    assert_eq!(first.next()["event"], "ready");
    let said = refused(&bus, &[TABLE], 6);
    assert!(
        said.contains(&first.child.id().to_string()),
        "the owner is named: {said}"
    );
}

#[test]
fn sighup_reads_the_tables_again_and_sigterm_ends_it_in_good_order() {
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
    assert!(running.child.wait().expect("it ends").success());
}
