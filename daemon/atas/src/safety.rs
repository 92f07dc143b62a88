//! The last gate. Nothing reaches the robot but through [`Gate::pass`]; a [`SafeCommand`] cannot be made elsewhere.
//!
//! In this order, visible in `pass`: finite, mode, grip ceiling, step, position → velocity → acceleration → jerk with
//! braking distance, following error, stamp and seal. Every check comes before any arithmetic that could swallow a NaN.
//! The gate publishes something in every mode: the command is the robot's heartbeat.

use crate::kinematics::HandCommand;
use crate::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3, STEP_FACTOR};
use crate::settings::Safety as Settings;
use crate::tick::Tick;
use crate::tick::nanoseconds;
use robot_model::{Joint, ROBOT_JOINTS_MAX, RobotModel, RobotVector, Side, VIRTUAL_FINGERS};
use shm_schemas::capacity::{HANDS, JOINTS};
use shm_schemas::{Cause, JointCommand, Mode, Reason, Stamp};

/// What kinematics wants of the whole robot.
pub type RawCommand = [HandCommand; HANDS];

/// What the gate knows of the hands' grip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Measured normal force per virtual finger, N.
    pub normal_n: [f64; VIRTUAL_FINGERS],
    /// F_2 of the object in the hand, if known, N.
    pub f2_n: Option<f64>,
}

/// A command that passed the gate.
#[derive(Clone, Copy, Debug)]
pub struct SafeCommand {
    command: JointCommand,
}

impl SafeCommand {
    /// The words to publish.
    #[must_use]
    pub fn command(&self) -> &JointCommand {
        &self.command
    }
}

/// The gate and what it last let through.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gate {
    joints: [Joint; ROBOT_JOINTS_MAX],
    limbs: [Limb; ROBOT_JOINTS_MAX],
    position_rad: RobotVector,
    velocity_rad_s: RobotVector,
    acceleration_rad_s2: RobotVector,
    /// What was wanted a tick ago and not refused, rad.
    wanted_rad: RobotVector,
    anchored: bool,
    sequence: u64,
    writer_epoch: u64,
    off_course_ticks: u32,
    finding: Reason,
}

impl Gate {
    /// A gate for this robot; it lets nothing through before [`Gate::anchor`].
    #[must_use]
    pub fn new(robot: &RobotModel, writer_epoch: u64) -> Self {
        let rest = RobotVector::zeros(robot.joint_count());
        Self {
            joints: core::array::from_fn(|joint| robot.joint(joint).copied().unwrap_or_default()),
            limbs: core::array::from_fn(|joint| Limb::of(robot, joint)),
            position_rad: rest,
            velocity_rad_s: rest,
            acceleration_rad_s2: rest,
            wanted_rad: rest,
            anchored: false,
            sequence: 0,
            writer_epoch,
            off_course_ticks: 0,
            finding: Reason::default(),
        }
    }

    /// Takes measured positions as the commanded ones, at rest: at the start, and when the robot was moved while it was
    /// not under command. What is measured beyond a limit is commanded at the limit.
    pub fn anchor(&mut self, measured_rad: &RobotVector) {
        let rest = RobotVector::zeros(self.position_rad.len());
        self.position_rad = RobotVector::from_fn(rest.len(), |i| {
            measured_rad[i].clamp(self.joints[i].lower_rad, self.joints[i].upper_rad)
        });
        self.velocity_rad_s = rest;
        self.acceleration_rad_s2 = rest;
        self.wanted_rad = self.position_rad;
        self.anchored = true;
        self.off_course_ticks = 0;
    }

    /// Lets nothing through before it is anchored again.
    pub fn release(&mut self) {
        self.anchored = false;
    }

    /// Whether the gate has a position to command.
    #[must_use]
    pub fn is_anchored(&self) -> bool {
        self.anchored
    }

    /// Commanded positions, rad.
    #[must_use]
    pub fn position_rad(&self) -> &RobotVector {
        &self.position_rad
    }

    /// What it let through in the last pass, before the limits of motion, rad: what the next wish goes on from.
    #[must_use]
    pub fn wanted_rad(&self) -> &RobotVector {
        &self.wanted_rad
    }

    /// What the gate had to refuse in the last pass, if anything. The mode machine answers with HOLD or SAFE_STOP.
    #[must_use]
    pub fn finding(&self) -> Reason {
        self.finding
    }

