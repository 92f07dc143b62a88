//! The whole program: real pseudo-terminal, real process, real bus.

mod common;
#[path = "common/process.rs"]
mod process;
#[path = "common/reader.rs"]
mod reader;

use std::fs;

use common::{acknowledgement, data_frame, forces_of, numbered_frame};
use process::{Pty, Sensor};
use reader::Reader;
use rustix::process::Signal;
use shm_bus::{FreshBus, now_ns};
use shm_schemas::{Hand, Layout};

const SCALE: &str = "--newtons-per-count 0.5,0.25,2";

#[test]
fn every_frame_reaches_a_subscriber() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::RIGHT);
    let pty = Pty::new();
    let sensor = Sensor::start(
        &pty.path,
        &format!(
            "--hand right --finger 1 --bus {} --no-configure {SCALE}",
            *bus
        ),
    );
    reader.wait_for_start();

    // 3000 frames across the wrap of the count; junk after every tenth, one duplicate, five lost.
    let counts: Vec<u16> = (0..3000_u16).map(|n| n.wrapping_add(64_000)).collect();
    let mut stream = Vec::new();
    for (n, &count) in counts
        .iter()
        .enumerate()
        .filter(|(n, _)| !(2000..2005).contains(n))
    {
        stream.extend(numbered_frame(count));
        if n % 10 == 0 {
            stream.extend([0xAA, 0x07, 0x08, 0x0A, 0xAA]);
        }
        if n == 500 {
            stream.extend(numbered_frame(count));
        }
    }
    let mut rest = stream.as_slice();
    for size in (1..80).cycle() {
        let (chunk, tail) = rest.split_at(size.min(rest.len()));
        pty.send(chunk);
        reader.poll();
        std::thread::sleep(std::time::Duration::from_micros(300));
        rest = tail;
        if rest.is_empty() {
            break;
        }
    }
    reader.wait_for_frames(2996);
    let before_end_ns = now_ns();
    sensor.signal(Signal::TERM);
    let (code, _, stderr) = sensor.finish();
    reader.poll();

    assert_eq!(code, Some(0), "{stderr}");
    assert!(
        stderr.contains("2996 frames, 5 lost, 1 duplicates, 0 late"),
        "{stderr}"
    );
    let status = reader.status;
    assert_eq!(
        (status.frames, status.lost, status.alive, status.junk_bytes),
        (2996, 5, 0, 299 * 5)
    );
    assert_eq!(
        (status.driver.as_str(), status.hand),
        ("optoforce", Hand::RIGHT)
    );

    let expected: Vec<u64> = (0..3000).filter(|n| !(2000..2005).contains(n)).collect();
    let sequences: Vec<u64> = reader
        .received
        .iter()
        .map(|frame| frame.stamp.sequence)
        .collect();
    assert_eq!(sequences, expected);
    assert!(
        reader
            .received
            .windows(2)
            .all(|pair| pair[0].stamp.captured_ns < pair[1].stamp.captured_ns)
    );
    for frame in &reader.received {
        let [x, y, z] = forces_of(counts[frame.stamp.sequence as usize]).map(f32::from);
        assert!(frame.is_intact() && frame.stamp.captured_ns < before_end_ns);
        assert_eq!(
            (frame.hand, frame.finger_count, frame.valid_mask),
            (Hand::RIGHT, 2, [0, 1, 0, 0])
        );
        assert_eq!(frame.force_n[1][0], [-2.0 * z, 0.5 * x, 0.25 * y]);
        assert_eq!(
            frame.layout_hash,
            Layout::from_name("dome-1").unwrap().hash()
        );
    }
}

#[test]
fn four_domes_give_four_fingertips_and_mask_failures() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let pty = Pty::new();
    let arguments = format!(
        "--hand left --channels 4 --bus {} --no-configure {SCALE} --axes x,y,z",
        *bus
    );
    let sensor = Sensor::start(&pty.path, &arguments);
    reader.wait_for_start();
    let values: Vec<i16> = (1..=12).collect();
    // Valid, overloaded in Fz, sensor error.
    for (count, status) in [(1, 0), (2, 0x0080), (3, 0x0400)] {
        pty.send(&data_frame(count, status, &values));
        reader.wait_for_frames(u64::from(count));
    }
    sensor.signal(Signal::INT);
    assert_eq!(sensor.finish().0, Some(0));
    reader.poll();
    let masks: Vec<_> = reader
        .received
        .iter()
        .map(|frame| frame.valid_mask)
        .collect();
    assert_eq!(masks, [[1; 4], [1; 4], [0; 4]]);
    let first_forces = [0, 1, 2, 3].map(|finger| reader.received[0].force_n[finger][0]);
    assert_eq!(
        first_forces,
        [
            [0.5, 0.5, 6.0],
            [2.0, 1.25, 12.0],
            [3.5, 2.0, 18.0],
            [5.0, 2.75, 24.0]
        ]
    );
    assert_eq!(
        (reader.status.device_errors, reader.status.device_status),
        (2, 0x0400)
    );
}

