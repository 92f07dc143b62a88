//! Latency from physical slip to the first command that increases grip, in ticks.
//!
//! Onset: nearly all of a fingertip's pressure is on sliding skin (ground truth; some skin at the
//! rim always slides). Response: the next closing command for that side. At F_2, Module 3 prevents
//! a response; these slips are counted separately.

use robot_model::GRASP_SIDES;
use shm_schemas::HandReport;
use sim_backend::World;

/// Sliding share of the pressure above which the fingertip slips as a whole. Design choice: the
/// remaining contact sticks by chance.
const GROSS_SLIP_SHARE: f64 = 0.9;
/// Sliding distance above which a slip counts, m. Design choice: excludes tremor at the slip limit.
const SLIP_DISTANCE_MIN_M: f64 = 5e-6;
/// Ticks without slip that end a slip. Design choice: longer than the swing of a load.
const SLIP_END_TICKS: u64 = 50;
/// Share of F_2 above which Module 3 allows no more force.
const AT_F2_SHARE: f32 = 0.97;
/// Threshold of the closing speed, m/s.
const CLOSING_SPEED_MIN_M_S: f32 = 1e-6;
/// Length of a tick, ms.
const TICK_MS: f64 = 1.0;

#[derive(Clone, Debug, Default)]
pub(super) struct Onsets {
    sides: [SideState; GRASP_SIDES],
    latencies_ms: Vec<f64>,
    at_f2_ms: Vec<f64>,
    unanswered: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct SideState {
    slid_before_m: f64,
    run: Option<Slip>,
}

#[derive(Clone, Copy, Debug)]
struct Slip {
    begin: u64,
    last: u64,
    slid_m: f64,
    response: Option<u64>,
    at_f2: bool,
}

impl Onsets {
    /// Processes one tick; `carries` is true while the hand carries an object under force control.
    pub(super) fn update(
        &mut self,
        tick: u64,
        world: &World,
        hand: usize,
        report: &HandReport,
        carries: bool,
    ) {
        let truth = world.truth();
        let fingers = &report.fingers[..GRASP_SIDES];
        let strongest_n = fingers.iter().map(|f| f.normal_n).fold(0.0, f32::max);
        let at_f2 = strongest_n > AT_F2_SHARE * report.f2_n;
        for (finger, measured) in fingers.iter().enumerate() {
            let state = &mut self.sides[finger];
            let slid_m = truth.slip_m[hand][finger];
            // The distance restarts at zero for a new grasp.
            let step_m = (slid_m - state.slid_before_m).max(0.0);
            state.slid_before_m = slid_m;
            let slips = carries && world.sliding_share(hand, finger) > GROSS_SLIP_SHARE;
            if slips {
                let run = state.run.get_or_insert(Slip {
                    begin: tick,
                    last: tick,
                    slid_m: 0.0,
                    response: None,
                    at_f2,
                });
                run.last = tick;
                run.slid_m += step_m;
            }
            let Some(run) = state.run.as_mut() else {
                continue;
            };
            if measured.closing_m_s > CLOSING_SPEED_MIN_M_S {
                run.response.get_or_insert(tick);
            }
            run.at_f2 |= at_f2 && run.response.is_none();
            if !carries || tick > run.last + SLIP_END_TICKS {
                let run = *run;
                state.run = None;
                self.end(&run);
            }
        }
    }

    fn end(&mut self, run: &Slip) {
        if run.slid_m < SLIP_DISTANCE_MIN_M {
            return;
        }
        let end = run.response.unwrap_or(run.last);
        let lasted_ms = (end - run.begin) as f64 * TICK_MS;
        if run.at_f2 {
            self.at_f2_ms.push(lasted_ms);
        } else {
            self.unanswered += u64::from(run.response.is_none());
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

    fn ended_slips(runs: &[(Option<u64>, bool, f64)]) -> Onsets {
        let mut onsets = Onsets::default();
        for &(answer, at_f2, slid_m) in runs {
            onsets.end(&Slip {
                begin: 100,
                last: 140,
                slid_m,
                response: answer,
                at_f2,
            });
        }
        onsets
    }

    #[test]
    fn slips_at_f2_are_counted_separately() {
        let onsets = ended_slips(&[
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
