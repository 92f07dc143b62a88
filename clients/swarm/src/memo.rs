//! What was tried already: a trial of a goal with tables that agree in every row that was read then cannot come out
//! differently.
//!
//! A goal is whatever points are given for: a goal of the field, in every set of trials another; an object to grasp; a group
//! of courses.

use crate::condition::GOALS;

/// Trials remembered per goal: enough for a population, its parents and their near kin (measured: more finds little more).
const MEMO_TRIALS: usize = 64;

/// The last trials of every goal, each with the tables of `N` agents.
#[derive(Debug)]
pub(crate) struct Memo<const N: usize>(Vec<Ring<N>>);

#[derive(Debug)]
struct Ring<const N: usize> {
    known: Vec<Known<N>>,
    oldest: usize,
}

#[derive(Debug)]
struct Known<const N: usize> {
    /// The bits of the rows that were read.
    mask: u128,
    /// Those bits, per agent.
    tables: [u128; N],
    points: f32,
}

impl<const N: usize> Default for Memo<N> {
    fn default() -> Self {
        Self::of(GOALS)
    }
}

impl<const N: usize> Memo<N> {
    /// A memo of so many goals that remembers nothing yet.
    pub(crate) fn of(goals: usize) -> Self {
        let empty = || Ring {
            known: Vec::new(),
            oldest: 0,
        };
        Self((0..goals).map(|_| empty()).collect())
    }

    /// The points of a trial that is known to come out so.
    pub(crate) fn recall(&self, goal: usize, tables: &[u128; N]) -> Option<f32> {
        let agrees = |known: &&Known<N>| {
            known
                .tables
                .iter()
                .zip(tables)
                .all(|(known_bits, bits)| bits & known.mask == *known_bits)
        };
        self.0[goal]
            .known
            .iter()
            .find(agrees)
            .map(|known| known.points)
    }

    /// Remembers a trial in which the bits of `mask` were read.
    pub(crate) fn learn(&mut self, goal: usize, tables: &[u128; N], mask: u128, points: f32) {
        let known = Known {
            mask,
            tables: tables.map(|bits| bits & mask),
            points,
        };
        let ring = &mut self.0[goal];
        if ring.known.len() < MEMO_TRIALS {
            ring.known.push(known);
        } else {
            ring.known[ring.oldest] = known;
            ring.oldest = (ring.oldest + 1) % MEMO_TRIALS;
        }
    }
}
