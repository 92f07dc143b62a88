//! Modules 0 and 4 of cap screwing.

use crate::bench::{Bench, fingertip, percept, pressed};
use atas_core::modules::{Proposal, Verdict};
use atas_core::perception::{ContactPercept, Percept};
use nalgebra::Vector3;
use shm_schemas::ModuleId;

/// Tangential offset of a side at the ends of a turn, m.
const TRAVEL_M: f64 = 0.007;

/// Percept of a cap that resists clockwise rotation with this shear force per side, N. The
/// fingertips roll on the cap: they are at the ends of a diameter that turns with it.
fn resisting(bench: &Bench, shear_n: f64) -> Percept {
    let [first, second] = bench.base_from_tip();
    let outwards = (first.translation_m - second.translation_m).normalize();
    let against = Vector3::new(-outwards.y, outwards.x, 0.0);
    let tip = |sign: f64| ContactPercept {
        force_tip_n: (outwards * 3.0 + against * shear_n) * sign,
        ..fingertip(3.0)
    };
    percept([tip(1.0), tip(-1.0)])
}

/// One clockwise turn with shear force up to `most_n`, and the return.
fn turn(bench: &mut Bench, most_n: f64) -> Verdict {
    let mut verdict = Verdict::None;
    let mut go = |bench: &mut Bench, ahead_m: f64, shear_n: f64| {
        bench.frame.tangential_m = [-ahead_m, ahead_m];
        let proposal = bench.evaluate(&resisting(bench, shear_n));
        if verdict == Verdict::None {
            verdict = proposal.verdict;
        }
    };
    for i in 0..=1000 {
        let way = f64::from(i) / 1000.0;
        go(
            bench,
            TRAVEL_M * (2.0 * way - 1.0),
            most_n * (4.0 * way).min(1.0),
        );
    }
    for i in (0..=1000).rev() {
        go(bench, TRAVEL_M * (2.0 * f64::from(i) / 1000.0 - 1.0), 0.0);
    }
    verdict
}

#[test]
fn screwing_ends_above_1_4_times_first_maximum() {
    let check = |turns_n: &[f64], expected: Verdict| {
        let mut bench = Bench::new(ModuleId::TERMINATE_SCREW);
        let (last_n, before_n) = turns_n.split_last().unwrap();
        for most_n in before_n {
            assert_eq!(turn(&mut bench, *most_n), Verdict::None, "{turns_n:?}");
        }
        assert_eq!(turn(&mut bench, *last_n), expected, "{turns_n:?}");
    };
    check(&[5.0], Verdict::None);
    check(&[0.5, 0.5, 0.69], Verdict::None);
    check(&[0.5, 0.5, 0.71], Verdict::Done);
    check(&[1.0, 0.3, 0.8], Verdict::None);
}

/// Runs Module 0 with a firm grip; the sides close at this speed while they turn.
fn square(bench: &mut Bench, ticks: usize, closing_m_s: f64) -> Vec<Proposal> {
    let run = |_| {
        let proposal = bench.evaluate(&pressed(2.0));
        let carried = proposal.pose.unwrap();
        bench.frame = carried.pose;
        bench.closing_m_s = [closing_m_s; 2];
        proposal
    };
    (0..ticks).map(run).collect()
}

fn ahead_m(proposal: &Proposal) -> f64 {
    -proposal.pose.unwrap().pose.tangential_m[0]
}

#[test]
fn square_trajectory_repeats() {
    let mut bench = Bench::new(ModuleId::TRAJECTORY);
    let round = square(&mut bench, 20_000, 0.0);
    let turns = round
        .windows(2)
        .filter(|w| ahead_m(&w[0]) < 0.0 && ahead_m(&w[1]) >= 0.0);
    assert!((4..12).contains(&turns.count()));
    let half_m = |p: &Proposal| p.pose.unwrap().pose.half_opening_m[0];
    for pair in round.windows(2) {
        let turning = ahead_m(&pair[1]) > ahead_m(&pair[0]);
        let away_m = half_m(&pair[1]) - 0.025;
        assert!(!turning || away_m.abs() < 1e-9, "turns at the cap");
        let back = ahead_m(&pair[1]) < ahead_m(&pair[0]);
        assert!(
            !back || (away_m - 0.003).abs() < 1e-9,
            "returns clear of it"
        );
        let step_m = (ahead_m(&pair[1]) - ahead_m(&pair[0])).abs();
        assert!(step_m <= 3.01e-5, "within the speed limit of its edge");
    }
}

#[test]
fn opening_is_kept_for_the_next_turn() {
    let mut bench = Bench::new(ModuleId::TRAJECTORY);
    let mut round = square(&mut bench, 1000, 0.001);
    round.extend(square(&mut bench, 9000, 0.0));
    let inmost_m = |range: core::ops::Range<usize>| {
        let half_m = |p: &Proposal| p.pose.unwrap().pose.half_opening_m[0];
        round[range]
            .iter()
            .map(half_m)
            .fold(f64::INFINITY, f64::min)
    };
    let (first_m, later_m) = (inmost_m(0..1400), inmost_m(3000..10_000));
    assert!(first_m < 0.0249, "{first_m}");
    assert!(
        (first_m - later_m).abs() < 2e-4 && later_m < 0.0249,
        "{first_m} {later_m}"
    );
}
