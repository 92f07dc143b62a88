//! Modules one by one: percept and context in, proposal out.

use crate::bench::{Bench, finger, path, percept, pressed, sliding};
use atas_core::modules::{Proposal, Selection, Verdict, force_range_n};
use atas_core::perception::{FingerPercept, Percept};
use nalgebra::Vector3;
use robot_model::Skin;
use shm_schemas::{Cause, ModuleId};

const FREE: f64 = f64::INFINITY;

fn speeds(p: &Proposal) -> (bool, [f64; 2], [f64; 2]) {
    (p.active, p.closing_m_s, p.closing_ceiling_m_s)
}

#[test]
fn module_1_closes_until_both_touch_and_then_until_f1() {
    for (all_touched, forces_n, active, closing_m_s) in [
        (false, [0.0, 0.0], true, [0.002, 0.002]),
        (false, [0.1, 0.0], true, [0.0, 0.002]),
        (false, [0.0, 0.1], true, [0.002, 0.0]),
        (false, [0.1, 0.1], false, [0.0, 0.0]),
        (true, [0.1, 0.1], true, [0.002, 0.002]),
        (true, [3.0, 0.4], true, [0.002, 0.002]),
        (true, [0.5, 0.5], true, [0.002, 0.002]),
        (true, [0.51, 0.51], false, [0.0, 0.0]),
        (true, [0.0, 0.0], true, [0.002, 0.002]),
    ] {
        let mut bench = Bench::new(ModuleId::FIRST_TOUCH);
        bench.all_touched = all_touched;
        let proposal = bench.evaluate(&percept(forces_n.map(finger)));
        assert_eq!(
            speeds(&proposal),
            (active, closing_m_s, [FREE; 2]),
            "touched {all_touched}, {forces_n:?} N"
        );
    }
}

#[test]
fn module_2_presses_while_friction_runs_out() {
    let slip = |utilisation, gross_slip_s, increment_n| FingerPercept {
        utilisation,
        gross_slip_s,
        increment_n,
        ..finger(2.0)
    };
    let blind = |friction, increment_n| FingerPercept {
        shows_slip: false,
        friction,
        ..slip(0.5, 0.0, increment_n)
    };
    for (case, one, active) in [
        (
            "(c) dF_t > dr, nothing known of friction",
            blind(0.0, 0.07),
            true,
        ),
        (
            "a steady load, nothing known of friction",
            blind(0.0, 0.05),
            false,
        ),
        ("dF_t > dr far below where it slid", blind(0.4, 0.07), false),
        ("friction to spare", slip(0.5, 0.0, 0.0), false),
        ("just below the threshold", slip(0.91, 0.0, 0.0), false),
        ("(a) S above slip_on", slip(0.93, 0.0, 0.0), true),
        ("(b) gross slip for a while", slip(0.5, 0.011, 0.0), true),
        ("gross slip too short", slip(0.5, 0.009, 0.0), false),
        ("(c) dF_t > dr near the limit", slip(0.85, 0.0, 0.07), true),
        (
            "dF_t > dr with friction to spare",
            slip(0.7, 0.0, 0.5),
            false,
        ),
        (
            "near the limit under steady load",
            slip(0.85, 0.0, 0.05),
            false,
        ),
    ] {
        for fingers in [[one, finger(2.0)], [finger(2.0), one]] {
            let proposal = Bench::new(ModuleId::SLIP).evaluate(&percept(fingers));
            let closing_m_s = if active { 0.002 } else { 0.0 };
            assert_eq!(
                speeds(&proposal),
                (active, [closing_m_s; 2], [FREE; 2]),
                "{case}"
            );
            assert_eq!(
                proposal.carry_ceiling,
                if active { 0.1 } else { 1.0 },
                "{case}"
            );
        }
    }
}

#[test]
fn module_2_has_hysteresis_and_a_latch() {
    let mut bench = Bench::new(ModuleId::SLIP);
    for (utilisation, ticks, active) in [
        (0.9, 1, false),
        (0.93, 1, true),
        (0.87, 100, true),
        (0.85, 19, true),
        (0.85, 3, false),
        (0.91, 100, false),
    ] {
        assert_eq!(
            bench.evaluate_for(ticks, &sliding(2.0, utilisation)).active,
            active,
            "S = {utilisation} for {ticks} ms"
        );
    }
}

