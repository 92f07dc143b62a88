//! Evaluation of recorded runs: the real recorder writes frames with known truth.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use atas_evaluation::recorded::{Fit, Labels, Model, Sheet, Verdict, evaluate, open};
use atas_recording::{Bounds, record};
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::service::{RUN_HEADER, TICK_INPUTS};
use shm_schemas::{Hand, HandFrame, RunHeader, Stamp, TickInputs};

/// Time of the first tick, ns.
const BEGUN_NS: u64 = 7_000_000_000;
/// Frames per case, at 100 Hz.
const CASE: u64 = 250;
const CASES: u64 = 12;
const ELEMENTS: usize = 24;

fn noise(index: u64) -> f64 {
    let mut z = (index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

/// Frame with slip on the second fingertip in every second case; one element is invalid at times.
fn sliding(n: u64) -> HandFrame {
    let (case, at_s) = (n / CASE, (n % CASE) as f64 / 100.0);
    let speed_n_s = if case % 2 == 1 { 0.5 } else { 0.01 };
    let mut frame = blank(n, 2);
    frame.valid_mask[1] = (1 << ELEMENTS) - 1;
    for element in 0..ELEMENTS {
        let moved_n = speed_n_s * at_s * (1.0 + (element % 5) as f64 * 0.3);
        let flicker_n = 0.06 * noise(n * ELEMENTS as u64 + element as u64);
        frame.force_n[1][element] = [(3.0 + moved_n + flicker_n) as f32, 0.25, -0.5];
    }
    if n % 17 == 3 {
        frame.valid_mask[1] &= !(1 << 5);
    }
    frame.seal();
    frame
}

/// Frame of two one-element fingertips. The first has contact in every second case; one frame is
/// damaged.
fn pressing(n: u64) -> HandFrame {
    let mut frame = blank(n, 2);
    frame.valid_mask = [1, 1, 0, 0];
    let is_pressed = n / CASE % 2 == 1;
    frame.force_n[0][0] = [if is_pressed { 40.0 } else { 0.5 }, 0.1, 0.2];
    frame.seal();
    if n == 600 {
        frame.force_n[0][0] = [40.0; 3];
    }
    frame
}

fn blank(n: u64, finger_count: u32) -> HandFrame {
    HandFrame {
        stamp: Stamp {
            sequence: n,
            captured_ns: BEGUN_NS + n * 10_000_000,
            writer_epoch: 3,
        },
        hand: Hand::LEFT,
        finger_count,
        ..HandFrame::default()
    }
}

fn recorded(out: &Path, frame: impl Fn(u64) -> HandFrame) {
    let bus = FreshBus::new("tape");
    let node = |name| Bus::open(&bus, name, Realtime::No).expect("a bus");
    let (listening, stop) = (AtomicBool::new(false), AtomicBool::new(false));
    thread::scope(|scope| {
        let recorder = scope.spawn(|| {
            let bounds = Bounds {
                file_bytes: None,
                files: None,
                total_bytes: None,
            };
            let listens = || listening.store(true, Ordering::Relaxed);
            record(
                &node("recorder"),
                out,
                bounds,
                BTreeMap::new(),
                None,
                listens,
                &stop,
            )
        });
        while !listening.load(Ordering::Relaxed) {
            assert!(!recorder.is_finished(), "the recorder listens");
            thread::sleep(Duration::from_millis(1));
        }
        let daemon = node("daemon");
        let runs = daemon.publisher(RUN_HEADER).expect("free");
        runs.send(&RunHeader::default()).expect("sent");
        let inputs = daemon.publisher::<TickInputs>(TICK_INPUTS).expect("free");
        for n in 0..CASE * CASES {
            let mut part: Box<TickInputs> = Box::default();
            part.stamp.sequence = n;
            part.stamp.captured_ns = BEGUN_NS + n * 10_000_000;
            part.tick = n;
            part.parts = 1;
            part.has_frame = [1, 0];
            part.frames[0] = frame(n);
            inputs.send(&*part).expect("sent");
            thread::sleep(Duration::from_micros(300));
        }
        thread::sleep(Duration::from_millis(50));
        stop.store(true, Ordering::Relaxed);
        let tally = recorder.join().expect("no panic").expect("recorded");
        assert_eq!((tally.parts, tally.lost), (CASE * CASES, 0));
    });
}

fn labelled() -> Labels {
    Labels {
        column: Some("label".to_owned()),
        ..Labels::default()
    }
}

/// Returns the label table with the spans of all cases; `of` appends columns to each.
fn spans(header: &str, of: impl Fn(u64) -> String) -> String {
    let seconds = CASE as f64 / 100.0;
    let mut text = format!("from_s,to_s,label{header}\n");
    for case in 0..CASES {
        // Ends before the next case's first frame.
        let (from_s, to_s) = (case as f64 * seconds, (case + 1) as f64 * seconds - 0.005);
        writeln!(text, "{},{to_s},{}{}", from_s - 0.005, case % 2, of(case)).expect("a string");
    }
    text
}

fn verdict(sheet: &Sheet, labels: &Labels, fit: Fit) -> Verdict {
    let model = Model::built_in().expect("a model");
    evaluate(sheet, labels, &model, fit).expect("judged")
}

#[test]
fn run_and_table_give_the_same_verdict() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run.mcap");
    recorded(&run, sliding);
    let beside = folder.path().join("run.csv");
    let object = |case| format!(",left,1,o{}", case % 3);
    fs::write(&beside, spans(",hand,finger,object", object)).expect("written");
    let mut table = "sequence,t_s,label,object".to_owned();
    for element in 0..ELEMENTS {
        let names = ["normal", "tangential1", "tangential2"];
        for axis in names {
            write!(table, ",{axis}{element}_n").expect("a string");
        }
    }
    table.push('\n');
    for n in 0..CASE * CASES {
        let (case, frame) = (n / CASE, sliding(n));
        let at_s = (n * 10_000_000) as f64 * 1e-9;
        write!(table, "{case},{at_s},{},o{}", case % 2, case % 3).expect("a string");
        for element in 0..ELEMENTS {
            for axis in frame.force_n[1][element] {
                let is_valid = frame.valid_mask[1] >> element & 1 == 1;
                let cell = if is_valid {
                    axis.to_string()
                } else {
                    String::new()
                };
                write!(table, ",{cell}").expect("a string");
            }
        }
        table.push('\n');
    }
    let table = Sheet::read(Path::new("made.csv"), table.as_bytes()).expect("a table");
    // The label table is found by the run's name, or given explicitly.
    let named = Labels {
        file: Some(beside),
        ..labelled()
    };
    for (labels, fit) in [(labelled(), Fit::Given), (named, Fit::Across)] {
        let (sheet, labels) = open(&run, &labels).expect("a run");
        let found = verdict(&sheet, &labels, fit);
        let rates = found.rates.expect("two classes");
        assert_eq!(
            (found.n, found.objects, rates.auc),
            (12, 3, 1.0),
            "{found:?}"
        );
        let json = |verdict: &Verdict| serde_json::to_string(verdict).expect("JSON");
        assert_eq!(json(&found), json(&verdict(&table, &labelled(), fit)));
    }
}

#[test]
fn contacts_of_one_fingertip_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = folder.path().join("run.mcap");
    recorded(&run, pressing);
    let beside = folder.path().join("run.csv");
    let opened = || open(&run, &labelled());
    let refused = |part: &str| {
        let error = format!("{:#}", opened().expect_err(part));
        assert!(error.contains(part), "{part}: {error}");
    };
    refused("from_s,to_s and a label");
    let check = |text: &str, part: &str| {
        fs::write(&beside, text).expect("written");
        refused(part);
    };
    check("label\n1\n", "but from_s, to_s and a label are needed");
    check("from_s,to_s,label\n2,1,x\n", "row 1");
    check("from_s,to_s,label,hand\n1,2,x,both\n", "row 1");
    check("from_s,to_s,label,finger\n1,2,x,4\n", "row 1");
    check(
        "from_s,to_s,label\n100,200,x\n",
        "none of its frames lies within",
    );
    check(
        "from_s,to_s,label,hand\n1,2,x,right\n",
        "none of its frames lies within",
    );
    check(
        "from_s,to_s,label\n1,2,x\n",
        "contacts of several fingertips",
    );
    fs::write(&beside, spans(",finger", |_| ",0".to_owned())).expect("written");
    let (sheet, labels) = opened().expect("a run");
    let found = verdict(&sheet, &labels, Fit::Given);
    // The damaged frame is ignored.
    assert_eq!(found.n as u64, CASE * CASES - 1);
    assert_eq!(found.touches.expect("touches").len() as u64, CASES / 2);
    assert!(found.rates.expect("two classes").balanced_accuracy > 0.98);
}
