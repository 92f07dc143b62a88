//! Observations of one run, input of the evaluation.

use atas_client::GoalProgress;
use shm_schemas::WorldTruth;

use super::punctuality::Punctuality;

pub(super) struct ObservedRun {
    pub(super) progress: GoalProgress,
    /// Ground truth before the goal.
    pub(super) start: WorldTruth,
    /// Ground truth at the end.
    pub(super) truth: WorldTruth,
    pub(super) turns: u32,
    pub(super) punctuality: Punctuality,
}
