//! Replay of recordings onto the bus: real recorder, program and reader.

mod common;
#[path = "common/process.rs"]
mod process;
#[path = "common/reader.rs"]
mod reader;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use atas_recording::{Bounds, record};
use common::numbered_frame;
use process::{Sensor, wait_until};
use reader::Reader;
use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime, now_ns};
use shm_schemas::service::{RUN_HEADER, TICK_INPUTS};
use shm_schemas::{Hand, HandFrame, Layout, RunHeader, Stamp, TickInputs};

/// Ticks of the recorded runs: more than are written between two flushes.
const TICKS: u64 = 600;
/// Recorded time between two frames, ns: the first frames come slower than the others.
const SPACING_NS: [u64; 2] = [3_000_000, 1_000_000];

/// Returns the left hand's frame of a tick, as a sensor process would send it.
fn frame(tick: u64) -> HandFrame {
    let slow = tick.min(20);
    let mut frame = HandFrame {
        stamp: Stamp {
            // Three frames were lost on the way to the daemon.
            sequence: 70 + tick + if tick < 300 { 0 } else { 3 },
            captured_ns: 5_000_000_000 + slow * SPACING_NS[0] + (tick - slow) * SPACING_NS[1],
            writer_epoch: 77,
        },
        layout_hash: Layout::dome_41().hash(),
        hand: Hand::LEFT,
        finger_count: 2,
        valid_mask: [u64::MAX >> 23, (u64::MAX >> 23) & !(tick % 4), 0, 0],
        ..HandFrame::default()
    };
    for (finger, elements) in frame.force_n.iter_mut().enumerate().take(2) {
        for (element, force_n) in elements.iter_mut().enumerate().take(41) {
            *force_n = [
                tick as f32 / 3.0,
                -(element as f32) / 7.0,
                finger as f32 + 0.1,
            ];
        }
    }
    frame.seal();
    frame
}

/// Records a run with inputs; `frame` returns the frame of a tick.
fn recorded(out: &Path, started_ns: u64, frame: impl Fn(u64) -> Option<HandFrame>) -> PathBuf {
    let bus = FreshBus::new("tape");
    let node = |name| Bus::open(&bus, name, Realtime::No).unwrap();
    let (listening, stop) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|scope| {
        let recorder = scope.spawn(|| {
            let listens = || listening.store(true, Ordering::Relaxed);
            record(
                &node("recorder"),
                out,
                Bounds {
                    file_bytes: None,
                    files: None,
                    total_bytes: None,
                },
                BTreeMap::new(),
                None,
                listens,
                &stop,
            )
        });
        wait_until("the recorder", || listening.load(Ordering::Relaxed));
        let daemon = node("daemon");
        let mut header = Box::new(RunHeader::default());
        header.stamp.captured_ns = started_ns;
        daemon
            .publisher(RUN_HEADER)
            .unwrap()
            .send(&*header)
            .unwrap();
        let inputs = daemon.publisher(TICK_INPUTS).unwrap();
        for tick in 0..TICKS {
            let frame = frame(tick);
            let mut part = Box::new(TickInputs {
                stamp: Stamp {
                    sequence: tick,
                    captured_ns: started_ns + tick,
                    writer_epoch: 5,
                },
                tick,
                parts: 1,
                has_frame: [u32::from(frame.is_some()), 0],
                ..TickInputs::default()
            });
            part.frames[0] = frame.unwrap_or_default();
            inputs.send(&*part).unwrap();
            thread::sleep(Duration::from_micros(500));
        }
        thread::sleep(Duration::from_millis(50));
        stop.store(true, Ordering::Relaxed);
        let tally = recorder.join().unwrap().unwrap();
        assert_eq!((tally.parts, tally.lost), (TICKS, 0));
    });
    out.to_owned()
}

/// Frames that a reader of the hand received, and the end of the program.
struct Received {
    reader: Reader,
    code: Option<i32>,
    stderr: String,
}

impl Received {
    fn frames(&self) -> &[HandFrame] {
        &self.reader.received
    }

    fn sequences(&self) -> Vec<u64> {
        let frames = self.frames().iter();
        frames.map(|frame| frame.stamp.sequence).collect()
    }
}

