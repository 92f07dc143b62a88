//! Numbers that nobody tunes: each with its unit, its source, and what breaks at the extremes.

/// Longest step the perception filters take, s. After a pause a longer step would throw away the whole filter state.
pub const FILTER_STEP_MAX_S: f64 = 0.05;
/// Slowest and fastest tick rate, Hz: windows and filters are in seconds, the bounds are what was tried.
pub const TICK_RATE_HZ: (u32, u32) = (100, 10_000);

/// Acceleration of every joint that the gate allows, rad/s² (ours: ten times what the tasks use).
pub const JOINT_ACCELERATION_RAD_S2: f64 = 60.0;
/// Jerk of every joint that the gate allows, rad/s³ (ours: a full stop from the largest acceleration takes 4 ms).
pub const JOINT_JERK_RAD_S3: f64 = 30_000.0;
/// Position step of one command, as a multiple of what the joint's top speed allows in one tick, above which the
/// command counts as a jump and is refused (ours; below 1 the gate would refuse what it could have limited).
pub const STEP_FACTOR: f64 = 8.0;
/// Joint feedback that moved faster than this multiple of the top speed since the last one is a jump (ours).
pub const FEEDBACK_JUMP_FACTOR: f64 = 5.0;
/// How far outside its limits a joint may be measured, rad (ours: sag and encoder noise at the stop; beyond it the
/// reading is wrong).
pub const FEEDBACK_MARGIN_RAD: f64 = 0.05;

/// How fast the closing speed of a finger may grow, m/s² (ours: 2 mm/s within 20 ms keeps finger jerk low).
pub const CLOSING_SPEED_UP_M_S2: f64 = 0.1;
/// How fast it may fall, m/s² (ours: Module 3 stops 2 mm/s within 2 ms).
pub const CLOSING_SLOW_DOWN_M_S2: f64 = 1.0;
/// How fast the speed of lowering builds up, m/s² (ours: 10 mm/s within 0.1 s; the step it makes in the load is 1 %).
pub const LOWERING_ACCELERATION_M_S2: f64 = 0.1;
/// How fast the slip gate may change the speed of the hand, 1/s (ours: full range within 20 ms).
pub const CARRY_SCALE_PER_S: f64 = 50.0;

/// Time constant of the force that feeds the compliance correction, s (robot design: 5 ms).
pub const COMPLIANCE_FILTER_S: f64 = 0.005;
/// Largest compliance correction, m (ours: four times what 8 N bends, a broken force reading must not move the hand).
pub const COMPLIANCE_MAX_M: f64 = 0.001;

/// Time without doubt after which HOLD ends by itself, s (fault catalogue F20: at most 50 ticks of 1 ms).
pub const REARM_S: f64 = 0.02;
/// Tick periods without a tick that never count as a stall, so that slow ticks may miss one (ours).
pub const STALL_PERIODS: f64 = 2.5;
/// Farthest that a servo which grips is commanded beyond where it is, rad (ours: a finger at the grip ceiling of 15 N bends by
/// 0.02). What is farther off does not follow its command.
pub const PRELOAD_MAX_RAD: f64 = 0.03;
/// Frames that may be lost between two before the second counts as another writer's (ours: ten seconds of a 1 kHz sensor).
pub const FRAMES_AHEAD_MAX: u64 = 10_000;
/// Time constant with which an element that reports nothing is forgotten, s (ours: what an object presses with changes within it; a load
/// that vanishes faster is taken for a fall).
pub const MASKED_FADE_S: f64 = 1.0;
/// Time after which a second writer may take over from a silent one, ns (ours: 20 frames of a 1 kHz sensor).
pub const WRITER_SILENT_NS: u64 = 20_000_000;

/// Farthest from where it was told that an object is believed to stand when the fingertips feel it there, m (ours: what a place may
/// be wrong by on both axes, and a little more).
pub const DISPLACED_MAX_M: f64 = 0.009;
/// Farthest that its faces are believed to be turned, rad (ours: 25°; a dome feels within a cone of 33°).
pub const TURNED_MAX_RAD: f64 = 0.44;

/// Weakest patch for which a contact normal is computed, N; below it the dome axis stands in (prototype: 0.1 N).
pub const PATCH_FLOOR_N: f64 = 0.1;
/// Weakest element that takes part in the contact normal, N (prototype: 10 mN, three times the noise).
pub const NORMAL_FLOOR_N: f64 = 0.01;
/// Weakest tangential force for which a friction utilisation is meaningful, N (prototype: 40 mN).
pub const TANGENTIAL_FLOOR_N: f64 = 0.04;
/// Smallest normal force that F_t is divided by, N.
pub(crate) const NORMAL_MIN_N: f64 = 0.01;
/// Largest friction ratio an element may report (prototype: 1.2; higher values are noise on weak elements).
pub const FRICTION_CLIP: f64 = 1.2;
/// Smallest friction estimate that is divided by (prototype: 0.05).
pub const FRICTION_FLOOR: f64 = 0.05;
/// Time constant with which the friction estimate follows F_t/F_n during gross slip, s (prototype: 2 % per 1 ms).
pub const FRICTION_RELAX_S: f64 = 0.05;
/// Longest slip window in samples; longer windows are thinned out.
pub const INCREMENT_SAMPLES: usize = 100;
/// Time in which the pull towards the preferred posture builds up after anchoring, s (ours: 2° off then start at about
/// 3 rad/s², well below what the gate allows).
pub const SECONDARY_BUILD_UP_S: f64 = 0.5;
/// Step for which that pull is tuned, s: at another tick rate it takes the same time, not the same number of ticks.
pub const SECONDARY_STEP_S: f64 = 1e-3;
/// Most of these steps that one tick makes up for (ours: half of the way in one tick of 100 Hz; more would overshoot).
pub const SECONDARY_STEPS_MAX: f64 = 10.0;