#[test]
fn device_is_configured_and_stopped() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let pty = Pty::new();
    let arguments = format!(
        "--hand left --bus {} {SCALE} --rate-hz 333 --filter-hz 15 --zero",
        *bus
    );
    let sensor = Sensor::start(&pty.path, &arguments);
    assert_eq!(
        pty.receive_command(),
        [0xAA, 0x00, 0x32, 0x03, 3, 4, 255, 0x01, 0xE5]
    );
    // A frame with old settings, the acknowledgement, a frame with new settings.
    pty.send(&[numbered_frame(1), acknowledgement(0), numbered_frame(2)].concat());
    reader.wait_for_frames(2);
    sensor.signal(Signal::INT);
    assert_eq!(
        pty.receive_command(),
        [0xAA, 0x00, 0x32, 0x03, 0, 0, 0, 0x00, 0xDF]
    );
    assert_eq!(sensor.finish().0, Some(0));
    reader.poll();
    assert_eq!(reader.received.len(), 1);
}

#[test]
fn returning_device_is_read_again() {
    let bus = FreshBus::new("sensor");
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let folder = tempfile::tempdir().unwrap();
    let (link, first, second) = (folder.path().join("tty"), Pty::new(), Pty::new());
    std::os::unix::fs::symlink(&first.path, &link).unwrap();
    let sensor = Sensor::start(
        &link,
        &format!(
            "--hand left --bus {} {SCALE} --no-configure --reconnect",
            *bus
        ),
    );
    reader.wait_for_start();
    first.send(&numbered_frame(1));
    reader.wait_for_frames(1);
    fs::remove_file(&link).unwrap();
    drop(first);
    std::os::unix::fs::symlink(&second.path, &link).unwrap();
    second.send(&numbered_frame(2));
    reader.wait_for_frames(2);
    sensor.signal(Signal::TERM);
    let (code, _, stderr) = sensor.finish();
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("trying again"), "{stderr}");
}

#[test]
fn recording_converts_to_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.bin");
    let frames = [data_frame(7, 0, &[1, -2, -3]), data_frame(9, 0, &[4, 5, 6])];
    fs::write(
        &path,
        [acknowledgement(0), frames.concat(), vec![0xAA]].concat(),
    )
    .unwrap();
    let (code, stdout, stderr) =
        Sensor::start(&path, &format!("--dry-run --no-configure {SCALE}")).finish();
    assert_eq!(code, Some(0), "{stderr}");
    assert!(
        stderr.contains(
            "2 frames, 1 lost, 0 duplicates, 0 late, 0 restarts, 0 stray counts; 40 bytes, 1 junk"
        ),
        "{stderr}"
    );
    let mut table = csv::Reader::from_reader(stdout.as_bytes());
    let header = "byte_offset,count,status,fx_counts,fy_counts,fz_counts,arrival,captured_ns,normal_n,tangential1_n,tangential2_n";
    assert_eq!(
        table
            .headers()
            .unwrap()
            .iter()
            .collect::<Vec<_>>()
            .join(","),
        header
    );
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let cells = |row: usize| {
        rows[row]
            .iter()
            .enumerate()
            .filter(|&(i, _)| i != 7)
            .map(|(_, c)| c)
            .collect::<Vec<_>>()
    };
    assert_eq!(
        cells(0),
        ["7", "7", "0", "1", "-2", "-3", "first", "6", "0.5", "-0.5"]
    );
    assert_eq!(
        cells(1),
        ["23", "9", "0", "4", "5", "6", "gap", "-12", "2", "1.25"]
    );
    assert_eq!(rows.len(), 2);
}

#[test]
fn every_failure_has_exit_code_and_message() {
    let bus = FreshBus::new("sensor");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, b"").unwrap();
    let publish = format!("--hand left --bus {} {SCALE}", *bus);
    let check = |sensor: Sensor, code: i32, sentence: &str| {
        let (found, _, stderr) = sensor.finish();
        assert_eq!(found, Some(code), "{stderr}");
        assert!(stderr.contains(sentence), "{sentence}: {stderr}");
    };
    check(
        Sensor::start(&file, "--hand left"),
        2,
        "--newtons-per-count",
    );
    check(
        Sensor::start(&file, "--dry-run --rate-hz 5"),
        2,
        "needs one of 1000",
    );
    check(
        Sensor::start(&folder.path().join("none"), &publish),
        11,
        "check the path",
    );
    check(Sensor::start(&file, &publish), 11, "add --dry-run");
    check(Sensor::start(&file, "--dry-run"), 11, "add --no-configure");
    check(
        Sensor::start(folder.path(), &publish),
        11,
        "not a terminal, FIFO or regular file",
    );
    check(
        Sensor::start("/dev/null".as_ref(), &publish),
        11,
        "not a terminal",
    );

    let pty = Pty::new();
    check(
        Sensor::start(&pty.path, &publish),
        11,
        "no acknowledgement within 1 s",
    );
    assert_eq!(pty.receive_command()[4], 1);
    let sensor = Sensor::start(&pty.path, &publish);
    pty.receive_command();
    pty.send(&acknowledgement(3));
    check(sensor, 11, "refused with status 3");
    let sensor = Sensor::start(&pty.path, &format!("{publish} --no-configure"));
    pty.send(
        &(0..40)
            .flat_map(|n| data_frame(n, 0, &[0; 12]))
            .collect::<Vec<_>>(),
    );
    check(sensor, 11, "pass --channels 4");

    let mut reader = Reader::new(&bus, Hand::LEFT);
    let sensor = Sensor::start(&pty.path, &format!("{publish} --no-configure"));
    reader.wait_for_start();
    check(
        Sensor::start(&pty.path, "--dry-run --no-configure"),
        11,
        "another process uses it",
    );
    check(Sensor::start(&Pty::new().path, &publish), 8, "sensor-left");
    drop(pty);
    check(sensor, 11, "start with --reconnect");
}
