//! Modules one by one: percept and context in, proposal out.

use crate::bench::{Bench, fingertip, path, percept, pressed, with_utilisation};
use atas_core::modules::{Proposal, Selection, Verdict};
use atas_core::perception::{ContactPercept, Percept};
use robot_model::{GraspSide, PerSide, Skin};
use shm_schemas::{ModuleId, Reason};

const FREE: f64 = f64::INFINITY;

fn speeds(p: &Proposal) -> (bool, [f64; 2], [f64; 2]) {
    (
        p.active,
        p.closing_m_s.into_array(),
        p.closing_ceiling_m_s.into_array(),
    )
}

#[test]
fn module_1_closes_until_contact_and_f1() {
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
        bench.object.all_touched = all_touched;
        let proposal = bench.evaluate(&percept(forces_n.map(fingertip)));
        assert_eq!(
            speeds(&proposal),
            (active, closing_m_s, [FREE; 2]),
            "contact {all_touched}, {forces_n:?} N"
        );
    }
}

#[test]
fn module_2_closes_at_high_utilisation() {
    let slip = |utilisation, gross_slip_s, increment_n| ContactPercept {
        utilisation,
        gross_slip_s,
        increment_n,
        ..fingertip(2.0)
    };
    let blind = |friction, increment_n| ContactPercept {
        shows_incipient_slip: false,
        friction,
        ..slip(0.5, 0.0, increment_n)
    };
    for (case, one, active) in [
        ("(c) dF_t > dr, friction unknown", blind(0.0, 0.07), true),
        ("steady load, friction unknown", blind(0.0, 0.05), false),
        (
            "dF_t > dr far below the utilisation at slip",
            blind(0.4, 0.07),
            false,
        ),
        ("low utilisation", slip(0.5, 0.0, 0.0), false),
        ("just below the threshold", slip(0.91, 0.0, 0.0), false),
        ("(a) S above slip_on", slip(0.93, 0.0, 0.0), true),
        ("(b) long gross slip", slip(0.5, 0.011, 0.0), true),
        ("short gross slip", slip(0.5, 0.009, 0.0), false),
        ("(c) dF_t > dr near the limit", slip(0.85, 0.0, 0.07), true),
        ("dF_t > dr at low utilisation", slip(0.7, 0.0, 0.5), false),
        (
            "high utilisation under steady load",
            slip(0.85, 0.0, 0.05),
            false,
        ),
    ] {
        for fingers in [[one, fingertip(2.0)], [fingertip(2.0), one]] {
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

/// The third fingertip is the only one of its side.
#[test]
fn slip_is_detected_on_the_thumb() {
    let finger = fingertip(1.0);
    let thumb = |utilisation, torsion| ContactPercept {
        utilisation,
        torsion,
        ..fingertip(2.0)
    };
    for (case, thumb, active) in [
        ("holds", thumb(0.5, 0.0), false),
        ("slips", thumb(0.95, 0.0), true),
        ("turns", thumb(0.5, 0.6), true),
    ] {
        let mut bench = Bench::new(ModuleId::SLIP);
        bench.object.carried_m = 0.01;
        let measured = Percept {
            fingertips: [finger, finger, thumb, ContactPercept::default()],
            side_of_fingertip: [
                GraspSide::First,
                GraspSide::First,
                GraspSide::Second,
                GraspSide::First,
            ],
            ..percept([fingertip(2.0), thumb])
        };
        assert_eq!(bench.evaluate(&measured).active, active, "the thumb {case}");
    }
}

#[test]
fn module_2_has_hysteresis_and_latch() {
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
            bench
                .evaluate_for(ticks, &with_utilisation(2.0, utilisation))
                .active,
            active,
            "S = {utilisation} for {ticks} ms"
        );
    }
}

/// Regression: a bottle dragged through the fingers of a teleoperated hand had S = 0.8 for 130 ms
/// and slid 1.2 mm without reaction.
#[test]
fn module_2_closes_earlier_during_teleoperation() {
    let active = |mut bench: Bench, s: f64| bench.evaluate(&with_utilisation(2.0, s)).active;
    for (s, free, guided) in [(0.75, false, false), (0.8, false, true), (0.93, true, true)] {
        assert_eq!(active(Bench::new(ModuleId::SLIP), s), free, "S = {s}");
        assert_eq!(
            active(Bench::teleoperated(ModuleId::SLIP), s),
            guided,
            "S = {s}, teleoperated"
        );
    }
}

/// A grip that holds its load overrides the force pattern, but not rotation or dropping.
#[test]
fn modules_2_and_3_accept_a_grip_that_holds_its_load() {
    let evaluate = |id, is_held, ticks, measured: &Percept| {
        let mut bench = Bench::new(id);
        (bench.object.load_is_held, bench.object.carried_m) = (is_held, 0.0005);
        bench.evaluate_for(ticks, measured)
    };
    let one = |one: ContactPercept| percept([one, fingertip(2.0)]);
    let (uses_up, slips, loads, turns) = (
        with_utilisation(2.0, 0.93),
        one(ContactPercept {
            gross_slip_s: 0.05,
            ..fingertip(2.0)
        }),
        one(ContactPercept {
            utilisation: 0.85,
            increment_n: 0.2,
            ..fingertip(2.0)
        }),
        one(ContactPercept {
            torsion: 0.6,
            ..fingertip(2.0)
        }),
    );
    for (case, measured, despite) in [
        ("(a)", uses_up, false),
        ("(b)", slips, false),
        ("(c)", loads, false),
        ("(d)", turns, true),
    ] {
        let active =
            [false, true].map(|is_held| evaluate(ModuleId::SLIP, is_held, 1, &measured).active);
        assert_eq!(active, [true, despite], "{case}: unknown, holds the load");
    }
    let verdicts = [false, true].map(|is_held| {
        evaluate(
            ModuleId::FORCE_LIMIT,
            is_held,
            999,
            &with_utilisation(4.1, 1.05),
        )
        .verdict
    });
    assert!(matches!(verdicts, [Verdict::Refuse(_), Verdict::None]));
}

#[test]
fn module_2_closes_three_times_faster_during_a_drop() {
    let mut bench = Bench::new(ModuleId::SLIP);
    let closing_m_s =
        |bench: &mut Bench| bench.evaluate(&pressed(2.0)).closing_m_s[GraspSide::First];
    assert_eq!(closing_m_s(&mut bench), 0.0);
    (bench.object.drops, bench.object.load_is_held) = (true, true);
    let enhance_m_s = bench.settings.grasp.enhance_m_s;
    assert_eq!(closing_m_s(&mut bench), 3.0 * enhance_m_s);
}

#[test]
fn module_2_slows_hand_only_while_effective() {
    assert_eq!(
        Bench::new(ModuleId::SLIP)
            .evaluate(&with_utilisation(3.9, 1.0))
            .carry_ceiling,
        0.1
    );
    assert_eq!(
        Bench::new(ModuleId::SLIP)
            .evaluate(&with_utilisation(4.1, 1.0))
            .carry_ceiling,
        1.0
    );
}

#[test]
fn module_3_stops_above_f2_then_opens() {
    let mut bench = Bench::new(ModuleId::FORCE_LIMIT);
    for (forces_n, active, ceiling_m_s) in [
        ([3.9, 0.1], false, FREE),
        ([4.05, 0.1], true, 0.0),
        ([0.1, 3.95], true, 0.0),
        ([3.8, 0.1], false, FREE),
        ([0.1, 4.2], true, -0.002),
        ([0.1, 4.05], true, 0.0),
        ([0.0, 0.0], false, FREE),
    ] {
        let proposal = bench.evaluate(&percept(forces_n.map(fingertip)));
        assert_eq!(
            speeds(&proposal),
            (active, [0.0; 2], [ceiling_m_s; 2]),
            "{forces_n:?} N"
        );
        // A hand that moves on may press the object further.
        let waits = if ceiling_m_s < 0.0 { 0.0 } else { 1.0 };
        assert_eq!(proposal.carry_ceiling, waits, "{forces_n:?} N");
        assert_eq!(proposal.verdict, Verdict::None);
    }
}

#[test]
fn module_3_refuses_objects_slipping_at_f2() {
    let mut bench = Bench::new(ModuleId::FORCE_LIMIT);
    assert_eq!(
        bench
            .evaluate_for(399, &with_utilisation(4.1, 1.05))
            .verdict,
        Verdict::None
    );
    let verdict = bench
        .evaluate_for(600, &with_utilisation(4.1, 1.05))
        .verdict;
    let too_soft = Reason::TooSoft {
        force_n: 4.1,
        limit_n: 4.0,
        module: ModuleId::FORCE_LIMIT,
    };
    assert_eq!(verdict, Verdict::Refuse(too_soft));
    // With F_2 at the hand's limit, the object is too heavy, not too soft.
    let mut rigid = Bench::new(ModuleId::FORCE_LIMIT);
    rigid.settings.grasp.f2_max_n = 4.0;
    let verdict = rigid
        .evaluate_for(999, &with_utilisation(4.1, 1.05))
        .verdict;
    assert!(matches!(verdict, Verdict::Refuse(Reason::TooHeavy { .. })));
    // The slip below F_2, or a low utilisation, is no reason to refuse.
    for innocent in [with_utilisation(3.0, 1.05), with_utilisation(4.1, 0.7)] {
        assert_eq!(
            Bench::new(ModuleId::FORCE_LIMIT)
                .evaluate_for(2000, &innocent)
                .verdict,
            Verdict::None
        );
    }
}

#[test]
fn relax_opens_at_low_utilisation_and_excess_force() {
    let measured = |utilisation, increment_n, gross_slip_s, normal_n| {
        percept(
            [ContactPercept {
                utilisation,
                increment_n,
                gross_slip_s,
                ..fingertip(normal_n)
            }; 2],
        )
    };
    for (case, percept, active) in [
        ("low utilisation", measured(0.4, 0.0, 0.0, 2.0), true),
        ("friction unknown", measured(0.0, 0.0, 0.0, 2.0), false),
        ("high utilisation", measured(0.90, 0.0, 0.0, 2.0), false),
        ("load changes", measured(0.4, 0.07, 0.0, 2.0), false),
        ("slip", measured(0.4, 0.0, 0.001, 2.0), false),
        (
            "below the minimum force",
            measured(0.4, 0.0, 0.0, 0.54),
            false,
        ),
        (
            "too close above it to begin",
            measured(0.4, 0.0, 0.0, 0.57),
            false,
        ),
        (
            "above the minimum force",
            measured(0.4, 0.0, 0.0, 0.59),
            true,
        ),
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
            .evaluate_for(200, &measured(utilisation, 0.0, 0.0, 2.0))
            .closing_m_s[GraspSide::First]
    };
    assert!(opening(0.82) < opening(0.86), "slower near its limit");
}

#[test]
fn relax_ignores_friction_within_noise() {
    for (friction_error, active) in [(0.0, true), (0.02, true), (0.06, false), (1.0, false)] {
        let measured = percept(
            [ContactPercept {
                utilisation: 0.7,
                friction: 0.4,
                friction_error,
                ..fingertip(2.0)
            }; 2],
        );
        let proposal = Bench::new(ModuleId::RELAX).evaluate_for(200, &measured);
        assert_eq!(proposal.active, active, "{friction_error}");
    }
}

#[test]
fn probe_returns_stiffness_after_100_ms() {
    let mut bench = Bench::new(ModuleId::PROBE);
    let tips = Skin::DOME_41.compression;
    let (mut verdict, mut ticks) = (Verdict::None, 0);
    while verdict == Verdict::None {
        ticks += 1;
        let normal_n = 0.1 + 0.005 * f64::from(ticks);
        let tips_m = tips.at_1n_m * normal_n.powf(tips.exponent);
        bench.object.closing_m = 2.0 * (tips_m + normal_n / 2000.0);
        let proposal = bench.evaluate(&pressed(normal_n));
        assert_eq!(proposal.active, ticks < 100, "after {ticks} ms");
        assert_eq!(
            proposal.closing_m_s,
            PerSide::repeat(if ticks < 100 { 0.002 } else { 0.0 }),
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
fn probe_stops_at_force_ceiling_without_result() {
    let mut bench = Bench::new(ModuleId::PROBE);
    assert_eq!(bench.evaluate(&pressed(8.1)).closing_m_s, [0.0; 2].into());
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
fn carry_follows_the_path_at_the_scaled_speed() {
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
            (carried.pose.centre_m.z - expected_m).abs() < 1e-4,
            "{ticks} ms at {carry_scale}: {}",
            carried.pose.centre_m.z
        );
        assert_eq!(
            (carried.arrived, proposal.active),
            (share == 1.0, share != 1.0)
        );
        assert!(!carried.with_fingers);
    }
}

#[test]
fn carry_moves_back_to_the_start_at_most() {
    let mut bench = Bench::new(ModuleId::CARRY);
    let ahead = bench
        .evaluate_for(2000, &pressed(1.0))
        .pose
        .unwrap()
        .pose
        .centre_m
        .z;
    bench.carry_scale = -1.0;
    let back = bench
        .evaluate_for(500, &pressed(1.0))
        .pose
        .unwrap()
        .pose
        .centre_m
        .z;
    assert!(back < ahead);
    let start = bench.evaluate_for(9000, &pressed(1.0)).pose.unwrap();
    assert_eq!(start.pose, path().pose_at(0.0));
    bench.modules.restart_step();
    bench.carry_scale = 1.0;
    assert!(!bench.evaluate(&pressed(1.0)).pose.unwrap().arrived);
}

#[test]
fn module_state_is_reset_after_the_object() {
    let mut bench = Bench::new(ModuleId::SLIP);
    assert!(bench.evaluate(&with_utilisation(2.0, 1.0)).active);
    bench.modules.reset();
    assert!(!bench.evaluate(&with_utilisation(2.0, 0.9)).active);
}

#[test]
fn force_range_covers_gripping_sides_only() {
    assert_eq!(
        percept([fingertip(1.0), fingertip(3.0)]).normal_range_n(),
        (1.0, 3.0)
    );
    assert!(Selection::from_modules(&[ModuleId::SLIP]).contains(ModuleId::SLIP));
    assert!(!Selection::default().contains(ModuleId::NONE));
}
