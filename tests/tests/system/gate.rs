//! Tests of the gate with real processes of several users: the service user, members of its group,
//! a stranger, and hostile clients.
//!
//! The users need no accounts: `setpriv` (util-linux) starts a process with any user id, which
//! requires root.

mod fixture;

use std::fs::{self, File};
use std::io::{IoSlice, Read};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::chown;
use std::process::{Child, Stdio};

use atas_gate::message::{self, PACKET_MAX, Reply, Request};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags, send, sendmsg};
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::LocalModes;
use serde_json::Value;
use shm_bus::BusName;
use system_tests::terminal::Terminal;
use system_tests::{lock_exclusive, wait_for};

use fixture::*;

/// A short grasp that waits for its result.
const GRASP: [&str; 7] = [
    "grasp",
    "--at",
    "0.32,-0.15,0.0345",
    "--width",
    "50",
    "--hold",
    "0.05",
];

#[test]
fn member_has_the_configured_rights() {
    let _alone = lock_exclusive();
    let Some(house) = GateFixture::new() else {
        return;
    };
    let mode = |house: &GateFixture| house.json(MEMBER, &["status"])["mode"].clone();
    // Every group member may observe; other users may not.
    wait_for("the start", || (mode(&house) == "ready").then_some(()));
    house.check(
        STRANGER,
        &["status"],
        3,
        &format!("not in group {SERVICE}; run `sudo usermod -aG"),
    );
    house.check(STRANGER, &["estop"], 3, "not in group");
    assert!(house.json(MEMBER, &["topic", "list"]).is_object());
    assert_eq!(
        house.json(MEMBER, &["param", "get", "grasp.dr_n"])["name"],
        "grasp.dr_n"
    );

    let needs = "access.group is \"observe\", needs \"command\"";
    house.check(MEMBER, &GRASP, 4, needs);
    house.check(MEMBER, &["cancel"], 4, needs);
    house.check(MEMBER, &["param", "set", "grasp.dr_n", "0.1"], 4, needs);
    house.check(MEMBER, &["recover"], 4, needs);
    let refused = house.run(MEMBER, &["recover", "--format", "json"]);
    let printed: Value = serde_json::from_slice(&refused.stderr).expect("JSON");
    assert_eq!(printed["exit"], 4);

    // Every group member may stop.
    house.check(MEMBER, &["estop"], 0, "");
    house.set_group_access("command");
    wait_for("the stop", || (mode(&house) == "safe-stop").then_some(()));
    house.check(MEMBER, &["recover"], 0, "");
    wait_for("the recovery", || (mode(&house) == "ready").then_some(()));
    assert_eq!(house.json(MEMBER, &GRASP)["state"], "succeeded");
    assert_eq!(
        house.json(MEMBER, &["explain", "last"])["state"],
        "succeeded"
    );
    house.check(
        MEMBER,
        &["grasp", "--at", "9,9,9", "--width", "50"],
        4,
        "atas:",
    );

    // Commands that use files or the network are reserved for the bus's user. Commands without a
    // bus run as the caller.
    let files = "reads or writes files";
    house.check(MEMBER, &["record"], 3, files);
    house.check(MEMBER, &["teleop", "targets.csv"], 3, files);
    house.check(
        MEMBER,
        &["explain", "last", "--out", "/tmp/why.svg"],
        3,
        files,
    );
    house.check(MEMBER, &["dashboard"], 3, "opens a port");
    house.check(MEMBER, &["robot", "list"], 0, "");
    // A user may create a private bus while other buses exist.
    let mine = house.folder.path().join("mine");
    fs::create_dir(&mine).expect("made");
    chown(&mine, Some(MEMBER), None).expect("the member's");
    let tape = mine.join("run.mcap");
    let own = BusName::fresh("own");
    let words = [
        "record",
        "--bus",
        own.as_str(),
        "--out",
        tape.to_str().expect("UTF-8"),
    ];
    let mut recorder = house.atas(MEMBER, &words).spawn().expect("it starts");
    wait_for("the recorder", || tape.exists().then_some(()));
    recorder.kill().expect("killed");
    recorder.wait().expect("ended");
    house.check(
        MEMBER,
        &["status", "--bus", "no-such-bus"],
        3,
        "no-such-bus",
    );

    let doctor = |user: u32| {
        let output = house.run(user, &["doctor", "--format", "json"]);
        let findings: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let mut findings = findings.as_array().expect("a list").clone().into_iter();
        let found = findings
            .find(|finding| finding["probe"] == "bus")
            .expect("a finding about the bus");
        found["what_to_do"].as_str().expect("text").to_owned()
    };
    assert!(
        doctor(MEMBER).contains("may use its gate"),
        "{}",
        doctor(MEMBER)
    );
    assert!(
        doctor(STRANGER).contains("not in group"),
        "{}",
        doctor(STRANGER)
    );

    house.set_group_access("none");
    house.check(
        MEMBER,
        &["status"],
        4,
        "access.group is \"none\", needs \"observe\"",
    );
    house.check(MEMBER, &["estop"], 4, "access.group is \"none\"");
    fs::write(house.config(), "access.group = ").expect("written");
    house.check(MEMBER, &["status"], 4, "atas.toml: is not TOML");
    house.check(MEMBER, &["estop"], 0, "");

    let log = house.log();
    for part in [
        &format!("uid {MEMBER} may observe: \"atas status"),
        &format!("uid {MEMBER} may stop: \"atas estop"),
        &format!("uid {MEMBER} may command: \"atas grasp"),
        &format!("uid {MEMBER} was refused"),
    ] {
        assert!(log.contains(part), "{part}: {log}");
    }
}

