//! Tests of caps and bottles without fingertips.

use super::*;
use crate::object::Object;
use crate::scene::Scene;
use crate::support::Ground;
use crate::thread::ClosingDirection;
use proptest::array::uniform3;
use proptest::prelude::*;
use robot_model::HandSide;

const DT_S: f64 = 250e-6;

/// Cap and bottle, stepped in the order that a world uses.
struct Bench {
    threaded_cap: ThreadedCap,
    objects: Vec<WorldObject>,
}

impl Bench {
    fn new(mount: Mount) -> Self {
        let part = |name| Object::built_in(name).expect("built in");
        let mut scene = Scene::screw(part("cap"), part("open-bottle"), HandSide::Right);
        scene.objects[0].mount = mount;
        scene.objects[1].mount = Mount::Standing;
        let mut objects = WorldObject::from_scene(&scene);
        let mut closure = ThreadedCap::from_scene(&scene.objects).expect("a cap and a bottle");
        closure.initialise(&mut objects, DT_S);
        Self {
            threaded_cap: closure,
            objects,
        }
    }

    /// Returns a loose cap above the rim with an offset, a height and a tilt.
    fn loose_above_rim(off_m: f64, up_m: f64, lean_rad: f64) -> Self {
        let mut bench = Self::new(Mount::Standing);
        let rim = bench.threaded_cap.rim(bench.bottle());
        let motion = Motion {
            position_m: rim.centre_m
                + Vector3::new(off_m, 0.0, up_m + bench.threaded_cap.cap_half_m),
            orientation: rotated([1.0, 0.0, 0.0, 0.0], &Vector3::new(0.0, lean_rad, 0.0)),
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
        };
        bench.objects[0].body.set_motion(&motion);
        bench
    }

    /// Returns an engaged cap that is turned to an angle.
    fn with_cap_turned(angle_rad: f64) -> Self {
        let mut bench = Self::new(Mount::OnNeck);
        while bench.truth().angle_rad < angle_rad {
            bench.step(1, [0.0; 3], [0.0, 0.0, -0.018]);
        }
        bench
    }

    /// Steps under a wrench about the centre of the cap, base frame.
    fn step(&mut self, steps: usize, force_n: [f64; 3], moment_n_m: [f64; 3]) {
        for _ in 0..steps {
            let at_m = self.cap().position_m;
            let wrench = Wrench {
                force_n: force_n.into(),
                moment_n_m: moment_n_m.into(),
            };
            self.objects[0].body.apply_at(&at_m, &wrench);
            self.threaded_cap.apply_load(&mut self.objects, DT_S);
            for index in 0..2 {
                let rim = self.threaded_cap.rim_for(index, &self.objects);
                if !self.threaded_cap.constrains(index) {
                    self.objects[index].step(
                        &Ground {
                            rim,
                            ..Ground::default()
                        },
                        DT_S,
                    );
                }
            }
            self.threaded_cap.update(&mut self.objects, DT_S);
        }
    }

    fn cap(&self) -> &Body {
        &self.objects[0].body
    }

    fn bottle(&self) -> &Body {
        &self.objects[1].body
    }

    fn truth(&self) -> CapTruth {
        self.threaded_cap.truth(0).expect("a cap")
    }
}

#[test]
fn cap_engages_only_near_the_axis() {
    let check = |off_m: f64, lean_rad: f64, expected: bool| {
        let mut bench = Bench::loose_above_rim(off_m, 0.0005, lean_rad);
        bench.step(400, [0.0; 3], [0.0; 3]);
        assert_eq!(bench.truth().engaged, expected, "{off_m} m, {lean_rad} rad");
    };
    check(0.0, 0.0, true);
    check(0.0018, 0.0, true);
    check(0.0, 0.07, true);
    check(0.0025, 0.0, false);
    check(0.010, 0.0, false);
}

#[test]
fn thread_centres_an_engaged_cap() {
    let mut bench = Bench::loose_above_rim(0.0015, 0.0001, 0.0);
    let before_m = bench.cap().position_m;
    bench.step(400, [0.0; 3], [0.0; 3]);
    assert!(bench.truth().engaged);
    let moved_m = (bench.cap().position_m - before_m).norm();
    assert!(moved_m < 2e-4, "moved by {moved_m} m");
    while bench.truth().angle_rad < 1.6 {
        bench.step(1, [0.0; 3], [0.0, 0.0, -0.018]);
    }
    let off_m = bench.cap().position_m - bench.bottle().position_m;
    assert!(off_m.xy().norm() < 1e-5, "off by {off_m}");
}

