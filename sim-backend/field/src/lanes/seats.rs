//! What each lane was given: the memory that trials are read from.

use crate::trial::Trial;

/// Lanes of the widest vector: two of AVX-512.
pub(crate) const WIDEST: usize = 32;

/// Starts, goal and tables of the trial in each lane; aligned so that no vector straddles two cache lines.
#[repr(C, align(64))]
pub(super) struct Seats<const N: usize> {
    pub(super) x: [[f32; WIDEST]; N],
    pub(super) y: [[f32; WIDEST]; N],
    pub(super) heading: [[i32; WIDEST]; N],
    pub(super) goal_x: [f32; WIDEST],
    pub(super) goal_y: [f32; WIDEST],
    /// Where the trial's stream of noise begins.
    pub(super) noise: [i32; WIDEST],
    /// Per combination of the photo sensors, per agent: eight rows of the table.
    pub(super) words: [[[i32; WIDEST]; N]; 4],
}

impl<const N: usize> Seats<N> {
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

    pub(super) fn take(&mut self, lane: usize, trial: &Trial) {
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
