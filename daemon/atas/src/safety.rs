//! Safety gate: last stage before the robot. Every command passes [`Gate::pass`], the only
//! constructor of [`SafeCommand`].
//!
//! Order of checks: finite, mode, grip ceiling, step size, motion limits with braking distance,
//! following error, stamp and seal. Each runs before any arithmetic that could hide a NaN. The gate
//! publishes in every mode, as a heartbeat for the robot.

use crate::kinematics::HandCommand;
use crate::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3, STEP_FACTOR};
use crate::settings::Safety as Settings;
use crate::tick::Tick;
use crate::tick::nanoseconds;
use robot_model::{GraspSide, HandSide, Joint, PerSide, ROBOT_JOINTS_MAX, RobotModel, RobotVector};
use shm_schemas::capacity::{HANDS, JOINTS};
use shm_schemas::{JointCommand, Mode, Reason, Stamp};

/// Unchecked commands of both hands.
pub type RawCommand = [HandCommand; HANDS];

/// Grip state of one hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Measured normal force per grasp side, N.
    pub normal_n: PerSide<f64>,
    /// F_2 of the held object, if known, N.
    pub f2_n: Option<f64>,
}

/// Command that passed the gate.
#[derive(Clone, Copy, Debug)]
pub struct SafeCommand {
    command: JointCommand,
}

impl SafeCommand {
    /// Returns the command to publish.
    #[must_use]
    pub fn command(&self) -> &JointCommand {
        &self.command
    }
}

/// Safety gate.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gate {
    joints: [Joint; ROBOT_JOINTS_MAX],
    roles: [JointRole; ROBOT_JOINTS_MAX],
    position: RobotVector,
    velocity: RobotVector,
    acceleration: RobotVector,
    /// Accepted request of the previous tick, rad or m.
    requested: RobotVector,
    synchronised: bool,
    sequence: u64,
    writer_epoch: u64,
    following_error_ticks: u32,
    refusal: Reason,
}

impl Gate {
    /// Creates a gate; it passes nothing before [`Gate::synchronise`].
    #[must_use]
    pub fn new(robot: &RobotModel, writer_epoch: u64) -> Self {
        let rest = RobotVector::zeros(robot.joint_count());
        Self {
            joints: core::array::from_fn(|joint| robot.joint(joint).copied().unwrap_or_default()),
            roles: core::array::from_fn(|joint| JointRole::new(robot, joint)),
            position: rest,
            velocity: rest,
            acceleration: rest,
            requested: rest,
            synchronised: false,
            sequence: 0,
            writer_epoch,
            following_error_ticks: 0,
            refusal: Reason::None,
        }
    }

    /// Takes the measured positions, clamped to the limits, as commanded ones at rest: at the
    /// start, and after the robot moved without command.
    pub fn synchronise(&mut self, measured: &RobotVector) {
        let rest = RobotVector::zeros(self.position.len());
        self.position = RobotVector::from_fn(rest.len(), |i| {
            measured[i].clamp(self.joints[i].lower, self.joints[i].upper)
        });
        self.halt();
        self.requested = self.position;
        self.synchronised = true;
        self.following_error_ticks = 0;
    }

    /// Continues from rest at the commanded positions: the last command expired, and the robot
    /// stopped there.
    pub fn halt(&mut self) {
        let rest = RobotVector::zeros(self.position.len());
        self.velocity = rest;
        self.acceleration = rest;
    }