#[test]
fn closing_turn_lowers_the_cap_by_its_pitch() {
    let start = Bench::new(Mount::OnNeck);
    let (start_m, rest) = (start.cap().position_m.z, start.cap().base_from_body);
    let bench = Bench::with_cap_turned(1.0);
    let down_m = start_m - bench.cap().position_m.z;
    let expected_m = 0.003 * bench.truth().angle_rad / core::f64::consts::TAU;
    assert!(
        (down_m - expected_m).abs() < 1e-6,
        "{down_m} of {expected_m} m"
    );
    let turn = rest.tr_mul(&bench.cap().base_from_body);
    assert!(libm::atan2(turn[(1, 0)], turn[(0, 0)]) < -0.98, "{turn}");
}

#[test]
fn a_left_hand_thread_closes_anticlockwise() {
    for (closes, sign) in [
        (ClosingDirection::Clockwise, -1.0),
        (ClosingDirection::Anticlockwise, 1.0),
    ] {
        let mut bench = Bench::new(Mount::OnNeck);
        bench.threaded_cap.thread.closes = closes;
        bench.step(400, [0.0; 3], [0.0, 0.0, 0.03 * sign]);
        assert!(bench.truth().angle_rad > 0.1, "{closes:?}");
        assert!(bench.cap().angular_rad_s.z * sign > 0.0);
    }
}

#[test]
fn bottle_carries_thread_torque_and_cap_weight() {
    let mut bench = Bench::new(Mount::OnNeck);
    let bottle_n = bench.bottle().weight_n();
    bench.step(2000, [0.0, 0.0, -1.0], [0.0, 0.0, -0.012]);
    let truth = bench.truth();
    assert!(truth.angle_rad < 0.01 && (truth.torque_n_m - 0.012).abs() < 1e-4);
    let expected_n = bottle_n + bench.cap().weight_n() + 1.0;
    assert!((bench.bottle().table_n / expected_n - 1.0).abs() < 1e-3);
    assert!(
        bench.bottle().angular_rad_s.norm() < 1e-3,
        "the table holds the bottle"
    );
}

/// A stiff thread turns the bottle with the cap once the torque exceeds the table's friction.
#[test]
fn a_free_bottle_spins_with_a_closed_cap() {
    let mut bench = Bench::new(Mount::OnNeck);
    bench.threaded_cap.thread.friction_n_m = 0.1;
    bench.step(1000, [0.0; 3], [0.0, 0.0, -0.05]);
    assert!(bench.truth().angle_rad < 0.02);
    assert!(
        bench.bottle().angular_rad_s.z < -1.0,
        "{}",
        bench.bottle().angular_rad_s
    );
    let cap = bench.cap().angular_rad_s.z - bench.bottle().angular_rad_s.z;
    assert!(cap.abs() < 0.1, "cap and bottle turn together");
}

#[test]
fn a_push_on_the_cap_tips_a_free_bottle() {
    let mut bench = Bench::with_cap_turned(0.1);
    bench.step(4000, [0.3, 0.0, 0.0], [0.0; 3]);
    assert!(bench.bottle().tilt_rad() < 0.02);
    bench.step(1600, [0.85, 0.0, 0.0], [0.0; 3]);
    assert!(
        bench.bottle().tilt_rad() > 0.5,
        "tilt {}",
        bench.bottle().tilt_rad()
    );
    assert!((bench.cap().tilt_rad() - bench.bottle().tilt_rad()).abs() < 1e-6);
}

#[test]
fn cap_comes_off_only_before_turning() {
    let mut bench = Bench::new(Mount::OnNeck);
    bench.step(40, [0.0, 0.0, 0.05], [0.0; 3]);
    assert!(bench.truth().engaged, "the weight of the cap holds it");
    bench.step(40, [0.0, 0.0, 0.5], [0.0; 3]);
    assert!(!bench.truth().engaged);
    let mut bench = Bench::with_cap_turned(0.1);
    bench.step(40, [0.0, 0.0, 0.5], [0.0; 3]);
    assert!(bench.truth().engaged);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn state_stays_finite_under_any_wrench(
        off_m in -0.01..0.01_f64,
        lean_rad in -0.2..0.2_f64,
        force_n in uniform3(-20.0..20.0_f64),
        moment_n_m in uniform3(-0.5..0.5_f64),
    ) {
        let mut bench = Bench::loose_above_rim(off_m, 0.0002, lean_rad);
        bench.step(200, [0.0, 0.0, -0.5], [0.0; 3]);
        bench.step(200, force_n, moment_n_m);
        prop_assert!(bench.cap().is_finite() && bench.bottle().is_finite());
        prop_assert!(bench.truth().angle_rad.is_finite());
    }
}
