//! Injection of a fault into a running task, at the present tick.

use atas_evaluation::offline::OfflineRun;
use robot_model::HandSide;
use sim_backend::faults::{Fault, FaultError, FaultPipeline};

/// Fault that virtual time can show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// Fault of the acting hand's frames, as for `atas-sim --fault`: kind and value, duration, s.
    Frames(&'static str, Option<f64>),
    /// Fault of the joint states: kind and value, duration, s.
    Joints(&'static str, Option<f64>),
    /// The sequence numbers of the acting hand's frames wrap to zero.
    FramesWrap,
    /// The controller does not run for this number of ticks.
    Pause(u64),
    /// A new controller begins after this number of ticks without one.
    Restart(u64),
    /// Commands do not reach the robot.
    Disconnected,
}

impl Injection {
    /// Returns the number of ticks without a command.
    #[must_use]
    pub fn pause_ticks(self) -> u64 {
        match self {
            Self::Pause(ticks) | Self::Restart(ticks) => ticks,
            _ => 0,
        }
    }

    /// Injects the fault; it acts from the next tick on.
    ///
    /// # Errors
    /// The description of a sensor fault is invalid.
    pub(crate) fn inject(
        self,
        run: &mut OfflineRun,
        side: HandSide,
        seed: u64,
    ) -> Result<(), FaultError> {
        let hand = match side {
            HandSide::Left => "left",
            HandSide::Right => "right",
        };
        let wrap = format!("wrap={}", run.ticks().max(1));
        let (kind, length_s, target) = match self {
            Self::Frames(kind, length_s) => (kind, length_s, hand),
            Self::Joints(kind, length_s) => (kind, length_s, "joints"),
            Self::FramesWrap => (wrap.as_str(), None, hand),
            Self::Pause(ticks) => {
                run.pause_controller(ticks);
                return Ok(());
            }
            Self::Restart(ticks) => {
                run.pause_controller(ticks);
                run.restart_controller();
                return Ok(());
            }
            Self::Disconnected => {
                run.disconnect_robot();
                return Ok(());
            }
        };
        let start_s = run.ticks() as f64 * 1e-3;
        let length = length_s.map_or(String::new(), |length_s| format!("+{length_s}"));
        let fault: Fault = format!("{kind}@{start_s}{length}:{target}").parse()?;
        run.inject(FaultPipeline::new(&[fault], seed));
        Ok(())
    }
}
