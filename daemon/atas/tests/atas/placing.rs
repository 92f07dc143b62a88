//! Modules 0' and 4 of pick and place.

use crate::bench::{Bench, fingertip, path, percept, pressed};
use atas_core::modules::Verdict;
use atas_core::perception::{ContactPercept, Percept};
use nalgebra::Vector3;
use shm_schemas::ModuleId;

const BOUND_M: f64 = 0.03;

fn lowering(id: ModuleId) -> Bench {
    Bench {
        lowering_m: Some(BOUND_M),
        ..Bench::new(id)
    }
}

/// Percept of an object whose load both sides share, N.
fn hanging(load_n: f64) -> Percept {
    percept(
        [ContactPercept {
            force_tip_n: Vector3::new(0.0, 0.0, -load_n / 2.0),
            ..fingertip(3.0)
        }; 2],
    )
}

#[test]
fn support_requires_rise_and_duration() {
    let check = |load_n: f64, rise_n: f64, frames: usize, expected: Verdict| {
        let mut bench = lowering(ModuleId::RELEASE_PLACED);
        bench.evaluate_for(1000, &hanging(load_n));
        let proposal = bench.evaluate_for(frames, &hanging(load_n - rise_n));
        assert_eq!(proposal.verdict, expected, "{load_n} {rise_n} {frames}");
    };
    check(0.5, 0.13, 3, Verdict::Done);
    check(0.5, 0.11, 100, Verdict::None);
    check(0.5, 0.13, 2, Verdict::None);
    // For a heavy object the threshold is a share of its weight.
    check(5.0, 0.29, 100, Verdict::None);
    check(5.0, 0.31, 3, Verdict::Done);
    // A growing load is not support.
    check(1.0, -1.0, 100, Verdict::None);
}

#[test]
fn support_is_ignored_during_settling_and_elsewhere() {
    let mut bench = lowering(ModuleId::RELEASE_PLACED);
    bench.evaluate(&hanging(2.0));
    assert_eq!(
        bench.evaluate_for(149, &hanging(1.0)).verdict,
        Verdict::None
    );
    let mut bench = Bench::new(ModuleId::RELEASE_PLACED);
    bench.evaluate_for(1000, &hanging(2.0));
    assert_eq!(
        bench.evaluate_for(100, &hanging(0.0)).verdict,
        Verdict::None
    );
}

#[test]
fn oscillation_after_stop_is_ignored() {
    let mut bench = lowering(ModuleId::RELEASE_PLACED);
    bench.evaluate_for(1000, &hanging(2.0));
    bench.modules.stop();
    let waits = bench.evaluate_for(150, &hanging(1.0));
    assert_eq!((waits.verdict, waits.carry_ceiling), (Verdict::None, 0.0));
    // The oscillation did not change the weight reference: a lasting support is detected at once.
    let lands = bench.evaluate_for(3, &hanging(1.0));
    assert_eq!((lands.verdict, lands.carry_ceiling), (Verdict::Done, 1.0));
}

#[test]
fn held_samples_count_once() {
    let mut bench = lowering(ModuleId::RELEASE_PLACED);
    bench.evaluate_for(1000, &hanging(2.0));
    let held = Percept {
        step_s: 0.0,
        ..hanging(1.0)
    };
    assert_eq!(bench.evaluate_for(10, &held).verdict, Verdict::None);
}

#[test]
fn transfer_conveys_then_lowers_to_search_depth() {
    let mut bench = lowering(ModuleId::TRANSFER);
    let over_m = path().end().centre_m.z;
    let height_m = |bench: &mut Bench, ticks| {
        let carried = bench.evaluate_for(ticks, &pressed(3.0)).pose.unwrap();
        (carried.pose.centre_m.z, carried.arrived)
    };
    let conveyed = (path().duration_s() * 1e3) as usize;
    let (start_m, _) = height_m(&mut bench, conveyed + 200);
    assert!(start_m < over_m);
    let (lower_m, arrived) = height_m(&mut bench, 1000);
    assert!(
        (start_m - lower_m - 0.01).abs() < 1e-6 && !arrived,
        "10 mm/s"
    );
    let (lowest_m, arrived) = height_m(&mut bench, 4000);
    assert!((over_m - lowest_m - BOUND_M).abs() < 2e-5 && arrived);
}