/// Plays to the end, or until the reader has received this many frames.
fn receive(words: &str, hand: Hand, until: Option<(usize, Signal)>) -> Received {
    let bus = FreshBus::new("replay");
    let mut reader = Reader::new(&bus, hand);
    let sensor = Sensor::start_line(&format!("replay {words} --hand {hand} --bus {}", *bus));
    let (done, finished) = std::sync::mpsc::channel();
    thread::scope(|scope| {
        let (enough, when) = std::sync::mpsc::channel::<Signal>();
        scope.spawn(move || {
            if let Ok(signal) = when.recv() {
                sensor.signal(signal);
            }
            done.send(sensor.finish()).unwrap();
        });
        let mut enough = Some(enough);
        loop {
            reader.poll();
            match until {
                None => drop(enough.take()),
                Some((count, signal)) if reader.received.len() >= count => {
                    enough.take().map(|enough| enough.send(signal));
                }
                Some(_) => {}
            }
            if let Ok((code, _, stderr)) = finished.try_recv() {
                reader.poll();
                return Received {
                    reader,
                    code,
                    stderr,
                };
            }
            thread::sleep(Duration::from_millis(1));
        }
    })
}

/// Checks that stamps keep the spacing; a slow machine may have stretched it.
fn check_spacing(received: &Received, expected_ns: impl Fn(&HandFrame) -> u64) {
    let kept_up = received.stderr.contains("0 delays");
    for pair in received.frames().windows(2) {
        let (after_ns, wanted_ns) = (
            pair[1].stamp.captured_ns - pair[0].stamp.captured_ns,
            expected_ns(&pair[1]),
        );
        assert!(
            after_ns == wanted_ns || !kept_up && after_ns > wanted_ns,
            "{after_ns} {wanted_ns}"
        );
    }
}

#[test]
fn recording_replays_bit_for_bit_with_new_stamps() {
    let folder = tempfile::tempdir().unwrap();
    // A duplicate, and a frame that was damaged on its way.
    let fate = |tick: u64| match tick {
        100 => Some(frame(99)),
        200 => Some(HandFrame {
            pad: 1,
            ..frame(200)
        }),
        400 => None,
        tick => Some(frame(tick)),
    };
    let file = recorded(&folder.path().join("run.mcap"), 5, fate);
    let begun_ns = now_ns();
    let received = receive(&format!("{} --speed 0.5", file.display()), Hand::LEFT, None);
    assert_eq!(received.code, Some(0), "{}", received.stderr);
    let played: Vec<u64> = (0..TICKS)
        .filter(|tick| ![100, 200, 400].contains(tick))
        .collect();
    // Also lost: the frames of the three skipped ticks, or ticks without a frame.
    let sentence = format!(
        "{} frames played, 6 lost when recorded, 2 skipped",
        played.len()
    );
    assert!(received.stderr.contains(&sentence), "{}", received.stderr);
    assert_eq!(received.frames().len(), played.len());
    let epoch = received.frames()[0].stamp.writer_epoch;
    assert_ne!(epoch, 77);
    for (received, &tick) in received.frames().iter().zip(&played) {
        let expected = frame(tick);
        assert!(received.is_intact() && received.stamp.captured_ns >= begun_ns);
        assert_eq!(received.stamp.writer_epoch, epoch);
        assert_eq!(received.stamp.sequence, expected.stamp.sequence - 70);
        let as_recorded = HandFrame {
            stamp: expected.stamp,
            crc32: expected.crc32,
            ..*received
        };
        assert_eq!(as_recorded, expected);
    }
    check_spacing(&received, |later| {
        let before = received
            .frames()
            .iter()
            .rev()
            .find(|f| f.stamp.sequence < later.stamp.sequence);
        let recorded_ns = |sequence: u64| {
            frame(sequence - if sequence < 303 { 0 } else { 3 })
                .stamp
                .captured_ns
        };
        2 * (recorded_ns(later.stamp.sequence) - recorded_ns(before.unwrap().stamp.sequence))
    });
    let status = received.reader.status;
    assert_eq!(
        (
            status.driver.as_str(),
            status.hand,
            status.frames,
            status.lost,
            status.alive
        ),
        ("replay", Hand::LEFT, played.len() as u64, 6, 0)
    );
    assert!(file.to_str().unwrap().starts_with(status.device.as_str()));
}

