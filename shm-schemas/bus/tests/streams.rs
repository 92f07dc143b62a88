//! Streams: round trip, newest, drain, overflow, history, restart of a writer.

mod common;

use common::{Peer, peer_role, ready, until};
use shm_bus::{Bus, BusError, BusName, FreshBus, Realtime, now_ns, writer_epoch};
use shm_schemas::service::{
    HAND_FRAME, JOINT_COMMAND, JOINT_STATE, MODULE_EVENT, SENSOR_STATUS, STATUS,
};
use shm_schemas::{HandFrame, JointCommand, JointState, ModuleEvent, SensorStatus, Stamp, Status};

fn stamp(sequence: u64) -> Stamp {
    Stamp {
        sequence,
        captured_ns: now_ns(),
        writer_epoch: 1,
    }
}

fn frame(sequence: u64) -> HandFrame {
    HandFrame {
        stamp: stamp(sequence),
        ..HandFrame::default()
    }
}

fn open(bus: &BusName, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::No).expect("the bus opens")
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    let bus = open(&name, &role);
    let publisher = bus.publisher::<HandFrame>(HAND_FRAME[0]).expect("frames");
    let epoch = writer_epoch();
    for sequence in 0.. {
        publisher
            .send_with(|frame| {
                frame.stamp = Stamp {
                    sequence,
                    captured_ns: now_ns(),
                    writer_epoch: epoch,
                }
            })
            .expect("sent");
        if sequence == 3 {
            ready();
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[test]
fn payloads_arrive_complete_and_in_order() {
    let name = FreshBus::new("order");
    let (writer, reader) = (open(&name, "writer"), open(&name, "reader"));
    let publisher = writer
        .publisher::<HandFrame>(HAND_FRAME[1])
        .expect("publisher");
    let mut subscriber = reader
        .subscriber::<HandFrame>(HAND_FRAME[1])
        .expect("subscriber");
    let mut sent = frame(0);
    sent.force_n[3][63] = [1.0, -2.0, 3.5];
    sent.seal();
    for sequence in 1..=5 {
        publisher.send(&frame(sequence)).expect("sent");
    }
    publisher.send(&sent).expect("sent");
    let mut seen = Vec::new();
    let count = subscriber
        .drain(5, |frame| seen.push(frame.stamp.sequence))
        .expect("drained");
    assert_eq!((count, seen), (5, vec![1, 2, 3, 4, 5]));
    let mut out = HandFrame::default();
    assert!(subscriber.newest(&mut out).expect("read"));
    assert_eq!(out, sent);
    assert!(out.is_intact());
    assert!(
        !subscriber.newest(&mut out).expect("read"),
        "nothing is left"
    );
    assert_eq!(out, sent, "an empty stream leaves the output unchanged");
    assert_eq!(subscriber.drain(5, |_| {}).expect("drained"), 0);
}

#[test]
fn a_slow_reader_loses_the_oldest() {
    let name = FreshBus::new("overflow");
    let bus = open(&name, "both");
    let publisher = bus
        .publisher::<JointCommand>(JOINT_COMMAND)
        .expect("publisher");
    let mut subscriber = bus
        .subscriber::<JointCommand>(JOINT_COMMAND)
        .expect("subscriber");
    for tick in 0..100 {
        publisher
            .send(&JointCommand {
                tick,
                ..JointCommand::default()
            })
            .expect("sent");
    }
    let mut seen = Vec::new();
    subscriber
        .drain(usize::MAX, |command| seen.push(command.tick))
        .expect("drained");
    assert_eq!(seen, [96, 97, 98, 99]);
}

#[test]
fn newest_skips_older_payloads() {
    let name = FreshBus::new("newest");
    let bus = open(&name, "both");
    let publisher = bus.publisher::<JointState>(JOINT_STATE).expect("publisher");
    let mut subscriber = bus
        .subscriber::<JointState>(JOINT_STATE)
        .expect("subscriber");
    let mut out = JointState::default();
    for last in [0, 1, 15, 16, 40] {
        for sequence in 0..=last {
            publisher
                .send(&JointState {
                    stamp: stamp(sequence),
                    ..JointState::default()
                })
                .expect("sent");
        }
        assert!(subscriber.newest(&mut out).expect("read"));
        assert_eq!(out.stamp.sequence, last);
        assert!(
            !subscriber.newest(&mut out).expect("read"),
            "no older payload follows {last}"
        );
    }
}

#[test]
fn late_reader_gets_the_history() {
    let name = FreshBus::new("history");
    let bus = open(&name, "both");
    let publisher = bus
        .publisher::<ModuleEvent>(MODULE_EVENT)
        .expect("publisher");
    for tick in 0..1100 {
        publisher
            .send(&ModuleEvent {
                tick,
                ..ModuleEvent::default()
            })
            .expect("sent");
    }
    let mut late = bus
        .subscriber::<ModuleEvent>(MODULE_EVENT)
        .expect("subscriber");
    publisher.connect_readers().expect("connected");
    let mut seen = Vec::new();
    late.drain(usize::MAX, |event| seen.push(event.tick))
        .expect("drained");
    assert_eq!(seen, (76..1100).collect::<Vec<_>>());
}

#[test]
fn sensor_status_allows_several_writers() {
    let name = FreshBus::new("several");
    let bus = open(&name, "both");
    let first = bus.publisher::<SensorStatus>(SENSOR_STATUS).expect("first");
    let second = bus
        .publisher::<SensorStatus>(SENSOR_STATUS)
        .expect("second");
    let mut subscriber = bus
        .subscriber::<SensorStatus>(SENSOR_STATUS)
        .expect("subscriber");
    first.send(&SensorStatus::default()).expect("sent");
    second.send(&SensorStatus::default()).expect("sent");
    assert_eq!(subscriber.drain(10, |_| {}).expect("drained"), 2);
}

#[test]
fn restarted_writer_is_received() {
    let name = FreshBus::new("restart");
    let bus = Bus::open(&name, "daemon", Realtime::Yes).expect("the bus opens");
    let mut subscriber = bus
        .subscriber::<HandFrame>(HAND_FRAME[0])
        .expect("subscriber");
    let mut out = HandFrame::default();
    let mut epochs = Vec::new();
    for _ in 0..3 {
        let writer = Peer::start(&name, "sensor");
        until("a frame of the new writer arrives", || {
            subscriber.drain(64, |frame| out = *frame).expect("read");
            out.stamp.writer_epoch != 0 && !epochs.contains(&out.stamp.writer_epoch)
        });
        epochs.push(out.stamp.writer_epoch);
        writer.kill();
    }
    assert_eq!(epochs.len(), 3);
}

#[test]
fn second_writer_is_rejected_naming_the_first() {
    let name = FreshBus::new("second");
    let writer = Peer::start(&name, "sensor-left");
    let bus = open(&name, "intruder");
    let refused = bus
        .publisher::<HandFrame>(HAND_FRAME[0])
        .expect_err("taken");
    let BusError::Taken { service, role, pid } = &refused else {
        panic!("{refused}")
    };
    assert_eq!(
        (*service, role.as_str(), *pid),
        (HAND_FRAME[0], "sensor-left", writer.pid())
    );
    writer.kill();
    bus.publisher::<HandFrame>(HAND_FRAME[0])
        .expect("a dead writer frees its slot");
}

#[test]
fn reader_slots_are_limited() {
    let name = FreshBus::new("places");
    let bus = open(&name, "reader");
    let readers: Vec<_> = (0..4)
        .map(|_| bus.subscriber::<JointState>(JOINT_STATE).expect("a slot"))
        .collect();
    let refused = bus.subscriber::<JointState>(JOINT_STATE).expect_err("full");
    assert!(
        matches!(refused, BusError::Full { limit: 4, .. }),
        "{refused}"
    );
    drop(readers);
    bus.subscriber::<JointState>(JOINT_STATE)
        .expect("a free slot");
}

#[test]
fn unknown_stream_is_rejected() {
    let name = FreshBus::new("table");
    let bus = open(&name, "both");
    assert!(matches!(
        bus.publisher::<Status>(HAND_FRAME[0]),
        Err(BusError::Unknown { .. })
    ));
    assert!(matches!(
        bus.subscriber::<Status>("atas/v0/status"),
        Err(BusError::Unknown { .. })
    ));
    bus.subscriber::<Status>(STATUS).expect("in the table");
}
