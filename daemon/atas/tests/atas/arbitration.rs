//! Arbitration: merge rules and independence of module order.

use atas_core::arbitration::{Arbiter, Intent};
use atas_core::limits::{
    CARRY_SCALE_PER_S, CLOSING_SLOW_DOWN_M_S2, CLOSING_SPEED_UP_M_S2, CLOSING_SPEED_UP_S,
};
use atas_core::modules::{PoseCommand, Proposal, Verdict};
use atas_core::perception::StiffnessFit;
use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::GraspPose;
use shm_schemas::{Cause, ModuleId, Reason, ReasonRecord};

const STEP_S: f64 = 1e-3;

fn closing_proposal(closing_m_s: f64) -> Proposal {
    Proposal {
        closing_m_s: [closing_m_s; 2].into(),
        ..Proposal::default()
    }
}

fn ceiling(closing_m_s: f64) -> Proposal {
    Proposal {
        closing_ceiling_m_s: [closing_m_s; 2].into(),
        ..Proposal::default()
    }
}

fn verdict(verdict: Verdict) -> Proposal {
    Proposal {
        verdict,
        ..Proposal::default()
    }
}

fn pose_command(with_fingers: bool) -> PoseCommand {
    let frame = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 0.0, 0.05);
    PoseCommand {
        pose: frame,
        with_fingers,
        arrived: false,
    }
}

/// Intent after all slews have ended.
fn settled(proposals: &[Proposal]) -> Intent {
    let mut arbiter = Arbiter::default();
    (0..1000)
        .map(|_| arbiter.merge(proposals, STEP_S))
        .last()
        .unwrap()
}

#[test]
fn closing_speeds_merge_by_the_rules() {
    for (rule, proposals, expected_m_s) in [
        ("no proposal", vec![], 0.0),
        (
            "highest closing speed wins",
            vec![closing_proposal(0.001), closing_proposal(0.002)],
            0.002,
        ),
        (
            "closing wins over opening",
            vec![closing_proposal(-0.005), closing_proposal(0.002)],
            0.002,
        ),
        (
            "without closing, fastest opening wins",
            vec![
                closing_proposal(-0.001),
                closing_proposal(-0.003),
                closing_proposal(0.0),
            ],
            -0.003,
        ),
        (
            "zero ceiling stops",
            vec![closing_proposal(0.002), ceiling(0.0)],
            0.0,
        ),
        (
            "ceiling limits",
            vec![closing_proposal(0.002), ceiling(0.0005)],
            0.0005,
        ),
        (
            "ceiling above the proposed speed has no effect",
            vec![closing_proposal(0.002), ceiling(0.01)],
            0.002,
        ),
        (
            "opening ceiling wins",
            vec![closing_proposal(0.002), ceiling(0.0), ceiling(-0.001)],
            -0.001,
        ),
        (
            "opening ceiling opens without a proposal",
            vec![ceiling(-0.001)],
            -0.001,
        ),
        (
            "opening faster than the ceiling is allowed",
            vec![closing_proposal(-0.003), ceiling(-0.001)],
            -0.003,
        ),
        (
            "NaN counts as no proposal",
            vec![
                closing_proposal(f64::NAN),
                ceiling(f64::NAN),
                closing_proposal(0.001),
            ],
            0.001,
        ),
    ] {
        assert_eq!(
            settled(&proposals).closing_m_s,
            [expected_m_s; 2].into(),
            "{rule}"
        );
    }
}

#[test]
fn grasp_sides_are_merged_separately() {
    let one = Proposal {
        closing_m_s: [0.002, 0.0].into(),
        ..Proposal::default()
    };
    let other = Proposal {
        closing_ceiling_m_s: [f64::INFINITY, -0.001].into(),
        ..Proposal::default()
    };
    assert_eq!(settled(&[one, other]).closing_m_s, [0.002, -0.001].into());
}

#[test]
fn refusal_outranks_every_other_verdict() {
    let stiffness = Verdict::Stiffness(StiffnessFit {
        object_n_m: 1000.0,
        confidence: 1.0,
        new_contact: false,
    });
    let refuse = Verdict::Refuse(Reason::TooHeavy {
        force_n: 8.1,
        limit_n: 8.0,
        module: ModuleId::FORCE_LIMIT,
    });
    for (proposals, expected) in [
        (vec![verdict(Verdict::None)], Verdict::None),
        (vec![verdict(Verdict::None), verdict(stiffness)], stiffness),
        (vec![verdict(stiffness), verdict(refuse)], refuse),
        (vec![verdict(refuse), verdict(stiffness)], refuse),
    ] {
        assert_eq!(settled(&proposals).verdict, expected);
    }
}

