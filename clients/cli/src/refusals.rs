//! Why the daemon refuses frames: what it counted, and what the sensor sends instead of what the configuration expects.

use std::time::{Duration, Instant};

use atas_client::{POLL, Session, layouts};
use shm_bus::{BusError, Subscriber};
use shm_schemas::{Cause, Hand, HandFrame, HandStatus, Status, service};

/// How long to wait for a frame to look at (ours: three of the slowest sensor, 30 Hz).
const FRAME: Duration = Duration::from_millis(100);

/// Frames of a hand that came and were not believed.
pub(crate) fn refused(sensor: &HandStatus) -> u64 {
    sensor.corrupt + sensor.mistimed + sensor.foreign + sensor.reordered
}

/// Waits a little where the daemon misses frames, so that two statuses can tell refusal from silence.
pub(crate) fn look_again(
    statuses: &mut Subscriber<Status>,
    status: &mut Status,
) -> Result<(), BusError> {
    let (before, begin) = (*status, Instant::now());
    let is_missed = |status: &Status| status.reason.cause == Cause::FRAMES_STOPPED;
    while is_missed(status) && refuses([&before, status]).is_none() && begin.elapsed() < FRAME {
        std::thread::sleep(POLL);
        statuses.newest(status)?;
    }
    Ok(())
}

/// Why the mode of the newer status is as it is. The daemon misses frames that it believes: that they come and are refused, its
/// counts tell.
pub(crate) fn why_so(looks: [&Status; 2]) -> String {
    let [_, now] = looks;
    match refuses(looks) {
        Some((hand, sensor)) => {
            let counted = kinds(sensor).map(|(count, what)| format!("{count} for their {what}"));
            let counted = counted.collect::<Vec<_>>().join(", ");
            format!("tactile frames of the {hand} hand come, but are refused: {counted}")
        }
        None => now.reason.to_string(),
    }
}

/// The hand whose frames the mode waits for while they come and are refused: none was ever believed, or more were refused since
/// the look before.
fn refuses([before, now]: [&Status; 2]) -> Option<(Hand, &HandStatus)> {
    let index = now.reason.index as usize;
    let (hand, sensor) = (Hand::BOTH.get(index)?, now.hands.get(index)?);
    let rises = before.pid == now.pid && refused(sensor) > refused(&before.hands[index]);
    let ever = sensor.frames == 0 && refused(sensor) > 0;
    let is_missed = now.reason.cause == Cause::FRAMES_STOPPED;
    (is_missed && (rises || ever)).then_some((*hand, sensor))
}

/// For what frames were refused, and how many.
fn kinds(sensor: &HandStatus) -> impl Iterator<Item = (u64, &'static str)> {
    let counted = [
        (sensor.corrupt, "checksum"),
        (sensor.mistimed, "timestamp"),
        (sensor.reordered, "order"),
        (sensor.foreign, "layout or writer"),
    ];
    counted.into_iter().filter(|(count, _)| *count > 0)
}

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
    layouts::name(hash).unwrap_or_else(|| format!("an unknown layout (hash {hash:016x})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{Layout, Reason};

    #[test]
    fn what_is_refused_is_not_told_as_silence() {
        let look = |value_ns: f64, sensor: HandStatus| {
            let mut status = Status {
                reason: Reason::limit(Cause::FRAMES_STOPPED, value_ns, 5e6).about(1),
                ..Status::default()
            };
            status.hands[1] = sensor;
            status
        };
        let check = |before: HandStatus, now: HandStatus, expected: &str| {
            let value_ns = if now.frames == 0 { f64::INFINITY } else { 6e6 };
            let looks = [before, now].map(|sensor| look(value_ns, sensor));
            assert_eq!(why_so([&looks[0], &looks[1]]), expected, "{now:?}");
        };
        let none = HandStatus::default();
        let believed = HandStatus { frames: 9, ..none };
        let corrupt = |corrupt, of: HandStatus| HandStatus { corrupt, ..of };
        check(
            none,
            none,
            "no tactile frame of hand right yet; is the sensor process running?",
        );
        let refused = "tactile frames of the right hand come, but are refused: ";
        check(
            corrupt(7, none),
            corrupt(7, none),
            &format!("{refused}7 for their checksum"),
        );
        check(
            believed,
            corrupt(7, believed),
            &format!("{refused}7 for their checksum"),
        );
        // What was refused long ago says nothing of now.
        check(
            corrupt(7, believed),
            corrupt(7, believed),
            "no tactile frame of hand right for 6.0 ms, allowed 5.0 ms; is the sensor process running?",
        );
        let mistimed = HandStatus {
            mistimed: 3,
            foreign: 2,
            reordered: 1,
            ..none
        };
        check(
            none,
            mistimed,
            &format!(
                "{refused}3 for their timestamp, 1 for their order, 2 for their layout or writer"
            ),
        );
        let stopped = Status {
            reason: Reason::of(Cause::ESTOP),
            ..look(6e6, corrupt(7, none))
        };
        assert_eq!(why_so([&stopped; 2]), Reason::of(Cause::ESTOP).to_string());
    }

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