    /// Returns true while no commanded joint moves.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.velocity.iter().all(|&speed| speed == 0.0)
    }

    /// Passes nothing until the next [`Gate::synchronise`].
    pub fn disarm(&mut self) {
        self.synchronised = false;
    }

    /// Returns whether the gate has a position to command.
    #[must_use]
    pub fn is_synchronised(&self) -> bool {
        self.synchronised
    }

    /// Returns the commanded positions, rad or m.
    #[must_use]
    pub fn position(&self) -> &RobotVector {
        &self.position
    }

    /// Returns the last accepted request, before motion limiting, rad or m; the next one continues
    /// from it.
    #[must_use]
    pub fn requested(&self) -> &RobotVector {
        &self.requested
    }

    /// Returns the refusal of the last pass, if any; it leads to HOLD or SAFE_STOP.
    #[must_use]
    pub fn refusal(&self) -> Reason {
        self.refusal
    }

    /// Limits and passes a command, or holds the last one.
    pub fn pass(
        &mut self,
        raw: &RawCommand,
        grips: &[Grip; HANDS],
        ctx: &GateContext<'_>,
    ) -> SafeCommand {
        self.refusal = Reason::None;
        let mut request = self.flatten(raw);
        if let Some(joint) = request.iter().position(|q| !q.is_finite()) {
            self.refuse(Reason::CommandNotFinite { joint }, &mut request);
        }
        if ctx.mode != Mode::RUN {
            request = self.position;
            self.requested = self.position;
        }
        self.limit_grip(raw, grips, ctx.settings, &mut request);
        self.refuse_jump(ctx.step_s, &mut request);
        self.limit(&request, ctx.step_s);
        self.requested = request;
        self.check_following_error(ctx);
        SafeCommand {
            command: self.seal(ctx),
        }
    }

    /// Rejects the whole vector, so that no joint moves on a partly invalid command.
    fn refuse(&mut self, reason: Reason, request: &mut RobotVector) {
        if !self.refusal.is_some() {
            self.refusal = reason;
        }
        *request = self.position;
        self.requested = self.position;
    }

    /// Above its force ceiling a side may only open, and its arm must not move.
    fn limit_grip(
        &mut self,
        raw: &RawCommand,
        grips: &[Grip; HANDS],
        settings: &Settings,
        request: &mut RobotVector,
    ) {
        for (hand, grip) in grips.iter().enumerate() {
            let ceiling_n = grip.f2_n.map_or(settings.grip_ceiling_n, |f2_n| {
                settings.grip_ceiling_n.min(f2_n * settings.grip_ceiling_f2)
            });
            for side in GraspSide::BOTH {
                let normal_n = grip.normal_n[side];
                // NaN counts as above the ceiling.
                let below = normal_n <= ceiling_n;
                if below {
                    continue;
                }
                let opens = raw[hand].closing_m_s[side] < 0.0;
                let joints = request.iter_mut().zip(self.position.iter());
                for ((request, commanded), limb) in joints.zip(&self.roles) {
                    let is_held = limb.arm || (limb.drives[side] && !opens);
                    if limb.hand == hand && is_held && request != commanded {
                        *request = *commanded;
                        self.refusal = Reason::GripCeiling {
                            side: side.index(),
                            force_n: normal_n,
                            limit_n: ceiling_n,
                        };
                    }
                }
            }
        }
    }

    /// Rejects a step far beyond the joint's capability, or a request too far ahead of the joint,
    /// as a sender fault; smoothing would hide it.
    fn refuse_jump(&mut self, step_s: f64, request: &mut RobotVector) {
        for (joint, &position) in request.iter().enumerate() {
            let allowed = STEP_FACTOR * self.joints[joint].velocity_max * step_s;
            let step = (position - self.requested[joint]).abs();
            let lag = (position - self.position[joint]).abs() - self.lag_max(joint);
            let step = step.max(lag);
            if step > allowed {
                let limit = allowed;
                return self.refuse(Reason::CommandStep { joint, step, limit }, request);
            }
        }
    }

    /// Returns the largest lag behind a request that starts at top speed, rad or m: v²/2A to
    /// accelerate, v²/2A to catch up at half the acceleration ([`braking_speed_rad_s`]).
    fn lag_max(&self, joint: usize) -> f64 {
        let (joint, unit) = (&self.joints[joint], self.joints[joint].radian());
        let speed_rad_s = joint.velocity_max / unit;
        speed_rad_s * speed_rad_s / JOINT_ACCELERATION_RAD_S2 * unit
    }

    fn flatten(&self, raw: &RawCommand) -> RobotVector {
        let mut request = self.position;
        let hands = raw.iter().flat_map(|hand| hand.q.iter());
        for (request, q) in request.iter_mut().zip(hands) {
            *request = *q;
        }
        request
    }

    fn limit(&mut self, request: &RobotVector, step_s: f64) {
        for (index, &request) in request.iter().enumerate() {
            if self.rests_at(index, request) {
                continue;
            }
            // Acceleration and jerk limits are in radians.
            let unit = self.joints[index].radian();
            let joint = in_radians(&self.joints[index]);
            let state = Motion {
                position: self.position[index] / unit,
                velocity: self.velocity[index] / unit,
                acceleration: self.acceleration[index] / unit,
            };
            let before = self.requested[index] / unit;
            let next = state.step_towards(request / unit, before, &joint, step_s);
            self.position[index] = within(&self.joints[index], next.position * unit);
            self.velocity[index] = next.velocity * unit;
            self.acceleration[index] = next.acceleration * unit;
        }
    }

    /// Returns true if the joint rests at its request, and thus stays there.
    fn rests_at(&self, joint: usize, request: f64) -> bool {
        let position = self.position[joint];
        position == request
            && position == self.requested[joint]
            && position == within(&self.joints[joint], position)
            && self.velocity[joint] == 0.0
            && self.acceleration[joint] == 0.0
    }

    /// Detects a blocked or dead joint; further motion would only build up force.
    fn check_following_error(&mut self, ctx: &GateContext<'_>) {
        let Some(measured) = ctx.measured.filter(|_| self.synchronised) else {
            return;
        };
        let settings = ctx.settings;
        let off_course = (0..self.position.len()).find_map(|joint| {
            let error = (self.position[joint] - measured[joint]).abs();
            let allowed = settings.following_floor_rad * self.joints[joint].radian()
                + settings.following_per_speed_s * self.velocity[joint].abs();
            (error > allowed).then_some(Reason::FollowingError {
                joint,
                error,
                limit: allowed,
            })
        });
        self.following_error_ticks =
            off_course.map_or(0, |_| self.following_error_ticks.saturating_add(1));
        let off_course_s = f64::from(self.following_error_ticks) * ctx.step_s;
        if let Some(reason) = off_course.filter(|_| off_course_s >= settings.following_s) {
            self.refusal = reason;
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
            joint_count: if self.synchronised {
                self.position.len() as u32
            } else {
                0
            },
            ..JointCommand::default()
        };
        const { assert!(ROBOT_JOINTS_MAX <= JOINTS) };
        if self.synchronised {
            let joints = self.position.len();
            command.position[..joints].copy_from_slice(&self.position);
            command.velocity[..joints].copy_from_slice(&self.velocity);
            command.grip_limit_n = ctx.grip_limit_n;
        }
        command.seal();
        command
    }
}

