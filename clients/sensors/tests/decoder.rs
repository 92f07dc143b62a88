//! Properties of the decoder: the result does not depend on chunks, damage loses no valid
//! neighbour, every byte is counted, and the result equals a search of the whole stream.

mod common;

use atas_sensors::reading::ByteCounts;
use atas_sensors::wire::optoforce::{Decoder, Kind, Message};
use common::{acknowledgement, data_frame, numbered_frame};
use proptest::prelude::*;

/// Decodes a stream in these chunks; returns messages and counts.
fn decode<'a>(chunks: impl IntoIterator<Item = &'a [u8]>) -> (Vec<Message>, ByteCounts) {
    let mut decoder = Decoder::default();
    let mut messages = Vec::new();
    for chunk in chunks {
        decoder.push(chunk, |message| messages.push(message));
        assert_balanced(decoder.counts());
        assert!(decoder.counts().pending < 34);
    }
    decoder.finish(|message| messages.push(message));
    assert_balanced(decoder.counts());
    assert_eq!(decoder.counts().pending, 0);
    (messages, decoder.counts())
}

fn assert_balanced(counts: ByteCounts) {
    assert_eq!(
        counts.received,
        counts.data + counts.acknowledgement + counts.junk + counts.pending
    );
}

/// Returns the counts of all data frames, in order.
fn frame_counts(messages: &[Message]) -> Vec<u16> {
    let count = |message: &Message| match message {
        Message::Data(frame) => Some(frame.count),
        Message::Acknowledgement(_) => None,
    };
    messages.iter().filter_map(count).collect()
}

/// Returns true if each of the expected counts occurs, in this order.
fn contains_in_order(found: &[u16], wanted: impl IntoIterator<Item = u16>) -> bool {
    let mut found = found.iter();
    wanted
        .into_iter()
        .all(|count| found.any(|&other| other == count))
}

/// Returns offset and length of every message, by a stateless search.
fn naive_search(stream: &[u8]) -> Vec<(u64, usize)> {
    let length_at = |rest: &[u8]| match rest {
        [0xAA, 0x07, 0x08, payload @ (0x0A | 0x10 | 0x1C), ..] => Some(usize::from(*payload) + 6),
        [0xAA, 0x00, 0x50, 0x01, ..] => Some(7),
        _ => None,
    };
    let is_valid = |bytes: &[u8]| {
        let (covered, sum) = bytes.split_at(bytes.len() - 2);
        covered.iter().map(|&b| u32::from(b)).sum::<u32>()
            == u32::from(u16::from_be_bytes([sum[0], sum[1]]))
    };
    (0..stream.len())
        .filter_map(|start| {
            let length = length_at(&stream[start..])?;
            is_valid(stream.get(start..start + length)?).then_some((start as u64, length))
        })
        .collect()
}

/// Pieces of damaged streams: complete and truncated messages, headers, junk.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let values = prop_oneof![
        prop::collection::vec(any::<i16>(), 3),
        prop::collection::vec(any::<i16>(), 6),
        prop::collection::vec(any::<i16>(), 12),
        // Payloads that look like headers.
        Just(vec![-22009, 2058, -22009]),
        Just(vec![0xAA, -22009, 2076]),
    ];
    let frame = (any::<u16>(), any::<u16>(), values)
        .prop_map(|(count, status, values)| data_frame(count, status, &values));
    let cut = (frame.clone(), any::<prop::sample::Index>())
        .prop_map(|(bytes, at)| bytes[..at.index(bytes.len())].to_vec());
    let header = prop_oneof![
        Just(vec![0xAA]),
        Just(vec![0xAA, 0x07, 0x08]),
        Just(vec![0xAA, 0x07, 0x08, 0x0A]),
        Just(vec![0xAA, 0x07, 0x08, 0x10]),
        Just(vec![0xAA, 0x07, 0x08, 0x1C]),
        Just(vec![0xAA, 0x00, 0x50, 0x01]),
    ];
    prop_oneof![
        4 => frame,
        2 => cut,
        2 => header,
        1 => any::<u8>().prop_map(acknowledgement),
        1 => prop::collection::vec(any::<u8>(), 0..40),
    ]
}

fn damaged_stream() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(piece(), 0..30).prop_map(|pieces| pieces.concat())
}

/// Junk without a message, but with parts of headers.
fn junk() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(
        prop_oneof![
            Just(0xAA_u8),
            Just(0x07),
            Just(0x08),
            Just(0x0A),
            Just(0x1C),
            any::<u8>()
        ],
        0..60,
    )
}