    /// Lets a command through, limited; or holds the last one.
    pub fn pass(
        &mut self,
        raw: &RawCommand,
        grips: &[Grip; HANDS],
        ctx: &GateContext<'_>,
    ) -> SafeCommand {
        self.finding = Reason::default();
        let mut wanted_rad = self.flatten(raw);
        if let Some(joint) = wanted_rad.iter().position(|q| !q.is_finite()) {
            self.refuse(
                Reason::of(Cause::COMMAND_NOT_FINITE).about(joint),
                &mut wanted_rad,
            );
        }
        if ctx.mode != Mode::RUN {
            wanted_rad = self.position_rad;
            self.wanted_rad = self.position_rad;
        }
        self.cap_grip(raw, grips, ctx.settings, &mut wanted_rad);
        self.refuse_jump(ctx.step_s, &mut wanted_rad);
        self.limit(&wanted_rad, ctx.step_s);
        self.wanted_rad = wanted_rad;
        self.check_following(ctx);
        SafeCommand {
            command: self.seal(ctx),
        }
    }

    /// Takes back the whole vector: no joint moves on a command that is partly wrong.
    fn refuse(&mut self, reason: Reason, wanted_rad: &mut RobotVector) {
        if !self.finding.is_some() {
            self.finding = reason;
        }
        *wanted_rad = self.position_rad;
        self.wanted_rad = self.position_rad;
    }

    /// A finger that presses harder than its ceiling may only open, and its arm may not press on: neither by its own motion
    /// nor by a correction of the finger that is no closing.
    fn cap_grip(
        &mut self,
        raw: &RawCommand,
        grips: &[Grip; HANDS],
        settings: &Settings,
        wanted_rad: &mut RobotVector,
    ) {
        for (hand, grip) in grips.iter().enumerate() {
            let ceiling_n = grip.f2_n.map_or(settings.grip_ceiling_n, |f2_n| {
                settings.grip_ceiling_n.min(f2_n * settings.grip_ceiling_f2)
            });
            for finger in 0..VIRTUAL_FINGERS {
                let normal_n = grip.normal_n[finger];
                // A force that is not a number counts as above the ceiling.
                let below = normal_n <= ceiling_n;
                if below {
                    continue;
                }
                let opens = raw[hand].closing_m_s[finger] < 0.0;
                let joints = wanted_rad.iter_mut().zip(self.position_rad.iter());
                for ((wanted_rad, held_rad), limb) in joints.zip(&self.limbs) {
                    let held = limb.arm || (limb.drives[finger] && !opens);
                    if limb.hand == hand && held && wanted_rad != held_rad {
                        *wanted_rad = *held_rad;
                        self.finding =
                            Reason::limit(Cause::GRIP_CEILING, normal_n, ceiling_n).about(finger);
                    }
                }
            }
        }
    }

    /// A step far beyond what the joint can do is a fault of the sender, not something to be smoothed over; so is a wish that
    /// runs away from the joint faster than the limits of motion explain.
    fn refuse_jump(&mut self, step_s: f64, wanted_rad: &mut RobotVector) {
        for (joint, &wanted) in wanted_rad.iter().enumerate() {
            let speed_rad_s = self.joints[joint].velocity_max_rad_s;
            let allowed_rad = STEP_FACTOR * speed_rad_s * step_s;
            let step_rad = (wanted - self.wanted_rad[joint]).abs();
            let lag_rad = (wanted - self.position_rad[joint]).abs() - self.lag_max_rad(joint);
            let step_rad = if lag_rad > step_rad {
                lag_rad
            } else {
                step_rad
            };
            if step_rad > allowed_rad {
                let reason = Reason::limit(Cause::COMMAND_STEP, step_rad, allowed_rad).about(joint);
                return self.refuse(reason, wanted_rad);
            }
        }
    }

    /// How far a joint falls behind a wish that starts at its top speed, rad: v²/2A to take the speed up, and as much to make
    /// up for it, at half of the acceleration ([`brake_rad_s`]).
    fn lag_max_rad(&self, joint: usize) -> f64 {
        let (joint, unit) = (&self.joints[joint], self.joints[joint].radian());
        let speed_rad_s = joint.velocity_max_rad_s / unit;
        speed_rad_s * speed_rad_s / JOINT_ACCELERATION_RAD_S2 * unit
    }

    /// The wanted positions of both hands, in the robot's order.
    fn flatten(&self, raw: &RawCommand) -> RobotVector {
        let mut wanted_rad = self.position_rad;
        let hands = raw.iter().flat_map(|hand| hand.q_rad.iter());
        for (wanted_rad, q_rad) in wanted_rad.iter_mut().zip(hands) {
            *wanted_rad = *q_rad;
        }
        wanted_rad
    }

