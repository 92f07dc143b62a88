//! Tests of a cut link: attached goals, stops, and the end of the server.

use std::io::Write;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use system_tests::{lock_exclusive, wait_for};

use super::fixture::*;
use super::parts;

/// Documented bound of an attached goal after a cut: `silence_s` (1 s), two checks of the server
/// (0.25 s), and one clean-up of the daemon (0.25 s), on a busy machine twice.
const BOUND: Duration = Duration::from_secs(3);

/// Documented bound of a stop without confirmation (4 s), on a busy machine 2 s more.
const STOP_BOUND: Duration = Duration::from_secs(6);

/// Waits until the attached goal has ended because of its client, and checks the bound.
fn expect_hold(rig: &RemoteFixture, cut: Instant, case: &str) {
    wait_for("the end of the goal", || {
        (rig.goal()["state"] == "failed").then_some(())
    });
    let took = cut.elapsed();
    assert!(took <= BOUND, "{case}: the goal continued for {took:?}");
    let reason = rig.goal()["reason"].clone();
    assert!(
        reason.to_string().contains("client-gone"),
        "{case}: {reason}"
    );
    // A measured figure of the guide.
    let _ = writeln!(
        std::io::stderr(),
        "{case}: ended {} ms after the cut",
        took.as_millis()
    );
    let released = rig.run("alice", "release");
    assert!(released.status.success(), "{case}: {released:?}");
}

fn end(mut child: Child, signal: Signal) -> Option<i32> {
    kill_process(Pid::from_child(&child), signal).expect("the client runs");
    child.wait().expect("ended").code()
}

#[test]
fn cut_link_holds_attached_goal_within_bound() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    let client = rig.start_goal(&rig.address);
    let cut = Instant::now();
    end(client, Signal::KILL);
    expect_hold(&rig, cut, "killed client");

    let client = rig.start_goal(&rig.address);
    kill_process(Pid::from_child(&client), Signal::STOP).expect("the client runs");
    expect_hold(
        &rig,
        Instant::now() - Duration::from_millis(1),
        "stopped client",
    );
    end(client, Signal::KILL);

    let network = Network::to(&rig.address);
    let mut client = rig.start_goal(&network.address);
    network.cut();
    expect_hold(&rig, Instant::now(), "silent partition");
    assert_eq!(client.wait().expect("ended").code(), Some(3));

    // Ctrl-C cancels, as on the robot's machine.
    let client = rig.start_goal(&rig.address);
    assert_eq!(end(client, Signal::INT), Some(5));
    wait_for("the cancellation", || {
        (rig.goal()["state"] == "cancelled").then_some(())
    });

    // The end of the server is a cut as well.
    rig.run("alice", "release");
    let client = rig.start_goal(&rig.address);
    let mut rig = rig;
    rig.end_server();
    wait_for("the end of the goal", || {
        (rig.goal()["state"] == "failed").then_some(())
    });
    let output = client.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(3));
}

#[test]
fn detached_goal_continues_after_a_cut() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    let line = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 3600";
    let client = rig
        .remote("alice", line)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    wait_for("the goal", || {
        (rig.goal()["state"] == "running").then_some(())
    });
    end(client, Signal::KILL);
    std::thread::sleep(BOUND);
    assert_eq!(rig.goal()["state"], "running");
    rig.check("alice", "cancel", 0, "");
    wait_for("the cancellation", || {
        (rig.goal()["state"] == "cancelled").then_some(())
    });
}

#[test]
fn slow_reader_gets_the_complete_output() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::by_the_clock();
    let mut echo = rig.remote("alice", "topic echo view --count 200 --format json");
    let echo = echo.stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = echo.spawn().expect("it starts");
    // Longer than the longest silence of a client.
    std::thread::sleep(BOUND);
    let (code, out, why) = parts(&child.wait_with_output().expect("ended"));
    assert_eq!(code, Some(0), "{why}");
    assert_eq!(out.lines().count(), 200);
    assert!(
        out.len() > 1_000_000,
        "{} bytes: a pipe holds them",
        out.len()
    );
}