/// Regression: a bottle dragged through the fingers of a teleoperated hand had S = 0.8 for 130 ms
/// and slid 1.2 mm without reaction.
#[test]
fn module_2_presses_sooner_in_a_hand_that_is_led() {
    let active = |mut bench: Bench, s: f64| bench.evaluate(&sliding(2.0, s)).active;
    for (s, free, led) in [(0.75, false, false), (0.8, false, true), (0.93, true, true)] {
        assert_eq!(active(Bench::new(ModuleId::SLIP), s), free, "S = {s}");
        assert_eq!(active(Bench::led(ModuleId::SLIP), s), led, "S = {s}, led");
    }
}

/// A verified grip overrides the force pattern, but not rotation or dropping.
#[test]
fn modules_2_and_3_do_not_doubt_a_grip_that_a_test_has_proved() {
    let evaluate = |id, proved, ticks, felt: &Percept| {
        let mut bench = Bench::new(id);
        (bench.proved, bench.carried_m) = (proved, 0.0005);
        bench.evaluate_for(ticks, felt)
    };
    let one = |one: FingerPercept| percept([one, finger(2.0)]);
    let (uses_up, slips, loads, turns) = (
        sliding(2.0, 0.93),
        one(FingerPercept {
            gross_slip_s: 0.05,
            ..finger(2.0)
        }),
        one(FingerPercept {
            utilisation: 0.85,
            increment_n: 0.2,
            ..finger(2.0)
        }),
        one(FingerPercept {
            torsion: 0.6,
            ..finger(2.0)
        }),
    );
    for (case, felt, despite) in [
        ("(a)", uses_up, false),
        ("(b)", slips, false),
        ("(c)", loads, false),
        ("(d)", turns, true),
    ] {
        let active = [false, true].map(|proved| evaluate(ModuleId::SLIP, proved, 1, &felt).active);
        assert_eq!(active, [true, despite], "{case}: unproved, proved");
    }
    let verdicts = [false, true]
        .map(|proved| evaluate(ModuleId::FORCE_LIMIT, proved, 999, &sliding(4.1, 1.05)).verdict);
    assert!(matches!(verdicts, [Verdict::Refuse(_), Verdict::None]));
}

/// Regression: misaligned faces shear the fingertips in proportion to grip force; the hand gripped
/// an object of 50 g with F_2.
#[test]
fn module_2_stops_pressing_what_bears_no_more_load_for_it() {
    // Half a second at 2 N, then half a second up to 4 N with a load of 0.5 N that grows by this
    // factor; returns whether the module is still active.
    let presses = |hangs: bool, load_growth: f64| {
        let mut bench = Bench::new(ModuleId::SLIP);
        (bench.hangs, bench.carried_m) = (hangs, 0.0005);
        let felt = |normal_n: f64, load_n: f64| {
            percept(
                [FingerPercept {
                    utilisation: 0.95,
                    force_tip_n: Vector3::new(0.0, 0.0, -load_n / 2.0),
                    ..finger(normal_n)
                }; 2],
            )
        };
        assert!(bench.evaluate_for(500, &felt(2.0, 0.5)).active);
        (0..500)
            .map(|tick| {
                let share = f64::from(tick) / 500.0;
                let (normal_n, load_n) = (2.0 + 2.0 * share, 0.5 + 0.5 * load_growth * share);
                bench.evaluate(&felt(normal_n, load_n)).active
            })
            .last()
            .unwrap()
    };
    assert!(!presses(false, 0.0), "what stands keeps its load");
    assert!(presses(false, 1.0), "what slides bears more");
    assert!(presses(true, 0.0), "what hangs always has the same load");
}

#[test]
fn module_2_slows_the_hand_only_while_pressing_helps() {
    assert_eq!(
        Bench::new(ModuleId::SLIP)
            .evaluate(&sliding(3.9, 1.0))
            .carry_ceiling,
        0.1
    );
    assert_eq!(
        Bench::new(ModuleId::SLIP)
            .evaluate(&sliding(4.1, 1.0))
            .carry_ceiling,
        1.0
    );
}