proptest! {
    #[test]
    fn chunking_changes_nothing(stream in damaged_stream(), sizes in prop::collection::vec(1_usize..50, 1..20)) {
        let mut rest = stream.as_slice();
        let mut chunks = Vec::new();
        for size in sizes.into_iter().cycle() {
            if rest.is_empty() { break; }
            let (chunk, tail) = rest.split_at(size.min(rest.len()));
            chunks.push(chunk);
            rest = tail;
        }
        prop_assert_eq!(decode(chunks), decode([stream.as_slice()]));
    }

    #[test]
    fn exactly_the_messages_of_a_naive_search_are_found(stream in damaged_stream()) {
        let (messages, counts) = decode([stream.as_slice()]);
        let offset = |message: &Message| match message {
            Message::Data(frame) => (frame.byte_offset, frame.kind.length()),
            Message::Acknowledgement(answer) => (answer.byte_offset, 7),
        };
        let naive = naive_search(&stream);
        prop_assert_eq!(messages.iter().map(offset).collect::<Vec<_>>(), naive.clone());
        let covered = |at: &usize| naive.iter().any(|&(start, length)| (start as usize..start as usize + length).contains(at));
        prop_assert_eq!(counts.junk, (0..stream.len()).filter(|at| !covered(at)).count() as u64);
    }

    #[test]
    fn junk_between_frames_costs_no_frame(junks in prop::collection::vec(junk(), 1..40)) {
        let mut stream = Vec::new();
        for (count, junk) in junks.iter().enumerate() {
            stream.extend(numbered_frame(count as u16));
            stream.extend(junk);
        }
        let found = frame_counts(&decode([stream.as_slice()]).0);
        prop_assert!(contains_in_order(&found, 0..junks.len() as u16), "{:?}", found);
    }

    #[test]
    fn one_corrupt_byte_costs_at_most_the_frame_it_hits(at in 0_usize..320, with: u8, start: u16) {
        let count = |n: usize| start.wrapping_add(n as u16);
        let mut stream: Vec<u8> = (0..20).flat_map(|n| numbered_frame(count(n))).collect();
        stream[at] = with;
        let found = frame_counts(&decode([stream.as_slice()]).0);
        let others = (0..20).filter(|&n| n != at / 16).map(count);
        prop_assert!(contains_in_order(&found, others), "{:?}", found);
    }

    #[test]
    fn a_dropped_or_inserted_byte_costs_at_most_the_frame_it_hits(at in 0_usize..320, insert: Option<u8>, start: u16) {
        let count = |n: usize| start.wrapping_add(n as u16);
        let mut stream: Vec<u8> = (0..20).flat_map(|n| numbered_frame(count(n))).collect();
        match insert {
            Some(byte) => stream.insert(at, byte),
            None => { stream.remove(at); }
        }
        let found = frame_counts(&decode([stream.as_slice()]).0);
        let others = (0..20).filter(|&n| n != at / 16).map(count);
        prop_assert!(contains_in_order(&found, others), "{:?}", found);
    }

    #[test]
    fn a_truncated_frame_costs_only_itself(cut in 0_usize..16, start: u16) {
        let stream = [&numbered_frame(start)[..cut], &numbered_frame(start.wrapping_add(1))].concat();
        prop_assert!(frame_counts(&decode([stream.as_slice()]).0).contains(&start.wrapping_add(1)));
    }

    #[test]
    fn all_kinds_are_read(count: u16, status: u16, values in prop::collection::vec(any::<i16>(), 12)) {
        for (kind, channels) in [(Kind::OneChannel, 1), (Kind::SixAxis, 1), (Kind::FourChannel, 4)] {
            let values = &values[..kind.value_count()];
            let (messages, counts) = decode([data_frame(count, status, values).as_slice()]);
            let Some(Message::Data(frame)) = messages.first() else { panic!("no {kind} frame") };
            prop_assert_eq!((frame.kind, frame.count, frame.status.0, frame.values()), (kind, count, status, values));
            let forces: Vec<_> = frame.forces().collect();
            prop_assert_eq!(forces.concat(), &values[..3 * channels]);
            prop_assert_eq!(counts.data, kind.length() as u64);
        }
    }
}

#[test]
fn shared_byte_gives_two_frames() {
    // Find a frame whose checksum ends in AA, and take that byte away.
    let first = (0..=u16::MAX)
        .map(numbered_frame)
        .find(|frame| frame.ends_with(&[0xAA]))
        .unwrap();
    let stream = [&first[..15], &numbered_frame(7)].concat();
    let (messages, counts) = decode([stream.as_slice()]);
    assert_eq!(messages.len(), 2);
    assert_eq!(
        (counts.data, counts.junk, counts.checksum_failures),
        (31, 0, 0)
    );
}

#[test]
fn checksum_failures_and_junk_are_counted() {
    let frame = numbered_frame(1);
    let mut corrupt = frame.clone();
    corrupt[9] ^= 0x10;
    let check = |pieces: &[&[u8]], frames, junk, failures| {
        let counts = decode([pieces.concat().as_slice()]).1;
        assert_eq!(
            (counts.frames, counts.junk, counts.checksum_failures),
            (frames, junk, failures),
            "{pieces:?}"
        );
    };
    check(&[&frame, &frame], 2, 0, 0);
    check(&[&frame, &corrupt, &frame], 2, 16, 1);
    check(&[&frame, b"junk", &frame], 2, 4, 0);
    check(&[&frame[..10], &frame], 1, 10, 1);
    check(&[&frame, &frame[..10]], 1, 10, 0);
    // A false header of the longest kind before a single frame: the stream ends before it fails.
    check(&[&[0xAA, 7, 8, 0x1C], &frame], 1, 4, 0);
    check(&[&[0xAA, 7, 8, 0x1C], &frame, &frame], 2, 4, 1);
    check(&[&acknowledgement(0), &frame, &acknowledgement(1)], 1, 0, 0);
}
