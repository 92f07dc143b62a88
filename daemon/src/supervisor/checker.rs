//! Thread that checks goals.
//!
//! A check follows the paths of a whole task; it takes milliseconds, or its upper bound for a
//! hostile goal. Meanwhile the supervisor continues its rounds.
//!
//! * **In:** a goal and the state at its arrival. **Out:** an executable goal or the reason against
//!   it. One check at a time.
//! * **Invariants:** a check that panics rejects its goal; the thread continues.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread::Builder;

use atas_core::check::{self, GoalContext};
use atas_core::tasks::Task;
use atas_core::{Goal, SensorSetup, Settings};
use crossbeam::channel::{Receiver, Sender, bounded};
use robot_model::{RobotModel, RobotVector};
use shm_schemas::{GoalRequest, Reason};

use super::SupervisorState;

const THREAD: &str = "atasd-check";
/// Stack, bytes, locked memory: four times the observed use. Design choice.
const STACK_BYTES: usize = 256 << 10;

#[derive(Debug)]
pub(super) struct Checker {
    jobs: Sender<Box<Job>>,
    checked: Receiver<CheckResult>,
}

#[derive(Debug)]
struct Job {
    request: GoalRequest,
    settings: Settings,
    tasks: Vec<Task>,
    commanded_position: Option<RobotVector>,
}

#[derive(Debug)]
pub(super) struct CheckResult {
    pub(super) request: GoalRequest,
    pub(super) goal: Result<Goal, Reason>,
    /// Commanded joint positions at the start of the check, rad.
    pub(super) commanded_position: Option<RobotVector>,
}

impl Checker {
    /// Starts the thread; it ends with this [`Checker`].
    pub(super) fn start(state: &SupervisorState) -> io::Result<Self> {
        let (jobs, waiting) = bounded::<Box<Job>>(1);
        let (done, checked) = bounded(1);
        let (robot, wiring) = (state.robot.clone(), state.sensor_setup);
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

    /// Starts a check. Call only after the previous result was read.
    pub(super) fn start_check(&self, request: GoalRequest, state: &SupervisorState) {
        let job = Job {
            request,
            settings: state.settings,
            tasks: state.config.tasks.as_slice().to_vec(),
            commanded_position: state.commanded_position,
        };
        // The queue has room: one check at a time.
        let _sent = self.jobs.try_send(Box::new(job));
    }

    /// The result, if the check is finished.
    pub(super) fn poll(&self) -> Option<CheckResult> {
        self.checked.try_recv().ok()
    }
}

impl Job {
    fn check(self: Box<Self>, robot: &RobotModel, wiring: &SensorSetup) -> CheckResult {
        let circumstances = GoalContext {
            robot,
            wiring,
            settings: &self.settings,
            tasks: &self.tasks,
            commanded_position: self.commanded_position.as_ref(),
        };
        let checked = catch_unwind(AssertUnwindSafe(|| {
            check::check(&self.request, &circumstances)
        }));
        CheckResult {
            request: self.request,
            goal: checked.unwrap_or(Err(Reason::ModulePanicked)),
            commanded_position: self.commanded_position,
        }
    }
}
