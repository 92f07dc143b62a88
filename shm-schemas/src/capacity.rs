//! Capacities of the payloads. A changed number changes a layout and needs a new type version.

/// Hands on one bus: two in the paper (Fig. 2).
pub const HANDS: usize = 2;
/// Fingertips of one hand: two in the paper; four covers common grippers and hands.
pub const FINGERS: usize = 4;
/// Three-axis elements of one fingertip: 41 on the paper's dome, up to 24 on a uSkin pad; 64 fills
/// one mask word.
pub const ELEMENTS: usize = 64;
/// Joints of one robot: 22 in the paper.
pub const JOINTS: usize = 32;
/// Agents of one swarm on the bus.
pub const AGENTS: usize = 1024;
/// Agents per field (paper Fig. 13).
pub const TEAM: usize = 4;
/// Walls per field, and also posts per field.
pub const OBSTACLES: usize = 16;
/// Goals per evaluation of a behaviour table (paper III.b.3).
pub const GOALS: usize = 8;
/// Separately timed stages of a tick, see [`crate::TickReport::stage_ns`].
pub const STAGES: usize = 8;
/// Tunable controller parameters; about half are used.
pub const SETTINGS: usize = 96;
/// Steps of one hand's task; the longest built-in task has 18.
pub const STEPS: usize = 32;
/// Sensor bits of a behaviour table: five in the paper.
pub const SENSOR_BITS: usize = 6;
/// Levels of one actuator of a behaviour table: two bits in the paper.
pub const LEVELS: usize = 4;
/// 64-bit words for the rows of a behaviour table, four bits per row.
pub const TABLE_WORDS: usize = 4;
