//! Mode machine. The most severe reaction wins; every mode change has a reason.
//!
//! ```text
//!               all checks pass                    goal started
//!   INIT ───────────────────────────▶ READY ◀───────────────────────▶ RUN
//!                                       │ ▲         goal ended         │ ▲
//!                                fault  │ │ no fault for        fault  │ │ no fault for that time
//!                                       ▼ │ the re-arm time            ▼ │ (goal paused)
//!                                       HOLD ◀─────────────────────────┘
//!       estop, shutdown, joint fault
//!   any ─────────────────────────▶ SAFE_STOP ── recover ──▶ HOLD
//!   any ── panic ──▶ FAULT (latched)
//! ```
//!
//! HOLD keeps position and grip. Opening the hand is never a fault reaction.
//!
//! The re-arm time is `REARM_S`. If the data only came too late, it is the time for which they were
//! missing, at least `REARM_LATE_S`: a single late frame on a busy machine pauses a goal briefly.

use crate::limits::{REARM_LATE_S, REARM_S};
use shm_schemas::{Mode, Reason};

/// Mode and its reason.
///
/// ```
/// use atas_core::ModeMachine;
/// use shm_schemas::{Mode, Reason};
///
/// let mut machine = ModeMachine::default();
/// assert_eq!(machine.mode(), Mode::INIT);
/// machine.stop(Reason::Estop);
/// assert_eq!(machine.mode(), Mode::SAFE_STOP);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ModeMachine {
    mode: Mode,
    reason: Reason,
    fault_free_ticks: u32,
    /// Duration of the faults of this HOLD, in ticks.
    fault_ticks: u32,
    /// Some fault of this HOLD was more than late data.
    rearms_fully: bool,
}

impl Default for ModeMachine {
    fn default() -> Self {
        Self {
            mode: Mode::INIT,
            reason: Reason::None,
            fault_free_ticks: 0,
            fault_ticks: 0,
            rearms_fully: true,
        }
    }
}

impl ModeMachine {
    /// Returns the mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns the reason for INIT, HOLD, SAFE_STOP or FAULT.
    #[must_use]
    pub fn reason(&self) -> Reason {
        self.reason
    }

    /// Runs one tick of `step_s`. A `hold_reason` requires HOLD; `has_goal`: a goal is active or
    /// paused.
    pub fn update(&mut self, hold_reason: Reason, has_goal: bool, step_s: f64) {
        if hold_reason.is_some() {
            if matches!(self.mode, Mode::READY | Mode::RUN) {
                (self.fault_ticks, self.rearms_fully) = (0, false);
            }
            self.fault_free_ticks = 0;
            self.fault_ticks = self.fault_ticks.saturating_add(1);
            self.rearms_fully |= !is_late_data(hold_reason);
        } else {
            self.fault_free_ticks = self.fault_free_ticks.saturating_add(1);
        }
        match self.mode {
            Mode::INIT if hold_reason.is_some() => self.reason = hold_reason,
            Mode::READY | Mode::RUN if hold_reason.is_some() => self.enter(Mode::HOLD, hold_reason),
            Mode::READY if has_goal => self.enter(Mode::RUN, Reason::None),
            Mode::RUN if !has_goal => self.enter(Mode::READY, Reason::None),
            Mode::INIT | Mode::HOLD if self.is_rearmed(step_s) => {
                self.enter(if has_goal { Mode::RUN } else { Mode::READY }, Reason::None);
            }
            _ => {}
        }
    }

    /// Latches SAFE_STOP.
    pub fn stop(&mut self, reason: Reason) {
        if self.mode != Mode::SAFE_STOP && self.mode != Mode::FAULT {
            self.enter(Mode::SAFE_STOP, reason);
        }
    }

    /// Latches FAULT after a failure of the daemon.
    pub fn fail(&mut self, reason: Reason) {
        if self.mode != Mode::FAULT {
            self.enter(Mode::FAULT, reason);
        }
    }

    /// Leaves SAFE_STOP for HOLD.
    pub fn recover(&mut self) {
        if self.mode == Mode::SAFE_STOP {
            (self.fault_free_ticks, self.rearms_fully) = (0, true);
            self.enter(Mode::HOLD, self.reason);
        }
    }

    fn is_rearmed(&self, step_s: f64) -> bool {
        let rearm_s = if self.rearms_fully {
            REARM_S
        } else {
            (f64::from(self.fault_ticks) * step_s).clamp(REARM_LATE_S, REARM_S)
        };
        f64::from(self.fault_free_ticks) * step_s >= rearm_s
    }

    fn enter(&mut self, mode: Mode, reason: Reason) {
        self.mode = mode;
        self.reason = reason;
    }
}

/// Returns true if correct data arrived too late, or not at all.
fn is_late_data(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::FramesStopped { .. }
            | Reason::FrameStale { .. }
            | Reason::FramesLost { .. }
            | Reason::JointsStopped { .. }
    )
}
