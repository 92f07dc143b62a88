//! Motion of the gate against a reference model of one joint: the same equations in other form.

use crate::gate_bench::{GateBench, positions};
use crate::support::{home, home_of, robot, test_bench};
use atas_core::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3, STEP_FACTOR};
use proptest::prelude::*;
use robot_model::{Joint, JointKind, RobotModel, RobotVector};
use shm_schemas::{Cause, Mode, Reason};

/// Joint of the reference model, in its own unit.
#[derive(Clone, Copy)]
struct Reference {
    limits: Joint,
    position: f64,
    velocity: f64,
    acceleration: f64,
    requested: f64,
}

impl Reference {
    fn all(robot: &RobotModel, at: &RobotVector) -> Vec<Self> {
        let joint = |(limits, position): (&Joint, &f64)| Self {
            limits: *limits,
            position: *position,
            velocity: 0.0,
            acceleration: 0.0,
            requested: *position,
        };
        robot.joints().zip(at.iter()).map(joint).collect()
    }

    /// Length of one radian: 1 rad, or the lever of 0.1 m of a sliding joint.
    fn unit(&self) -> f64 {
        match self.limits.kind {
            JointKind::Revolute => 1.0,
            JointKind::Prismatic => 0.1,
        }
    }

    /// Step or lag that the gate compares with its limit, and that limit.
    fn jump(&self, request: f64, step_s: f64) -> (f64, f64) {
        let step = (request - self.requested).abs();
        let speed = self.limits.velocity_max;
        let lag_max = speed * speed / (JOINT_ACCELERATION_RAD_S2 * self.unit());
        let lag = (request - self.position).abs() - lag_max;
        (step.max(lag), STEP_FACTOR * speed * step_s)
    }

    /// Speed v from which the joint stops within a distance d: d = v²/A + v·T.
    fn braking_speed(&self, distance: f64, step_s: f64) -> f64 {
        let acceleration = JOINT_ACCELERATION_RAD_S2 * self.unit();
        let settle_s = (4.0 * step_s).max(0.004);
        let distance = distance.max(0.0);
        2.0 * distance / (settle_s + (settle_s * settle_s + 4.0 * distance / acceleration).sqrt())
    }

    /// Acceleration a that decays to zero within a change of speed v: v = a²/2J + a·T.
    fn decaying(&self, room: f64, step_s: f64) -> f64 {
        let jerk = JOINT_JERK_RAD_S3 * self.unit();
        let room = room.max(0.0);
        2.0 * room / (step_s + (step_s * step_s + 2.0 * room / jerk).sqrt())
    }

    fn advance(&mut self, request: f64, step_s: f64) {
        let limits = self.limits;
        let within = |q: f64| q.max(limits.lower).min(limits.upper);
        let top = limits.velocity_max;
        let (now, before) = (within(request), within(self.requested));
        let moving = ((now - before) / step_s).max(-top).min(top);
        let lag = now - moving * step_s - self.position;
        let catch_up = self.braking_speed(lag.abs(), step_s) * lag.signum();
        let target = (moving + catch_up)
            .max(-self.braking_speed(self.position - limits.lower, step_s))
            .min(self.braking_speed(limits.upper - self.position, step_s));
        let change = target - self.velocity;
        let at_once = change.abs() <= 1e-6 * self.unit();
        let within_s = if at_once { step_s } else { step_s.max(0.001) };
        let build_up = JOINT_JERK_RAD_S3 * self.unit() * step_s;
        let most = JOINT_ACCELERATION_RAD_S2 * self.unit();
        self.acceleration = (change / within_s)
            .max(self.acceleration - build_up)
            .min(self.acceleration + build_up)
            .max(-most)
            .min(most)
            .max(-self.decaying(top + self.velocity, step_s))
            .min(self.decaying(top - self.velocity, step_s));
        self.velocity += self.acceleration * step_s;
        self.position = within(self.position + self.velocity * step_s);
        self.requested = request;
    }
}

