//! Playback of a target file, in the daemon's time.

use std::io::Write as _;

use atas_client::{POLL, Session, TeleopHands, TeleopTarget};
use atas_console::{Interrupt, Output};
use shm_bus::BusName;
use shm_schemas::Hand;

use super::file::TimedTarget;
use super::{Stream, VALID_NS};

/// Repetition period of a valid target, ns. Design choice: 20 Hz.
const REPEAT_NS: u64 = 50_000_000;
/// Hold time of the last targets before the stream ends, s. Design choice: lets the hand arrive.
const FINAL_HOLD_S: f64 = 2.0;

/// Moves the hands of the file along its targets.
pub(super) fn play(
    targets: &[TimedTarget],
    bus: &BusName,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut stream = Stream::open(&session, hands(targets))?;
    let mut present: [Option<TeleopTarget>; 2] = [None; 2];
    let (mut next, mut sent, mut sent_ns) = (0, 0, 0);
    let end_s = targets.last().map_or(0.0, |last| last.t_s) + FINAL_HOLD_S;
    loop {
        for warning in stream.poll()? {
            // Failed warning output must not stop the playback.
            let _written = writeln!(std::io::stderr(), "atas: {warning}");
        }
        let now_ns = stream.leader.now_ns();
        let time_s = now_ns.saturating_sub(stream.started_ns) as f64 * 1e-9;
        if time_s > end_s || interrupt.is_set() {
            return stream.end(sent, interrupt.is_set(), output);
        }
        let mut news = now_ns.saturating_sub(sent_ns) > REPEAT_NS;
        while let Some(due) = targets.get(next).filter(|target| target.t_s <= time_s) {
            present[due.wanted.hand.index().unwrap_or(0)] = Some(due.wanted);
            (next, news) = (next + 1, true);
        }
        if news {
            for wanted in present.iter().flatten() {
                stream.leader.send(wanted, VALID_NS)?;
                sent += 1;
            }
            sent_ns = now_ns;
        }
        std::thread::sleep(POLL / 5);
    }
}

fn hands(targets: &[TimedTarget]) -> TeleopHands {
    let first = targets
        .first()
        .map_or(Hand::RIGHT, |target| target.wanted.hand);
    if targets.iter().all(|target| target.wanted.hand == first) {
        TeleopHands::One(first)
    } else {
        TeleopHands::Both
    }
}
