//! Input data of each lane's trial.

use crate::trial::Trial;

/// Lanes of two AVX-512 registers.
pub(crate) const WIDEST: usize = 32;

/// Aligned so that no vector crosses a cache line.
#[repr(C, align(64))]
pub(super) struct LaneInputs<const N: usize> {
    pub(super) x: [[f32; WIDEST]; N],
    pub(super) y: [[f32; WIDEST]; N],
    pub(super) heading: [[i32; WIDEST]; N],
    pub(super) goal_x: [f32; WIDEST],
    pub(super) goal_y: [f32; WIDEST],
    /// Initial noise state.
    pub(super) noise: [i32; WIDEST],
    /// Eight table rows per photo combination and agent.
    pub(super) words: [[[i32; WIDEST]; N]; 4],
}

impl<const N: usize> LaneInputs<N> {
    pub(super) fn empty() -> Self {
        Self {
            x: [[0.0; WIDEST]; N],
            y: [[0.0; WIDEST]; N],
            heading: [[0; WIDEST]; N],
            goal_x: [0.0; WIDEST],
            goal_y: [0.0; WIDEST],
            noise: [0; WIDEST],
            words: [[[0; WIDEST]; N]; 4],
        }
    }

    pub(super) fn load_trial(&mut self, lane: usize, trial: &Trial) {
        for i in 0..N {
            let start = trial.layout.starts[i];
            (self.x[i][lane], self.y[i][lane]) = (start.x_px, start.y_px);
            self.heading[i][lane] = i32::from(start.heading);
            for (photo, word) in trial.tables[i].words().into_iter().enumerate() {
                self.words[photo][i][lane] = word;
            }
        }
        self.noise[lane] = trial.layout.noise.0 as i32;
        (self.goal_x[lane], self.goal_y[lane]) = (trial.layout.goal.x_px, trial.layout.goal.y_px);
    }
}