/// Tick data for the gate.
#[derive(Clone, Copy, Debug)]
pub struct GateContext<'a> {
    /// Tick index and time.
    pub tick: Tick,
    /// Period, s.
    pub step_s: f64,
    /// Mode; only RUN moves.
    pub mode: Mode,
    /// Valid, fresh measured positions, rad or m; `None` skips the following-error check.
    pub measured: Option<&'a RobotVector>,
    /// Sequence number of the joint state.
    pub joint_sequence: u64,
    /// F_2 per hand, N, for a restarted daemon; zero for an empty hand.
    pub grip_limit_n: [f64; HANDS],
    /// Limits.
    pub settings: &'a Settings,
}

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct JointRole {
    hand: usize,
    arm: bool,
    /// Grasp sides whose fingertips the joint moves relative to the palm.
    drives: PerSide<bool>,
}

impl JointRole {
    fn new(robot: &RobotModel, joint: usize) -> Self {
        let of_side = |side: &HandSide| robot.joint_range(*side).contains(&joint);
        let Some(side) = HandSide::BOTH.into_iter().find(of_side) else {
            return Self::default();
        };
        let (hand, own) = (robot.hand(side), joint - robot.joint_range(side).start);
        Self {
            hand: side.index(),
            arm: hand.arm_joints().contains(&own),
            drives: PerSide::from_fn(|side| hand.drives(own, side)),
        }
    }
}

/// Converts the joint's limits to its radian equivalent ([`Joint::radian`]).
fn in_radians(joint: &Joint) -> Joint {
    let unit = joint.radian();
    Joint {
        lower: joint.lower / unit,
        upper: joint.upper / unit,
        velocity_max: joint.velocity_max / unit,
        ..*joint
    }
}

fn within(joint: &Joint, q: f64) -> f64 {
    q.clamp(joint.lower, joint.upper)
}

