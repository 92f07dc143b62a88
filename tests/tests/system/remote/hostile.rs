//! Tests of hostile connections: garbage, wrong lengths, silence, slow senders, floods.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use atas_remote::frame::{CLIENT_MAX, Kind, encode};
use atas_remote::{PROTOCOL, Reply};
use system_tests::{lock_exclusive, wait_for};

use super::fixture::*;

/// Number of threads of the server.
fn threads(rig: &RemoteFixture) -> usize {
    let tasks = std::fs::read_dir(format!("/proc/{}/task", rig.server.pid()));
    tasks.expect("the server runs").count()
}

/// Reads until the server closes.
fn is_closed(mut from: impl Read) -> bool {
    let mut bytes = [0; 4096];
    loop {
        match from.read(&mut bytes) {
            Ok(0) => return true,
            Ok(_) => {}
            Err(error) => return error.kind() != std::io::ErrorKind::WouldBlock,
        }
    }
}

/// Reads the reply of a raw connection.
fn reply(link: &mut RawLink) -> Reply {
    let mut header = [0; 5];
    link.read_exact(&mut header).expect("a header");
    assert_eq!(header[0], Kind::Reply as u8);
    let length = u32::from_be_bytes([header[1], header[2], header[3], header[4]]);
    let mut payload = vec![0; length as usize];
    link.read_exact(&mut payload).expect("a payload");
    serde_json::from_slice(&payload).expect("JSON")
}

#[test]
fn invalid_requests_are_refused_and_closed() {
    let _alone = lock_exclusive();
    let rig = RemoteFixture::new();
    let check = |payload: &str, part: &str| {
        let mut link = rig.raw_request("alice", payload.as_bytes());
        match reply(&mut link) {
            Reply::Refused { reason, .. } => assert!(reason.contains(part), "{part}: {reason}"),
            other => panic!("{part}: {other:?}"),
        }
        assert!(is_closed(link), "{part}");
    };
    check("junk", "the request is invalid");
    check("{\"protocol\":99,\"work\":\"fly\"}", "protocol version 99");
    let run = |words: &str| format!("{{\"protocol\":{PROTOCOL},\"work\":{{\"run\":[{words}]}}}}");
    check(&run("\"status\",\"a\\u0000b\""), "zero byte");
    check(&run("\"fly\""), "the command line is invalid");
    check(&run("\"--help\""), "the command line is invalid");
    let onward = run("\"status\",\"--remote\",\"x\"");
    check(&onward, "does not connect to other machines");
    check(
        &run("\"explain\",\"/etc/shadow\""),
        "runs on this machine only",
    );
    check(
        &run("\"record\",\"--out\",\"/tmp/x.mcap\""),
        "reads or writes files",
    );
    check(&run("\"recordings\",\"fetch\",\"../x.mcap\""), "invalid");
    let folder = run("\"recordings\",\"list\",\"--folder\",\"/etc\"");
    check(&folder, "in the server's configuration");

    // Frames after the handshake.
    let check = |bytes: &[u8]| {
        let mut link = rig.raw(Some(&rig.path("lab/alice")));
        // The server may close before the last byte.
        let _ = link.write_all(bytes).and_then(|()| link.flush());
        assert!(is_closed(link), "{:?}", &bytes[..bytes.len().min(8)]);
    };
    check(&encode(Kind::Request, &vec![b'['; CLIENT_MAX + 1]));
    check(&[2, 0xFF, 0xFF, 0xFF, 0xFF]);
    check(&[0; 16]);
    check(b"GET / HTTP/1.1\r\n\r\n");
    check(&encode(Kind::Stdout, b"text"));
    // A running command ends at an invalid frame.
    let status = run("\"status\",\"--watch\"");
    let mut link = rig.raw_request("alice", status.as_bytes());
    assert!(matches!(reply(&mut link), Reply::Started { .. }));
    link.write_all(&[9, 0, 0, 0, 0]).expect("sent");
    assert!(is_closed(link));
    rig.check("alice", "status", 0, "");
}

#[test]
fn silent_and_slow_connections_do_not_exhaust_the_server() {
    let _alone = lock_exclusive();
    let mut rig = RemoteFixture::new();
    let before = threads(&rig);
    for bytes in [
        &b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n"[..],
        &[0xFF; 4096],
        &[0x16, 3, 1, 0xFF, 0xFF],
    ] {
        let mut socket = rig.socket();
        socket.write_all(bytes).expect("sent");
        drop(socket.shutdown(std::net::Shutdown::Write));
        assert!(is_closed(socket));
    }
    // Half-open connections, and slow senders of a valid beginning, beyond every limit.
    let quiet: Vec<TcpStream> = (0..100).map(|_| rig.socket()).collect();
    let mut slow: Vec<TcpStream> = (0..100).map(|_| rig.socket()).collect();
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_secs(2) {
        for socket in &mut slow {
            // The server has closed most of them.
            let _ = socket.write_all(&[0x16]);
        }
        std::thread::sleep(Duration::from_millis(50));
        assert!(threads(&rig) < before + 50, "{} threads", threads(&rig));
        rig.check("alice", "estop", 0, "");
    }
    rig.check("alice", "status", 0, "");
    for socket in quiet.into_iter().chain(slow) {
        assert!(is_closed(socket), "the server closes silent connections");
    }
    // Clients that are silent after their handshake.
    let silent: Vec<RawLink> = (0..40)
        .map(|_| {
            let mut link = rig.raw(Some(&rig.path("lab/alice")));
            link.flush().expect("sent");
            link
        })
        .collect();
    rig.check("alice", "status", 0, "");
    drop(silent);
    wait_for("the end of all connections", || {
        (threads(&rig) <= before).then_some(())
    });

    let waiting: Vec<TcpStream> = (0..10).map(|_| rig.socket()).collect();
    rig.end_server();
    drop(waiting);
}
