//! Memo of simulated trials: a trial is skipped if its tables equal a stored one's in every row
//! that the stored trial read.
//!
//! A goal here is any unit that earns points: a goal of the field (per set of trials), an object to
//! grasp, or a group of courses.

use crate::condition::GOALS;

/// Trials stored per goal: enough for a population, its parents and close relatives. Measurements
/// show few more hits above it.
const MEMO_TRIALS: usize = 64;

/// The last trials of every goal, each with the tables of `N` agents.
#[derive(Debug)]
pub(crate) struct Memo<const N: usize>(Vec<Ring<N>>);

#[derive(Debug)]
struct Ring<const N: usize> {
    entries: Vec<Entry<N>>,
    oldest: usize,
}

#[derive(Debug)]
struct Entry<const N: usize> {
    /// Bits of the rows that the trial read.
    mask: u128,
    /// Values of those bits, per agent.
    tables: [u128; N],
    points: f32,
}

impl<const N: usize> Default for Memo<N> {
    fn default() -> Self {
        Self::with_goals(GOALS)
    }
}

impl<const N: usize> Memo<N> {
    pub(crate) fn with_goals(goals: usize) -> Self {
        let empty = || Ring {
            entries: Vec::new(),
            oldest: 0,
        };
        Self((0..goals).map(|_| empty()).collect())
    }

    /// Returns the points of a matching trial.
    pub(crate) fn recall(&self, goal: usize, tables: &[u128; N]) -> Option<f32> {
        let agrees = |known: &&Entry<N>| {
            known
                .tables
                .iter()
                .zip(tables)
                .all(|(known_bits, bits)| bits & known.mask == *known_bits)
        };
        self.0[goal]
            .entries
            .iter()
            .find(agrees)
            .map(|known| known.points)
    }

    pub(crate) fn store(&mut self, goal: usize, tables: &[u128; N], mask: u128, points: f32) {
        let known = Entry {
            mask,
            tables: tables.map(|bits| bits & mask),
            points,
        };
        let ring = &mut self.0[goal];
        if ring.entries.len() < MEMO_TRIALS {
            ring.entries.push(known);
        } else {
            ring.entries[ring.oldest] = known;
            ring.oldest = (ring.oldest + 1) % MEMO_TRIALS;
        }
    }
}
