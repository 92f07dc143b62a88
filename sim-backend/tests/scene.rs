//! Scenes: nominal data, variations and rejections.

use robot_model::{GraspPose, HandSide, RobotModel};
use sim_backend::{Mount, Object, Placed, Plate, Scene, World, home};

fn scene(name: &str, side: HandSide) -> Scene {
    Scene::grasp(Object::built_in(name).expect(name), side)
}

fn robot() -> RobotModel {
    RobotModel::two_hand_arm().expect("the built-in robot loads")
}

#[test]
fn every_built_in_object_is_reachable() {
    for side in HandSide::BOTH {
        for name in Object::names() {
            let hint = scene(name, side)
                .grasp_hint(0)
                .expect("scene has an object");
            let robot = robot();
            let (hand, centre_m) = (robot.hand(side), hint.from_m.into());
            let yaw_rad = hand.closing_yaw_rad(&centre_m, hint.yaw_rad);
            let frame = GraspPose::from_above(centre_m, yaw_rad, hint.width_m + 0.02);
            let reached = hand.posture_for(&frame);
            assert!(
                reached.is_ok(),
                "{name} with the {side:?} hand: {reached:?}"
            );
        }
    }
}

#[test]
fn home_posture_is_symmetric() {
    let home = home(&robot()).expect("home posture exists");
    for joint in 0..11 {
        let sign = if joint == 0 || joint == 4 { -1.0 } else { 1.0 };
        let other = if joint < 5 {
            joint
        } else {
            5 + (joint - 5 + 3) % 6
        };
        let (left, right) = (home[joint], sign * home[11 + other]);
        assert!(
            (left - right).abs() < 1e-6,
            "joint {joint}: {left} and {right} rad"
        );
    }
}

#[test]
fn families_keep_ranges_and_nominal_data() {
    let nominal = scene("bottle", HandSide::Right);
    let mut widest = [0.0_f64; 6];
    for seed in 0..500 {
        let varied = nominal.varied(seed);
        assert_eq!(varied.grasp_hint(0), nominal.grasp_hint(0));
        let (v, n) = (&varied.objects[0], &nominal.objects[0]);
        let shares = [
            (v.object.mass_kg / n.object.mass_kg - 1.0) / 0.2,
            (v.object.friction / n.object.friction - 1.0) / 0.2,
            (v.object.stiffness_n_m / n.object.stiffness_n_m - 1.0) / 0.2,
            (v.position_m[0] - n.position_m[0]) / 0.002,
            (v.position_m[1] - n.position_m[1]) / 0.002,
            (v.yaw_rad - n.yaw_rad).to_degrees() / 5.0,
        ];
        for (widest, share) in widest.iter_mut().zip(shares) {
            assert!(share.abs() <= 1.0 + 1e-12, "seed {seed}: {shares:?}");
            *widest = widest.max(share.abs());
        }
    }
    assert!(
        widest.iter().all(|share| *share > 0.97),
        "draws cover the ranges: {widest:?}"
    );
    assert_eq!(nominal.varied(3), nominal.varied(3));
    assert_ne!(nominal.varied(3), nominal.varied(4));
}

#[test]
fn rigid_uncrushable_object_stays_so_in_its_family() {
    let wood = &scene("wood", HandSide::Left).varied(1).objects[0].object;
    assert!(wood.stiffness_n_m.is_infinite() && wood.crush_n.is_infinite());
}

#[test]
fn errors_state_value_and_range() {
    let check = |change: &dyn Fn(&mut Scene), part: &str| {
        let mut scene = scene("wood", HandSide::Right);
        change(&mut scene);
        let message = World::new(&robot(), &scene, 1).expect_err(part).to_string();
        assert!(message.contains(part), "{message}");
    };
    let wood = Object::built_in("wood").expect("built-in object");
    check(
        &|s| s.noise_factor = f64::NAN,
        "the noise factor is NaN, needs 0 to 100",
    );
    check(&|s| s.vibration_m = -1.0, "the vibration in metres is -1");
    check(
        &|s| s.sensor_rate_hz[1] = 0,
        "the sensor rate in hertz is 0, needs 1 to 1000",
    );
    check(
        &|s| s.objects[0].position_m[0] = f64::INFINITY,
        "an object's x in metres is inf",
    );
    check(
        &|s| s.objects[0].yaw_rad = 100.0,
        "an object's yaw in radians is 100",
    );
    check(&|s| s.objects[0].mount = Mount::OnNeck, "no bottle has one");
    check(
        &|s| {
            s.objects.push(Placed::new(
                Object::built_in("open-bottle").expect("built-in object"),
                [0.3, 0.0],
                0.0,
            ));
            s.objects[0].mount = Mount::OnNeck;
        },
        "\"wood\" is on a bottle's neck but has no thread",
    );
    check(
        &|s| {
            s.plates.push(Plate {
                centre_m: [0.3, 0.0],
                half_m: [0.1; 2],
                height_m: -0.01,
            })
        },
        "a plate's height in metres is -0.01",
    );
    check(
        &|s| s.start = Some([f64::NAN; 22].into()),
        "a start angle in radians is NaN",
    );
    check(
        &|s| s.objects = vec![Placed::new(wood.clone(), [0.3, 0.0], 0.0); 5],
        "it has 5 objects, needs at most 4",
    );
}