#[test]
fn stops_arrive_while_other_traffic_floods() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::by_the_clock();
    // Two of the floods are not read.
    let lines = ["topic echo view", "topic echo status", "topic echo view"];
    let others = [
        "topic echo world-truth",
        "status --watch",
        "events --follow",
    ];
    let mut floods: Vec<Child> = lines
        .iter()
        .chain(&others)
        .enumerate()
        .map(|(index, line)| {
            let stdout = if index < 2 {
                Stdio::piped()
            } else {
                Stdio::null()
            };
            let mut flood = rig.remote("alice", line);
            flood.stdout(stdout).stderr(Stdio::null());
            flood.spawn().expect("it starts")
        })
        .collect();
    wait_for("the floods", || {
        (rig.server.log().matches(" runs ").count() >= floods.len()).then_some(())
    });
    rig.check("alice", "status", 4, "all connections are in use");
    let mut times = Vec::new();
    for round in 0..100 {
        let begin = Instant::now();
        let (code, out, why) = parts(&rig.run("alice", "estop --format json"));
        assert_eq!(code, Some(0), "stop {round}: {out} {why}");
        assert!(out.contains("\"stopped\""), "stop {round}: {out}");
        times.push(begin.elapsed().as_millis());
    }
    times.sort_unstable();
    let (p50, max) = (times[49], times[99]);
    // A measured figure of the guide.
    let _ = writeln!(
        std::io::stderr(),
        "100 stops in a flood: p50 {p50} ms, max {max} ms"
    );
    // More at once than there are places for stops.
    let at_once: Vec<Child> = (0..20)
        .map(|_| {
            let mut stop = rig.remote("pendant", "estop");
            stop.stdout(Stdio::null()).spawn().expect("it starts")
        })
        .collect();
    for mut stop in at_once {
        assert_eq!(stop.wait().expect("ended").code(), Some(0));
    }
    for flood in &mut floods {
        assert_eq!(
            flood.try_wait().expect("waitable"),
            None,
            "a flood has ended"
        );
    }
    assert_eq!(parts(&rig.run("display", "status")).0, Some(0));
    for flood in &mut floods {
        flood.kill().expect("killed");
        flood.wait().expect("ended");
    }
    wait_for("a free place", || {
        (parts(&rig.run("alice", "status")).0 == Some(0)).then_some(())
    });
}

#[test]
fn unconfirmed_stop_says_so() {
    let _alone = lock_exclusive();
    let mut rig = RemoteFixture::new();
    let check = |rig: &RemoteFixture, address: &str, part: &str| {
        let begin = Instant::now();
        let output = rig.remote_at(address, "alice", "estop").output();
        assert!(begin.elapsed() <= STOP_BOUND, "{:?}", begin.elapsed());
        let (code, _, why) = parts(&output.expect("it starts"));
        assert_eq!(code, Some(3), "{why}");
        for part in ["stop not confirmed", part] {
            assert!(why.contains(part), "{part}: {why}");
        }
    };
    let remedy = "Use the emergency stop of the hardware";
    let network = Network::to(&rig.address);
    rig.check("alice", "estop", 0, "");
    network.cut();
    check(&rig, &network.address, remedy);
    check(&rig, "127.0.0.1:1", "Connection refused");
    // A hung server.
    rig.server.signal(Signal::STOP);
    check(&rig, &rig.address, remedy);
    rig.server.signal(Signal::CONT);
    rig.check("alice", "estop", 0, "");
    // A daemon that does not answer: the text of the local command.
    rig.daemon.signal(Signal::STOP);
    let local = parts(&rig.local("estop"));
    assert_eq!(local, parts(&rig.run("alice", "estop")));
    assert!(local.2.contains("stop not confirmed"), "{local:?}");
    rig.daemon.signal(Signal::CONT);
    rig.server.signal(Signal::KILL);
    rig.server.wait();
    check(&rig, &rig.address, remedy);
}
