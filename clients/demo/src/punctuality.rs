//! Missed deadlines of daemon and simulator during a goal, from their own counters.

use serde_json::{Value, json};
use shm_schemas::{Status, StatusFlags, WorldTruth};

/// Share of missed ticks above which machine load may have affected the outcome (design choice: a
/// bare loop at the highest priority misses up to 0.05 % on a shared virtual machine, 0 on an idle
/// machine).
const OVERLOAD_SHARE: f64 = 0.002;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Punctuality {
    pub(crate) ticks: u64,
    /// Daemon ticks skipped because their time had passed.
    pub(crate) daemon_missed: u64,
    pub(crate) simulator_missed: u64,
    /// Commands that expired without a successor, or were rejected.
    pub(crate) expired: u32,
    flags: u32,
}

impl Punctuality {
    /// Counts between two snapshots of truth and status in which `ticks` daemon ticks were due.
    pub(crate) fn between([from, to]: [(&WorldTruth, &Status); 2], ticks: u64) -> Self {
        Self {
            ticks,
            daemon_missed: to.1.missed_ticks.saturating_sub(from.1.missed_ticks),
            simulator_missed: to.0.missed_ticks.saturating_sub(from.0.missed_ticks),
            expired: to
                .0
                .expired_commands
                .saturating_sub(from.0.expired_commands),
            flags: to.1.flags,
        }
    }

    pub(crate) fn missed(&self) -> u64 {
        self.daemon_missed + self.simulator_missed
    }

    fn missed_share(&self) -> f64 {
        self.missed() as f64 / self.ticks.max(1) as f64
    }

    pub(crate) fn sum(counts: impl Iterator<Item = Self>) -> Self {
        counts.fold(Self::default(), |sum, next| Self {
            ticks: sum.ticks + next.ticks,
            daemon_missed: sum.daemon_missed + next.daemon_missed,
            simulator_missed: sum.simulator_missed + next.simulator_missed,
            expired: sum.expired + next.expired,
            flags: next.flags,
        })
    }

    /// Describes the counts; `None` in lock-step, where no tick can be missed.
    pub(crate) fn text(&self) -> Option<String> {
        let has = |flag| self.flags & flag != 0;
        if has(StatusFlags::LOCKSTEP) {
            return None;
        }
        let mut text = format!(
            "Real time: missed {} of {} ticks (atasd {}, atas-sim {}), {} commands expired; {}, {}.",
            self.missed(),
            self.ticks,
            self.daemon_missed,
            self.simulator_missed,
            self.expired,
            if has(StatusFlags::REALTIME) {
                "real-time scheduling"
            } else {
                "ordinary scheduling"
            },
            if has(StatusFlags::PHASE_LOCKED) {
                "phase-locked"
            } else {
                "not phase-locked"
            },
        );
        if self.missed_share() > OVERLOAD_SHARE {
            text += " The machine was overloaded, and held objects may slip: end other programs, \
                or use --lockstep.";
        } else if self.missed() > 0 {
            text += " Measure the timing of this machine with `atas bench latency`.";
        }
        if has(StatusFlags::DEGRADED) {
            text += " The daemon is DEGRADED, because it has no real-time rights: ticks start late \
                while other programs use its core (`atas doctor` names the missing rights).";
        }
        Some(text)
    }

    pub(crate) fn value(&self) -> Value {
        json!({
            "ticks": self.ticks,
            "missed_ticks": self.missed(),
            "starved": self.missed_share(),
            "missed_by_atasd": self.daemon_missed,
            "missed_by_atas_sim": self.simulator_missed,
            "expired_commands": self.expired,
            "lockstep": self.flags & StatusFlags::LOCKSTEP != 0,
            "realtime": self.flags & StatusFlags::REALTIME != 0,
            "phase_locked": self.flags & StatusFlags::PHASE_LOCKED != 0,
            "degraded": self.flags & StatusFlags::DEGRADED != 0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn snapshot(by_daemon: u64, by_simulator: u64) -> (WorldTruth, Status) {
        let truth = WorldTruth {
            missed_ticks: by_simulator,
            ..WorldTruth::default()
        };
        let status = Status {
            missed_ticks: by_daemon,
            ..Status::default()
        };
        (truth, status)
    }

    #[test]
    fn missed_ticks_of_both_processes_are_counted() {
        let check = |to: (WorldTruth, Status), expected: [u64; 3]| {
            let from = snapshot(7, 5);
            let counts = Punctuality::between([(&from.0, &from.1), (&to.0, &to.1)], 1000);
            let found = [
                counts.missed(),
                counts.daemon_missed,
                counts.simulator_missed,
            ];
            assert_eq!(found, expected);
        };
        check(snapshot(7, 5), [0, 0, 0]);
        check(snapshot(10, 7), [5, 3, 2]);
        check(snapshot(0, 0), [0, 0, 0]);
    }

    #[test]
    fn lock_step_has_no_punctuality_text() {
        let sentence = |flags, daemon_missed| {
            Punctuality {
                ticks: 9,
                daemon_missed,
                flags,
                ..Punctuality::default()
            }
            .text()
        };
        assert_eq!(sentence(StatusFlags::LOCKSTEP, 0), None);
        let reported =
            sentence(StatusFlags::REALTIME | StatusFlags::PHASE_LOCKED, 0).expect("a sentence");
        assert_eq!(
            reported,
            "Real time: missed 0 of 9 ticks (atasd 0, atas-sim 0), 0 commands expired; real-time scheduling, phase-locked."
        );
        let reported = sentence(StatusFlags::DEGRADED, 2).expect("a sentence");
        assert!(
            reported.contains("missed 2 of 9")
                && reported.contains("--lockstep")
                && reported.contains("DEGRADED"),
            "{reported}"
        );
    }
}