#[test]
fn terminal_works_through_gate_and_is_restored() {
    let _alone = lock_exclusive();
    let Some(house) = GateFixture::new() else {
        return;
    };
    let terminal = Terminal::from_command(house.atas(MEMBER, &["top"]));
    terminal.wait_for("READY");
    assert!(terminal.has_written("\x1b[38;5;"), "colours on a terminal");
    // Path of the signal: terminal, client, gate, command.
    terminal.resize(12, 60);
    kill_process(terminal.pid(), Signal::WINCH).expect("the client runs");
    terminal.wait_for("needs 80 × 24 characters, has 60 × 12");
    terminal.resize(40, 120);
    kill_process(terminal.pid(), Signal::WINCH).expect("the client runs");
    terminal.wait_for("READY");
    terminal.quit();

    let mut plain = house.atas(MEMBER, &["top"]);
    plain.env("NO_COLOR", "yes");
    let plain = Terminal::from_command(plain);
    plain.wait_for("READY");
    assert!(
        !plain.has_written("\x1b[38;5;"),
        "no colours under NO_COLOR"
    );
    plain.quit();

    let mut cut = Terminal::from_command(house.atas(MEMBER, &["top"]));
    cut.wait_for("READY");
    assert!(
        !cut.modes().contains(LocalModes::ICANON),
        "raw mode while the program runs"
    );
    for visit in house.running("--visit") {
        // Another visit process may just have ended.
        let _ = kill_process(visit, Signal::KILL);
    }
    assert_eq!(cut.exit_code(), Some(3));
    cut.wait_for("lost the connection to the gate");
    assert!(
        cut.modes().contains(LocalModes::ICANON),
        "terminal modes are restored"
    );
    wait_for("the command's end", || {
        house.running("top").is_empty().then_some(())
    });
}

