//! Tests of `atas foxglove`: the WebSocket messages contain the values of the bus, also after a
//! restart of the daemon.
//!
//! The viewer implements Foxglove's specification (`foxglove.sdk.v1`) directly, so the server's
//! library does not verify itself.

use std::collections::{BTreeMap, BTreeSet};
use std::net::TcpStream;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::{Value, json};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Hand, TickReport, service};
use system_tests::{Process, lock_exclusive, wait_for};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{HandshakeError, Message, WebSocket};

/// Compared topics: a scalar of the tick and the joint states.
const NORMAL: &str = "/right/finger1/normal";
const JOINTS: &str = "/joint_states";
/// Compared messages per topic.
const COMPARED: usize = 50;

/// A connected viewer.
struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Channels by topic: id and schema name.
    channels: BTreeMap<String, (u64, String)>,
}

impl Viewer {
    fn connect(port: u64) -> Self {
        let stream =
            TcpStream::connect(("127.0.0.1", port as u16)).expect("the server accepts connections");
        stream
            .set_read_timeout(Some(Duration::from_secs(30)))
            .expect("a timeout");
        let mut request = format!("ws://127.0.0.1:{port}")
            .into_client_request()
            .expect("a request");
        let protocol = "foxglove.sdk.v1".parse().expect("a header");
        request
            .headers_mut()
            .insert("Sec-WebSocket-Protocol", protocol);
        let (socket, _) = tungstenite::client(request, stream).expect("a WebSocket");
        Self {
            socket,
            channels: BTreeMap::new(),
        }
    }

    /// Reads the next message: updates the channels from text operations, returns the data of a
    /// subscription.
    fn next(&mut self) -> Option<(u32, Vec<u8>)> {
        match self.socket.read().expect("the server runs") {
            Message::Text(text) => {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                if message["op"] == "advertise" {
                    for channel in message["channels"].as_array().into_iter().flatten() {
                        let text = |key: &str| channel[key].as_str().unwrap_or_default().to_owned();
                        let id = channel["id"].as_u64().expect("a number");
                        assert_eq!(
                            (text("encoding"), text("schemaEncoding")),
                            ("cdr".into(), "ros2msg".into())
                        );
                        self.channels
                            .insert(text("topic"), (id, text("schemaName")));
                    }
                }
                None
            }
            // Operation code, subscription id, log time, data.
            Message::Binary(bytes) if bytes.first() == Some(&1) => {
                let subscription = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
                Some((subscription, bytes[13..].to_vec()))
            }
            _ => None,
        }
    }

    /// Subscribes to a topic once it is advertised.
    fn subscribe(&mut self, topic: &str, subscription: u32, schema: &str) {
        while !self.channels.contains_key(topic) {
            self.next();
        }
        let (channel, named) = &self.channels[topic];
        assert_eq!(named, schema);
        let asked = json!({ "op": "subscribe", "subscriptions": [{ "id": subscription, "channelId": channel }] });
        self.socket
            .send(Message::text(asked.to_string()))
            .expect("the server runs");
    }

    /// Collects `COMPARED` messages of each subscription; calls `meanwhile` between messages.
    fn collect_messages(
        &mut self,
        subscriptions: [u32; 2],
        mut meanwhile: impl FnMut(),
    ) -> [Vec<Vec<u8>>; 2] {
        let mut gathered = [Vec::new(), Vec::new()];
        while gathered.iter().any(|of| of.len() < COMPARED) {
            if let Some((subscription, data)) = self.next() {
                let index = subscriptions.iter().position(|&id| id == subscription);
                gathered[index.expect("a subscribed topic")].push(data);
            }
            meanwhile();
        }
        gathered
    }
}

/// Decodes a `std_msgs/Float64` in CDR: four header bytes, then the number.
fn float64(cdr: &[u8]) -> f64 {
    f64::from_le_bytes(cdr[4..12].try_into().expect("eight bytes"))
}

/// Decodes the joint names of a `sensor_msgs/JointState` in CDR: stamp, frame, then a sequence of
/// length-prefixed strings.
fn joint_names(cdr: &[u8]) -> Vec<String> {
    let mut at = 4 + 8;
    let number = |at: &mut usize| {
        *at = (*at - 4).next_multiple_of(4) + 4;
        let number = u32::from_le_bytes(cdr[*at..*at + 4].try_into().expect("four bytes")) as usize;
        *at += 4;
        number
    };
    at += number(&mut at);
    let count = number(&mut at);
    let mut name = |_| {
        let bytes = number(&mut at);
        let text = std::str::from_utf8(&cdr[at..at + bytes - 1]).expect("UTF-8");
        at += bytes;
        text.to_owned()
    };
    (0..count).map(&mut name).collect()
}

