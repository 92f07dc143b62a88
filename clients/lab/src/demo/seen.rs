//! What is seen of one run, for whoever judges it.

use atas_client::GoalProgress;
use shm_schemas::WorldTruth;

use super::punctuality::Punctuality;

/// What was seen of a run.
pub(super) struct Seen {
    pub(super) progress: GoalProgress,
    /// The truth before the goal.
    pub(super) start: WorldTruth,
    /// The truth at the end.
    pub(super) truth: WorldTruth,
    /// Turns of a cap.
    pub(super) turns: u32,
    pub(super) punctuality: Punctuality,
}
