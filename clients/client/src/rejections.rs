//! Causes of rejected tactile frames: the daemon's counters, and received compared with configured
//! layout.

use std::time::{Duration, Instant};

use crate::{POLL, Session, layouts};
use shm_bus::{BusError, Subscriber};
use shm_schemas::{Hand, HandFrame, HandStatus, Reason, Status, service};

/// Longest wait for a frame. Design choice: three periods of the slowest sensor, 30 Hz.
const FRAME: Duration = Duration::from_millis(100);

/// Returns the number of rejected frames of a hand.
#[must_use]
pub fn rejected_frames(sensor: &HandStatus) -> u64 {
    sensor.corrupt + sensor.mistimed + sensor.foreign + sensor.reordered
}

/// Waits briefly if the daemon misses frames, so that two statuses distinguish rejected frames from
/// absent ones.
///
/// # Errors
/// [`BusError`] if the status cannot be read.
pub fn await_rejections(
    statuses: &mut Subscriber<Status>,
    status: &mut Status,
) -> Result<(), BusError> {
    let (before, begin) = (*status, Instant::now());
    while silent_hand(status).is_some()
        && rejecting_hand([&before, status]).is_none()
        && begin.elapsed() < FRAME
    {
        std::thread::sleep(POLL);
        statuses.newest(status)?;
    }
    Ok(())
}

/// Returns the reason for the mode of the newer status. The daemon reports only missing valid
/// frames; the counters show whether frames arrive and are rejected.
#[must_use]
pub fn mode_reason(looks: [&Status; 2]) -> String {
    let [_, now] = looks;
    match rejecting_hand(looks) {
        Some((hand, sensor)) => {
            let counted =
                counts_by_cause(sensor).map(|(count, what)| format!("{count} for {what}"));
            let counted = counted.collect::<Vec<_>>().join(", ");
            format!("tactile frames of the {hand} hand arrive but are rejected: {counted}")
        }
        None => now.reason.to_string(),
    }
}

/// Returns the hand whose missing frames cause the mode although frames arrive. Either no frame was
/// ever valid, or the number of rejected frames has increased since the earlier status.
fn rejecting_hand([before, now]: [&Status; 2]) -> Option<(Hand, &HandStatus)> {
    let hand = silent_hand(now)?;
    let index = hand.index()?;
    let sensor = &now.hands[index];
    let rises =
        before.pid == now.pid && rejected_frames(sensor) > rejected_frames(&before.hands[index]);
    let ever = sensor.frames == 0 && rejected_frames(sensor) > 0;
    (rises || ever).then_some((hand, sensor))
}

/// Returns the hand whose missing frames cause the mode.
fn silent_hand(status: &Status) -> Option<Hand> {
    match Reason::from(status.reason) {
        Reason::FramesStopped { hand, .. } => Some(hand),
        _ => None,
    }
}

/// Returns the causes of rejected frames with their counts.
fn counts_by_cause(sensor: &HandStatus) -> impl Iterator<Item = (u64, &'static str)> {
    let counted = [
        (sensor.corrupt, "checksum"),
        (sensor.mistimed, "timestamp"),
        (sensor.reordered, "order"),
        (sensor.foreign, "layout or writer"),
    ];
    counted.into_iter().filter(|(count, _)| *count > 0)
}

/// Describes the rejected frames since the daemon's start, one text per hand.
///
/// # Errors
/// [`BusError`] if the frames cannot be read.
pub fn rejection_texts(session: &Session, status: &Status) -> Result<Vec<String>, BusError> {
    let mut sentences = Vec::new();
    for (index, (hand, sensor)) in Hand::BOTH.iter().zip(&status.hands).enumerate() {
        let sent = if sensor.foreign > 0 {
            newest(session, service::HAND_FRAME[index])?
        } else {
            None
        };
        let reasons = reasons(*hand, sensor, sent.as_deref());
        if !reasons.is_empty() {
            sentences.push(format!("{hand} hand rejected {}", reasons.join("; ")));
        }
    }
    Ok(sentences)
}

