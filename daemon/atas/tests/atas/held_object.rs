//! Estimates of the held object from series of percepts.

use crate::bench::{fingertip, path, percept};
use atas_core::Settings;
use atas_core::executor::HandMotion;
use atas_core::held_object::{HeldObject, HeldObjectEstimator, LiftFinding, StepFacts};
use atas_core::perception::{ContactPercept, Percept};
use atas_core::thresholds::Thresholds;
use nalgebra::Vector3;
use robot_model::{GraspPose, Skin, Transform};

/// Step that lifts, with lift verification.
pub(crate) const LIFTS: StepFacts = StepFacts {
    searches: false,
    verifies_lift: true,
    lowers: false,
    steadies: false,
    is_monitored: true,
};

/// An object in a hand that closes along x.
pub(crate) struct Rig {
    pub(crate) estimator: HeldObjectEstimator,
    pub(crate) settings: Settings,
    pub(crate) pose: GraspPose,
    pub(crate) carry_scale: f64,
    pub(crate) gap_m: f64,
}

impl Rig {
    /// Not yet touched.
    pub(crate) fn new() -> Self {
        let settings = Settings::default();
        let thresholds = Thresholds::for_stiffness(10_000.0, &settings.grasp);
        Self {
            estimator: HeldObjectEstimator::new(thresholds),
            settings,
            pose: path().pose_at(0.0),
            carry_scale: 1.0,
            gap_m: 0.05,
        }
    }

    /// Found in the hand, then raised by 10 mm.
    pub(crate) fn found() -> Self {
        let mut rig = Self::new();
        let thresholds = rig.estimator.thresholds();
        rig.estimator = HeldObjectEstimator::for_found_object(thresholds, rig.pose.centre_m);
        rig.pose.centre_m.z += 0.01;
        rig
    }

    /// Touched and gripped, about to be lifted.
    pub(crate) fn gripped() -> Self {
        let mut rig = Self::new();
        let thresholds = rig.estimator.thresholds();
        let fit = atas_core::perception::StiffnessFit {
            object_n_m: 10_000.0,
            confidence: 1.0,
            new_contact: false,
        };
        let searches = StepFacts {
            searches: true,
            ..LIFTS
        };
        rig.update(&holding(2.0, 0.0), searches);
        rig.estimator.set_stiffness(fit, thresholds);
        rig.estimator.lift(rig.pose.centre_m);
        rig
    }

    pub(crate) fn update(&mut self, measured: &Percept, step: StepFacts) -> HeldObject {
        let hand = HandMotion {
            carry_scale: self.carry_scale,
            closing_m_s: [0.0; 2].into(),
            pose: &self.pose,
            closing_axis: Vector3::x(),
            turns_by_wrist: false,
            base_from_tip: &[Transform::IDENTITY; 2],
            side_m: [Vector3::zeros(); 2].into(),
            compression: Skin::DOME_41.compression,
            tactile_over_torque: 1.0,
            torque_over_tactile: 1.0,
        };
        let measures = (self.gap_m, measured.step_s);
        self.estimator
            .update(measured, &hand, measures, step, &self.settings);
        *self.estimator.object()
    }

    pub(crate) fn hold(&mut self, ticks: usize, normal_n: f64, load_n: f64) -> HeldObject {
        let all = (0..ticks).map(|_| self.update(&holding(normal_n, load_n), LIFTS));
        all.last().unwrap()
    }

    /// Gripped and raised by 10 mm.
    pub(crate) fn raised() -> Self {
        let mut rig = Self::gripped();
        rig.pose.centre_m.z += 0.01;
        rig
    }

    /// Raised, with a load of 2 N verified at 4 N per side.
    pub(crate) fn verified() -> Self {
        let mut rig = Self::raised();
        rig.hold(1000, 4.0, 2.0);
        rig.estimator.receive(LiftFinding::Suspended, true);
        rig
    }
}

/// Percept of a load that both sides carry together.
pub(crate) fn holding(normal_n: f64, load_n: f64) -> Percept {
    let side = ContactPercept {
        force_tip_n: Vector3::new(0.0, 0.0, -load_n / 2.0),
        tangential_n: load_n / 2.0,
        ..fingertip(normal_n)
    };
    percept([side; 2])
}

pub(crate) fn with_step(step_s: f64, measured: Percept) -> Percept {
    Percept { step_s, ..measured }
}