#[test]
fn module_3_stops_above_f2_and_opens_well_above() {
    let mut bench = Bench::new(ModuleId::FORCE_LIMIT);
    for (forces_n, active, ceiling_m_s) in [
        ([3.9, 0.1], false, FREE),
        ([4.1, 0.1], true, 0.0),
        ([0.1, 3.95], true, 0.0),
        ([3.8, 0.1], false, FREE),
        ([0.1, 4.7], true, -0.001),
        ([0.1, 4.5], true, 0.0),
        ([0.0, 0.0], false, FREE),
    ] {
        let proposal = bench.evaluate(&percept(forces_n.map(finger)));
        assert_eq!(
            speeds(&proposal),
            (active, [0.0; 2], [ceiling_m_s; 2]),
            "{forces_n:?} N"
        );
        assert_eq!(proposal.verdict, Verdict::None);
    }
}

#[test]
fn module_3_refuses_what_slides_out_at_f2() {
    let mut bench = Bench::new(ModuleId::FORCE_LIMIT);
    assert_eq!(
        bench.evaluate_for(399, &sliding(4.1, 1.05)).verdict,
        Verdict::None
    );
    let Verdict::Refuse(reason) = bench.evaluate_for(600, &sliding(4.1, 1.05)).verdict else {
        panic!("not refused")
    };
    assert_eq!(
        (reason.cause, reason.module, reason.value, reason.limit),
        (Cause::TOO_SOFT, ModuleId::FORCE_LIMIT, 4.1, 4.0)
    );
    // With F_2 at the hand's limit, the object is too heavy, not too soft.
    let mut rigid = Bench::new(ModuleId::FORCE_LIMIT);
    rigid.settings.grasp.f2_max_n = 4.0;
    let verdict = rigid.evaluate_for(999, &sliding(4.1, 1.05)).verdict;
    assert!(matches!(verdict, Verdict::Refuse(reason) if reason.cause == Cause::TOO_HEAVY));
    // The slip below F_2, or a low utilisation, is no reason to refuse.
    for innocent in [sliding(3.0, 1.05), sliding(4.1, 0.7)] {
        assert_eq!(
            Bench::new(ModuleId::FORCE_LIMIT)
                .evaluate_for(2000, &innocent)
                .verdict,
            Verdict::None
        );
    }
}

#[test]
fn relax_opens_while_friction_and_force_are_to_spare() {
    let felt = |utilisation, increment_n, gross_slip_s, normal_n| {
        percept(
            [FingerPercept {
                utilisation,
                increment_n,
                gross_slip_s,
                ..finger(normal_n)
            }; 2],
        )
    };
    for (case, percept, active) in [
        ("to spare", felt(0.4, 0.0, 0.0, 2.0), true),
        ("nothing known of friction", felt(0.0, 0.0, 0.0, 2.0), false),
        ("near the limit", felt(0.90, 0.0, 0.0, 2.0), false),
        ("load changes", felt(0.4, 0.07, 0.0, 2.0), false),
        ("slips", felt(0.4, 0.0, 0.001, 2.0), false),
        ("below the least force", felt(0.4, 0.0, 0.0, 0.54), false),
        ("too near it to begin", felt(0.4, 0.0, 0.0, 0.57), false),
        ("above the least force", felt(0.4, 0.0, 0.0, 0.59), true),
    ] {
        let mut bench = Bench::new(ModuleId::RELAX);
        assert!(!bench.evaluate(&percept).active, "{case}: not at once");
        let proposal = bench.evaluate_for(200, &percept);
        assert_eq!(proposal.active, active, "{case}");
        assert!(
            proposal.closing_m_s.iter().all(|v| if active {
                (-0.001..0.0).contains(v)
            } else {
                *v == 0.0
            }),
            "{case}"
        );
    }
    let opening = |utilisation| {
        Bench::new(ModuleId::RELAX)
            .evaluate_for(200, &felt(utilisation, 0.0, 0.0, 2.0))
            .closing_m_s[0]
    };
    assert!(
        opening(0.82) < opening(0.86),
        "the nearer to its limit, the more slowly"
    );
}

#[test]
fn relax_distrusts_a_friction_that_noise_may_have_made() {
    for (friction_error, active) in [(0.0, true), (0.02, true), (0.06, false), (1.0, false)] {
        let felt = percept(
            [FingerPercept {
                utilisation: 0.7,
                friction: 0.4,
                friction_error,
                ..finger(2.0)
            }; 2],
        );
        let proposal = Bench::new(ModuleId::RELAX).evaluate_for(200, &felt);
        assert_eq!(proposal.active, active, "{friction_error}");
    }
}

