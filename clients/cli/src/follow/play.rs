//! A file of targets, sent as the daemon's time comes to each.

use std::io::Write as _;

use atas_client::{Led, POLL, Session, Wanted};
use atas_console::{Interrupt, Output};
use shm_bus::BusName;
use shm_schemas::Hand;

use super::file::Timed;
use super::{Stream, VALID_NS};

/// Time between two sendings of a target that is still wanted, ns (ours: 20 Hz).
const REPEAT_NS: u64 = 50_000_000;
/// How long the last targets are held before the stream ends, s (ours: the hand arrives).
const LAST_S: f64 = 2.0;

/// Leads the hands that the file names along its targets.
pub(super) fn play(
    targets: &[Timed],
    bus: &BusName,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut stream = Stream::open(&session, hands(targets))?;
    let mut present: [Option<Wanted>; 2] = [None; 2];
    let (mut next, mut sent, mut sent_ns) = (0, 0, 0);
    let end_s = targets.last().map_or(0.0, |last| last.t_s) + LAST_S;
    loop {
        for warning in stream.look()? {
            // If nobody can read it, nobody needs to be told.
            let _told = writeln!(std::io::stderr(), "atas: {warning}");
        }
        let now_ns = stream.leader.now_ns();
        let time_s = now_ns.saturating_sub(stream.begun_ns) as f64 * 1e-9;
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
                stream.leader.lead(wanted, VALID_NS)?;
                sent += 1;
            }
            sent_ns = now_ns;
        }
        std::thread::sleep(POLL / 5);
    }
}

fn hands(targets: &[Timed]) -> Led {
    let first = targets
        .first()
        .map_or(Hand::RIGHT, |target| target.wanted.hand);
    if targets.iter().all(|target| target.wanted.hand == first) {
        Led::One(first)
    } else {
        Led::Both
    }
}