fn daemon(bus: &FreshBus) -> Process {
    Process::start("atasd", &["--config", "/dev/null", "--bus", bus.as_str()])
}

/// Starts the server; returns its port.
fn serve(bus: &str) -> (Process, u64) {
    let server = ["foxglove", "--port", "0", "--format", "json", "--bus", bus];
    let server = Process::start("atas-live", &server);
    let port = wait_for("the server to report its address", || {
        let log = server.log();
        let message: Value = serde_json::from_str(log.lines().find(|l| l.contains("url"))?).ok()?;
        message["port"].as_u64()
    });
    (server, port)
}

#[test]
fn foreign_pages_are_rejected() {
    let bus = FreshBus::new("foxorigin");
    let (_server, port) = serve(bus.as_str());
    let answer = |name: &'static str, value: &str| {
        let stream = TcpStream::connect(("127.0.0.1", port as u16)).expect("connects");
        let url = format!("ws://127.0.0.1:{port}");
        let mut request = url.into_client_request().expect("a request");
        let headers = request.headers_mut();
        let protocol = "foxglove.sdk.v1".parse().expect("a header");
        headers.insert("Sec-WebSocket-Protocol", protocol);
        headers.insert(name, value.parse().expect("a header"));
        match tungstenite::client(request, stream) {
            Ok((_, response)) => response.status().as_u16(),
            Err(HandshakeError::Failure(tungstenite::Error::Http(response))) => {
                response.status().as_u16()
            }
            Err(error) => panic!("{error}"),
        }
    };
    for (name, value, expected) in [
        ("Origin", "https://app.foxglove.dev", 101),
        ("Origin", "file://", 101),
        ("Origin", "https://other.example", 403),
        ("Origin", "null", 403),
        ("Host", "rebound.example", 403),
    ] {
        assert_eq!(answer(name, value), expected, "{name}: {value}");
    }
}

#[test]
fn server_ends_while_viewers_are_connected() {
    for signal in [Signal::TERM, Signal::INT] {
        let bus = FreshBus::new("foxend");
        let (mut server, port) = serve(bus.as_str());
        let _viewer = Viewer::connect(port);
        let _silent = TcpStream::connect(("127.0.0.1", port as u16)).expect("connects");
        server.signal(signal);
        assert_eq!(server.wait().code(), Some(0), "{}", server.log());
    }
}

#[test]
fn viewer_receives_bus_values_after_restart() {
    let _alone = lock_exclusive();
    let bus = FreshBus::new("foxglove");
    let name = bus.as_str();
    let _robot = Process::start("atas-sim", &["run", "--object", "wood", "--bus", name]);
    let (_server, port) = serve(name);
    // The server runs without a daemon, and connections survive the daemon's restart.
    let mut viewer = Viewer::connect(port);
    let mut first = daemon(&bus);
    compare(&mut viewer, &bus, 1);
    first.signal(Signal::TERM);
    assert_eq!(first.wait().code(), Some(0));
    let _second = daemon(&bus);
    compare(&mut Viewer::connect(port), &bus, 10);
}

/// Checks that the viewer's numbers occur on the bus and that the joints are the robot's.
fn compare(viewer: &mut Viewer, bus: &FreshBus, first: u32) {
    let observer = Bus::open(bus, "watch", Realtime::No).expect("a bus");
    let mut reports = observer.subscriber(service::TICK_REPORT).expect("a place");
    viewer.subscribe(NORMAL, first, "std_msgs/msg/Float64");
    viewer.subscribe(JOINTS, first + 1, "sensor_msgs/msg/JointState");
    let mut output = BTreeSet::new();
    let right = Hand::BOTH
        .iter()
        .position(|hand| hand.to_string() == "right");
    let right = right.expect("two hands");
    let [numbers, joints] = viewer.collect_messages([first, first + 1], || {
        let take = |report: &TickReport| {
            let normal_n = report.hands[right].fingers[0].normal_n;
            output.insert(f64::from(normal_n).to_bits());
        };
        reports.drain(usize::MAX, take).expect("readable");
    });
    let common = numbers
        .iter()
        .filter(|cdr| output.contains(&float64(cdr).to_bits()));
    // On a busy machine, viewer and test may each miss messages.
    assert!(
        common.count() > numbers.len() / 2,
        "{} values on the bus",
        output.len()
    );
    let robot = robot_model::RobotModel::two_hand_arm().expect("built in");
    let names = joint_names(&joints[0]);
    assert_eq!(names.len(), robot.joint_count(), "{names:?}");
}
