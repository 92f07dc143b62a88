//! The gate with real processes of real users: a service, members of its group, a stranger, and visitors who mean harm.
//!
//! Users need no accounts: `setpriv` (util-linux) starts a process as any number, which only root may.

mod house;

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
use system_tests::{alone, wait_for};

use house::*;

/// Asked until it has an answer.
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
fn a_member_does_what_the_configuration_lets_it() {
    let _alone = alone();
    let Some(house) = House::new() else { return };
    let mode = |house: &House| house.json(MEMBER, &["status"])["mode"].clone();
    // Looking on is everybody's in the group, and nobody's outside.
    wait_for("the start", || (mode(&house) == "ready").then_some(()));
    house.check(
        STRANGER,
        &["status"],
        3,
        &format!("not in group {SERVICE}: `sudo usermod -aG"),
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
    let told: Value = serde_json::from_slice(&refused.stderr).expect("JSON");
    assert_eq!(told["exit"], 4);

    // Whatever may be stopped may be stopped by anyone of the group.
    house.check(MEMBER, &["estop"], 0, "");
    house.allow("command");
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

    // What touches files or the network stays the bus's user's; what needs no bus is the caller's.
    let files = "reads or writes files of its own";
    house.check(MEMBER, &["record"], 3, files);
    house.check(MEMBER, &["follow", "targets.csv"], 3, files);
    house.check(
        MEMBER,
        &["explain", "last", "--out", "/tmp/why.svg"],
        3,
        files,
    );
    house.check(MEMBER, &["dashboard"], 3, "opens a port");
    house.check(MEMBER, &["robot", "list"], 0, "");
    // A bus that nobody has may be made, whatever others there are.
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
            .expect("asked");
        found["what_to_do"].as_str().expect("text").to_owned()
    };
    assert!(doctor(MEMBER).contains("may knock"), "{}", doctor(MEMBER));
    assert!(
        doctor(STRANGER).contains("not in group"),
        "{}",
        doctor(STRANGER)
    );

    house.allow("none");
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
fn a_terminal_is_drawn_on_through_the_gate_and_given_back() {
    let _alone = alone();
    let Some(house) = House::new() else { return };
    let terminal = Terminal::with(house.atas(MEMBER, &["top"]));
    terminal.wait_for("READY");
    assert!(terminal.has_written("\x1b[38;5;"), "colours on a terminal");
    // The terminal tells the caller, the caller the gate, the gate the command.
    terminal.resize(12, 60);
    kill_process(terminal.pid(), Signal::WINCH).expect("it lives");
    terminal.wait_for("needs 80 × 24 characters, has 60 × 12");
    terminal.resize(40, 120);
    kill_process(terminal.pid(), Signal::WINCH).expect("it lives");
    terminal.wait_for("READY");
    terminal.quit();

    let mut plain = house.atas(MEMBER, &["top"]);
    plain.env("NO_COLOR", "yes");
    let plain = Terminal::with(plain);
    plain.wait_for("READY");
    assert!(
        !plain.has_written("\x1b[38;5;"),
        "no colours under NO_COLOR"
    );
    plain.quit();

    let mut cut = Terminal::with(house.atas(MEMBER, &["top"]));
    cut.wait_for("READY");
    assert!(
        !cut.modes().contains(LocalModes::ICANON),
        "keys are read one by one"
    );
    for visit in house.running("--visit") {
        // Another visit may just have ended.
        let _ = kill_process(visit, Signal::KILL);
    }
    assert_eq!(cut.code(), Some(3));
    cut.wait_for("the gate is gone");
    assert!(cut.modes().contains(LocalModes::ICANON), "as it was");
    wait_for("the command's end", || {
        house.running("top").is_empty().then_some(())
    });
}

#[test]
fn signals_reach_the_command_and_death_takes_it_along() {
    let _alone = alone();
    let Some(mut house) = House::new() else {
        return;
    };
    let watch = |house: &House| {
        let mut child = house
            .atas(MEMBER, &["status", "--watch"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        let mut first = [0; 1];
        let out = child.stdout.as_mut().expect("a pipe");
        out.read_exact(&mut first).expect("it speaks");
        child
    };
    let nobody_left = |house: &House| {
        wait_for("the command's end", || {
            house.running("--watch").is_empty().then_some(())
        });
    };
    // Ctrl-C at a watch is its way to end.
    let ends = |signal: Signal| {
        let mut child = watch(&house);
        kill_process(Pid::from_child(&child), signal).expect("it lives");
        // What it still says is heard, and then its end.
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
    assert!(alone_ends, "nothing watches yet");
    let code = ends(Signal::INT);
    assert!(matches!(code, Some(0 | 5)), "{code:?}");
    nobody_left(&house);
    assert_eq!(ends(Signal::TERM), code);
    nobody_left(&house);
    assert_eq!(ends(Signal::KILL), None);
    nobody_left(&house);

    // A gate that is killed leaves those inside alone; whoever knocks meanwhile is served by the next.
    let mut inside = watch(&house);
    house.close();
    let mut waiting = house
        .atas(MEMBER, &["status"])
        .stdout(Stdio::null())
        .spawn()
        .expect("it starts");
    house.open();
    assert_eq!(waiting.wait().expect("ended").code(), Some(0));
    let mut more = [0; 64];
    inside
        .stdout
        .as_mut()
        .expect("a pipe")
        .read_exact(&mut more)
        .expect("it goes on");
    kill_process(Pid::from_child(&inside), Signal::INT).expect("it lives");
    drop(inside.stdout.take());
    inside.wait().expect("ended");

    // A daemon that is killed is told as ever.
    drop(house.daemon.take());
    house.check(MEMBER, &["status"], 3, "atasd");
    house.daemon = Some(daemon(&house.programs, &house.bus));
    wait_for("the daemon again", || {
        (house.code(MEMBER, &["status"]) == 0).then_some(())
    });
    // And without a gate it is said what is missing.
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
fn a_crowd_and_one_that_hangs_do_no_harm() {
    let _alone = alone();
    let Some(house) = House::new() else { return };
    let start = |user: u32, arguments: &[&str]| {
        house
            .atas(user, arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    // Nobody reads what it says.
    let mut hanging = start(OTHER_MEMBER, &["topic", "echo", "view"]);
    let crowd: Vec<Child> = (0..20).map(|_| start(MEMBER, &["status"])).collect();
    for mut child in crowd {
        assert_eq!(child.wait().expect("ended").code(), Some(0));
    }
    // One user who takes all places has none left, but for a stop; another one has.
    let mut greedy: Vec<Child> = (0..6)
        .map(|_| start(MEMBER, &["status", "--watch"]))
        .collect();
    for child in &mut greedy {
        let mut first = [0; 1];
        let out = child.stdout.as_mut().expect("a pipe");
        if let Err(error) = out.read_exact(&mut first) {
            let mut told = String::new();
            let errors = child.stderr.as_mut().expect("a pipe");
            errors.read_to_string(&mut told).expect("UTF-8");
            panic!("it does not speak: {error}: {told}");
        }
    }
    house.check(
        MEMBER,
        &["status"],
        4,
        "runs 6 commands through the gate already",
    );
    house.check(OTHER_MEMBER, &["status"], 0, "");
    // Who waits gets the place that becomes free, although its own earlier knocks were counted.
    let mut waiting = start(MEMBER, &["status"]);
    wait_for("a knock in vain", || {
        (!house.running("--full").is_empty()).then_some(())
    });
    let mut gone = greedy.pop().expect("six");
    gone.kill().expect("killed");
    gone.wait().expect("ended");
    assert_eq!(waiting.wait().expect("ended").code(), Some(0));
    // Visitors who say nothing take the places beyond for a while, and the stop gets through all the same.
    house.check(MEMBER, &["estop"], 0, "");
    for child in greedy.iter_mut().chain([&mut hanging]) {
        child.kill().expect("killed");
        child.wait().expect("ended");
    }
    wait_for("room again", || {
        (house.code(MEMBER, &["status"]) == 0).then_some(())
    });
}

#[test]
fn what_is_hostile_is_answered_once_and_closed() {
    let _alone = alone();
    let Some(house) = House::new() else { return };
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
    let told = |socket: &OwnedFd, part: &str| {
        match hear(socket) {
            Some(Reply::Refused(why)) => assert!(why.contains(part), "{part}: {why}"),
            other => panic!("{part}: {other:?}"),
        }
        assert_eq!(hear(socket), None, "{part}: closed");
    };
    let check_packet = |packet: &[u8], descriptors: &[BorrowedFd<'_>], part: &str| {
        let socket = house.knock();
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
        told(&socket, part);
    };
    let status = serde_json::to_vec(&request(&["status"], &[])).expect("JSON");
    let three = [null.as_fd(), null.as_fd(), null.as_fd()];
    check_packet(b"\xff\0junk", &three, "cannot be read");
    check_packet(&status[..status.len() / 2], &three, "cannot be read");
    check_packet(&vec![b'['; PACKET_MAX], &three, "cannot be read");
    check_packet(&vec![b'a'; PACKET_MAX + 1], &three, "longer than");
    check_packet(
        b"{\"arguments\":[\"status\"],\"environment\":[],\"cwd\":\"/tmp\"}",
        &three,
        "cannot be read",
    );
    check_packet(&status, &[], "0 descriptors, needs 3");
    check_packet(&status, &three[..2], "2 descriptors, needs 3");
    check_packet(&status, &[three[0]; 8], "more than 3 descriptors");

    let check = |arguments: &[&str], environment: &[(&str, &str)], part: &str| {
        let socket = house.knock();
        message::ask(&socket, &request(arguments, environment), three).expect("sent");
        told(&socket, part);
    };
    check(
        &["status"],
        &[("LD_PRELOAD", "/tmp/x.so")],
        "\"LD_PRELOAD\" of the environment",
    );
    check(
        &["status"],
        &[("TERM", "../../tmp/x")],
        "\"TERM\" of the environment",
    );
    check(
        &["status"],
        &[("ATAS_BUS", "a/b")],
        "\"ATAS_BUS\" of the environment",
    );
    check(&["status", "a\0b"], &[], "zero byte");
    check(&["status", "--bus", "../x"], &[], "none that it knows");
    check(&["fly"], &[], "none that it knows");
    check(&[], &[], "none that it knows");
    check(&["--help"], &[], "none that it knows");
    check(&["man", "/tmp/x"], &[], "needs nobody else's bus");
    check(&["demo", "grasp"], &[], "needs nobody else's bus");
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
    check(&["explain", "/etc/shadow"], &[], "needs nobody else's bus");
    check(
        &["dashboard", "--robot", "/etc/shadow"],
        &[],
        "opens a port",
    );
    let socket = house.knock();
    message::ask(
        &socket,
        &request(&["status"], &[]),
        [null.as_fd(), disk.as_fd(), null.as_fd()],
    )
    .expect("sent");
    told(&socket, "a standard stream is Directory");
    // A megabyte does not even fit the socket.
    let megabyte = "a".repeat(1 << 20);
    let error =
        message::ask(house.knock(), &request(&[&megabyte], &[]), three).expect_err("too long");
    assert_eq!(error.kind(), std::io::ErrorKind::ArgumentListTooLong);

    // Silence is ended by the gate, and what is no signal ends the command.
    let silent = house.knock();
    let mute = house.knock();
    let socket = house.knock();
    let watch = request(&["status", "--watch"], &[("ATAS_BUS", house.bus.as_str())]);
    message::ask(&socket, &watch, three).expect("sent");
    assert_eq!(hear(&socket), Some(Reply::Started));
    send(&socket, b"\x09", SendFlags::NOSIGNAL).expect("sent");
    assert_eq!(hear(&socket), Some(Reply::Killed(9)));
    assert_eq!((hear(&silent), hear(&mute)), (None, None));
    // A caller whose environment could do harm is served without it.
    let mut loaded = house.atas(MEMBER, &["status"]);
    loaded
        .env("LANG", "/tmp/x")
        .env("RUST_LOG", "trace")
        .env("HOME", "/root");
    let output = loaded.output().expect("it starts");
    assert!(output.status.success(), "{output:?}");
    assert!(house.running("--visit").is_empty() || house.code(MEMBER, &["status"]) == 0);
}