#[test]
fn the_probe_presses_for_100_ms_and_then_says_how_hard() {
    let mut bench = Bench::new(ModuleId::PROBE);
    let tips = Skin::DOME_41.compression;
    let (mut verdict, mut ticks) = (Verdict::None, 0);
    while verdict == Verdict::None {
        ticks += 1;
        let normal_n = 0.1 + 0.005 * f64::from(ticks);
        let tips_m = tips.at_1n_m * normal_n.powf(tips.exponent);
        bench.closing_m = 2.0 * (tips_m + normal_n / 2000.0);
        let proposal = bench.evaluate(&pressed(normal_n));
        assert_eq!(proposal.active, ticks < 100, "after {ticks} ms");
        assert_eq!(
            proposal.closing_m_s,
            if ticks < 100 { [0.002; 2] } else { [0.0; 2] },
            "after {ticks} ms"
        );
        verdict = proposal.verdict;
    }
    let Verdict::Stiffness(fit) = verdict else {
        panic!("{verdict:?}")
    };
    assert_eq!(ticks, 100);
    assert!((fit.object_n_m / 2000.0 - 1.0).abs() < 0.1, "{fit:?}");
    // A lower force adds no data.
    assert_eq!(bench.evaluate(&pressed(0.3)).verdict, verdict);
}

#[test]
fn the_probe_stops_pressing_at_the_largest_force_and_guesses_nothing() {
    let mut bench = Bench::new(ModuleId::PROBE);
    assert_eq!(bench.evaluate(&pressed(8.1)).closing_m_s, [0.0; 2]);
    assert_eq!(
        bench.evaluate_for(300, &pressed(8.1)).verdict,
        Verdict::None,
        "one force alone has no slope"
    );
    let mut silent = pressed(1.0);
    silent.step_s = 0.0;
    assert_eq!(
        Bench::new(ModuleId::PROBE)
            .evaluate_for(300, &silent)
            .verdict,
        Verdict::None
    );
}

#[test]
fn carry_walks_the_path_at_the_tolerated_speed() {
    for (carry_scale, ticks, share) in [
        (1.0, 2500, 0.5),
        (0.5, 5000, 0.5),
        (0.0, 1000, 0.0),
        (-1.0, 1000, 0.0),
        (1.0, 5001, 1.0),
    ] {
        let mut bench = Bench::new(ModuleId::CARRY);
        bench.carry_scale = carry_scale;
        let proposal = bench.evaluate_for(ticks, &pressed(1.0));
        let carried = proposal.pose.unwrap();
        let expected_m = 0.1 + 0.05 * share;
        assert!(
            (carried.frame.centre_m.z - expected_m).abs() < 1e-4,
            "{ticks} ms at {carry_scale}: {}",
            carried.frame.centre_m.z
        );
        assert_eq!(
            (carried.arrived, proposal.active),
            (share == 1.0, share != 1.0)
        );
        assert!(!carried.with_fingers);
    }
}

#[test]
fn carry_goes_back_but_not_beyond_the_start() {
    let mut bench = Bench::new(ModuleId::CARRY);
    let ahead = bench
        .evaluate_for(2000, &pressed(1.0))
        .pose
        .unwrap()
        .frame
        .centre_m
        .z;
    bench.carry_scale = -1.0;
    let back = bench
        .evaluate_for(500, &pressed(1.0))
        .pose
        .unwrap()
        .frame
        .centre_m
        .z;
    assert!(back < ahead);
    let start = bench.evaluate_for(9000, &pressed(1.0)).pose.unwrap();
    assert_eq!(start.frame, path().at(0.0));
    bench.modules.restart_step();
    bench.carry_scale = 1.0;
    assert!(!bench.evaluate(&pressed(1.0)).pose.unwrap().arrived);
}

#[test]
fn memories_end_with_the_object() {
    let mut bench = Bench::new(ModuleId::SLIP);
    assert!(bench.evaluate(&sliding(2.0, 1.0)).active);
    bench.modules.reset();
    assert!(!bench.evaluate(&sliding(2.0, 0.9)).active);
}

#[test]
fn forces_are_those_of_the_fingers_that_grip() {
    assert_eq!(
        force_range_n(&percept([finger(1.0), finger(3.0)])),
        (1.0, 3.0)
    );
    assert!(Selection::of(&[ModuleId::SLIP]).contains(ModuleId::SLIP));
    assert!(!Selection::default().contains(ModuleId::NONE));
}
