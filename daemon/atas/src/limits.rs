//! Fixed constants, with unit, source and the effect of extreme values.

/// Longest step of the perception filters, s; a longer one would discard their state.
pub const FILTER_STEP_MAX_S: f64 = 0.05;
/// Lowest and highest tested tick rate, Hz.
pub const TICK_RATE_HZ: (u32, u32) = (100, 10_000);

/// Joint acceleration limit of the gate, rad/s². Design choice: ten times what the tasks use.
pub const JOINT_ACCELERATION_RAD_S2: f64 = 60.0;
/// Joint jerk limit of the gate, rad/s³. Design choice: the largest acceleration decays in 4 ms.
pub const JOINT_JERK_RAD_S3: f64 = 30_000.0;
/// Largest position step of one command, in multiples of top speed × tick period. Design choice;
/// below 1 the gate would refuse commands that it could limit.
pub const STEP_FACTOR: f64 = 8.0;
/// Largest joint motion between two feedback samples, in multiples of top speed × time (design
/// choice).
pub const FEEDBACK_JUMP_FACTOR: f64 = 5.0;
/// Largest measured excess over the joint limits, rad. Design choice: covers sag and encoder noise
/// at the end stop.
pub const FEEDBACK_MARGIN_RAD: f64 = 0.05;

/// Time in which a closing speed rises from rest, s. Design choice: keeps finger jerk low.
pub const CLOSING_SPEED_UP_S: f64 = 0.02;
/// Largest increase of a closing speed of 2 mm/s and less, m/s²: as follows from that time.
pub const CLOSING_SPEED_UP_M_S2: f64 = 0.1;
/// Largest decrease and increase of a closing speed, m/s². Design choice: Module 3 stops 2 mm/s
/// within 2 ms.
pub const CLOSING_SLOW_DOWN_M_S2: f64 = 1.0;
/// Acceleration of lowering, m/s². Design choice: 10 mm/s within 0.1 s; changes the load by 1 %.
pub const LOWERING_ACCELERATION_M_S2: f64 = 0.1;
/// Largest change of the hand's speed factor, 1/s. Design choice: full range within 20 ms.
pub const CARRY_SCALE_PER_S: f64 = 50.0;

/// Time constant of the force for the compliance correction, s (robot design: 5 ms).
pub const COMPLIANCE_FILTER_S: f64 = 0.005;
/// Largest compliance correction, m. Design choice: four times the bending at 8 N; bounds the
/// effect of a wrong force.
pub const COMPLIANCE_MAX_M: f64 = 0.001;

/// Fault-free time after which HOLD ends, s (fault catalogue F20: at most 50 ticks of 1 ms).
pub const REARM_S: f64 = 0.02;
/// Shortest fault-free time after which a HOLD for late data ends, s. Design choice: as long as the
/// tolerated age; a mode changes at most a hundred times per second.
pub const REARM_LATE_S: f64 = 0.005;
/// Tick periods without a tick that never count as a stall. Design choice: slow ticks may miss one.
pub const STALL_PERIODS: f64 = 2.5;
/// Largest offset of a gripping servo's command, rad; more means that it does not track. Design
/// choice: a finger bends by 0.02 rad at the grip ceiling of 15 N.
pub const PRELOAD_MAX_RAD: f64 = 0.03;
/// Largest frame gap of one writer; more means another writer. Design choice: ten seconds at 1 kHz.
pub const FRAME_GAP_MAX: u64 = 10_000;
/// Decay time constant of a silent element's contribution, s. Design choice: a load that vanishes
/// faster counts as a drop.
pub const MASKED_DECAY_S: f64 = 1.0;
/// Time constant of zero tracking, s. Design choice: a fraction of the shortest free motion, long
/// against sensor noise.
pub const ZERO_TRACKING_S: f64 = 0.3;
/// Silence of a writer after which another may take over, ns. Design choice: 20 frames at 1 kHz.
pub const WRITER_SILENT_NS: u64 = 20_000_000;

/// Standard gravity, m/s².
pub(crate) const GRAVITY_M_S2: f64 = 9.81;
/// Largest accepted offset of an object from its given position, m. Design choice: the tolerated
/// placement error on both axes, plus a margin.
pub const DISPLACED_MAX_M: f64 = 0.009;
/// Largest accepted yaw error of an object's faces, rad. Design choice: 25°; a fingertip senses
/// within a cone of 33°.
pub const YAW_ERROR_MAX_RAD: f64 = 0.44;

/// Weakest patch with a computed contact normal, N; below it the fingertip axis is used (prototype:
/// 0.1 N).
pub const PATCH_FLOOR_N: f64 = 0.1;
/// Weakest element in the contact normal, N (prototype: 10 mN, three times the noise).
pub const NORMAL_FLOOR_N: f64 = 0.01;
/// Weakest tangential force for a friction utilisation, N (prototype: 40 mN).
pub const TANGENTIAL_FLOOR_N: f64 = 0.04;
/// Smallest divisor of F_t, N.
pub(crate) const NORMAL_MIN_N: f64 = 0.01;
/// Largest friction ratio of an element (prototype: 1.2; more is noise).
pub const FRICTION_CLIP: f64 = 1.2;
/// Smallest friction estimate as a divisor (prototype: 0.05).
pub const FRICTION_FLOOR: f64 = 0.05;
/// Time constant of the friction estimate during gross slip, s (prototype: 2 % per 1 ms).
pub const FRICTION_RELAX_S: f64 = 0.05;
/// Largest number of samples in the slip window; longer windows are decimated.
pub const INCREMENT_SAMPLES: usize = 100;
/// Build-up time of the gain towards the preferred posture, s. Design choice: a 2° offset starts at
/// about 3 rad/s², well below the gate's limit.
pub const SECONDARY_BUILD_UP_S: f64 = 0.5;
/// Step for which that gain is tuned, s; makes it independent of the tick rate.
pub const SECONDARY_STEP_S: f64 = 1e-3;
/// Largest number of such steps per tick. Design choice: half of the way per tick at 100 Hz; more
/// would overshoot.
pub const SECONDARY_STEPS_MAX: f64 = 10.0;
