//! Tests of remote operation with real processes: daemon, simulator, server and clients, over
//! loopback.

mod certificates;
mod cut;
mod fixture;
mod hostile;

use std::fs;
use std::process::Output;

use regex::Regex;
use serde_json::Value;
use system_tests::lock_exclusive;

use fixture::*;

/// A short grasp that waits for its result.
const GRASP: &str = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 0.05";

fn parts(output: &Output) -> (Option<i32>, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// Returns the keys of a JSON object, also of nested ones.
fn keys(value: &Value) -> Vec<String> {
    let Value::Object(map) = value else {
        return Vec::new();
    };
    map.iter()
        .flat_map(|(key, value)| [vec![key.clone()], keys(value)].concat())
        .collect()
}

#[test]
fn remote_commands_equal_local_ones() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    let random = Regex::new(r#""goal_id":\d+"#).expect("valid");
    let same = |line: &str, code: i32| {
        let [local, remote] = [rig.local(line), rig.run("alice", line)].map(|output| {
            let (code, out, error) = parts(&output);
            (code, random.replace_all(&out, "").into_owned(), error)
        });
        assert_eq!(local.0, Some(code), "{line}: {local:?}");
        assert_eq!(local, remote, "{line}");
    };
    same("param list", 0);
    same("param list --format json", 0);
    same("param get grasp.dr_n", 0);
    same("param get no.such --format json", 4);
    same("param set grasp.dr_n 0.06", 0);
    same("grasp --at 9,9,9 --width 50", 4);
    same("grasp --at 9,9,9 --width 50 --format json", 4);
    same("task no-such-task", 4);
    same("topic echo no-such-topic", 2);
    same("estop", 0);
    same("estop --format json", 0);
    same("cancel", 4);
    let recovered = [false, true].map(|is_remote| {
        rig.check("alice", "estop", 0, "");
        let line = "recover";
        parts(&if is_remote {
            rig.run("alice", line)
        } else {
            rig.local(line)
        })
    });
    assert_eq!(recovered[0].0, Some(0), "{recovered:?}");
    assert_eq!(recovered[0], recovered[1]);

    let fields = |output: &Output| keys(&last_json(output));
    let line = "status --format json";
    let (local, remote) = (rig.local(line), rig.run("display", line));
    assert_eq!(fields(&local), fields(&remote));
    assert!(fields(&local).contains(&"goal".to_owned()));
    let line = format!("{GRASP} --format json");
    let mut ends = Vec::new();
    for remote in [false, true] {
        let grasped = if remote {
            rig.run("alice", &line)
        } else {
            rig.local(&line)
        };
        assert_eq!(last_json(&grasped)["state"], "succeeded", "{grasped:?}");
        // Progress is sampled: a fast goal passes some steps between two lines.
        let progress = parts(&grasped).2;
        assert!(progress.contains("grasp: hold"), "{progress}");
        ends.push(fields(&grasped));
        let released = rig.run("alice", "release");
        assert!(released.status.success(), "{released:?}");
    }
    assert_eq!(ends[0], ends[1], "fields of the result");
    same("events --last-goal --kind step --format json", 0);
    same("explain last --format json", 0);
}

#[test]
fn unsuitable_commands_are_refused_by_reason() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    rig.check("alice", "top", 2, "needs a terminal");
    rig.check("alice", "teleop", 2, "needs a terminal");
    rig.check("alice", "dashboard", 2, "opens a port");
    rig.check("alice", "record", 2, "reads or writes files");
    rig.check("alice", "demo grasp", 2, "runs on this machine only");
    rig.check("alice", "status --bus other", 4, "serves bus");
    rig.check("alice", "estop --bus other", 4, "stop not confirmed");
    let mut unknown = atas("status --remote lab --remote-config");
    let unknown = unknown.arg(rig.path("lab/alice/remote.toml")).output();
    let unknown = parts(&unknown.expect("it starts"));
    assert_eq!(unknown.0, Some(2), "{unknown:?}");
    assert!(unknown.2.contains("add [servers.lab]"), "{unknown:?}");
    let without = parts(&atas("status --remote lab:1").output().expect("it starts"));
    assert_eq!(without.0, Some(7), "{without:?}");
    assert!(without.2.contains("`atas remote keys`"), "{without:?}");
}