#[test]
fn verified_grip_holds_loads_in_proportion_to_its_force() {
    for (normal_n, load_n, is_held) in [
        (4.0, 2.0, true),
        (4.0, 2.08, true),
        (4.0, 2.3, false),
        (5.0, 2.4, true),
        (3.0, 2.0, false),
    ] {
        let mut rig = Rig::verified();
        let object = rig.hold(300, normal_n, load_n);
        assert_eq!(
            object.load_is_held, is_held,
            "{normal_n} N, load {load_n} N"
        );
    }
}

/// Regression: misaligned faces shear the fingertips in proportion to grip force; the hand gripped
/// an object of 50 g with F_2.
#[test]
fn closing_without_load_response_shows_that_the_load_is_held() {
    // Half a second at 2 N, then half a second up to 4 N with a load that grows by this factor.
    let held_after = |load_growth: f64| {
        let mut rig = Rig::gripped();
        rig.pose.centre_m.z += 0.0005;
        assert!(!rig.hold(500, 2.0, 0.5).load_is_held);
        let presses = (0..500).map(|tick| {
            let share = f64::from(tick) / 500.0;
            let load_n = 0.5 + 0.5 * load_growth * share;
            rig.hold(1, 2.0 + 2.0 * share, load_n).load_is_held
        });
        presses.last().unwrap()
    };
    assert!(held_after(0.0), "a held object keeps its load");
    assert!(
        !held_after(1.0),
        "the load of a slipping object grows with the grip"
    );
}

#[test]
fn drop_counts_only_while_the_hand_alone_carries_the_object() {
    let drops = |rig: &mut Rig, step: StepFacts| {
        rig.hold(1000, 4.0, 2.0);
        (0..200).any(|_| rig.update(&holding(4.0, 1.8), step).drops)
    };
    let lowers = StepFacts {
        lowers: true,
        ..LIFTS
    };
    assert!(drops(&mut Rig::verified(), LIFTS), "carried");
    assert!(!drops(&mut Rig::verified(), lowers), "set down");
    let mut standing = Rig::gripped();
    standing.pose.centre_m.z += 0.002;
    assert!(!drops(&mut standing, LIFTS), "not verified");
    standing.estimator.receive(LiftFinding::MinimisesGrip, true);
    assert!(drops(&mut standing, LIFTS), "grip minimisation");
    let mut braking = Rig::verified();
    braking.hold(1000, 4.0, 2.0);
    braking.carry_scale = 0.5;
    let swings = braking.update(&holding(4.0, 1.8), LIFTS);
    assert!(
        swings.swings && !swings.drops,
        "a load swings after braking"
    );
}

/// Regression: the hand took the shake of the pull-back for slip and tightened a grip that had just
/// held the object.
#[test]
fn minimised_grip_is_known_to_hold_its_load() {
    let mut rig = Rig::gripped();
    rig.pose.centre_m.z += 0.002;
    rig.hold(500, 4.0, 2.0);
    rig.estimator.receive(LiftFinding::MinimisesGrip, true);
    assert!(!rig.hold(500, 3.0, 2.0).load_is_held, "not yet");
    rig.estimator.receive(LiftFinding::None, true);
    assert!(rig.hold(100, 3.0, 2.05).load_is_held, "pull-back");
    assert!(!rig.hold(300, 3.0, 2.3).load_is_held, "larger load");
    rig.estimator.receive(LiftFinding::Standing, true);
    assert!(!rig.hold(300, 3.0, 1.0).load_is_held, "it stands");
}

#[test]
fn another_search_forgets_the_contact() {
    let mut rig = Rig::verified();
    assert!(rig.hold(1, 4.0, 2.0).carried_m > 0.009);
    rig.estimator.begin_search();
    let object = rig.update(&holding(0.0, 0.0), LIFTS);
    let facts = (object.all_touched, object.carried_m, object.load_is_held);
    assert_eq!(facts, (false, 0.0, false));
    assert!(rig.estimator.stiffness().is_some() && object.grip.is_none());
}

/// Regression: a thread dragged a bottle along that was held with 1 N of 8 N.
#[test]
fn steadied_object_is_gripped_with_a_share_of_f2() {
    let mut rig = Rig::gripped();
    let f2_n = rig.estimator.thresholds().f2_n;
    let steadies = StepFacts {
        steadies: true,
        ..LIFTS
    };
    for (step, expected) in [(LIFTS, 0.0..0.2), (steadies, 0.39..0.41)] {
        let share = rig.update(&holding(2.0, 0.0), step).min_force_n / f2_n;
        assert!(expected.contains(&share), "{share} of F_2: {step:?}");
    }
}