#[test]
fn loop_repeats_at_requested_rate_until_signal() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(&folder.path().join("run.mcap"), 5, |tick| {
        (tick < 40).then(|| frame(tick))
    });
    let words = format!("{} --rate-hz 500 --loop", file.display());
    for signal in [Signal::INT, Signal::TERM] {
        let received = receive(&words, Hand::LEFT, Some((100, signal)));
        assert_eq!(received.code, Some(0), "{}", received.stderr);
        let expected: Vec<u64> = (0..received.frames().len() as u64).collect();
        assert_eq!(received.sequences(), expected);
        for (n, received) in received.frames().iter().enumerate() {
            assert_eq!(received.force_n, frame(n as u64 % 40).force_n);
        }
        check_spacing(&received, |_| 2_000_000);
        let sentence = format!("{} frames played, 0 lost", received.frames().len());
        assert!(received.stderr.contains(&sentence), "{}", received.stderr);
    }
}

#[test]
fn damaged_recording_is_played_up_to_the_damage() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(&folder.path().join("run.mcap"), 5, |tick| Some(frame(tick)));
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let words = format!("{} --rate-hz 2000 --loop", file.display());
    let received = receive(&words, Hand::LEFT, None);
    assert_eq!(received.code, Some(7), "{}", received.stderr);
    let count = received.frames().len();
    assert!(count > 0 && count < TICKS as usize, "{count}");
    for part in [
        format!("{count} frames played"),
        format!("atas record repair {}", file.display()),
    ] {
        assert!(
            received.stderr.contains(&part),
            "{part}: {}",
            received.stderr
        );
    }
}

#[test]
fn table_in_newtons_is_played() {
    let folder = tempfile::tempdir().unwrap();
    let [capture, table] = ["capture.bin", "table.csv"].map(|name| folder.path().join(name));
    // The third is a duplicate.
    let counts = [1, 2, 3, 3, 4, 5];
    fs::write(&capture, counts.map(numbered_frame).concat()).unwrap();
    let scale = "--newtons-per-count 0.5,0.25,2";
    let dry = Sensor::start(&capture, &format!("--dry-run --no-configure {scale}"));
    let (code, printed, stderr) = dry.finish();
    assert_eq!(code, Some(0), "{stderr}");
    fs::write(&table, &printed).unwrap();
    let words = format!("{} --rate-hz 100 --layout dome-1", table.display());
    let received = receive(&words, Hand::RIGHT, None);
    assert_eq!(received.code, Some(0), "{}", received.stderr);
    assert_eq!(received.sequences(), [0, 1, 2, 3, 4]);
    for (received, count) in received.frames().iter().zip(1..) {
        let [x, y, z] = common::forces_of(count).map(f32::from);
        assert_eq!(received.force_n[0][0], [-2.0 * z, 0.5 * x, 0.25 * y]);
        assert_eq!(
            (received.hand, received.finger_count, received.valid_mask),
            (Hand::RIGHT, 1, [1, 0, 0, 0])
        );
        assert_eq!(
            received.layout_hash,
            Layout::from_name("dome-1").unwrap().hash()
        );
    }
    check_spacing(&received, |_| 10_000_000);

    // Two fingertips with two elements each; one element is invalid once. The last frame is late:
    // frames of a process that has ended are lost.
    let header = "captured_ns".to_owned()
        + &[0, 1, 2, 3]
            .map(|e| format!(",normal{e}_n,tangential1{e}_n,tangential2{e}_n"))
            .concat();
    let lines = [
        "1000,1,2,3,4,5,6,7,8,9,10,11,12",
        "1001000,1,2,3,nan,5,6,7,8,9,10,11,12",
        "501001000,1,2,3,4,5,6,7,8,9,10,11,12",
    ];
    fs::write(&table, format!("{header}\n{}\n", lines.join("\n"))).unwrap();
    let received = receive(
        &format!("{} --fingers 2", table.display()),
        Hand::LEFT,
        None,
    );
    let masks: Vec<_> = received
        .frames()
        .iter()
        .map(|frame| frame.valid_mask)
        .collect();
    assert_eq!(
        masks,
        [[3, 3, 0, 0], [1, 3, 0, 0], [3, 3, 0, 0]],
        "{}",
        received.stderr
    );
    assert_eq!(received.frames()[1].force_n[1][1], [10.0, 11.0, 12.0]);
    assert_eq!(
        received.frames()[1].layout_hash,
        Layout::from_name("pad-2").unwrap().hash()
    );
    check_spacing(&received, |frame| match frame.stamp.sequence {
        2 => 500_000_000,
        _ => 1_000_000,
    });
}

