//! Assignment of trials to lanes.
//!
//! A trial is over after its last frame, or when its state equals the state [`STRIDE`] frames
//! earlier (nothing moves, or an agent oscillates). Such a trial repeats the cycle to its end,
//! because a frame depends only on the previous frame; it reads no new row and reaches no new
//! position. Lanes are checked once per stride and refilled when enough are free.

use super::Lanes;
use super::inputs::{LaneInputs, WIDEST};
use super::kernel::Fields;
use super::results::LaneResults;
use crate::constants::Constants;
use crate::obstacle::Obstacles;
use crate::trial::{EXECUTION_FRAMES, Outcome, TRIAL_FRAMES, Trial};

/// Frames between two checks; divides both measurement instants. Six detects the common cycles of
/// 1, 2, 3 and 6 frames (measured).
const STRIDE: u32 = 6;
const _: () =
    assert!(EXECUTION_FRAMES.is_multiple_of(STRIDE) && TRIAL_FRAMES.is_multiple_of(STRIDE));
/// Lanes are refilled when one in this many is free. Larger: too frequent refills; smaller: idle
/// lanes (measured).
const FILL_ONE_IN: u32 = 8;

#[inline(always)]
pub(crate) fn run<T: Lanes, const N: usize, const WALLED: bool>(
    cpu: T::Cpu,
    (c, obstacles): (&Constants, &Obstacles),
    trials: &[Trial],
    outcomes: &mut [Outcome],
) {
    let mut fields = Fields::<T, N, WALLED>::new(cpu, c, obstacles);
    let mut lanes = LaneAllocation {
        inputs: LaneInputs::empty(),
        queue: trials,
        outcomes,
        assigned: 0,
        trial: [0; WIDEST],
        live: 0,
        unmeasured: 0,
    };
    while lanes.fill(T::WIDTH, |filled, seats| {
        fields.start_trials(T::mask(cpu, filled), seats)
    }) {
        let before = fields.state();
        for _ in 0..STRIDE {
            fields.advance(&lanes.inputs);
        }

        let over = (fields.at_frame(TRIAL_FRAMES) | fields.equals_state(&before)) & lanes.live;
        let executed = (fields.at_frame(EXECUTION_FRAMES) | over) & lanes.unmeasured;
        if executed | over != 0 {
            lanes.store_results(executed, over, &fields.measure());
        }
    }
}

/// A set of lanes is a word with one bit per lane.
struct LaneAllocation<'a, const N: usize> {
    inputs: LaneInputs<N>,
    queue: &'a [Trial],
    outcomes: &'a mut [Outcome],
    assigned: usize,
    /// Trial of each lane.
    trial: [usize; WIDEST],
    /// Lanes with a running trial.
    live: u32,
    /// Running lanes before the end of the execution time.
    unmeasured: u32,
}

impl<const N: usize> LaneAllocation<'_, N> {
    /// Refills if enough lanes are free; returns true while any trial runs.
    #[inline(always)]
    fn fill(&mut self, width: usize, admit: impl FnOnce(u32, &LaneInputs<N>)) -> bool {
        let free = width as u32 - self.live.count_ones();
        if self.assigned < self.queue.len()
            && (free * FILL_ONE_IN >= width as u32 || self.live == 0)
        {
            let lanes = self.assign_trials(width);
            admit(lanes, &self.inputs);
        }
        self.live != 0
    }

    fn assign_trials(&mut self, width: usize) -> u32 {
        let before = self.live;
        let every = u32::MAX >> (u32::BITS - width as u32);
        for (lane, trial) in lanes_of(every & !before).zip(self.assigned..self.queue.len()) {
            self.inputs.load_trial(lane, &self.queue[trial]);
            self.trial[lane] = trial;
            self.assigned += 1;
            self.live |= 1 << lane;
        }
        let lanes = self.live & !before;
        self.unmeasured |= lanes;
        lanes
    }

    /// Stores results at the end of execution and of trials. A trial that ends early is in both
    /// sets.
    fn store_results(&mut self, executed: u32, over: u32, results: &LaneResults<N>) {
        for lane in lanes_of(executed) {
            self.outcomes[self.trial[lane]].executed = results.snapshot(lane);
        }
        for lane in lanes_of(over) {
            let outcome = &mut self.outcomes[self.trial[lane]];
            *outcome = results.outcome(lane, outcome.executed);
        }
        self.unmeasured &= !executed;
        self.live &= !over;
    }
}

/// Lanes of a set, lowest first.
fn lanes_of(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (lane < WIDEST).then_some(lane)
    })
}
