//! Output data of each lane's trial.

use super::inputs::WIDEST;
use crate::trial::{MAX_AGENTS, Outcome, Snapshot};

/// Distances at one instant, rows read and arrival frame.
#[repr(C, align(64))]
pub(super) struct LaneResults<const N: usize> {
    pub(super) goal_px: [f32; WIDEST],
    pub(super) agents_px: [[f32; WIDEST]; N],
    pub(super) rows_read: [i32; WIDEST],
    pub(super) reached_frame: [i32; WIDEST],
}

impl<const N: usize> LaneResults<N> {
    pub(super) fn snapshot(&self, lane: usize) -> Snapshot {
        let mut agents_px = [0.0; MAX_AGENTS];
        for (to, from) in agents_px.iter_mut().zip(&self.agents_px) {
            *to = from[lane];
        }
        Snapshot {
            goal_px: self.goal_px[lane],
            agents_px,
        }
    }

    pub(super) fn outcome(&self, lane: usize, executed: Snapshot) -> Outcome {
        Outcome {
            rows_read: self.rows_read[lane] as u32,
            reached_frame: self.reached_frame[lane] as u32,
            executed,
            evaluated: self.snapshot(lane),
        }
    }
}
