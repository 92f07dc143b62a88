use shm_schemas::{HandFrame, Stamp};

use super::super::reader::{Entry, Reader, payload};
use super::*;

const KIB: u64 = 1 << 10;
/// Bytes of one part, before compression.
const PART: u64 = size_of::<TickInputs>() as u64;

/// Returns a part that does not compress.
fn part(sequence: u64) -> TickInputs {
    let mut state = sequence + 1;
    let mut frame = HandFrame::default();
    for element in frame.force_n.iter_mut().flatten().flatten() {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        *element = f32::from_bits((state >> 33) as u32 >> 2);
    }
    TickInputs {
        stamp: Stamp {
            sequence,
            ..Stamp::default()
        },
        frames: [frame; 2],
        ..TickInputs::default()
    }
}

/// Records parts of one run within the limits.
fn recorded(folder: &Path, bounds: Bounds, parts: u64) -> Tally {
    let mut recording =
        Recording::create(&folder.join("run.mcap"), bounds, notes(), None).expect("made");
    recording.begin_run(Box::default()).expect("begun");
    for sequence in 0..parts {
        recording.inputs(&part(sequence)).expect("written");
        if !recording.flush_and_rotate().expect("kept up") {
            break;
        }
    }
    recording.finish().expect("finished")
}

fn notes() -> BTreeMap<String, String> {
    BTreeMap::from([("seed".to_owned(), "7".to_owned())])
}

/// Returns the sequences in a file, which must be complete and contain origin and notes.
fn sequences(path: &Path) -> Vec<u64> {
    let mut sequences = Vec::new();
    let (mut headers, mut origins, mut noted) = (0, 0, 0);
    for entry in Reader::open(path).expect("opened") {
        match entry.expect("whole") {
            Entry::Message(message) => {
                headers += u32::from(
                    payload::<RunHeader>(&message)
                        .expect("this version")
                        .is_some(),
                );
                sequences.extend(
                    payload::<TickInputs>(&message)
                        .expect("this version")
                        .map(|part| part.stamp.sequence),
                );
            }
            Entry::Metadata(metadata) if metadata.name == NOTES => {
                noted += u32::from(metadata.metadata == notes());
            }
            Entry::Metadata(metadata) => origins += u32::from(metadata.name == ORIGIN),
        }
    }
    assert_eq!((headers, origins, noted), (1, 1, 1), "{}", path.display());
    sequences
}

fn unbounded() -> Bounds {
    Bounds {
        file_bytes: None,
        files: None,
        total_bytes: None,
    }
}

#[test]
fn large_file_continues_in_another_without_loss() {
    let folder = tempfile::tempdir().expect("a folder");
    let bounds = Bounds {
        file_bytes: Some(256 * KIB),
        ..unbounded()
    };
    let tally = recorded(folder.path(), bounds, 200);
    assert!(tally.files.len() >= 3, "{:?}", tally.files);
    let all: Vec<u64> = tally
        .files
        .iter()
        .flat_map(|file| sequences(file))
        .collect();
    assert!(all.into_iter().eq(0..200));
    for file in &tally.files {
        let size = std::fs::metadata(file).expect("there").len();
        assert!(
            size < 2 * 256 * KIB + 16 * KIB,
            "{}: {size}",
            file.display()
        );
    }
    assert_eq!(
        (tally.parts, tally.lost, tally.has_beginning),
        (200, 0, true)
    );
    let sizes = tally
        .files
        .iter()
        .map(|file| std::fs::metadata(file).expect("there").len());
    assert_eq!(tally.bytes, sizes.sum::<u64>());
}

#[test]
fn only_the_newest_files_are_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let bounds = Bounds {
        file_bytes: Some(128 * KIB),
        files: Some(2),
        ..unbounded()
    };
    let tally = recorded(folder.path(), bounds, 200);
    let there = std::fs::read_dir(folder.path()).expect("readable").count();
    assert_eq!((tally.files.len(), there), (2, 2), "{:?}", tally.files);
    let kept: Vec<u64> = tally
        .files
        .iter()
        .flat_map(|file| sequences(file))
        .collect();
    let first = *kept.first().expect("parts");
    assert!(first > 0 && kept.into_iter().eq(first..200));
}

#[test]
fn disk_budget_ends_recording_with_complete_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let budget = 512 * KIB;
    let bounds = Bounds {
        file_bytes: Some(200 * KIB),
        total_bytes: Some(budget),
        ..unbounded()
    };
    let tally = recorded(folder.path(), bounds, 1000);
    assert!(tally.parts < 1000, "{}", tally.parts);
    let most = budget + 200 * KIB + 2 * PART + 16 * KIB;
    assert!(
        tally.bytes >= budget && tally.bytes < most,
        "{}",
        tally.bytes
    );
    let all: Vec<u64> = tally
        .files
        .iter()
        .flat_map(|file| sequences(file))
        .collect();
    assert!(all.into_iter().eq(0..tally.parts));
}

#[test]
fn another_run_goes_into_another_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run.mcap");
    let mut recording = Recording::create(&out, unbounded(), notes(), None).expect("made");
    for run in 1..=2 {
        recording.begin_run(Box::default()).expect("begun");
        for sequence in 0..3 * run {
            recording.inputs(&part(sequence)).expect("written");
        }
    }
    let tally = recording.finish().expect("finished");
    let lengths: Vec<usize> = tally
        .files
        .iter()
        .map(|file| sequences(file).len())
        .collect();
    assert_eq!(
        (lengths, tally.lost, tally.has_beginning),
        (vec![3, 6], 0, true)
    );
}
