//! One step per 1 ms tick along the motions of the assembly: both hands, start to end.

use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, IkStatus, IkWeights, PerSide, RobotVector};

use crate::support::ROBOT;
use Motion::{Linear, Smooth, Swing};

const DT_S: f64 = 1e-3;

/// Kind of a motion, with its tracking tolerance.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    /// Minimum jerk, with or without an object.
    Smooth,
    /// Constant speed, pressing or turning.
    Linear,
    /// Minimum jerk of an empty hand that turns or tilts by tens of degrees. The dome axes lag,
    /// because they correct 5 % of their error per tick.
    Swing,
}

impl Motion {
    /// Largest distance of a tip from its target after the tick's step. Measured: 0.02 µm, on
    /// swings 0.16 µm.
    fn tip_error_max_m(self) -> f64 {
        if self == Motion::Swing {
            0.2e-6
        } else {
            0.1e-6
        }
    }

    /// Measured: 0.032°, on swings 0.56°.
    fn dome_error_max_deg(self) -> f64 {
        if self == Motion::Swing { 0.6 } else { 0.1 }
    }
}

/// Target grasp and kind of motion.
struct Key {
    grasp: GraspPose,
    seconds: f64,
    motion: Motion,
}

fn blend(from: &GraspPose, to: &GraspPose, s: f64) -> GraspPose {
    let mix = |a: f64, b: f64| a + (b - a) * s;
    let pair = |a: PerSide<f64>, b: PerSide<f64>| PerSide::from_fn(|side| mix(a[side], b[side]));
    GraspPose {
        centre_m: from.centre_m + (to.centre_m - from.centre_m) * s,
        closing_yaw_rad: mix(from.closing_yaw_rad, to.closing_yaw_rad),
        hand_azimuth_rad: mix(from.hand_azimuth_rad, to.hand_azimuth_rad),
        hand_pitch_rad: mix(from.hand_pitch_rad, to.hand_pitch_rad),
        root_rad: mix(from.root_rad, to.root_rad),
        half_opening_m: pair(from.half_opening_m, to.half_opening_m),
        tangential_m: pair(from.tangential_m, to.tangential_m),
        up_m: pair(from.up_m, to.up_m),
    }
}

