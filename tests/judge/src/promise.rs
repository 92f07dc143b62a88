//! Promises: a mode must appear in time, or must not appear.

use shm_schemas::Mode;

use crate::findings::{Findings, ViolationKind};

/// Promise about the modes of the following commands.
///
/// Ticks count from the first command after the promise, which is tick 0: the first tick at which
/// a fault is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Promise {
    modes: &'static [Mode],
    ticks: u64,
    must_appear: bool,
}

impl Promise {
    /// Creates a promise that one of `modes` is reached within this number of ticks; 0: in the
    /// first command.
    #[must_use]
    pub const fn reach(modes: &'static [Mode], within_ticks: u64) -> Self {
        Self {
            modes,
            ticks: within_ticks,
            must_appear: true,
        }
    }

    /// Creates a promise that none of `modes` appears until this tick, inclusive.
    #[must_use]
    pub const fn avoid(modes: &'static [Mode], until_tick: u64) -> Self {
        Self {
            modes,
            ticks: until_tick,
            must_appear: false,
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Open {
    promise: Promise,
    /// Number of commands since the promise.
    ticks: u64,
    is_broken: bool,
}

/// Open promises.
#[derive(Clone, Debug, Default)]
pub(crate) struct Promises {
    open: Vec<Open>,
    reached_after: Option<u64>,
}

impl Promises {
    pub(crate) fn add(&mut self, promise: Promise) {
        if promise.must_appear {
            self.reached_after = None;
        }
        self.open.push(Open {
            promise,
            ticks: 0,
            is_broken: false,
        });
    }

    pub(crate) fn reached_after(&self) -> Option<u64> {
        self.reached_after
    }

    /// Counts a command; its mode is unknown if the command is not intact.
    pub(crate) fn check(&mut self, mode: Option<Mode>, findings: &mut Findings) {
        let reached_after = &mut self.reached_after;
        self.open.retain_mut(|open| {
            let appears = mode.filter(|mode| open.promise.modes.contains(mode));
            let stays = match (open.promise.must_appear, appears) {
                (true, None) => open.wait(findings),
                (true, Some(_)) => {
                    *reached_after = Some(open.ticks);
                    false
                }
                (false, None) => open.ticks < open.promise.ticks,
                (false, Some(mode)) => {
                    report_forbidden(mode, open, findings);
                    false
                }
            };
            open.ticks += 1;
            stays
        });
    }

    /// Reports the promises that nothing has fulfilled at the end.
    pub(crate) fn finish(&mut self, findings: &mut Findings) {
        for open in self.open.drain(..) {
            if open.promise.must_appear && !open.is_broken {
                findings.report(
                    ViolationKind::PromiseBroken,
                    format_args!(
                        "{:?} not reached: the commands end after {} ticks; permitted: {}",
                        open.promise.modes, open.ticks, open.promise.ticks
                    ),
                );
            }
        }
    }
}

impl Open {
    /// Reports a promise once it cannot be kept any more; it stays open until the mode appears.
    fn wait(&mut self, findings: &mut Findings) -> bool {
        if self.ticks >= self.promise.ticks && !self.is_broken {
            self.is_broken = true;
            findings.report(
                ViolationKind::PromiseBroken,
                format_args!(
                    "{:?} not reached within {} ticks",
                    self.promise.modes, self.promise.ticks
                ),
            );
        }
        true
    }
}

fn report_forbidden(mode: Mode, open: &Open, findings: &mut Findings) {
    findings.report(
        ViolationKind::ForbiddenMode,
        format_args!(
            "{mode} after {} ticks; it must not appear before tick {}",
            open.ticks,
            open.promise.ticks.saturating_add(1)
        ),
    );
}