/// Speed factors of the requests, of which some are beyond the top speed, for some ticks.
fn any_legs() -> impl Strategy<Value = Vec<(Vec<f64>, usize, Mode)>> {
    let factors = prop::collection::vec(prop_oneof![3 => -1.0..1.0, 1 => -5.0..5.0], 22);
    let mode = prop_oneof![5 => Just(Mode::RUN), 1 => Just(Mode::HOLD)];
    prop::collection::vec((factors, 1_usize..150, mode), 1..12)
}

proptest! {
    #![proptest_config(crate::support::cases(60))]

    #[test]
    fn motion_equals_the_reference_model(
        legs in any_legs(), sliding in any::<bool>(),
        rate_hz in prop::sample::select(vec![100.0, 250.0, 1000.0, 4000.0]),
    ) {
        let robot = if sliding { test_bench() } else { robot() };
        let mut rig = GateBench::of(robot);
        rig.step_s = 1.0 / rate_hz;
        let mut joints = Reference::all(robot, rig.gate.position());
        for (factors, ticks, mode) in legs {
            for _ in 0..ticks {
                let wanted = RobotVector::from_fn(joints.len(), |i| {
                    joints[i].requested + factors[i] * joints[i].limits.velocity_max * rig.step_s
                });
                let command = *rig.pass(mode, &wanted).command();
                let jumps = joints.iter().zip(wanted.iter()).any(|(joint, request)| {
                    let (step, allowed) = joint.jump(*request, 1.0 / rate_hz);
                    step > allowed
                });
                let refused = mode == Mode::RUN && jumps;
                prop_assert_eq!(rig.gate.refusal().cause() == Cause::COMMAND_STEP, refused);
                for (i, joint) in joints.iter_mut().enumerate() {
                    let stays = refused || mode != Mode::RUN;
                    if stays {
                        joint.requested = joint.position;
                    }
                    joint.advance(if stays { joint.position } else { wanted[i] }, 1.0 / rate_hz);
                    let (q, v) = (command.position[i], command.velocity[i]);
                    prop_assert!((q - joint.position).abs() < 1e-9, "{q} of {}", joint.position);
                    prop_assert!((v - joint.velocity).abs() < 1e-6, "{v} of {}", joint.velocity);
                    // Rounding errors do not add up.
                    (joint.position, joint.velocity) = (q, v);
                }
            }
        }
    }
}

/// A stream of small steps is refused once it is too far ahead of the joint.
#[test]
fn request_far_ahead_of_the_joint_is_refused() {
    for (robot, joint) in [(robot(), 6), (test_bench(), 0)] {
        let mut rig = GateBench::of(robot);
        let mut joints = Reference::all(robot, rig.gate.position());
        let mut wanted = home_of(robot);
        let refused_at = (0..500).find(|_| {
            wanted[joint] += 3.0 * joints[joint].limits.velocity_max * rig.step_s;
            let (lag, allowed) = joints[joint].jump(wanted[joint], rig.step_s);
            rig.pass(Mode::RUN, &wanted);
            joints[joint].position = rig.gate.position()[joint];
            joints[joint].requested = wanted[joint];
            let Reason::CommandStep { step, limit, .. } = rig.gate.refusal() else {
                assert!(lag <= allowed, "{lag} of {allowed}");
                return false;
            };
            assert!(lag > allowed, "{lag} of {allowed}");
            assert!((step - lag).abs() < 1e-12 && (limit - allowed).abs() < 1e-12);
            true
        });
        assert!(refused_at.is_some_and(|tick| tick > 10), "{refused_at:?}");
    }
}

/// Gate at zero, where differences of positions are exact.
fn at_zero() -> (GateBench, RobotVector) {
    let (mut rig, zero) = (GateBench::new(), RobotVector::repeat(22, 0.0));
    rig.gate.synchronise(&zero);
    assert_eq!(rig.gate.position()[11], 0.0, "within the limits");
    let at = *rig.gate.position();
    (rig, at)
}

