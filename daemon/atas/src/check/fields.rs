//! Indices of the validated values in [`shm_schemas::GoalRequest::VALUE_NAMES`].

pub(super) const FROM_X: usize = 0;
pub(super) const FROM_YAW: usize = 3;
pub(super) const TO_X: usize = 4;
pub(super) const TO_YAW: usize = 7;
pub(super) const WIDTH: usize = 8;
pub(super) const LIFT: usize = 9;
pub(super) const HOLD: usize = 10;
pub(super) const HELPER_WIDTH: usize = 11;
pub(super) const TOP: usize = 12;
pub(super) const MAX_FORCE: usize = 13;