#[test]
fn hand_moves_at_the_lowest_carry_ceiling() {
    let carry = Proposal {
        pose: Some(pose_command(true)),
        ..Proposal::default()
    };
    let slow = Proposal {
        carry_ceiling: 0.1,
        ..Proposal::default()
    };
    let back = Proposal {
        carry_ceiling: -1.0,
        ..Proposal::default()
    };
    for (proposals, scale) in [
        (vec![carry], 1.0),
        (vec![carry, slow], 0.1),
        (vec![back, slow, carry], -1.0),
    ] {
        let mut arbiter = Arbiter::default();
        let intent = (0..1000)
            .map(|_| arbiter.merge(&proposals, STEP_S))
            .last()
            .unwrap();
        assert_eq!(
            (intent.pose, arbiter.carry_scale()),
            (Some(pose_command(true)), scale)
        );
    }
}

#[test]
fn reset_clears_the_closing_speed() {
    let mut arbiter = Arbiter::default();
    for _ in 0..100 {
        arbiter.merge(&[closing_proposal(0.002)], STEP_S);
    }
    arbiter.reset();
    let intent = arbiter.merge(&[closing_proposal(0.002)], STEP_S);
    assert_eq!(
        intent.closing_m_s,
        [CLOSING_SPEED_UP_M_S2 * STEP_S; 2].into()
    );
}

fn speeds() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        -0.02..0.02,
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY)
    ]
}

fn any_proposal() -> impl Strategy<Value = Proposal> {
    let ceilings = prop_oneof![Just(f64::INFINITY), speeds()];
    (
        [speeds(), speeds()],
        [ceilings.clone(), ceilings],
        -1.0..1.0,
        any::<bool>(),
    )
        .prop_map(|(wish, ceiling, carry, active)| Proposal {
            active,
            closing_m_s: wish.into(),
            closing_ceiling_m_s: ceiling.into(),
            carry_ceiling: carry,
            ..Proposal::default()
        })
}

/// Few distinct values, so that ties are frequent.
fn any_verdict() -> impl Strategy<Value = Verdict> {
    let few = || prop::sample::select(vec![7.0, 8.0, -8.0, f64::INFINITY]);
    let reason = (
        prop::sample::select(vec![Cause::TOO_HEAVY, Cause::TOO_SOFT, Cause::OBSTRUCTED]),
        prop::sample::select(vec![ModuleId::FORCE_LIMIT, ModuleId::LIFT_VERIFICATION]),
        few(),
        few(),
    );
    let refuse = reason.prop_map(|(cause, module, value, limit)| {
        let record = ReasonRecord {
            cause,
            module,
            value,
            limit,
            ..ReasonRecord::default()
        };
        Verdict::Refuse(record.into())
    });
    let fit = (few(), few()).prop_map(|(object_n_m, confidence)| {
        Verdict::Stiffness(StiffnessFit {
            object_n_m,
            confidence,
            new_contact: false,
        })
    });
    prop_oneof![
        2 => Just(Verdict::None),
        1 => Just(Verdict::Done),
        2 => fit,
        3 => refuse,
    ]
}

/// Any verdicts with ties; at most one module carries, as the task rules require.
fn any_proposals() -> impl Strategy<Value = Vec<Proposal>> {
    let with_verdict = (any_proposal(), any_verdict()).prop_map(|(proposal, verdict)| Proposal {
        verdict,
        ..proposal
    });
    let carries = prop::option::of(any::<bool>());
    (prop::collection::vec(with_verdict, 3..7), carries).prop_map(|(mut proposals, carries)| {
        proposals[0].pose = carries.map(pose_command);
        proposals
    })
}

proptest! {
    #[test]
    fn module_order_has_no_effect(
        (ordered, shuffled) in any_proposals().prop_flat_map(|p| (Just(p.clone()), Just(p).prop_shuffle())),
    ) {
        let (mut a, mut b) = (Arbiter::default(), Arbiter::default());
        for _ in 0..5 {
            prop_assert_eq!(a.merge(&ordered, STEP_S), b.merge(&shuffled, STEP_S));
            prop_assert_eq!(a, b);
        }
    }

    #[test]
    fn speeds_rise_slowly_and_fall_fast(series in prop::collection::vec(any_proposals(), 1..30)) {
        let mut arbiter = Arbiter::default();
        let (mut before_m_s, mut before_scale) = ([0.0; 2], 1.0);
        for proposals in series {
            let fastest_m_s = proposals.iter().flat_map(|p| p.closing_m_s).fold(0.0, f64::max);
            let speed_up_m_s2 = (fastest_m_s / CLOSING_SPEED_UP_S)
                .clamp(CLOSING_SPEED_UP_M_S2, CLOSING_SLOW_DOWN_M_S2);
            let intent = arbiter.merge(&proposals, STEP_S);
            for (now, before) in intent.closing_m_s.into_iter().zip(before_m_s) {
                prop_assert!(now.is_finite());
                let closes_more = now > before && now > 0.0;
                let most = if closes_more { speed_up_m_s2 } else { CLOSING_SLOW_DOWN_M_S2 } * STEP_S;
                prop_assert!((now - before).abs() <= most + 1e-15, "{before} to {now}");
            }
            prop_assert!((arbiter.carry_scale() - before_scale).abs() <= CARRY_SCALE_PER_S * STEP_S + 1e-15);
            (before_m_s, before_scale) = (intent.closing_m_s.into_array(), arbiter.carry_scale());
        }
    }
}
