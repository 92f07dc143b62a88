//! Hands of several devices.

mod common;
#[path = "common/peers.rs"]
mod peers;
#[path = "common/process.rs"]
mod process;
#[path = "common/reader.rs"]
mod reader;

use std::fs;
use std::time::Duration;

use common::{data_frame, numbered_frame};
use process::{Pty, Sensor, wait_until};
use reader::Reader;
use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{Hand, Layout};

const SCALE: &str = "--newtons-per-count 1,1,1";

#[test]
fn two_domes_on_two_ports_form_one_hand() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let (first, second) = (Pty::new(), Pty::new());
    let sensor = Sensor::start_line(&format!(
        "optoforce --device {} --device {} --hand left --bus {} --no-configure {SCALE}",
        first.path.display(),
        second.path.display(),
        *bus
    ));
    reader.wait_for_start();
    second.send(&data_frame(1, 0, &[10, 20, -30]));
    let mut count = 0;
    // The second dome's data may arrive after the first frames.
    wait_until("both fingers", || {
        count += 1;
        first.send(&data_frame(count, 0, &[1, 2, -3]));
        second.send(&data_frame(1 + count, 0, &[10, 20, -30]));
        std::thread::sleep(Duration::from_millis(1));
        reader.poll();
        reader
            .received
            .last()
            .is_some_and(|frame| frame.valid_mask == [1, 1, 0, 0])
    });
    let frame = *reader.received.last().unwrap();
    assert_eq!((frame.finger_count, frame.is_intact()), (2, true));
    assert_eq!(
        [frame.force_n[0][0], frame.force_n[1][0]],
        [[3.0, 1.0, 2.0], [30.0, 10.0, 20.0]]
    );
    // One device stops sending: its fingertip becomes invalid, the hand continues at the rate of
    // the other.
    wait_until("the silent finger is invalid", || {
        count += 1;
        first.send(&data_frame(count, 0, &[1, 2, -3]));
        std::thread::sleep(Duration::from_millis(1));
        reader.poll();
        reader
            .received
            .last()
            .is_some_and(|frame| frame.valid_mask == [1, 0, 0, 0])
    });
    let mut newest = reader.received.windows(2);
    assert!(
        newest.all(|pair| pair[0].stamp.sequence < pair[1].stamp.sequence
            && pair[0].stamp.captured_ns < pair[1].stamp.captured_ns)
    );
    sensor.signal(Signal::TERM);
    let (code, _, stderr) = sensor.finish();
    assert_eq!(code, Some(0), "{stderr}");
    assert_eq!(stderr.matches("optoforce /dev/pts").count(), 2, "{stderr}");
}

#[test]
fn next_device_sets_the_pace_after_silence() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::RIGHT);
    let (first, second) = (Pty::new(), Pty::new());
    let sensor = Sensor::start_line(&format!(
        "optoforce --device {} --device {} --hand right --bus {} --no-configure {SCALE}",
        first.path.display(),
        second.path.display(),
        *bus
    ));
    reader.wait_for_start();
    let mut count = 0;
    wait_until("the second alone", || {
        count += 1;
        second.send(&numbered_frame(count));
        std::thread::sleep(Duration::from_millis(1));
        reader.poll();
        reader.received.len() > 20
    });
    assert!(
        reader
            .received
            .iter()
            .all(|frame| frame.valid_mask == [0, 1, 0, 0])
    );
    sensor.signal(Signal::TERM);
    assert_eq!(sensor.finish().0, Some(0));
}

#[test]
fn file_describes_a_hand_of_mixed_sensors() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let (dome, tip) = (Pty::new(), Pty::new());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("left.toml");
    let text = format!(
        "hand = \"left\"\nbus = \"{}\"\n\
         [[port]]\nsensor = \"optoforce\"\ndevice = \"{}\"\nno-configure = true\n\
         newtons-per-count = \"1,1,1\"\n\
         [[port]]\nsensor = \"paxini\"\ndevice = \"{}\"\nfinger = 1\n",
        *bus,
        dome.path.display(),
        tip.path.display(),
    );
    fs::write(&file, text).unwrap();
    let sensor = Sensor::start_line(&format!("hand {}", file.display()));
    reader.wait_for_start();
    let mut count = 0;
    wait_until("both fingers", || {
        let _: [u8; 14] = tip.receive();
        tip.send(&peers::paxini_reply(3, 31));
        for _ in 0..4 {
            count += 1;
            dome.send(&data_frame(count, 0, &[1, 2, -3]));
            std::thread::sleep(Duration::from_millis(1));
        }
        reader.poll();
        let valid = (1 << 31) - 1;
        let newest = reader.received.last();
        newest.is_some_and(|frame| frame.valid_mask == [valid, valid, 0, 0])
    });
    let frame = *reader.received.last().unwrap();
    assert_eq!(
        frame.layout_hash,
        Layout::from_name("pad-31").unwrap().hash()
    );
    assert_eq!(frame.force_n[0][..2], [[3.0, 1.0, 2.0], [0.0; 3]]);
    let normal = peers::magnitude(3, 3 * 30 + 2) as f32 * 0.1;
    assert!((frame.force_n[1][30][0] - normal).abs() < 1e-4);
    sensor.signal(Signal::TERM);
    let (code, _, stderr) = sensor.finish();
    assert_eq!(code, Some(0), "{stderr}");
}

#[test]
fn invalid_hand_file_names_the_port() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hand.toml");
    let check = |text: &str, sentence: &str| {
        fs::write(&file, text).unwrap();
        let (code, _, stderr) = Sensor::start_line(&format!("hand {}", file.display())).finish();
        assert_eq!(code, Some(2), "{text}: {stderr}");
        assert!(stderr.contains(sentence), "{text}: {stderr}");
    };
    check("hand = \"left\"", "names no [[port]]");
    check("hand = 3 4", "could not read");
    check("wrist = 1\n[[port]]\n", "has the key \"wrist\"");
    check("[[port]]\nsensor = \"optofrce\"", "needs one of optoforce");
    check(
        "hand = \"left\"\n[[port]]\nsensor = \"paxini\"\ndevice = \"/dev/null\"\nmodel = \"x\"",
        "[[port]] 1",
    );
    check(
        "hand = \"left\"\n[[port]]\nsensor = \"paxini\"\ndevice = \"a\"\n[[port]]\nsensor = \"paxini\"\ndevice = \"b\"",
        "a and b on the same finger",
    );
    check(
        "hand = \"left\"\nlayout = \"dome-1\"\n[[port]]\nsensor = \"paxini\"\ndevice = \"a\"",
        "at least 31 elements: pad-31",
    );
}