#[test]
fn unplayable_source_is_rejected_with_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = recorded(&path("run.mcap"), 5, |tick| Some(frame(tick)));
    let other = recorded(&path("other.mcap"), 6, |_| None);
    let mut cut = fs::read(&run).unwrap();
    cut.truncate(40);
    let written = |name: &str, bytes: &[u8]| {
        fs::write(path(name), bytes).unwrap();
        path(name)
    };
    let cut = written("cut.mcap", &cut);
    let empty = written("empty", b"");
    let counts = written(
        "counts.csv",
        b"byte_offset,count,status,fx_counts,arrival,captured_ns\n",
    );
    let none = written(
        "none.csv",
        b"captured_ns,normal_n,tangential1_n,tangential2_n\n",
    );
    let wrong = written(
        "wrong.csv",
        b"captured_ns,normal_n,tangential1_n,tangential2_n\nsoon,1,2,3\n",
    );
    let [run, other, cut, empty, counts, none, wrong] =
        [run, other, cut, empty, counts, none, wrong].map(|path| path.display().to_string());
    let check = |words: &str, hand: Hand, code: i32, part: &str| {
        let received = receive(words, hand, None);
        assert_eq!(received.code, Some(code), "{words}: {}", received.stderr);
        assert!(
            received.stderr.contains(part),
            "{words}: {}",
            received.stderr
        );
        assert!(received.frames().is_empty());
    };
    check(&run, Hand::RIGHT, 7, "only the other hand has frames");
    check(&other, Hand::LEFT, 7, "recorded without a sensor");
    check(&cut, Hand::LEFT, 7, "atas record repair");
    check(&empty, Hand::LEFT, 7, "neither a recording");
    check(&counts, Hand::LEFT, 7, "--newtons-per-count");
    check(&none, Hand::LEFT, 7, "it has no frames");
    check(
        &wrong,
        Hand::LEFT,
        7,
        "after row 1: its captured_ns is \"soon\"",
    );
    check("nowhere.mcap", Hand::LEFT, 7, "could not open nowhere.mcap");
    check(
        &format!("{run} {other}"),
        Hand::LEFT,
        7,
        "2 runs of the daemon",
    );
    check(&format!("{none} {none}"), Hand::LEFT, 2, "several tables");
    check(
        &format!("{run} --fingers 2"),
        Hand::LEFT,
        2,
        "a recording contains its layout",
    );
    check(
        &format!("{none} --fingers 2"),
        Hand::LEFT,
        7,
        "set their number with --fingers",
    );
    check(
        &format!("{none} --layout dome"),
        Hand::LEFT,
        7,
        "pad-1, or dome-41",
    );
    check(
        &format!("{run} --speed 0"),
        Hand::LEFT,
        2,
        "from 0.01 to 100",
    );
    check(
        &format!("{run} --speed 2 --rate-hz 5"),
        Hand::LEFT,
        2,
        "cannot be used with",
    );

    let bus = FreshBus::new("replay");
    let words = format!("replay {run} --hand left --loop --bus {}", *bus);
    let mut reader = Reader::new(&bus, Hand::LEFT);
    let first = Sensor::start_line(&words);
    reader.wait_for_start();
    let (code, _, stderr) = Sensor::start_line(&words).finish();
    assert_eq!(code, Some(8), "{stderr}");
    first.signal(Signal::TERM);
    assert_eq!(first.finish().0, Some(0));
}