#[test]
fn signals_and_client_death_reach_the_command() {
    let _alone = lock_exclusive();
    let Some(mut house) = GateFixture::new() else {
        return;
    };
    let watch = |house: &GateFixture| {
        let mut child = house
            .atas(MEMBER, &["status", "--watch"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let mut first = [0; 1];
        let out = child.stdout.as_mut().expect("a pipe");
        out.read_exact(&mut first).expect("the command writes");
        child
    };
    let nobody_left = |house: &GateFixture| {
        wait_for("the command's end", || {
            house.running("--watch").is_empty().then_some(())
        });
    };
    // Ctrl-C ends a watching command regularly.
    let ends = |signal: Signal| {
        let mut child = watch(&house);
        kill_process(Pid::from_child(&child), signal).expect("the client runs");
        // The client forwards the remaining output, then ends.
        let mut rest = Vec::new();
        child
            .stdout
            .take()
            .expect("a pipe")
            .read_to_end(&mut rest)
            .expect("read");
        child.wait().expect("ended").code()
    };
    let alone_ends = house.running("--watch").is_empty();
    assert!(alone_ends, "no other watching command runs");
    let code = ends(Signal::INT);
    assert!(matches!(code, Some(0 | 5)), "{code:?}");
    nobody_left(&house);
    assert_eq!(ends(Signal::TERM), code);
    nobody_left(&house);
    assert_eq!(ends(Signal::KILL), None);
    nobody_left(&house);

    // Commands survive the death of the gate; the next gate serves waiting connections.
    let mut inside = watch(&house);
    house.kill_gate();
    let mut waiting = house
        .atas(MEMBER, &["status"])
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    house.start_gate();
    assert_eq!(waiting.wait().expect("ended").code(), Some(0));
    let mut more = [0; 64];
    inside
        .stdout
        .as_mut()
        .expect("a pipe")
        .read_exact(&mut more)
        .expect("the command continues");
    kill_process(Pid::from_child(&inside), Signal::INT).expect("the client runs");
    drop(inside.stdout.take());
    inside.wait().expect("ended");

    // The error names the daemon after it was killed.
    drop(house.daemon.take());
    house.check(MEMBER, &["status"], 3, "atasd");
    house.daemon = Some(daemon(&house.programs, &house.bus));
    wait_for("the daemon again", || {
        (house.code(MEMBER, &["status"]) == 0).then_some(())
    });
    // Without the gate's socket, the error names the unit to enable.
    fs::remove_file(house.socket()).expect("removed");
    house.check(
        MEMBER,
        &["status"],
        3,
        "systemctl enable --now atas-gate.socket",
    );
    house.check(
        MEMBER,
        &["estop"],
        3,
        "systemctl enable --now atas-gate.socket",
    );
}

#[test]
fn many_clients_and_hung_client_are_tolerated() {
    let _alone = lock_exclusive();
    let Some(house) = GateFixture::new() else {
        return;
    };
    let start = |user: u32, arguments: &[&str]| {
        house
            .atas(user, arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    // A client whose output is not read.
    let mut hanging = start(OTHER_MEMBER, &["topic", "echo", "view"]);
    let crowd: Vec<Child> = (0..20).map(|_| start(MEMBER, &["status"])).collect();
    for mut child in crowd {
        assert_eq!(child.wait().expect("ended").code(), Some(0));
    }
    // A user with the maximum number of commands may only stop; other users are not affected.
    let mut greedy: Vec<Child> = (0..6)
        .map(|_| start(MEMBER, &["status", "--watch"]))
        .collect();
    for child in &mut greedy {
        let mut first = [0; 1];
        let out = child.stdout.as_mut().expect("a pipe");
        if let Err(error) = out.read_exact(&mut first) {
            let mut printed = String::new();
            let errors = child.stderr.as_mut().expect("a pipe");
            errors.read_to_string(&mut printed).expect("UTF-8");
            panic!("the command writes nothing: {error}: {printed}");
        }
    }
    house.check(
        MEMBER,
        &["status"],
        4,
        "runs 6 commands through the gate already",
    );
    house.check(OTHER_MEMBER, &["status"], 0, "");
    // A waiting command gets the slot that becomes free, although its earlier attempts were
    // counted.
    let mut waiting = start(MEMBER, &["status"]);
    wait_for("a rejected attempt", || {
        (!house.running("--full").is_empty()).then_some(())
    });
    let mut gone = greedy.pop().expect("six");
    gone.kill().expect("killed");
    gone.wait().expect("ended");
    assert_eq!(waiting.wait().expect("ended").code(), Some(0));
    // Silent connections occupy the reserved slots for a while; the stop is still accepted.
    house.check(MEMBER, &["estop"], 0, "");
    for child in greedy.iter_mut().chain([&mut hanging]) {
        child.kill().expect("killed");
        child.wait().expect("ended");
    }
    wait_for("a free slot", || {
        (house.code(MEMBER, &["status"]) == 0).then_some(())
    });
}

#[test]
fn hostile_requests_are_rejected_and_closed() {
    let _alone = lock_exclusive();
    let Some(house) = GateFixture::new() else {
        return;
    };
    let null = File::options()
        .read(true)
        .write(true)
        .open("/dev/null")
        .expect("opened");
    let disk = File::open("/").expect("opened");
    let request = |arguments: &[&str], environment: &[(&str, &str)]| Request {
        arguments: arguments.iter().map(|word| (*word).to_owned()).collect(),
        environment: environment
            .iter()
            .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()))
            .collect(),
    };
    let printed = |socket: &OwnedFd, part: &str| {
        match receive_reply(socket) {
            Some(Reply::Refused(why)) => assert!(why.contains(part), "{part}: {why}"),
            other => panic!("{part}: {other:?}"),
        }
        assert_eq!(receive_reply(socket), None, "{part}: closed");
    };
    let check_packet = |packet: &[u8], descriptors: &[BorrowedFd<'_>], part: &str| {
        let socket = house.connect_as_root();
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(8))];
        let mut control = SendAncillaryBuffer::new(&mut space);
        if !descriptors.is_empty() {
            control.push(SendAncillaryMessage::ScmRights(descriptors));
        }
        sendmsg(
            &socket,
            &[IoSlice::new(packet)],
            &mut control,
            SendFlags::NOSIGNAL,
        )
        .expect("sent");
        printed(&socket, part);
    };
    let status = serde_json::to_vec(&request(&["status"], &[])).expect("JSON");
    let three = [null.as_fd(), null.as_fd(), null.as_fd()];
    check_packet(b"\xff\0junk", &three, "the request is invalid");
    check_packet(
        &status[..status.len() / 2],
        &three,
        "the request is invalid",
    );
    check_packet(&vec![b'['; PACKET_MAX], &three, "the request is invalid");
    check_packet(&vec![b'a'; PACKET_MAX + 1], &three, "longer than");
    check_packet(
        b"{\"arguments\":[\"status\"],\"environment\":[],\"cwd\":\"/tmp\"}",
        &three,
        "the request is invalid",
    );
    check_packet(&status, &[], "0 descriptors, needs 3");
    check_packet(&status, &three[..2], "2 descriptors, needs 3");
    check_packet(&status, &[three[0]; 8], "more than 3 descriptors");

    let check = |arguments: &[&str], environment: &[(&str, &str)], part: &str| {
        let socket = house.connect_as_root();
        message::send_request(&socket, &request(arguments, environment), three).expect("sent");
        printed(&socket, part);
    };
    check(
        &["status"],
        &[("LD_PRELOAD", "/tmp/x.so")],
        "environment variable \"LD_PRELOAD\"",
    );
    check(
        &["status"],
        &[("TERM", "../../tmp/x")],
        "environment variable \"TERM\"",
    );
    check(
        &["status"],
        &[("ATAS_BUS", "a/b")],
        "environment variable \"ATAS_BUS\"",
    );
    check(&["status", "a\0b"], &[], "zero byte");
    check(
        &["status", "--bus", "../x"],
        &[],
        "the command line is invalid",
    );
    check(&["fly"], &[], "the command line is invalid");
    check(&[], &[], "the command line is invalid");
    check(&["--help"], &[], "the command line is invalid");
    check(&["man", "/tmp/x"], &[], "does not need another user's bus");
    check(&["demo", "grasp"], &[], "does not need another user's bus");
    check(
        &["record", "--out", "/tmp/x.mcap"],
        &[],
        "reads or writes files",
    );
    check(
        &["explain", "last", "--out", "/tmp/x.svg"],
        &[],
        "reads or writes files",
    );
    check(
        &["explain", "/etc/shadow"],
        &[],
        "does not need another user's bus",
    );
    check(
        &["dashboard", "--robot", "/etc/shadow"],
        &[],
        "opens a port",
    );
    let socket = house.connect_as_root();
    message::send_request(
        &socket,
        &request(&["status"], &[]),
        [null.as_fd(), disk.as_fd(), null.as_fd()],
    )
    .expect("sent");
    printed(&socket, "a standard stream is Directory");
    // A request of one megabyte exceeds the socket's packet size.
    let megabyte = "a".repeat(1 << 20);
    let error = message::send_request(house.connect_as_root(), &request(&[&megabyte], &[]), three)
        .expect_err("too long");
    assert_eq!(error.kind(), std::io::ErrorKind::ArgumentListTooLong);

    // The gate closes silent connections. An invalid signal number ends the command.
    let silent = house.connect_as_root();
    let mute = house.connect_as_root();
    let socket = house.connect_as_root();
    let watch = request(&["status", "--watch"], &[("ATAS_BUS", house.bus.as_str())]);
    message::send_request(&socket, &watch, three).expect("sent");
    assert_eq!(receive_reply(&socket), Some(Reply::Started));
    send(&socket, b"\x09", SendFlags::NOSIGNAL).expect("sent");
    assert_eq!(receive_reply(&socket), Some(Reply::Killed(9)));
    assert_eq!((receive_reply(&silent), receive_reply(&mute)), (None, None));
    // Unsafe environment variables of the caller are dropped.
    let mut loaded = house.atas(MEMBER, &["status"]);
    loaded
        .env("LANG", "/tmp/x")
        .env("RUST_LOG", "trace")
        .env("HOME", "/root");
    let output = loaded.output().expect("it starts");
    assert!(output.status.success(), "{output:?}");
    assert!(house.running("--visit").is_empty() || house.code(MEMBER, &["status"]) == 0);
}
