//! `atas foxglove`: what a viewer gets over the WebSocket is what the bus says, also after the daemon's restart.
//!
//! The viewer is played by hand after Foxglove's specification (`foxglove.sdk.v1`), so that the library that serves does not
//! judge itself.

use std::collections::{BTreeMap, BTreeSet};
use std::net::TcpStream;
use std::time::Duration;

use rustix::process::Signal;
use serde_json::{Value, json};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Hand, TickReport, service};
use system_tests::{Process, alone, wait_for};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Topics that are compared: a number of the tick, and one of the robot.
const NORMAL: &str = "/right/finger1/normal";
const JOINTS: &str = "/joint_states";
/// Messages of a topic that are compared.
const COMPARED: usize = 50;

/// A viewer that is connected.
struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Channels by topic: number and name of the schema.
    channels: BTreeMap<String, (u64, String)>,
}

impl Viewer {
    fn connect(port: u64) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port as u16)).expect("somebody listens");
        stream
            .set_read_timeout(Some(Duration::from_secs(30)))
            .expect("a limit");
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

    /// The next message: a text's operation is taken in, data of a subscription returned.
    fn next(&mut self) -> Option<(u32, Vec<u8>)> {
        match self.socket.read().expect("the server lives") {
            Message::Text(text) => {
                let said: Value = serde_json::from_str(&text).expect("JSON");
                if said["op"] == "advertise" {
                    for channel in said["channels"].as_array().into_iter().flatten() {
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
            // Operation, subscription, log time, data.
            Message::Binary(bytes) if bytes.first() == Some(&1) => {
                let subscription = u32::from_le_bytes(bytes[1..5].try_into().expect("four bytes"));
                Some((subscription, bytes[13..].to_vec()))
            }
            _ => None,
        }
    }

    /// Subscribes to a topic as soon as it is there.
    fn subscribe(&mut self, topic: &str, subscription: u32, schema: &str) {
        while !self.channels.contains_key(topic) {
            self.next();
        }
        let (channel, named) = &self.channels[topic];
        assert_eq!(named, schema);
        let asked = json!({ "op": "subscribe", "subscriptions": [{ "id": subscription, "channelId": channel }] });
        self.socket
            .send(Message::text(asked.to_string()))
            .expect("the server lives");
    }

    /// So many messages of each subscription; `meanwhile` is called between them.
    fn gather(
        &mut self,
        subscriptions: [u32; 2],
        mut meanwhile: impl FnMut(),
    ) -> [Vec<Vec<u8>>; 2] {
        let mut gathered = [Vec::new(), Vec::new()];
        while gathered.iter().any(|of| of.len() < COMPARED) {
            if let Some((subscription, data)) = self.next() {
                let index = subscriptions.iter().position(|&id| id == subscription);
                gathered[index.expect("a topic of ours")].push(data);
            }
            meanwhile();
        }
        gathered
    }
}

/// `std_msgs/Float64` as CDR: four bytes of header, then the number.
fn float64(cdr: &[u8]) -> f64 {
    f64::from_le_bytes(cdr[4..12].try_into().expect("eight bytes"))
}

/// Names of the joints of a `sensor_msgs/JointState` as CDR: stamp, frame, then a sequence of strings, each with its length.
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

#[test]
fn a_viewer_gets_what_the_bus_says_also_after_the_daemons_restart() {
    let _alone = alone();
    let bus = FreshBus::new("foxglove");
    let name = bus.as_str();
    let _robot = Process::start("atas-sim", &["run", "--object", "wood", "--bus", name]);
    let server = ["foxglove", "--port", "0", "--format", "json", "--bus", name];
    let server = Process::start("atas-live", &server);
    let port = wait_for("the server to say its address", || {
        let log = server.log();
        let said: Value = serde_json::from_str(log.lines().find(|l| l.contains("url"))?).ok()?;
        said["port"].as_u64()
    });
    // It serves before there is a daemon, and whoever connected stays connected.
    let mut viewer = Viewer::connect(port);
    let mut first = daemon(&bus);
    compare(&mut viewer, &bus, 1);
    first.signal(Signal::TERM);
    assert_eq!(first.wait().code(), Some(0));
    let _second = daemon(&bus);
    compare(&mut Viewer::connect(port), &bus, 10);
}

/// Numbers that the viewer gets are among those of the bus, and the joints are the robot's.
fn compare(viewer: &mut Viewer, bus: &FreshBus, first: u32) {
    let observer = Bus::open(bus, "watch", Realtime::No).expect("a bus");
    let mut reports = observer.subscriber(service::TICK_REPORT).expect("a place");
    viewer.subscribe(NORMAL, first, "std_msgs/msg/Float64");
    viewer.subscribe(JOINTS, first + 1, "sensor_msgs/msg/JointState");
    let mut told = BTreeSet::new();
    let right = Hand::BOTH
        .iter()
        .position(|hand| hand.to_string() == "right");
    let right = right.expect("two hands");
    let [numbers, joints] = viewer.gather([first, first + 1], || {
        let take = |report: &TickReport| {
            let normal_n = report.hands[right].fingers[0].normal_n;
            told.insert(f64::from(normal_n).to_bits());
        };
        reports.drain(usize::MAX, take).expect("readable");
    });
    let common = numbers
        .iter()
        .filter(|cdr| told.contains(&float64(cdr).to_bits()));
    // A busy machine may make either of us miss some.
    assert!(
        common.count() > numbers.len() / 2,
        "{} of the bus",
        told.len()
    );
    let robot = robot_model::RobotModel::two_hand_arm().expect("built in");
    let names = joint_names(&joints[0]);
    assert_eq!(names.len(), robot.joint_count(), "{names:?}");
}
