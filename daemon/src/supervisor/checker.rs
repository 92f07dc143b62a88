//! The thread that checks goals: a check follows the ways of a whole task, which takes milliseconds and, for a hostile goal,
//! as long as its bound allows. Meanwhile the supervisor serves stops, feeds the watchdog and is heard by the tick.
//!
//! * **In:** a goal, and what it is checked against, as it was when the goal came. **Out:** a goal that can be pursued from
//!   there, or the reason against it. One check at a time.
//! * **Invariants:** a check that panics refuses its goal and ends nothing.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::Builder;

use atas_core::check::{self, Circumstances};
use atas_core::tasks::Task;
use atas_core::{Goal, Settings, Wiring};
use crossbeam::channel::{Receiver, Sender, bounded};
use robot_model::{RobotModel, RobotVector};
use shm_schemas::{Cause, GoalRequest, Reason};

use super::SupervisorState;

/// Name of the thread.
const THREAD: &str = "atasd-check";
/// Its stack, bytes: four times what a check was seen to use. It is locked memory. Ours.
const STACK_BYTES: usize = 256 << 10;

/// The supervisor's end.
#[derive(Debug)]
pub(super) struct Checker {
    jobs: Sender<Box<Job>>,
    checked: Receiver<Checked>,
}

/// What is checked, against what.
#[derive(Debug)]
struct Job {
    request: GoalRequest,
    settings: Settings,
    tasks: Vec<Task>,
    commanded_rad: Option<RobotVector>,
}

/// What came of it.
#[derive(Debug)]
pub(super) struct Checked {
    pub(super) request: GoalRequest,
    pub(super) goal: Result<Goal, Reason>,
    /// Where the joints were commanded when the check began, rad.
    pub(super) commanded_rad: Option<RobotVector>,
}

impl Checker {
    /// Starts the thread. It ends with its [`Checker`].
    pub(super) fn start(state: &SupervisorState) -> io::Result<Self> {
        let (jobs, waiting) = bounded::<Box<Job>>(1);
        let (done, checked) = bounded(1);
        let (robot, wiring) = (state.robot.clone(), state.wiring);
        Builder::new()
            .name(THREAD.to_owned())
            .stack_size(STACK_BYTES)
            .spawn(move || {
                for job in waiting {
                    if done.send(job.check(&robot, &wiring)).is_err() {
                        return;
                    }
                }
            })?;
        Ok(Self { jobs, checked })
    }

    /// Begins a check; only when the one before was fetched.
    pub(super) fn begin(&self, request: GoalRequest, state: &SupervisorState) {
        let job = Job {
            request,
            settings: state.settings,
            tasks: state.config.tasks.as_slice().to_vec(),
            commanded_rad: state.commanded_rad,
        };
        // There is room: one check at a time.
        let _sent = self.jobs.try_send(Box::new(job));
    }

    /// What came of the check, once it is done.
    pub(super) fn fetch(&self) -> Option<Checked> {
        self.checked.try_recv().ok()
    }
}

impl Job {
    fn check(self: Box<Self>, robot: &RobotModel, wiring: &Wiring) -> Checked {
        let circumstances = Circumstances {
            robot,
            wiring,
            settings: &self.settings,
            tasks: &self.tasks,
            commanded_rad: self.commanded_rad.as_ref(),
        };
        let checked = catch_unwind(AssertUnwindSafe(|| {
            check::check(&self.request, &circumstances)
        }));
        Checked {
            request: self.request,
            goal: checked.unwrap_or(Err(Reason::of(Cause::MODULE_PANICKED))),
            commanded_rad: self.commanded_rad,
        }
    }
}
