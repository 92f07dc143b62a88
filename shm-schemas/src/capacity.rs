//! How much fits into one payload. Changing a number changes a layout, so it changes a type version.

/// Hands on one bus: the paper's robot has two (Fig. 2).
pub const HANDS: usize = 2;
/// Fingers of one hand: the paper's hand has two; four leaves room for common grippers and hands.
pub const FINGERS: usize = 4;
/// Three-axis elements of one fingertip: the paper's dome has 41; a uSkin pad has up to 24; 64 fills one mask word.
pub const ELEMENTS: usize = 64;
/// Joints of one robot: the paper's robot has 22.
pub const JOINTS: usize = 32;
/// Agents of one swarm on the bus.
pub const AGENTS: usize = 1024;
/// Agents on one of its fields (paper Fig. 13).
pub const TEAM: usize = 4;
/// Walls, and likewise posts, inside one of its fields.
pub const OBSTACLES: usize = 16;
/// Goals of one evaluation of a behaviour table (paper III.b.3).
pub const GOALS: usize = 8;
/// Stages of the tick that are timed separately, see [`crate::TickReport::stage_ns`].
pub const STAGES: usize = 8;
/// Tunable numbers of the controller; it has about half as many.
pub const SETTINGS: usize = 96;
/// Steps of one hand's task; the longest built-in task has 18.
pub const STEPS: usize = 32;
/// Sensor bits of a behaviour table; the paper's has five.
pub const SENSOR_BITS: usize = 6;
/// Levels of one actuator of a behaviour table: the paper's two bits.
pub const LEVELS: usize = 4;
/// Words of 64 bits that a behaviour table's rows take, four bits per row.
pub const TABLE_WORDS: usize = 4;
