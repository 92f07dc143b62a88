//! Recordings played onto the bus: written by the real recorder, played by the real program, read by a real reader.

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

/// The left hand's frame of a tick, as a sensor process would send it.
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

/// A run of which the recorder wrote what the tick takes in; `frame` says what that is.
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

/// What reached a reader of that hand, and how the program ended.
struct Heard {
    reader: Reader,
    code: Option<i32>,
    stderr: String,
}

impl Heard {
    fn frames(&self) -> &[HandFrame] {
        &self.reader.received
    }

    fn sequences(&self) -> Vec<u64> {
        let frames = self.frames().iter();
        frames.map(|frame| frame.stamp.sequence).collect()
    }
}

/// Plays until its end, or until so many frames were heard.
fn hear(words: &str, hand: Hand, until: Option<(usize, Signal)>) -> Heard {
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
                return Heard {
                    reader,
                    code,
                    stderr,
                };
            }
            thread::sleep(Duration::from_millis(1));
        }
    })
}

/// Stamps keep the spacing; a machine that did not keep up has stretched it.
fn check_spacing(heard: &Heard, expected_ns: impl Fn(&HandFrame) -> u64) {
    let kept_up = heard.stderr.contains("0 delays");
    for pair in heard.frames().windows(2) {
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
fn what_was_recorded_is_played_bit_for_bit_with_fresh_stamps() {
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
    let heard = hear(&format!("{} --speed 0.5", file.display()), Hand::LEFT, None);
    assert_eq!(heard.code, Some(0), "{}", heard.stderr);
    let played: Vec<u64> = (0..TICKS)
        .filter(|tick| ![100, 200, 400].contains(tick))
        .collect();
    // Also lost: the frames of the three ticks that were left out, or had none.
    let sentence = format!(
        "{} frames played, 6 lost when recorded, 2 left out",
        played.len()
    );
    assert!(heard.stderr.contains(&sentence), "{}", heard.stderr);
    assert_eq!(heard.frames().len(), played.len());
    let epoch = heard.frames()[0].stamp.writer_epoch;
    assert_ne!(epoch, 77);
    for (heard, &tick) in heard.frames().iter().zip(&played) {
        let expected = frame(tick);
        assert!(heard.is_intact() && heard.stamp.captured_ns >= begun_ns);
        assert_eq!(heard.stamp.writer_epoch, epoch);
        assert_eq!(heard.stamp.sequence, expected.stamp.sequence - 70);
        let as_recorded = HandFrame {
            stamp: expected.stamp,
            crc32: expected.crc32,
            ..*heard
        };
        assert_eq!(as_recorded, expected);
    }
    check_spacing(&heard, |later| {
        let before = heard
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
    let status = heard.reader.status;
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
fn round_follows_round_at_the_rate_that_was_asked_for_until_a_signal() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(&folder.path().join("run.mcap"), 5, |tick| {
        (tick < 40).then(|| frame(tick))
    });
    let words = format!("{} --rate-hz 500 --loop", file.display());
    for signal in [Signal::INT, Signal::TERM] {
        let heard = hear(&words, Hand::LEFT, Some((100, signal)));
        assert_eq!(heard.code, Some(0), "{}", heard.stderr);
        let expected: Vec<u64> = (0..heard.frames().len() as u64).collect();
        assert_eq!(heard.sequences(), expected);
        for (n, heard) in heard.frames().iter().enumerate() {
            assert_eq!(heard.force_n, frame(n as u64 % 40).force_n);
        }
        check_spacing(&heard, |_| 2_000_000);
        let sentence = format!("{} frames played, 0 lost", heard.frames().len());
        assert!(heard.stderr.contains(&sentence), "{}", heard.stderr);
    }
}

#[test]
fn a_torn_recording_is_played_as_far_as_it_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(&folder.path().join("run.mcap"), 5, |tick| Some(frame(tick)));
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() * 3 / 4]).unwrap();
    let words = format!("{} --rate-hz 2000 --loop", file.display());
    let heard = hear(&words, Hand::LEFT, None);
    assert_eq!(heard.code, Some(5), "{}", heard.stderr);
    let count = heard.frames().len();
    assert!(count > 0 && count < TICKS as usize, "{count}");
    for part in [
        format!("{count} frames played"),
        format!("atas record repair {}", file.display()),
    ] {
        assert!(heard.stderr.contains(&part), "{part}: {}", heard.stderr);
    }
}

#[test]
fn a_table_in_newtons_is_played_too() {
    let folder = tempfile::tempdir().unwrap();
    let [capture, table] = ["capture.bin", "table.csv"].map(|name| folder.path().join(name));
    // The third comes twice.
    let counts = [1, 2, 3, 3, 4, 5];
    fs::write(&capture, counts.map(numbered_frame).concat()).unwrap();
    let scale = "--newtons-per-count 0.5,0.25,2";
    let dry = Sensor::start(&capture, &format!("--dry-run --no-configure {scale}"));
    let (code, printed, stderr) = dry.finish();
    assert_eq!(code, Some(0), "{stderr}");
    fs::write(&table, &printed).unwrap();
    let words = format!("{} --rate-hz 100 --layout dome-1", table.display());
    let heard = hear(&words, Hand::RIGHT, None);
    assert_eq!(heard.code, Some(0), "{}", heard.stderr);
    assert_eq!(heard.sequences(), [0, 1, 2, 3, 4]);
    for (heard, count) in heard.frames().iter().zip(1..) {
        let [x, y, z] = common::forces_of(count).map(f32::from);
        assert_eq!(heard.force_n[0][0], [-2.0 * z, 0.5 * x, 0.25 * y]);
        assert_eq!(
            (heard.hand, heard.finger_count, heard.valid_mask),
            (Hand::RIGHT, 1, [1, 0, 0, 0])
        );
        assert_eq!(heard.layout_hash, Layout::named("dome-1").unwrap().hash());
    }
    check_spacing(&heard, |_| 10_000_000);

    // Two fingers with two elements each, of which one was not felt once.
    let header = "captured_ns".to_owned()
        + &[0, 1, 2, 3]
            .map(|e| format!(",normal{e}_n,tangential1{e}_n,tangential2{e}_n"))
            .concat();
    let lines = [
        "1000,1,2,3,4,5,6,7,8,9,10,11,12",
        "1001000,1,2,3,nan,5,6,7,8,9,10,11,12",
    ];
    fs::write(&table, format!("{header}\n{}\n", lines.join("\n"))).unwrap();
    let heard = hear(
        &format!("{} --fingers 2", table.display()),
        Hand::LEFT,
        None,
    );
    let masks: Vec<_> = heard
        .frames()
        .iter()
        .map(|frame| frame.valid_mask)
        .collect();
    assert_eq!(masks, [[3, 3, 0, 0], [1, 3, 0, 0]], "{}", heard.stderr);
    assert_eq!(heard.frames()[1].force_n[1][1], [10.0, 11.0, 12.0]);
    assert_eq!(
        heard.frames()[1].layout_hash,
        Layout::named("pad-2").unwrap().hash()
    );
    check_spacing(&heard, |_| 1_000_000);
}

#[test]
fn what_cannot_be_played_is_refused_with_its_reason() {
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
        let heard = hear(words, hand, None);
        assert_eq!(heard.code, Some(code), "{words}: {}", heard.stderr);
        assert!(heard.stderr.contains(part), "{words}: {}", heard.stderr);
        assert!(heard.frames().is_empty());
    };
    check(&run, Hand::RIGHT, 3, "only the other hand has frames");
    check(&other, Hand::LEFT, 3, "no sensor was there");
    check(&cut, Hand::LEFT, 3, "atas record repair");
    check(&empty, Hand::LEFT, 3, "neither a recording");
    check(&counts, Hand::LEFT, 3, "--newtons-per-count");
    check(&none, Hand::LEFT, 3, "it has no frames");
    check(
        &wrong,
        Hand::LEFT,
        3,
        "beyond row 1: its captured_ns is \"soon\"",
    );
    check("nowhere.mcap", Hand::LEFT, 3, "could not open nowhere.mcap");
    check(
        &format!("{run} {other}"),
        Hand::LEFT,
        3,
        "2 runs of the daemon",
    );
    check(&format!("{none} {none}"), Hand::LEFT, 2, "several tables");
    check(
        &format!("{run} --fingers 2"),
        Hand::LEFT,
        2,
        "a recording has its own",
    );
    check(
        &format!("{none} --fingers 2"),
        Hand::LEFT,
        3,
        "say how many with --fingers",
    );
    check(
        &format!("{none} --layout dome"),
        Hand::LEFT,
        3,
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
    assert_eq!(code, Some(6), "{stderr}");
    first.signal(Signal::TERM);
    assert_eq!(first.finish().0, Some(0));
}