/// Motion of one joint: rad, rad/s and rad/s², or their equivalents ([`Joint::radian`]).
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Motion {
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl Motion {
    /// Returns the next motion towards `requested` within all joint limits. Both requests, now and
    /// a tick ago, are finite.
    ///
    /// Requests within the limits are tracked without lag. After a lag the joint catches up at a
    /// speed from which it can brake, so that it does not oscillate.
    fn step_towards(
        self,
        requested: f64,
        requested_before: f64,
        joint: &Joint,
        step_s: f64,
    ) -> Self {
        let (requested, requested_before) =
            (within(joint, requested), within(joint, requested_before));
        let speed_rad_s = joint.velocity_max;
        let moving_rad_s =
            ((requested - requested_before) / step_s).clamp(-speed_rad_s, speed_rad_s);
        let lag_rad = requested - moving_rad_s * step_s - self.position;
        let catch_up_rad_s = braking_speed_rad_s(lag_rad.abs(), step_s).copysign(lag_rad);
        let target_rad_s = (moving_rad_s + catch_up_rad_s).clamp(
            -braking_speed_rad_s(self.position - joint.lower, step_s),
            braking_speed_rad_s(joint.upper - self.position, step_s),
        );
        let acceleration = self.accelerate_rad_s2(target_rad_s, speed_rad_s, step_s);
        let velocity = self.velocity + acceleration * step_s;
        Self {
            position: within(joint, self.position + velocity * step_s),
            velocity,
            acceleration,
        }
    }

    /// Returns the acceleration towards a speed, within its limit and the jerk limit, and low
    /// enough to vanish before the top speed.
    fn accelerate_rad_s2(&self, target_rad_s: f64, speed_rad_s: f64, step_s: f64) -> f64 {
        let (now_rad_s, now_rad_s2) = (self.velocity, self.acceleration);
        let change_rad_s2 = JOINT_JERK_RAD_S3 * step_s;
        let ending_below = |room_rad_s: f64| {
            let build_up_s2 = step_s * step_s + 2.0 * room_rad_s.max(0.0) / JOINT_JERK_RAD_S3;
            JOINT_JERK_RAD_S3 * (libm::sqrt(build_up_s2) - step_s)
        };
        let difference_rad_s = target_rad_s - now_rad_s;
        let within_s = if difference_rad_s.abs() <= SPEED_CHANGE_AT_ONCE_RAD_S {
            step_s
        } else {
            step_s.max(SPEED_CHANGE_MIN_S)
        };
        (difference_rad_s / within_s)
            .clamp(now_rad_s2 - change_rad_s2, now_rad_s2 + change_rad_s2)
            .clamp(-JOINT_ACCELERATION_RAD_S2, JOINT_ACCELERATION_RAD_S2)
            .clamp(
                -ending_below(speed_rad_s + now_rad_s),
                ending_below(speed_rad_s - now_rad_s),
            )
    }
}

/// Smallest settling time constant, in steps; with fewer the jerk limit causes oscillation.
const SETTLE_STEPS: f64 = 4.0;
/// Smallest settling time constant, s. Derivation: twice the build-up time of the largest
/// acceleration under the jerk limit. Smaller values oscillate at high tick rates.
const SETTLE_MIN_S: f64 = 0.004;
/// Shortest time for a speed change, s. Design choice: a quarter of `SETTLE_MIN_S`, as at 1 kHz.
const SPEED_CHANGE_MIN_S: f64 = 0.001;
/// Speed change applied at once, rad/s. Design choice: small; ends the exponential decay.
const SPEED_CHANGE_AT_ONCE_RAD_S: f64 = 1e-6;

/// Returns the highest speed from which the joint stops within a distance, rad/s: v from d = v²/A +
/// v·T. It brakes at half the acceleration; the other half covers the jerk-limited build-up. T is
/// the settling time constant near the end.
fn braking_speed_rad_s(distance_rad: f64, step_s: f64) -> f64 {
    if distance_rad <= 0.0 {
        return 0.0;
    }
    let settle_s = (SETTLE_STEPS * step_s).max(SETTLE_MIN_S);
    let whole_s = libm::sqrt(settle_s * settle_s + 4.0 * distance_rad / JOINT_ACCELERATION_RAD_S2);
    0.5 * JOINT_ACCELERATION_RAD_S2 * (whole_s - settle_s)
}