#[test]
fn recordings_are_listed_and_fetched() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    let tape: Vec<u8> = (0..3_000_000_u32).flat_map(u32::to_le_bytes).collect();
    fs::write(rig.path("tapes/run.mcap"), &tape).expect("written");
    fs::write(rig.path("tapes/notes.txt"), "private").expect("written");
    std::os::unix::fs::symlink("/etc/passwd", rig.path("tapes/link.mcap")).expect("linked");
    let folder = rig.path("tapes");
    let local = rig.local(&format!("recordings list --folder {}", folder.display()));
    let remote = rig.run("display", "recordings list");
    assert_eq!(parts(&local), parts(&remote));
    let (_, listed, _) = parts(&remote);
    assert!(
        listed.contains("run.mcap") && !listed.contains("notes"),
        "{listed}"
    );
    assert!(!listed.contains("link"), "{listed}");

    let line = "recordings fetch run.mcap --out copy.mcap --format json";
    let fetched = rig.run("display", line);
    assert_eq!(last_json(&fetched)["bytes"], tape.len(), "{fetched:?}");
    assert_eq!(fs::read(rig.path("copy.mcap")).expect("readable"), tape);
    rig.check("display", line, 1, "copy.mcap: it exists");
    for name in ["link.mcap", "absent.mcap"] {
        let line = format!("recordings fetch {name} --out other.mcap");
        rig.check("display", &line, 7, "could not read recording");
    }
    rig.check("pendant", "recordings list", 4, "needs \"observe\"");
    rig.check(
        "display",
        "recordings list --folder /etc",
        4,
        "server's configuration",
    );
    let left: Vec<_> = fs::read_dir(rig.folder.path())
        .expect("readable")
        .map(|entry| entry.expect("an entry").file_name())
        .filter(|name| name.to_string_lossy().contains("other"))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn only_listed_clients_have_their_right() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    rig.check("display", "status", 0, "");
    rig.check(
        "display",
        GRASP,
        4,
        "right \"observe\", this command needs \"command\"",
    );
    rig.check("display", "recover", 4, "needs \"command\"");
    rig.check(
        "pendant",
        "status",
        4,
        "right \"stop\", this command needs \"observe\"",
    );
    rig.check("pendant", "estop", 0, "");
    rig.check("display", "estop", 0, "");
    rig.check("stranger", "status", 4, "does not list client \"stranger\"");
    rig.check(
        "stranger",
        "estop",
        4,
        "stop not confirmed: rejected by the server",
    );
    let checked = last_json(&rig.run("display", "remote check --count 10 --format json"));
    assert_eq!(
        (&checked["client"], &checked["right"]),
        (&"display".into(), &"observe".into())
    );

    // A change takes effect with the next connection. Without a valid file, only a stop passes.
    let file = rig.path("remote.toml");
    let text = fs::read_to_string(&file).expect("readable");
    let changed = text.replace("display = 'observe'\n", "");
    fs::write(&file, changed).expect("written");
    rig.check("display", "status", 4, "does not list client \"display\"");
    create_keys(&rig.path("lab"), &[], &["late"]);
    let added = format!("{text}late = 'observe'\n");
    fs::write(&file, added).expect("written");
    rig.check("late", "status", 0, "");
    fs::write(&file, "listen = ").expect("written");
    rig.check(
        "alice",
        "status",
        4,
        "until it is corrected, only a stop passes",
    );
    rig.check("alice", "estop", 0, "");
    rig.check("stranger", "estop", 4, "does not list client");
    let log = rig.server.log();
    for part in [
        "display (127.0.0.1",
        "runs \"atas status\"",
        "pendant (127.0.0.1",
        "stops the robot",
        "was refused: the server's configuration does not list",
    ] {
        assert!(log.contains(part), "{part}: {log}");
    }
}
