//! Transitions between modes.

use shm_schemas::Mode;

use crate::findings::{Findings, ViolationKind};

/// First modes of a new writer: it waits for inputs, or a stop or panic came first.
const FIRST: [Mode; 3] = [Mode::INIT, Mode::SAFE_STOP, Mode::FAULT];

/// Permitted transitions apart from those to SAFE_STOP and FAULT.
const PERMITTED: [(Mode, Mode); 7] = [
    (Mode::INIT, Mode::READY),
    (Mode::READY, Mode::RUN),
    (Mode::READY, Mode::HOLD),
    (Mode::RUN, Mode::READY),
    (Mode::RUN, Mode::HOLD),
    (Mode::HOLD, Mode::READY),
    (Mode::HOLD, Mode::RUN),
];

/// Check of transitions.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModeCheck {
    last: Option<Mode>,
    recovery: bool,
}

impl ModeCheck {
    /// Permits one transition from SAFE_STOP to HOLD.
    pub(crate) fn recover_requested(&mut self) {
        self.recovery = true;
    }

    pub(crate) fn check(&mut self, mode: Mode, is_new_writer: bool, findings: &mut Findings) {
        if !mode.is_known() {
            findings.report(
                ViolationKind::Transition,
                format_args!("the mode is {mode}"),
            );
            return;
        }
        let last = self.last.replace(mode);
        if is_new_writer {
            self.recovery = false;
            if !FIRST.contains(&mode) {
                findings.report(
                    ViolationKind::Transition,
                    format_args!("a new writer begins in {mode}; expected init"),
                );
            }
        } else if let Some(last) = last.filter(|last| !self.is_permitted(*last, mode)) {
            findings.report(
                ViolationKind::Transition,
                format_args!("{mode} follows {last}, which is not permitted"),
            );
        }
    }

    /// Returns whether the transition is permitted; uses up a requested recovery.
    fn is_permitted(&mut self, from: Mode, to: Mode) -> bool {
        match (from, to) {
            _ if from == to => true,
            (Mode::FAULT, _) => false,
            (_, Mode::FAULT) => true,
            (Mode::SAFE_STOP, Mode::HOLD) => std::mem::take(&mut self.recovery),
            (Mode::SAFE_STOP, _) => false,
            (_, Mode::SAFE_STOP) => true,
            pair => PERMITTED.contains(&pair),
        }
    }
}
