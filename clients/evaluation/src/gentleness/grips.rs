//! Grippers of the gentleness table, and the candidates among which the baselines are tuned.

use crate::held::Grip;
use crate::policy::GripPolicy;

/// Candidates of the margin of the position-controlled gripper, m: expected width minus commanded
/// width. The smallest barely touches, the largest deforms every soft object.
const MARGINS_M: [f64; 9] = [
    0.0005, 0.001, 0.0015, 0.002, 0.0025, 0.003, 0.004, 0.005, 0.006,
];

/// Best fixed force, N, slip-reactive start and maximum, N, and margin, m, on the reference
/// objects: success over the tuning seeds, then lowest peak force (`atas eval gentleness --tune`).
const FIXED_N: f64 = 1.0;
const START_N: f64 = 1.0;
const CEILING_N: f64 = 8.0;
const MARGIN_M: f64 = 0.005;

/// Returns the ATAS modules, then the baselines.
pub(super) fn grips() -> Vec<Grip> {
    let slip_reactive = GripPolicy::SlipReactive {
        start_n: START_N,
        ceiling_n: CEILING_N,
    };
    vec![
        Grip::Policy(GripPolicy::BuiltIn),
        Grip::Policy(GripPolicy::FixedForce(FIXED_N)),
        Grip::Policy(slip_reactive),
        Grip::Position(MARGIN_M),
    ]
}

/// Returns all baselines that tuning compares.
pub(super) fn candidates() -> Vec<Grip> {
    let policies = GripPolicy::candidates().into_iter().map(Grip::Policy);
    policies.chain(MARGINS_M.map(Grip::Position)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn baselines_are_candidates() {
        let (grips, candidates) = (grips(), candidates());
        assert_eq!(grips[0].name(), "ours");
        for grip in &grips[1..] {
            assert!(candidates.contains(grip), "{grip:?}");
        }
    }
}