    fn limit(&mut self, wanted_rad: &RobotVector, step_s: f64) {
        for (index, &wanted_rad) in wanted_rad.iter().enumerate() {
            // What bounds acceleration and jerk is written for radians.
            let unit = self.joints[index].radian();
            let joint = in_radians(&self.joints[index]);
            let state = Motion {
                position_rad: self.position_rad[index] / unit,
                velocity_rad_s: self.velocity_rad_s[index] / unit,
                acceleration_rad_s2: self.acceleration_rad_s2[index] / unit,
            };
            let before_rad = self.wanted_rad[index] / unit;
            let next = state.towards(wanted_rad / unit, before_rad, &joint, step_s);
            self.position_rad[index] = within(&self.joints[index], next.position_rad * unit);
            self.velocity_rad_s[index] = next.velocity_rad_s * unit;
            self.acceleration_rad_s2[index] = next.acceleration_rad_s2 * unit;
        }
    }

    /// A joint that stays behind its command is blocked or dead: pushing on would only wind up force.
    fn check_following(&mut self, ctx: &GateContext<'_>) {
        let Some(measured_rad) = ctx.measured_rad.filter(|_| self.anchored) else {
            return;
        };
        let settings = ctx.settings;
        let off_course = (0..self.position_rad.len()).find_map(|joint| {
            let error_rad = (self.position_rad[joint] - measured_rad[joint]).abs();
            let allowed_rad = settings.following_floor_rad * self.joints[joint].radian()
                + settings.following_per_speed_s * self.velocity_rad_s[joint].abs();
            (error_rad > allowed_rad)
                .then(|| Reason::limit(Cause::FOLLOWING_ERROR, error_rad, allowed_rad).about(joint))
        });
        self.off_course_ticks = off_course.map_or(0, |_| self.off_course_ticks.saturating_add(1));
        let off_course_s = f64::from(self.off_course_ticks) * ctx.step_s;
        if let Some(reason) = off_course.filter(|_| off_course_s >= settings.following_s) {
            self.finding = reason;
        }
    }

    fn seal(&mut self, ctx: &GateContext<'_>) -> JointCommand {
        let stamp = Stamp {
            sequence: self.sequence,
            captured_ns: ctx.tick.now_ns,
            writer_epoch: self.writer_epoch,
        };
        self.sequence += 1;
        let mut command = JointCommand {
            stamp,
            valid_until_ns: ctx
                .tick
                .now_ns
                .saturating_add(nanoseconds(ctx.settings.valid_s)),
            tick: ctx.tick.index,
            answers_sequence: ctx.joint_sequence,
            mode: ctx.mode,
            joint_count: if self.anchored {
                self.position_rad.len() as u32
            } else {
                0
            },
            ..JointCommand::default()
        };
        const { assert!(ROBOT_JOINTS_MAX <= JOINTS) };
        if self.anchored {
            let joints = self.position_rad.len();
            command.position_rad[..joints].copy_from_slice(&self.position_rad);
            command.velocity_rad_s[..joints].copy_from_slice(&self.velocity_rad_s);
            command.grip_limit_n = ctx.grip_limit_n;
        }
        command.seal();
        command
    }
}

/// What the gate needs to know of the tick.
#[derive(Clone, Copy, Debug)]
pub struct GateContext<'a> {
    /// The tick.
    pub tick: Tick,
    /// Time since the tick before, s.
    pub step_s: f64,
    /// Mode of this tick: only RUN moves.
    pub mode: Mode,
    /// Measured positions, if believed and fresh, rad: a robot that is not heard of is no robot that does not follow.
    pub measured_rad: Option<&'a RobotVector>,
    /// Sequence of the joint state that the tick used.
    pub joint_sequence: u64,
    /// F_2 of what each hand holds, N, for the next daemon; zero for an empty hand.
    pub grip_limit_n: [f64; HANDS],
    /// Limits.
    pub settings: &'a Settings,
}

/// What a joint is of.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Limb {
    hand: usize,
    /// It is one of the arm.
    arm: bool,
    /// It moves fingertips of these sides against the palm.
    drives: [bool; VIRTUAL_FINGERS],
}

impl Limb {
    fn of(robot: &RobotModel, joint: usize) -> Self {
        let of_side = |side: &Side| robot.joint_range(*side).contains(&joint);
        let Some(side) = Side::BOTH.into_iter().find(of_side) else {
            return Self::default();
        };
        let (hand, own) = (robot.hand(side), joint - robot.joint_range(side).start);
        Self {
            hand: side.index(),
            arm: hand.arm_joints().contains(&own),
            drives: core::array::from_fn(|finger| hand.drives(own, finger)),
        }
    }
}

/// The same joint with its limits in what counts as radians for it.
fn in_radians(joint: &Joint) -> Joint {
    let unit = joint.radian();
    Joint {
        lower_rad: joint.lower_rad / unit,
        upper_rad: joint.upper_rad / unit,
        velocity_max_rad_s: joint.velocity_max_rad_s / unit,
        ..*joint
    }
}

fn within(joint: &Joint, q_rad: f64) -> f64 {
    q_rad.clamp(joint.lower_rad, joint.upper_rad)
}

