//! Requests over sockets: dashboard, Foxglove viewers, the gate, other machines.

use atas_gate::message::Request;
use atas_live::requests::{Dashboard, is_admitted};
use atas_remote::frame::{CLIENT_MAX, Decoder, Kind, encode};
use foxglove::ws_protocol::client::ClientMessage;

use crate::target::Target;

/// Targets of this file.
pub(crate) const TARGETS: [Target; 5] = [
    Target::new("dashboard", dashboard, dashboard_seeds),
    Target::new("foxglove-head", foxglove_head, foxglove_head_seeds),
    Target::new("foxglove-message", foxglove_message, foxglove_message_seeds),
    Target::new("gate-request", gate_request, gate_seeds).executions(200),
    Target::new("remote-frames", remote_frames, remote_seeds),
];

fn dashboard(bytes: &[u8]) {
    thread_local! {
        static DASHBOARD: Dashboard = Dashboard::new().expect("a server");
    }
    let answer = DASHBOARD.with(|dashboard| dashboard.answer(bytes));
    let answer = answer.expect("an end of the connection");
    let is_served = bytes.starts_with(b"GET / HTTP/1.1\r\nHost: 127.0.0.1:8470\r\n\r\n");
    assert!(
        !is_served || answer.starts_with(b"HTTP/1.1 200"),
        "no answer"
    );
}

fn dashboard_seeds() -> Vec<Vec<u8>> {
    let ours = "Host: 127.0.0.1:8470\r\n";
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let mut seeds: Vec<Vec<u8>> = [
        "/",
        "/scene.json",
        "/recording.json",
        "/pictures/3/5",
        "/flight/7",
        "/none",
    ]
    .map(|path| format!("GET {path} HTTP/1.1\r\n{ours}\r\n").into_bytes())
    .to_vec();
    for path in ["/stop", "/recover"] {
        let head = format!(
            "POST {path} HTTP/1.1\r\n{ours}Origin: http://127.0.0.1:8470\r\nAuthorization: Bearer 00112233445566778899aabbccddeeff\r\n"
        );
        seeds.push(format!("{head}Content-Length: 2\r\n\r\n{{}}").into_bytes());
        seeds.push(
            format!("{head}Transfer-Encoding: chunked\r\n\r\n2\r\nab\r\n0\r\n\r\n").into_bytes(),
        );
    }
    let mut socket = format!("GET /feed HTTP/1.1\r\n{ours}{upgrade}\r\n").into_bytes();
    seeds.push(socket.clone());
    // A masked text, a ping and a close.
    socket.extend([
        0x81,
        0x82,
        1,
        2,
        3,
        4,
        b'a' ^ 1,
        b'b' ^ 2,
        0x89,
        0x80,
        0,
        0,
        0,
        0,
        0x88,
        0x80,
        0,
        0,
        0,
        0,
    ]);
    seeds.push(socket);
    seeds.push(seeds.concat());
    seeds
}

fn foxglove_head(bytes: &[u8]) {
    let _admitted = is_admitted(bytes).expect("random bytes");
}

fn foxglove_head_seeds() -> Vec<Vec<u8>> {
    [
        "GET / HTTP/1.1\r\nHost: localhost:8470\r\nOrigin: https://app.foxglove.dev\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: 127.0.0.1:8470\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\nUpgrade: websocket\r\n\r\nrest",
        "GET / HTTP/1.1\r\nHost: localhost:8470\r\nOrigin: http://localhost:8080\r\n\r\n",
    ]
    .map(|head| head.as_bytes().to_vec())
    .to_vec()
}

/// Messages of viewers, which the library parses.
fn foxglove_message(bytes: &[u8]) {
    let _binary = ClientMessage::parse_binary(bytes);
    let _text = ClientMessage::parse_json(&String::from_utf8_lossy(bytes));
}

fn foxglove_message_seeds() -> Vec<Vec<u8>> {
    let mut seeds: Vec<Vec<u8>> = [
        r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]}"#,
        r#"{"op":"unsubscribe","subscriptionIds":[0,1]}"#,
        r#"{"op":"advertise","channels":[{"id":1,"topic":"/t","encoding":"json","schemaName":"s","schema":"{}"}]}"#,
        r#"{"op":"getParameters","parameterNames":["a"],"id":"r"}"#,
        r#"{"op":"setParameters","parameters":[{"name":"a","value":[1,2]}],"id":"r"}"#,
        r#"{"op":"fetchAsset","uri":"package://x","requestId":1}"#,
        r#"{"op":"subscribeConnectionGraph"}"#,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec();
    seeds.push([&[1, 1, 0, 0, 0][..], b"data"].concat());
    seeds.push([&[2, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0][..], b"jsondata"].concat());
    seeds.push([&[3, 0][..], &[0; 24]].concat());
    seeds
}

/// Request of a member of the group: never a right beyond those of the command.
fn gate_request(bytes: &[u8]) {
    if let Ok(request) = Request::parse(bytes) {
        let _right = request.right();
        for (name, value) in &request.environment {
            let _permitted = Request::is_permitted(name, value);
        }
    }
}

fn gate_seeds() -> Vec<Vec<u8>> {
    [
        r#"{"arguments":["status"],"environment":[["TERM","xterm"],["ATAS_BUS","left-arm"]]}"#,
        r#"{"arguments":["estop","--reason","x"],"environment":[]}"#,
        r#"{"arguments":["grasp","--object","wood","--hand","right"],"environment":[]}"#,
        r#"{"arguments":["param","set","grasp.dr_n","0.1","--format","json"],"environment":[["LANG","C.UTF-8"]]}"#,
    ]
    .map(|request| request.as_bytes().to_vec())
    .to_vec()
}

/// Frames of a client with a certificate, in pieces of seven bytes: the waiting data stay bounded.
fn remote_frames(bytes: &[u8]) {
    let mut decoder = Decoder::new(CLIENT_MAX);
    for piece in bytes.chunks(7) {
        assert!(decoder.has_space(), "waiting data beyond one frame");
        decoder.push(piece);
        loop {
            match decoder.next_frame() {
                Ok(Some(frame)) => {
                    let _request = atas_remote::Request::parse(&frame.payload);
                }
                Ok(None) => break,
                Err(_) => return,
            }
        }
    }
}

fn remote_seeds() -> Vec<Vec<u8>> {
    let run = br#"{"protocol":1,"work":{"run":["status","--format","json"]}}"#;
    let check = br#"{"protocol":1,"work":"check"}"#;
    let end = [encode(Kind::Interrupt, &[]), encode(Kind::Alive, &[])].concat();
    vec![
        [encode(Kind::Request, run), end].concat(),
        [encode(Kind::Request, check), encode(Kind::Echo, &[0, 1])].concat(),
        encode(Kind::Request, &vec![b'['; CLIENT_MAX + 1]),
    ]
}