#[test]
fn largest_permitted_step_is_accepted() {
    let allowed = STEP_FACTOR * robot().joint(11).unwrap().velocity_max * 1e-3;
    for (step, cause) in [
        (allowed, Cause::NONE),
        (-allowed, Cause::NONE),
        (allowed.next_up(), Cause::COMMAND_STEP),
    ] {
        let (mut rig, mut wanted) = at_zero();
        wanted[11] = step;
        rig.pass(Mode::RUN, &wanted);
        assert_eq!(rig.gate.refusal().cause(), cause, "{step}");
    }
}

#[test]
fn largest_permitted_following_error_is_accepted() {
    for (error_rad, cause) in [
        (0.125, Cause::NONE),
        (0.125_f64.next_up(), Cause::FOLLOWING_ERROR),
    ] {
        let (mut rig, at) = at_zero();
        rig.settings.following_floor_rad = 0.125;
        let mut measured = at;
        measured[11] = error_rad;
        rig.measured = Some(measured);
        for _ in 0..20 {
            rig.pass(Mode::RUN, &at);
        }
        assert_eq!(rig.gate.refusal().cause(), cause, "{error_rad} rad");
    }
}

/// A sliding joint may be off by a tenth of the number for a turning one, in metres.
#[test]
fn following_error_of_a_sliding_joint_is_in_metres() {
    for (error_m, cause) in [(0.0079, Cause::NONE), (0.0081, Cause::FOLLOWING_ERROR)] {
        let mut rig = GateBench::of(test_bench());
        let mut measured = home_of(test_bench());
        measured[0] += error_m;
        rig.measured = Some(measured);
        for _ in 0..20 {
            rig.pass(Mode::RUN, &home_of(test_bench()));
        }
        assert_eq!(rig.gate.refusal().cause(), cause, "{error_m} m");
    }
}

/// Conversion to radians and back would change some positions by a rounding error.
#[test]
fn sliding_joint_at_rest_keeps_its_position_bit_for_bit() {
    for millimetres in 0..150_u32 {
        let mut rig = GateBench::of(test_bench());
        let mut at = home_of(test_bench());
        at[0] = f64::from(millimetres) * 1e-3;
        rig.gate.synchronise(&at);
        for mode in [Mode::RUN, Mode::HOLD] {
            let safe = rig.pass(mode, &at);
            assert_eq!(safe.command().position[..2], at[..], "{mode}");
            assert_eq!(safe.command().velocity[..2], [0.0; 2], "{mode}");
        }
    }
}

/// Gate whose joint 6 moves, with the last request.
fn moving() -> (GateBench, RobotVector) {
    let (mut rig, mut wanted) = (GateBench::new(), home());
    for _ in 0..50 {
        wanted[6] += 5e-4;
        rig.pass(Mode::RUN, &wanted);
    }
    (rig, wanted)
}

#[test]
fn halted_gate_continues_from_rest() {
    let (mut rig, wanted) = moving();
    assert!(!rig.gate.is_at_rest());
    let at = *rig.gate.position();
    rig.gate.halt();
    assert!(rig.gate.is_at_rest());
    assert_eq!(*rig.gate.position(), at);
    let first = rig.pass(Mode::RUN, &wanted).command().velocity[6].abs();
    assert!(
        first <= JOINT_JERK_RAD_S3 * rig.step_s * rig.step_s,
        "{first} rad/s"
    );
}

#[test]
fn synchronised_gate_starts_at_rest_at_the_measured_position() {
    let (mut rig, _) = moving();
    rig.gate.synchronise(&home());
    assert!(rig.gate.is_at_rest() && rig.gate.is_synchronised());
    assert_eq!(
        (*rig.gate.position(), *rig.gate.requested()),
        (home(), home())
    );
    assert_eq!(positions(&rig.pass(Mode::RUN, &home())), home());
    rig.gate.disarm();
    assert!(!rig.gate.is_synchronised());
    assert_eq!(rig.pass(Mode::RUN, &home()).command().joint_count, 0);
}
