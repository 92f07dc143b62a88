use std::fs;

use proptest::prelude::*;
use shm_schemas::Stamp;

use super::*;

/// Parts between two flushes.
const FLUSHED: u64 = 3;

/// Returns a recording's bytes, and after each flush its size and number of parts.
fn recording(folder: &Path) -> (Vec<u8>, Vec<(u64, u64)>) {
    let path = folder.join("whole.mcap");
    let mut writer = Writer::create(&path).expect("made");
    let mut flushed = Vec::new();
    for sequence in 0..5 * FLUSHED {
        let stamp = Stamp {
            sequence,
            ..Stamp::default()
        };
        let part = TickInputs {
            stamp,
            ..TickInputs::default()
        };
        writer.write(&part).expect("written");
        if (sequence + 1) % FLUSHED == 0 {
            flushed.push((writer.flush().expect("flushed"), sequence + 1));
        }
    }
    writer.finish().expect("finished");
    (fs::read(&path).expect("read"), flushed)
}

fn contents(path: &Path) -> Contents {
    Contents::read(path, |_| Ok(())).expect("opened")
}

fn repair_into(path: &Path, out: &Path) {
    let _ = fs::remove_file(out);
    save(path, out).expect("repaired");
}

#[test]
fn complete_recording_has_no_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, _) = recording(folder.path());
    let whole = contents(&folder.path().join("whole.mcap"));
    assert_eq!((whole.parts, whole.lost, whole.damage), (15, 0, None));
}

#[test]
fn existing_recording_is_not_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    recording(folder.path());
    assert!(Writer::create(&folder.path().join("whole.mcap")).is_err());
}

#[test]
fn truncated_recording_keeps_flushed_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let (bytes, flushed) = recording(folder.path());
    let (cut, out) = (
        folder.path().join("cut.mcap"),
        folder.path().join("out.mcap"),
    );
    proptest!(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }, |(length in 0..bytes.len())| {
        fs::write(&cut, &bytes[..length]).expect("written");
        prop_assert!(contents(&cut).damage.is_some(), "cut at {}", length);
        repair_into(&cut, &out);
        let saved = contents(&out);
        let kept = flushed.iter().filter(|(size, _)| *size <= length as u64);
        let least = kept.map(|(_, parts)| *parts).max().unwrap_or(0);
        prop_assert!(saved.parts >= least, "cut at {}: {} of {}", length, saved.parts, least);
        prop_assert_eq!((saved.lost, saved.damage), (0, None));
    });
}

#[test]
fn flipped_bit_is_reported_without_panic() {
    let folder = tempfile::tempdir().expect("a folder");
    let (bytes, flushed) = recording(folder.path());
    let (bad, out) = (
        folder.path().join("bad.mcap"),
        folder.path().join("out.mcap"),
    );
    let data_end = flushed.last().expect("flushed").0 as usize;
    proptest!(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }, |(at in 0..data_end, bit in 0..8_u32)| {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << bit;
        fs::write(&bad, &flipped).expect("written");
        prop_assert!(contents(&bad).damage.is_some(), "bit {} of byte {}", bit, at);
        repair_into(&bad, &out);
        prop_assert_eq!(contents(&out).damage, None);
    });
}

#[test]
fn sequences_at_the_ends_of_their_range_are_counted_without_overflow() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("crafted.mcap");
    let mut writer = Writer::create(&path).expect("created");
    for sequence in [0, u64::MAX, 1, u64::MAX - 1, 2, u64::MAX] {
        let part = TickInputs {
            stamp: Stamp {
                sequence,
                captured_ns: u64::MAX - sequence,
                ..Stamp::default()
            },
            ..TickInputs::default()
        };
        writer.write(&part).expect("written");
    }
    writer.finish().expect("finished");
    let found = contents(&path);
    assert_eq!((found.parts, found.lost), (6, u64::MAX));
    repair_into(&path, &folder.path().join("repaired.mcap"));
}
