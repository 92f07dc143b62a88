//! Observations of one run, input of the evaluation.

use atas_client::GoalProgress;
use shm_schemas::WorldTruth;

use crate::punctuality::Punctuality;

pub(crate) struct ObservedRun {
    pub(crate) progress: GoalProgress,
    /// Ground truth before the goal.
    pub(crate) start: WorldTruth,
    /// Ground truth at the end.
    pub(crate) truth: WorldTruth,
    pub(crate) turns: u32,
    pub(crate) punctuality: Punctuality,
}
