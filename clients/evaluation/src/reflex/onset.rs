//! Latency from physical slip to the first command that increases grip, in ticks.
//!
//! Onset: nearly all of a fingertip's pressure is on sliding skin (ground truth; some skin at the
//! rim always slides). Response: the next closing command for that side. At F_2, Module 3 prevents
//! a response; these slips are counted separately.

use robot_model::{FINGERTIPS_MAX, GraspSides};
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

#[derive(Clone, Debug)]
pub(super) struct Onsets {
    sides: GraspSides,
    fingertips: [FingertipState; FINGERTIPS_MAX],
    latencies_ms: Vec<f64>,
    at_f2_ms: Vec<f64>,
    unanswered: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct FingertipState {
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
    pub(super) fn new(sides: GraspSides) -> Self {
        Self {
            sides,
            fingertips: [FingertipState::default(); FINGERTIPS_MAX],
            latencies_ms: Vec::new(),
            at_f2_ms: Vec::new(),
            unanswered: 0,
        }
    }

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
        let at_f2 = self.is_at_f2(report);
        let fingers = &report.fingers[..self.sides.fingertip_count()];
        for (finger, measured) in fingers.iter().enumerate() {
            let state = &mut self.fingertips[finger];
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

    fn is_at_f2(&self, report: &HandReport) -> bool {
        let normal_n = |fingertip: usize| f64::from(report.fingers[fingertip].normal_n);
        let stronger_n = self.sides.sums(normal_n).into_iter().fold(0.0, f64::max);
        stronger_n > f64::from(AT_F2_SHARE * report.f2_n)
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
    use robot_model::RobotModel;

    use super::*;
    use crate::SIDE;

    fn onsets(robot: &str) -> Onsets {
        let robot = RobotModel::find(robot).expect("built-in robot");
        Onsets::new(robot.hand(SIDE).grasp_sides())
    }

    /// Regression: only the first two fingertips were compared with F_2, each alone.
    #[test]
    fn force_of_the_thumb_reaches_f2() {
        let check = |robot: &str, normal_n: [f32; 3], expected| {
            let mut report = HandReport {
                f2_n: 2.0,
                ..HandReport::default()
            };
            for (finger, force_n) in report.fingers.iter_mut().zip(normal_n) {
                finger.normal_n = force_n;
            }
            let at_f2 = onsets(robot).is_at_f2(&report);
            assert_eq!(at_f2, expected, "{robot} {normal_n:?}");
        };
        check("three-finger", [0.5, 0.5, 2.0], true);
        check("three-finger", [1.0, 1.0, 1.5], true);
        check("three-finger", [0.5, 0.5, 1.0], false);
        check("two-hand-arm", [1.0, 1.0, 0.0], false);
        check("two-hand-arm", [2.0, 1.0, 0.0], true);
    }

    fn ended_slips(runs: &[(Option<u64>, bool, f64)]) -> Onsets {
        let mut onsets = onsets("two-hand-arm");
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
