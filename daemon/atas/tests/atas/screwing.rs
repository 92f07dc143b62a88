//! Modules 0 and 4 of cap screwing.

use crate::bench::{Bench, fingertip, percept, pressed};
use atas_core::modules::{Proposal, Verdict};
use atas_core::perception::{ContactPercept, Percept};
use nalgebra::Vector3;
use robot_model::GraspSide;
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

/// Descent of a cap on its thread in one turn, m.
const DESCENT_M: f64 = 0.0005;

/// One clockwise turn of a cap on its thread with shear force up to `most_n`, and the return.
fn turn(bench: &mut Bench, most_n: f64) -> Verdict {
    turn_descending(bench, most_n, DESCENT_M)
}

/// One clockwise turn of a cap that descends, m, with shear force up to `most_n`, and the return.
fn turn_descending(bench: &mut Bench, most_n: f64, descent_m: f64) -> Verdict {
    let mut verdict = Verdict::None;
    let height_m = bench.frame.centre_m.z;
    let mut go = |bench: &mut Bench, ahead_m: f64, shear_n: f64| {
        bench.frame.tangential_m = [-ahead_m, ahead_m].into();
        let way = (ahead_m / TRAVEL_M + 1.0) / 2.0;
        let lowest_m = bench.frame.centre_m.z;
        bench.frame.centre_m.z = lowest_m.min(height_m - descent_m * way);
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

/// Regression: the friction of a loose cap on its rim counted as the first turn, so that the thread
/// itself seemed tight.
#[test]
fn turns_beside_the_thread_do_not_count() {
    let mut bench = Bench::new(ModuleId::TERMINATE_SCREW);
    for _ in 0..2 {
        assert_eq!(turn_descending(&mut bench, 0.1, 0.0), Verdict::None);
    }
    assert_eq!(turn(&mut bench, 0.5), Verdict::None);
    assert_eq!(turn(&mut bench, 0.71), Verdict::Done);
}

/// Runs Module 0 with a firm grip; the sides close at this speed while they turn.
fn square(bench: &mut Bench, ticks: usize, closing_m_s: f64) -> Vec<Proposal> {
    square_with(bench, &pressed(2.0), ticks, closing_m_s)
}

fn square_with(
    bench: &mut Bench,
    measured: &Percept,
    ticks: usize,
    closing_m_s: f64,
) -> Vec<Proposal> {
    let run = |_| {
        let proposal = bench.evaluate(measured);
        let carried = proposal.pose.unwrap();
        bench.frame = carried.pose;
        bench.closing_m_s = [closing_m_s; 2].into();
        proposal
    };
    (0..ticks).map(run).collect()
}

fn ahead_m(proposal: &Proposal) -> f64 {
    -proposal.pose.unwrap().pose.tangential_m[GraspSide::First]
}

#[test]
fn square_trajectory_repeats() {
    let mut bench = Bench::new(ModuleId::TRAJECTORY);
    let round = square(&mut bench, 20_000, 0.0);
    let turns = round
        .windows(2)
        .filter(|w| ahead_m(&w[0]) < 0.0 && ahead_m(&w[1]) >= 0.0);
    assert!((4..12).contains(&turns.count()));
    let half_m = |p: &Proposal| p.pose.unwrap().pose.half_opening_m[GraspSide::First];
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
fn loose_cap_is_carried_along_a_spiral() {
    let mut bench = Bench::new(ModuleId::TRAJECTORY);
    let start_m = bench.frame.centre_m;
    // The rim carries the force with which the hand presses down: the cap does not descend.
    let mut on_rim = pressed(2.0);
    for fingertip in &mut on_rim.fingertips[..2] {
        fingertip.force_tip_n.z = 0.15;
    }
    let poses = square_with(&mut bench, &on_rim, 60_000, 0.0);
    let centres_m = poses.iter().map(|p| p.pose.unwrap().pose.centre_m);
    let centres_m: Vec<Vector3<f64>> = centres_m.collect();
    let off_m = |centre_m: &Vector3<f64>| (centre_m - start_m).xy().norm();
    let farthest_m = centres_m.iter().map(off_m).fold(0.0, f64::max);
    assert!((0.002..0.0023).contains(&farthest_m), "{farthest_m}");
    for pair in centres_m.windows(2) {
        let step_m = (pair[1] - pair[0]).xy().norm();
        assert!(step_m < 1e-5, "the place never jumps: {step_m}");
    }
    let last = poses.last().unwrap().pose.unwrap().pose;
    assert!(
        last.half_opening_m[GraspSide::First] > 0.0279,
        "waits, open"
    );
}

#[test]
fn opening_is_kept_for_the_next_turn() {
    let mut bench = Bench::new(ModuleId::TRAJECTORY);
    let mut round = square(&mut bench, 1000, 0.001);
    round.extend(square(&mut bench, 9000, 0.0));
    let inmost_m = |range: core::ops::Range<usize>| {
        let half_m = |p: &Proposal| p.pose.unwrap().pose.half_opening_m[GraspSide::First];
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