/// Reads a frame of the sensor, without taking it from the daemon.
fn newest(session: &Session, service: &str) -> Result<Option<Box<HandFrame>>, BusError> {
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
            "with a wrong checksum (CRC-32): memory was overwritten, or the sender has another \
             version"
                .to_owned(),
        ),
        (
            sensor.mistimed,
            "with a timestamp in the future or too old: check that the sensor process uses \
             CLOCK_MONOTONIC"
                .to_owned(),
        ),
        (sensor.reordered, "that arrived after newer ones".to_owned()),
        (sensor.foreign, mismatch_text(hand, sensor, sent)),
    ];
    let some = counted.into_iter().filter(|(count, _)| *count > 0);
    some.map(|(count, why)| format!("{count} frames {why}"))
        .collect()
}

/// Describes the mismatch of a frame from another layout, writer or hand.
fn mismatch_text(hand: Hand, sensor: &HandStatus, sent: Option<&HandFrame>) -> String {
    match sent {
        Some(frame) if frame.layout_hash != sensor.layout_hash => format!(
            "of another layout: received {}, configured {}; set hands.{hand}.layout",
            layout_name(frame.layout_hash),
            layout_name(sensor.layout_hash)
        ),
        _ => format!(
            "of another writer or hand: only one process may publish frames of the {hand} \
            hand"
        ),
    }
}

/// Returns the name of a layout, or its hash if it is unknown.
fn layout_name(hash: u64) -> String {
    layouts::name(hash).unwrap_or_else(|| format!("an unknown layout (hash {hash:016x})"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::Layout;

    #[test]
    fn rejected_frames_are_not_reported_as_missing() {
        let look = |age_ns: Option<f64>, sensor: HandStatus| {
            let mut status = Status {
                reason: Reason::FramesStopped {
                    hand: Hand::RIGHT,
                    age_ns,
                    limit_ns: 5e6,
                }
                .into(),
                ..Status::default()
            };
            status.hands[1] = sensor;
            status
        };
        let check = |before: HandStatus, now: HandStatus, expected: &str| {
            let age_ns = (now.frames > 0).then_some(6e6);
            let looks = [before, now].map(|sensor| look(age_ns, sensor));
            assert_eq!(mode_reason([&looks[0], &looks[1]]), expected, "{now:?}");
        };
        let none = HandStatus::default();
        let believed = HandStatus { frames: 9, ..none };
        let corrupt = |corrupt, of: HandStatus| HandStatus { corrupt, ..of };
        check(
            none,
            none,
            "no tactile frame of hand right yet; is the sensor process running?",
        );
        let refused = "tactile frames of the right hand arrive but are rejected: ";
        check(
            corrupt(7, none),
            corrupt(7, none),
            &format!("{refused}7 for checksum"),
        );
        check(
            believed,
            corrupt(7, believed),
            &format!("{refused}7 for checksum"),
        );
        // Frames rejected long ago do not explain the present state.
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
            &format!("{refused}3 for timestamp, 1 for order, 2 for layout or writer"),
        );
        let stopped = Status {
            reason: Reason::Estop.into(),
            ..look(Some(6e6), corrupt(7, none))
        };
        assert_eq!(mode_reason([&stopped; 2]), Reason::Estop.to_string());
    }

    #[test]
    fn rejections_name_cause_and_fix() {
        let hash = |name| Layout::from_name(name).map_or(0, |layout| layout.hash());
        let frame = |layout_hash| HandFrame {
            layout_hash,
            ..HandFrame::default()
        };
        let sensor = HandStatus {
            layout_hash: hash("dome-41"),
            ..HandStatus::default()
        };
        let check = |sensor: HandStatus, sent: Option<&HandFrame>, parts: &[&str]| {
            let reported = reasons(Hand::LEFT, &sensor, sent);
            assert_eq!(
                reported.len(),
                usize::from(!parts.is_empty()),
                "{reported:?}"
            );
            let part_is_there =
                |part: &&str| reported.iter().any(|reported| reported.contains(*part));
            assert!(parts.iter().all(part_is_there), "{reported:?}");
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
                "received dome-1, configured dome-41",
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
