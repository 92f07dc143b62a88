//! Frames of one goal.

use shm_schemas::GoalRequest;

/// Goal being read.
pub(super) struct Episode {
    pub(super) goal: GoalRequest,
    pub(super) next_tick: u64,
    pub(super) states: Vec<f32>,
    pub(super) taxels: Vec<f32>,
    pub(super) actions: Vec<f32>,
    pub(super) frames: usize,
}

impl Episode {
    /// Adds the action of the newest frame, if it has none yet.
    pub(super) fn add_action(&mut self, action: [f32; 5]) {
        if self.actions.len() < self.frames * action.len() {
            self.actions.extend(action);
        }
    }
}
