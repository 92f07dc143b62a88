//! What is tried, and what becomes of it.

/// What can be grasped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Mass, kg.
    pub mass_kg: f32,
    /// Static friction coefficient under a fingertip.
    pub friction: f32,
    /// Stiffness under one fingertip, N/m; a rigid one has 1e6.
    pub stiffness_n_m: f32,
    /// Normal force of one finger that crushes it, N; infinite for none.
    pub crush_n: f32,
}

/// A sensor bit of a table, as `shm_schemas::SensorBit` defines them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bit {
    /// The fingers touch.
    Touching,
    /// They press more than F_1.
    AboveF1,
    /// Friction is nearly used up, or they slip.
    Slipping,
    /// They press more than F_2.
    AboveF2,
    /// The hand has carried the object for more than 3 mm.
    Lifted,
    /// Friction has been spare for 100 ms.
    Spare,
}

/// What all tables of a call share: what their bits mean and what their levels do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface<'a> {
    /// At most six bits, the first is the lowest of the row's number.
    pub bits: &'a [Bit],
    /// Closing speed of each finger by level, m/s, negative opens.
    pub fingers_m_s: [f32; 4],
    /// Factor on the hand's speed along its path by level, −1 to 1.
    pub hand: [f32; 4],
    /// Whether Module 3 stands beside the table, as a task on a robot must have it.
    pub force_limit: bool,
    /// When time is up.
    pub patience: Patience,
}

/// A table's rows: four bits per row, row 0 lowest: level of the fingers, then level of the hand times four.
pub type Rows = [u64; 4];

/// One grasp to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// What is grasped.
    pub object: Object,
    /// Who grasps it.
    pub rows: Rows,
    /// What the sensor's noise and the hand's tremble are drawn from.
    pub seed: u32,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Time was up before the hand was at its end.
    Late,
    /// The hand came to the end of its way and stayed there for a second.
    Arrived,
    /// The table took the hand back for so long that it means refusing.
    Refused,
    /// The object was crushed.
    Crushed,
    /// The fingers came off an object that they had lifted.
    Lost,
}

/// What became of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// Height of the object over its place when the hand arrived, and at the end, m.
    pub raised_m: [f32; 2],
    /// How far the object had slid in the fingers at the same instants, m.
    pub slid_m: [f32; 2],
    /// Normal force of one finger at the end, and the most there was, N.
    pub normal_n: f32,
    /// Most normal force of one finger, N.
    pub most_n: f32,
    /// When it ended, s.
    pub time_s: f32,
    /// Bit r: row r was read.
    pub rows_read: u64,
}

/// Height that the hand lifts to, m (`atas grasp`).
pub const LIFT_M: f32 = 0.04;
/// How long it stays there: the paper's second judgement, s (`atas grasp`).
pub const HOLD_S: f32 = 1.0;
/// When time is up: after some slack and a multiple of the time that the hand's way so far takes at full speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patience {
    /// The slack, s.
    pub slack_s: f32,
    /// The multiple. A lift that is never slowed down takes 4 s.
    pub slowest: f32,
}

impl Patience {
    /// For evolution: who is slow has lost already.
    pub const SHORT: Self = Self {
        slack_s: 2.0,
        slowest: 1.5,
    };
    /// For comparison: as long as the full simulation waits for a step.
    pub const LONG: Self = Self {
        slack_s: 20.0,
        slowest: 0.0,
    };
}

impl Object {
    /// F_1 and F_2 of the paper's rule at a stiffness, N: the law of the controller with its default settings.
    #[must_use]
    pub fn thresholds_n(stiffness_n_m: f32) -> [f32; 2] {
        let f2_n = (0.0005 * stiffness_n_m).clamp(0.7, 8.0);
        let f1_n = (0.1 * f2_n + 0.2).clamp(0.35, 1.0);
        let most_n = 0.8 * f2_n;
        [if f1_n < most_n { f1_n } else { most_n }, f2_n]
    }

    /// Normal force of one finger that carries it by friction, N.
    #[must_use]
    pub fn needed_n(&self) -> f32 {
        self.mass_kg * GRAVITY_M_S2 / (2.0 * self.friction)
    }

    /// Whether the paper's rule allows it to be held: what it needs neither exceeds F_2 nor crushes it.
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        let [_, f2_n] = Self::thresholds_n(self.stiffness_n_m);
        self.needed_n() < f2_n && self.needed_n() < self.crush_n
    }
}

/// Gravity, m/s².
pub(crate) const GRAVITY_M_S2: f32 = 9.81;
