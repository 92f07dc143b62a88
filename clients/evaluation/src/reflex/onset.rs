//! From physical slip to the first harder command, in ticks.
//!
//! The simulator knows which share of a fingertip's pressure lies on skin that slides. At the rim some always does; when nearly
//! all of it slides, friction is exhausted and the object moves in the hand: that tick is the onset. It is answered by the first
//! tick from then on in which that finger is commanded to close. A finger at F_2 may not press harder (Module 3): slips there are
//! kept apart.

use robot_model::VIRTUAL_FINGERS;
use shm_schemas::HandReport;
use sim_backend::World;

/// Share of the pressure that slides from which on the fingertip slips as a whole (ours: what is left sticks by chance).
const SLIPS_SHARE: f64 = 0.9;
/// Distance that the skin must slide in a run for it to count, m (ours: a tremble at the edge of slipping is none).
const SLIP_M: f64 = 5e-6;
/// Ticks without slip that end a run (ours: longer than the swing of a load).
const CALM_TICKS: u64 = 50;
/// Share of F_2 from which on a finger may not press harder: Module 3's.
const AT_F2_SHARE: f32 = 0.97;
/// Closing speed that is one, m/s.
const CLOSES_M_S: f32 = 1e-6;
/// Length of a tick, ms.
const TICK_MS: f64 = 1.0;

/// The slips of one trial.
#[derive(Clone, Debug, Default)]
pub(super) struct Onsets {
    fingers: [Finger; VIRTUAL_FINGERS],
    latencies_ms: Vec<f64>,
    at_f2_ms: Vec<f64>,
    unanswered: u64,
}

/// One fingertip.
#[derive(Clone, Copy, Debug, Default)]
struct Finger {
    slid_before_m: f64,
    run: Option<Run>,
}

/// A run of slipping.
#[derive(Clone, Copy, Debug)]
struct Run {
    begin: u64,
    last: u64,
    slid_m: f64,
    answer: Option<u64>,
    at_f2: bool,
}

impl Onsets {
    /// Takes in one tick: the world after it, and what it commanded this hand. `carries` is whether the hand holds something by
    /// touch.
    pub(super) fn watch(
        &mut self,
        tick: u64,
        world: &World,
        hand: usize,
        report: &HandReport,
        carries: bool,
    ) {
        let truth = world.truth();
        let fingers = &report.fingers[..VIRTUAL_FINGERS];
        let strongest_n = fingers.iter().map(|f| f.normal_n).fold(0.0, f32::max);
        let at_f2 = strongest_n > AT_F2_SHARE * report.f2_n;
        for (finger, felt) in fingers.iter().enumerate() {
            let state = &mut self.fingers[finger];
            let slid_m = truth.slip_m[hand][finger];
            // A new grasp counts from zero again.
            let step_m = (slid_m - state.slid_before_m).max(0.0);
            state.slid_before_m = slid_m;
            let slips = carries && world.sliding_share(hand, finger) > SLIPS_SHARE;
            if slips {
                let run = state.run.get_or_insert(Run {
                    begin: tick,
                    last: tick,
                    slid_m: 0.0,
                    answer: None,
                    at_f2,
                });
                run.last = tick;
                run.slid_m += step_m;
            }
            let Some(run) = state.run.as_mut() else {
                continue;
            };
            if felt.closing_m_s > CLOSES_M_S {
                run.answer.get_or_insert(tick);
            }
            run.at_f2 |= at_f2 && run.answer.is_none();
            if !carries || tick > run.last + CALM_TICKS {
                let run = *run;
                state.run = None;
                self.end(&run);
            }
        }
    }

    fn end(&mut self, run: &Run) {
        if run.slid_m < SLIP_M {
            return;
        }
        let end = run.answer.unwrap_or(run.last);
        let lasted_ms = (end - run.begin) as f64 * TICK_MS;
        if run.at_f2 {
            self.at_f2_ms.push(lasted_ms);
        } else {
            self.unanswered += u64::from(run.answer.is_none());
            self.latencies_ms.push(lasted_ms);
        }
    }

    /// From onset to answer, or to the end of a slip that had none, ms; of slips at F_2 apart.
    pub(super) fn latencies_ms(&self) -> &[f64] {
        &self.latencies_ms
    }

    /// The same of the slips during which F_2 forbade an answer, ms.
    pub(super) fn at_f2_ms(&self) -> &[f64] {
        &self.at_f2_ms
    }

    pub(super) fn unanswered(&self) -> u64 {
        self.unanswered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(runs: &[(Option<u64>, bool, f64)]) -> Onsets {
        let mut onsets = Onsets::default();
        for &(answer, at_f2, slid_m) in runs {
            onsets.end(&Run {
                begin: 100,
                last: 140,
                slid_m,
                answer,
                at_f2,
            });
        }
        onsets
    }

    #[test]
    fn a_slip_counts_until_it_is_answered_or_over_and_apart_at_f2() {
        let onsets = told(&[
            (Some(103), false, 1e-4),
            (None, false, 1e-4),
            (Some(103), false, 1e-6),
            (Some(119), true, 1e-4),
            (None, true, 1e-4),
        ]);
        assert_eq!(onsets.latencies_ms(), [3.0, 40.0]);
        assert_eq!(onsets.unanswered(), 1);
        assert_eq!(onsets.at_f2_ms(), [19.0, 40.0]);
    }
}
