//! Why the daemon refuses frames: what it counted, and what the sensor sends instead of what the configuration expects.

use std::time::{Duration, Instant};

use atas_client::{POLL, Session};
use shm_schemas::{Hand, HandFrame, HandStatus, Layout, Status, service};

/// How long to wait for a frame to look at (ours: three of the slowest sensor, 30 Hz).
const FRAME: Duration = Duration::from_millis(100);

/// One sentence per hand that refused frames since the daemon's start.
pub(crate) fn refusals(session: &Session, status: &Status) -> anyhow::Result<Vec<String>> {
    let mut sentences = Vec::new();
    for (index, (hand, sensor)) in Hand::BOTH.iter().zip(&status.hands).enumerate() {
        let sent = if sensor.foreign > 0 {
            newest(session, service::HAND_FRAME[index])?
        } else {
            None
        };
        let reasons = reasons(*hand, sensor, sent.as_deref());
        if !reasons.is_empty() {
            sentences.push(format!("{hand} hand refused {}", reasons.join("; ")));
        }
    }
    Ok(sentences)
}

/// A frame as the sensor sends it; the daemon's own are not taken away by looking.
fn newest(session: &Session, service: &str) -> anyhow::Result<Option<Box<HandFrame>>> {
    let mut frames = session.bus().subscriber::<HandFrame>(service)?;
    let mut frame = Box::<HandFrame>::default();
    let begin = Instant::now();
    while begin.elapsed() < FRAME {
        if frames.newest(&mut frame)? {
            return Ok(Some(frame));
        }
        std::thread::sleep(POLL);
    }
    Ok(None)
}

fn reasons(hand: Hand, sensor: &HandStatus, sent: Option<&HandFrame>) -> Vec<String> {
    let counted = [
        (
            sensor.corrupt,
            "with a wrong checksum (CRC-32): memory was overwritten, or the sender is not of this version".to_owned(),
        ),
        (
            sensor.mistimed,
            "with a timestamp in the future or too old: does the sensor process use CLOCK_MONOTONIC?".to_owned(),
        ),
        (sensor.reordered, "that came after newer ones".to_owned()),
        (sensor.foreign, foreign(hand, sensor, sent)),
    ];
    let some = counted.into_iter().filter(|(count, _)| *count > 0);
    some.map(|(count, why)| format!("{count} frames {why}"))
        .collect()
}

/// What is foreign about a frame.
fn foreign(hand: Hand, sensor: &HandStatus, sent: Option<&HandFrame>) -> String {
    match sent {
        Some(frame) if frame.layout_hash != sensor.layout_hash => format!(
            "of another layout: they carry {}, the configuration says {}; set hands.{hand}.layout",
            layout(frame.layout_hash),
            layout(sensor.layout_hash)
        ),
        _ => format!("of another writer or hand: one process may feel for the {hand} hand"),
    }
}

/// A layout by its name, or its hash if it has none here.
fn layout(hash: u64) -> String {
    let named = |name: &&&str| Layout::named(name).is_some_and(|layout| layout.hash() == hash);
    Layout::NAMES.iter().find(named).map_or_else(
        || format!("an unknown layout (hash {hash:016x})"),
        |name| (*name).to_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_refusal_says_why_and_what_to_do() {
        let hash = |name| Layout::named(name).map_or(0, |layout| layout.hash());
        let frame = |layout_hash| HandFrame {
            layout_hash,
            ..HandFrame::default()
        };
        let sensor = HandStatus {
            layout_hash: hash("dome-41"),
            ..HandStatus::default()
        };
        let check = |sensor: HandStatus, sent: Option<&HandFrame>, parts: &[&str]| {
            let told = reasons(Hand::LEFT, &sensor, sent);
            assert_eq!(told.len(), usize::from(!parts.is_empty()), "{told:?}");
            let part_is_there = |part: &&str| told.iter().any(|told| told.contains(*part));
            assert!(parts.iter().all(part_is_there), "{told:?}");
        };
        check(sensor, None, &[]);
        let corrupt = HandStatus {
            corrupt: 3,
            ..sensor
        };
        check(corrupt, None, &["3 frames", "checksum (CRC-32)"]);
        let foreign = HandStatus {
            foreign: 7,
            ..sensor
        };
        let other = frame(hash("dome-1"));
        check(
            foreign,
            Some(&other),
            &[
                "7 frames",
                "carry dome-1, the configuration says dome-41",
                "hands.left.layout",
            ],
        );
        let unknown = frame(0xfeed);
        check(foreign, Some(&unknown), &["hash 000000000000feed"]);
        let same = frame(hash("dome-41"));
        check(foreign, Some(&same), &["another writer or hand"]);
        check(foreign, None, &["another writer or hand"]);
    }
}