/// Returns the fraction of a minimum-jerk motion.
fn minimum_jerk(s: f64) -> f64 {
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// Tracks the keys from the posture of the first one, checks every tick and returns the last
/// command.
fn track(name: &str, side: HandSide, keys: &[Key]) -> HandVector {
    let hand = ROBOT.hand(side);
    let mut q = hand
        .posture_for(&keys[0].grasp)
        .expect("the first key is reachable")
        .q;
    for pair in keys.windows(2) {
        let motion = pair[1].motion;
        let ticks = (pair[1].seconds / DT_S).round() as usize;
        for tick in 1..=ticks {
            let s = tick as f64 / ticks as f64;
            let s = if motion == Motion::Linear {
                s
            } else {
                minimum_jerk(s)
            };
            let target = blend(&pair[0].grasp, &pair[1].grasp, s).target(hand);
            let pose = hand.forward(&q);
            let step = hand.ik_step(
                &pose,
                &hand.jacobian(&pose),
                &target,
                DT_S,
                &IkWeights::TICK,
            );
            assert_eq!(
                step.status,
                IkStatus::Free,
                "{name}: a joint was held back at s = {s}"
            );
            q = step.q;
            let reached = hand.forward(&q);
            for finger in 0..2 {
                let tip_error_m = (reached.tip_m(finger) - target.tip_m[finger]).norm();
                assert!(
                    tip_error_m <= motion.tip_error_max_m(),
                    "{name}: tip {tip_error_m:e} m off at s = {s}"
                );
                let dome_error = reached
                    .dome_axis(finger)
                    .angle(&target.dome_axis[finger])
                    .to_degrees();
                assert!(
                    dome_error <= motion.dome_error_max_deg(),
                    "{name}: dome {dome_error}° off at s = {s}"
                );
            }
        }
    }
    q
}

/// Cap from its stand to the bottle: approach, descend, close at 2 mm/s, lift, convey 260 mm,
/// lower, release, then two rectangles of ±7 × 3 mm, open, up.
#[test]
fn right_hand_carries_and_turns_a_cap() {
    let hand = ROBOT.hand(HandSide::Right);
    let (stand, bottle) = (
        Vector3::new(0.32, -0.18, 0.05),
        Vector3::new(0.38, 0.0, 0.13),
    );
    let yaw = 60_f64.to_radians();
    let at = |centre_m: Vector3<f64>, half_m: f64, turned_m: f64, seconds: f64, motion: Motion| {
        let mut grasp = GraspPose::from_above(centre_m, yaw, 2.0 * half_m);
        grasp.tangential_m = PerSide::new(turned_m, -turned_m);
        Key {
            grasp,
            seconds,
            motion,
        }
    };
    let up = |centre: Vector3<f64>, by_m: f64| centre + Vector3::z() * by_m;
    let carry_z = 0.18;
    let lifted = |centre: Vector3<f64>| Vector3::new(centre.x, centre.y, carry_z);
    let home_m = Vector3::new(0.26, -0.22, 0.15);
    let mut home = at(home_m, 0.03, 0.0, 3.0, Smooth);
    home.grasp.closing_yaw_rad = hand.bearing_rad(&home_m) + 90_f64.to_radians();
    let mut keys = vec![
        home,
        at(up(stand, 0.08), 0.03, 0.0, 2.0, Swing),
        at(stand, 0.03, 0.0, 2.0, Smooth),
        at(stand, 0.02, 0.0, 1.0, Smooth),
        at(stand, 0.0145, 0.0, 2.75, Linear),
        at(lifted(stand), 0.0145, 0.0, 3.5, Smooth),
        at(lifted(bottle), 0.0145, 0.0, 4.0, Smooth),
        at(bottle, 0.0145, 0.0, 6.0, Smooth),
        at(bottle, 0.018, 0.0, 0.5, Smooth),
    ];
    for _ in 0..2 {
        keys.push(at(bottle, 0.0174, -0.007, 1.5, Smooth));
        keys.push(at(bottle, 0.0144, -0.007, 0.3, Linear));
        keys.push(at(bottle, 0.0144, 0.007, 1.4, Linear));
        keys.push(at(bottle, 0.0174, 0.007, 0.3, Linear));
        keys.push(at(bottle, 0.0174, -0.007, 1.4, Linear));
    }
    keys.push(at(bottle, 0.03, 0.0, 1.0, Smooth));
    keys.push(at(up(bottle, 0.07), 0.03, 0.0, 2.0, Smooth));
    track("cap", HandSide::Right, &keys);
}

/// The hand holds the bottle from the side: tilt to 45°, approach along its bearing, close.
#[test]
fn left_hand_grasps_a_bottle_from_the_side() {
    let hand = ROBOT.hand(HandSide::Left);
    let bottle = Vector3::new(0.38, 0.0, 0.045);
    let tilted =
        |centre_m: Vector3<f64>, bearing_rad: f64, half_m: f64, seconds: f64, motion: Motion| {
            let yaw = bearing_rad + 90_f64.to_radians();
            let mut grasp = GraspPose::from_above(centre_m, yaw, 2.0 * half_m);
            grasp.hand_azimuth_rad = bearing_rad;
            grasp.hand_pitch_rad = 45_f64.to_radians();
            grasp.root_rad = -27.5_f64.to_radians();
            Key {
                grasp,
                seconds,
                motion,
            }
        };
    let bearing = hand.bearing_rad(&bottle);
    let behind = bottle + Vector3::new(-0.1 * bearing.cos(), -0.1 * bearing.sin(), 0.03);
    let home_m = Vector3::new(0.26, 0.22, 0.15);
    let home_bearing = hand.bearing_rad(&home_m);
    let home = GraspPose::from_above(home_m, home_bearing + 90_f64.to_radians(), 0.08);
    let keys = [
        Key {
            grasp: GraspPose {
                hand_azimuth_rad: home_bearing,
                ..home
            },
            seconds: 0.0,
            motion: Smooth,
        },
        tilted(home_m, home_bearing, 0.05, 2.0, Swing),
        tilted(behind, bearing, 0.05, 2.0, Swing),
        tilted(bottle, bearing, 0.05, 2.0, Smooth),
        tilted(bottle, bearing, 0.035, 1.5, Smooth),
        tilted(bottle, bearing, 0.0295, 2.75, Linear),
        tilted(bottle, bearing, 0.05, 2.0, Smooth),
        tilted(behind, bearing, 0.05, 2.0, Smooth),
    ];
    track("bottle", HandSide::Left, &keys);
}

/// A vector of the whole robot takes both hands' commands at their first joints.
#[test]
fn commands_of_both_hands_fill_the_robot_vector() {
    let mut robot_rad = RobotVector::zeros(ROBOT.joint_count());
    for side in HandSide::BOTH {
        let q = ROBOT.hand(side).reference();
        robot_rad[ROBOT.joint_range(side)].copy_from_slice(q);
    }
    assert_eq!(robot_rad[0], -robot_rad[11]);
    assert_eq!(robot_rad[1..11], robot_rad[12..22]);
}
