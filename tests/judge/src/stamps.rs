//! Stamp, validity and tick counter of consecutive commands.

use shm_schemas::JointCommand;

use crate::allowance::Allowance;
use crate::findings::{Findings, ViolationKind};

/// Relation of a command to the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// First command, or next one of the same writer.
    Next,
    /// Next command after the last one expired: the robot has stopped.
    Expired,
    /// Commands in between are unknown.
    Lost,
    /// First command of a new writer after an announced restart.
    NewWriter,
    /// First command of a new writer after unknown commands of the former one.
    NewWriterAfterLoss,
}

#[derive(Clone, Copy, Debug)]
struct Last {
    sequence: u64,
    epoch: u64,
    captured_ns: u64,
    valid_until_ns: u64,
    tick: u64,
}

/// Check of stamps.
#[derive(Clone, Debug)]
pub(crate) struct StampCheck {
    tick_ns: u64,
    validity_max_ns: u64,
    skips: bool,
    uneven: bool,
    last: Option<Last>,
    restart: bool,
    /// The commands before the next one may be unknown.
    paused: bool,
}

impl StampCheck {
    pub(crate) fn new(tick_ns: u64, validity_max_ns: u64) -> Self {
        Self {
            tick_ns,
            validity_max_ns,
            skips: false,
            uneven: false,
            last: None,
            restart: false,
            paused: false,
        }
    }

    pub(crate) fn allow(&mut self, allowance: Allowance) {
        self.skips |= allowance == Allowance::MissedTicks;
        self.uneven |= allowance == Allowance::UnevenTicks;
    }

    /// Permits one new writer.
    pub(crate) fn restarted(&mut self) {
        self.restart = true;
    }

    /// Accepts a gap before the next command.
    pub(crate) fn observer_paused(&mut self) {
        self.paused = true;
    }

    /// Accepts any next sequence number, time and tick of the same writer, once.
    pub(crate) fn forget(&mut self) {
        self.last = None;
    }

    pub(crate) fn check(&mut self, command: &JointCommand, findings: &mut Findings) -> Relation {
        self.check_validity(command, findings);
        let now = Last {
            sequence: command.stamp.sequence,
            epoch: command.stamp.writer_epoch,
            captured_ns: command.stamp.captured_ns,
            valid_until_ns: command.valid_until_ns,
            tick: command.tick,
        };
        let paused = std::mem::take(&mut self.paused);
        match self.last.replace(now) {
            None => Relation::Next,
            Some(last) if last.epoch == now.epoch && paused => {
                check_later(&last, &now, findings);
                Relation::Lost
            }
            Some(last) if last.epoch == now.epoch => self.check_next(&last, &now, findings),
            Some(last) => self.check_writer(&last, &now, paused, findings),
        }
    }

    fn check_validity(&self, command: &JointCommand, findings: &mut Findings) {
        let (from_ns, until_ns) = (command.stamp.captured_ns, command.valid_until_ns);
        let valid_ns = until_ns.saturating_sub(from_ns);
        if valid_ns == 0 || valid_ns > self.validity_max_ns {
            findings.report(
                ViolationKind::Validity,
                format_args!(
                    "valid until {until_ns} ns, {} ns after the tick; permitted: 1 to {} ns",
                    i128::from(until_ns) - i128::from(from_ns),
                    self.validity_max_ns
                ),
            );
        }
    }

    fn check_writer(
        &mut self,
        last: &Last,
        now: &Last,
        paused: bool,
        findings: &mut Findings,
    ) -> Relation {
        check_later(last, now, findings);
        if !std::mem::take(&mut self.restart) {
            findings.report(
                ViolationKind::WriterEpoch,
                format_args!(
                    "writer epoch {} follows {} without a restart",
                    now.epoch, last.epoch
                ),
            );
            return Relation::Lost;
        }
        if now.sequence != 0 && !paused {
            findings.report(
                ViolationKind::Sequence,
                format_args!("a new writer begins with {}; expected 0", now.sequence),
            );
        }
        if paused {
            return Relation::NewWriterAfterLoss;
        }
        Relation::NewWriter
    }

    fn check_next(&self, last: &Last, now: &Last, findings: &mut Findings) -> Relation {
        let expected = last.sequence.wrapping_add(1);
        let follows = now.sequence == expected;
        if !follows {
            findings.report(
                ViolationKind::Sequence,
                format_args!("sequence number {}; expected {expected}", now.sequence),
            );
        }
        if check_later(last, now, findings) {
            self.check_period(last, now, findings);
        }
        if !follows {
            Relation::Lost
        } else if now.captured_ns > last.valid_until_ns {
            Relation::Expired
        } else {
            Relation::Next
        }
    }

    /// Checks captured time and tick counter against the period.
    fn check_period(&self, last: &Last, now: &Last, findings: &mut Findings) {
        let elapsed_ns = now.captured_ns - last.captured_ns;
        let periods = elapsed_ns / self.tick_ns;
        if !self.uneven && periods * self.tick_ns != elapsed_ns {
            findings.report(
                ViolationKind::CapturedTime,
                format_args!(
                    "{elapsed_ns} ns after the last tick; the period is {} ns",
                    self.tick_ns
                ),
            );
        }
        let ticks = now.tick.saturating_sub(last.tick);
        let in_step = ticks == 1 || ticks == periods || self.uneven;
        if ticks == 0 || !in_step {
            findings.report(
                ViolationKind::TickCounter,
                format_args!(
                    "tick {} follows {} after {elapsed_ns} ns",
                    now.tick, last.tick
                ),
            );
        } else if !self.skips && (ticks > 1 || (periods > 1 && !self.uneven)) {
            findings.report(
                ViolationKind::MissedTick,
                format_args!(
                    "{} ticks missing: {elapsed_ns} ns after the last one",
                    ticks.max(periods) - 1
                ),
            );
        }
    }
}

fn check_later(last: &Last, now: &Last, findings: &mut Findings) -> bool {
    let later = now.captured_ns > last.captured_ns;
    if !later {
        findings.report(
            ViolationKind::CapturedTime,
            format_args!(
                "captured at {} ns, not after the last tick at {} ns",
                now.captured_ns, last.captured_ns
            ),
        );
    }
    later
}
