//! Decoder on a long generated stream and, if present, on a real recording, which is not part of
//! this repository.
#![expect(clippy::print_stderr, reason = "says when the recording is absent")]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use atas_sensors::continuity::{Continuity, Totals};
use atas_sensors::reading::ByteCounts;
use atas_sensors::wire::optoforce::{DataFrame, Decoder, Message};
use common::{acknowledgement, numbered_frame};

/// Returns the recording from the folder next to the workspace, if present.
fn recording() -> Option<(Vec<u8>, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/optoforce_wire");
    let bytes = fs::read(folder.join("capture.bin")).ok();
    if bytes.is_none() {
        eprintln!(
            "SKIPPED: no recording at {}; only the generated stream is tested",
            folder.display()
        );
    }
    Some((bytes?, folder))
}

fn frames_of(stream: &[u8], chunk: usize) -> (Vec<DataFrame>, ByteCounts) {
    let (mut decoder, mut frames) = (Decoder::default(), Vec::new());
    let mut keep = |message: Message| {
        if let Message::Data(frame) = message {
            frames.push(frame);
        }
    };
    stream
        .chunks(chunk)
        .for_each(|bytes| decoder.push(bytes, &mut keep));
    decoder.finish(&mut keep);
    (frames, decoder.counts())
}

/// A stream like the recording: an acknowledgement, frames without gaps across the wrap, a
/// truncated end.
#[test]
fn long_generated_stream_decodes_exactly() {
    const FRAMES: u16 = 34_374;
    let count = |n: u16| n.wrapping_add(50_000);
    let mut stream = acknowledgement(0);
    stream.extend((0..FRAMES).flat_map(|n| numbered_frame(count(n))));
    stream.extend(&numbered_frame(7)[..9]);
    for chunk in [1, 7, 64, stream.len()] {
        let (frames, counts) = frames_of(&stream, chunk);
        let expected = ByteCounts {
            received: 550_000,
            data: 34_374 * 16,
            acknowledgement: 7,
            junk: 9,
            pending: 0,
            frames: 34_374,
            acknowledgements: 1,
            checksum_failures: 0,
        };
        assert_eq!(counts, expected, "chunks of {chunk}");
        assert!(
            frames
                .iter()
                .zip(0..FRAMES)
                .all(|(frame, n)| frame.count == count(n)
                    && frame.forces().next() == Some(common::forces_of(count(n))))
        );
    }
    assert_neighbours_survive(&stream[7..]);
}

#[test]
fn recording_decodes_exactly() {
    let Some((stream, folder)) = recording() else {
        return;
    };
    for chunk in [1, 7, 64, stream.len()] {
        let (frames, counts) = frames_of(&stream, chunk);
        let expected = ByteCounts {
            received: 550_000,
            data: 34_374 * 16,
            acknowledgement: 7,
            junk: 9,
            pending: 0,
            frames: 34_374,
            acknowledgements: 1,
            checksum_failures: 0,
        };
        assert_eq!(counts, expected, "chunks of {chunk}");
        let mut continuity = Continuity::new(16);
        for frame in &frames {
            continuity.observe(frame.count.into());
        }
        assert_eq!(continuity.totals(), Totals::default());
        assert_eq!((frames[0].count, frames[34_373].count), (11_626, 45_999));
    }
    let frames = frames_of(&stream, 4096).0;
    let mut rows = csv::Reader::from_path(folder.join("frames_expected.csv"))
        .expect("the recording comes with its table");
    let mut compared = 0;
    for (row, frame) in rows
        .deserialize::<(u64, u16, u16, i16, i16, i16)>()
        .zip(&frames)
    {
        let [fx, fy, fz] = frame.forces().next().expect("a frame has a channel");
        assert_eq!(
            row.expect("the table is sound"),
            (frame.byte_offset, frame.count, frame.status.0, fx, fy, fz)
        );
        compared += 1;
    }
    assert_eq!(compared, 1_250);
}

#[test]
fn damaged_frame_leaves_neighbours_intact() {
    let Some((stream, _)) = recording() else {
        return;
    };
    assert_neighbours_survive(&stream[7..]);
}

/// One byte of every frame is deleted or doubled, or the frame is truncated there. The frames
/// before and after remain.
fn assert_neighbours_survive(stream: &[u8]) {
    let frames: Vec<&[u8]> = stream.chunks_exact(16).collect();
    for (n, at) in (1..frames.len() - 1).map(|n| (n, n * 7 % 16)) {
        let (before, hit, after) = (frames[n - 1], frames[n], frames[n + 1]);
        let damaged = [
            [&hit[..at], &hit[at + 1..]].concat(),
            [&hit[..=at], &hit[at..]].concat(),
            hit[..at].to_vec(),
        ];
        for middle in damaged {
            let found: Vec<u16> = frames_of(&[before, &middle, after].concat(), 48)
                .0
                .iter()
                .map(|frame| frame.count)
                .collect();
            let count = |frame: &[u8]| u16::from_be_bytes([frame[4], frame[5]]);
            assert!(
                found.contains(&count(before)) && found.contains(&count(after)),
                "frame {n}, byte {at}: {found:?}"
            );
        }
    }
}
