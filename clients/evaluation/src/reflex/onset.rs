//! Latency from physical slip to the first command that increases grip, in ticks.
//!
//! Onset: nearly all of a fingertip's pressure is on sliding skin (ground truth; some skin at the
//! rim always slides). Response: the next closing command for that side. At F_2, Module 3 prevents
//! a response; these slips are counted separately.

use robot_model::VIRTUAL_FINGERS;
use shm_schemas::HandReport;
use sim_backend::World;

/// Sliding share of the pressure above which the fingertip slips as a whole. Design choice: the
/// remaining contact sticks by chance.
const SLIPS_SHARE: f64 = 0.9;
/// Sliding distance above which a slip counts, m. Design choice: excludes tremor at the slip limit.
const SLIP_M: f64 = 5e-6;
/// Ticks without slip that end a slip. Design choice: longer than the swing of a load.
const CALM_TICKS: u64 = 50;
/// Share of F_2 above which Module 3 allows no more force.
const AT_F2_SHARE: f32 = 0.97;
/// Threshold of the closing speed, m/s.
const CLOSES_M_S: f32 = 1e-6;
/// Length of a tick, ms.
const TICK_MS: f64 = 1.0;

#[derive(Clone, Debug, Default)]
pub(super) struct Onsets {
    fingers: [Finger; VIRTUAL_FINGERS],
    latencies_ms: Vec<f64>,
    at_f2_ms: Vec<f64>,
    unanswered: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Finger {
    slid_before_m: f64,
    run: Option<Run>,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    begin: u64,
    last: u64,
    slid_m: f64,
    answer: Option<u64>,
    at_f2: bool,
}

impl Onsets {
    /// Processes one tick; `carries` is true while the hand carries an object under force control.
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
            // The distance restarts at zero for a new grasp.
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

    /// Returns latencies to the response or the end of the slip, ms; without slips at F_2.
    pub(super) fn latencies_ms(&self) -> &[f64] {
        &self.latencies_ms
    }

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