/// One joint's commanded motion.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Motion {
    position_rad: f64,
    velocity_rad_s: f64,
    acceleration_rad_s2: f64,
}

impl Motion {
    /// The next motion towards `wanted_rad`, which was `wanted_before_rad` a tick ago, within every limit of the joint.
    /// Both are finite.
    ///
    /// A wanted motion within the limits is followed without lag. Where the limits made the joint fall behind, it catches
    /// up at a speed from which it can still brake, so that it does not swing about the wanted motion.
    fn towards(self, wanted_rad: f64, wanted_before_rad: f64, joint: &Joint, step_s: f64) -> Self {
        let (wanted_rad, wanted_before_rad) =
            (within(joint, wanted_rad), within(joint, wanted_before_rad));
        let speed_rad_s = joint.velocity_max_rad_s;
        let moving_rad_s =
            ((wanted_rad - wanted_before_rad) / step_s).clamp(-speed_rad_s, speed_rad_s);
        let lag_rad = wanted_rad - moving_rad_s * step_s - self.position_rad;
        let catch_up_rad_s = brake_rad_s(lag_rad.abs(), step_s).copysign(lag_rad);
        let wanted_rad_s = (moving_rad_s + catch_up_rad_s).clamp(
            -brake_rad_s(self.position_rad - joint.lower_rad, step_s),
            brake_rad_s(joint.upper_rad - self.position_rad, step_s),
        );
        let acceleration_rad_s2 = self.accelerate_rad_s2(wanted_rad_s, speed_rad_s, step_s);
        let velocity_rad_s = self.velocity_rad_s + acceleration_rad_s2 * step_s;
        Self {
            position_rad: within(joint, self.position_rad + velocity_rad_s * step_s),
            velocity_rad_s,
            acceleration_rad_s2,
        }
    }

    /// The acceleration towards a wanted speed: within its own limit, within the jerk limit, and never so high that the
    /// jerk limit could not take it back before the top speed.
    fn accelerate_rad_s2(&self, wanted_rad_s: f64, speed_rad_s: f64, step_s: f64) -> f64 {
        let (now_rad_s, now_rad_s2) = (self.velocity_rad_s, self.acceleration_rad_s2);
        let change_rad_s2 = JOINT_JERK_RAD_S3 * step_s;
        let ending_below = |room_rad_s: f64| {
            let room_rad_s = if room_rad_s > 0.0 { room_rad_s } else { 0.0 };
            let build_up_s2 = step_s * step_s + 2.0 * room_rad_s / JOINT_JERK_RAD_S3;
            JOINT_JERK_RAD_S3 * (libm::sqrt(build_up_s2) - step_s)
        };
        let news_rad_s = wanted_rad_s - now_rad_s;
        let within_s = if news_rad_s.abs() <= SPEED_STEP_RAD_S {
            step_s
        } else {
            step_s.max(SPEED_UP_MIN_S)
        };
        (news_rad_s / within_s)
            .clamp(now_rad_s2 - change_rad_s2, now_rad_s2 + change_rad_s2)
            .clamp(-JOINT_ACCELERATION_RAD_S2, JOINT_ACCELERATION_RAD_S2)
            .clamp(
                -ending_below(speed_rad_s + now_rad_s),
                ending_below(speed_rad_s - now_rad_s),
            )
    }
}

/// Steps of the exponential with which a joint comes to rest: fewer, and the jerk limit makes it swing.
const SETTLE_STEPS: f64 = 4.0;
/// Shortest time constant of it, s (ours: twice the time in which the jerk limit builds up the largest acceleration).
/// Shorter, and a joint at a high tick rate swings, because its acceleration cannot follow.
const SETTLE_MIN_S: f64 = 0.004;
/// Shortest time in which a joint takes up another speed, s (ours: a quarter of the above, as at 1 kHz).
const SPEED_UP_MIN_S: f64 = 0.001;
/// Change of speed that is taken up at once, rad/s (ours: so small that it comes to rest instead of fading away).
const SPEED_STEP_RAD_S: f64 = 1e-6;

/// Highest speed from which the joint still stops within a distance, rad/s: the v of d = v²/A + v·T. Far away it slows
/// down at half the acceleration; the other half is kept in reserve for the time that the jerk limit needs to build it
/// up. Near the end it settles with the time constant T.
fn brake_rad_s(distance_rad: f64, step_s: f64) -> f64 {
    if distance_rad <= 0.0 {
        return 0.0;
    }
    let settle_s = (SETTLE_STEPS * step_s).max(SETTLE_MIN_S);
    let whole_s = libm::sqrt(settle_s * settle_s + 4.0 * distance_rad / JOINT_ACCELERATION_RAD_S2);
    0.5 * JOINT_ACCELERATION_RAD_S2 * (whole_s - settle_s)
}
