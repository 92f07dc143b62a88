//! Mode machine. The most severe reaction wins; every mode change has a reason.
//!
//! ```text
//!               all checks pass                    goal started
//!   INIT ───────────────────────────▶ READY ◀───────────────────────▶ RUN
//!                                       │ ▲         goal ended         │ ▲
//!                                fault  │ │ no fault            fault  │ │ no fault for REARM_S
//!                                       ▼ │ for REARM_S                ▼ │ (goal paused)
//!                                       HOLD ◀─────────────────────────┘
//!       estop, shutdown, joint fault
//!   any ─────────────────────────▶ SAFE_STOP ── recover ──▶ HOLD
//!   any ── panic ──▶ FAULT (latched)
//! ```
//!
//! HOLD keeps position and grip. Opening the hand is never a fault reaction.

use crate::limits::REARM_S;
use shm_schemas::{Mode, Reason};

/// Mode and its reason.
///
/// ```
/// use atas_core::ModeMachine;
/// use shm_schemas::{Cause, Mode, Reason};
///
/// let mut machine = ModeMachine::default();
/// assert_eq!(machine.mode(), Mode::INIT);
/// machine.stop(Reason::new(Cause::ESTOP));
/// assert_eq!(machine.mode(), Mode::SAFE_STOP);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ModeMachine {
    mode: Mode,
    reason: Reason,
    fault_free_ticks: u32,
}

impl Default for ModeMachine {
    fn default() -> Self {
        Self {
            mode: Mode::INIT,
            reason: Reason::default(),
            fault_free_ticks: 0,
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
        self.fault_free_ticks = if hold_reason.is_some() {
            0
        } else {
            self.fault_free_ticks.saturating_add(1)
        };
        match self.mode {
            Mode::INIT if hold_reason.is_some() => self.reason = hold_reason,
            Mode::READY | Mode::RUN if hold_reason.is_some() => self.enter(Mode::HOLD, hold_reason),
            Mode::READY if has_goal => self.enter(Mode::RUN, Reason::default()),
            Mode::RUN if !has_goal => self.enter(Mode::READY, Reason::default()),
            Mode::INIT | Mode::HOLD if f64::from(self.fault_free_ticks) * step_s >= REARM_S => {
                self.enter(
                    if has_goal { Mode::RUN } else { Mode::READY },
                    Reason::default(),
                );
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
            self.fault_free_ticks = 0;
            self.enter(Mode::HOLD, self.reason);
        }
    }

    fn enter(&mut self, mode: Mode, reason: Reason) {
        self.mode = mode;
        self.reason = reason;
    }
}
