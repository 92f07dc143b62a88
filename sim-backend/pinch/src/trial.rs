//! Inputs and outcomes of trials.

/// Object to grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Mass, kg.
    pub mass_kg: f32,
    /// Static friction at a fingertip.
    pub friction: f32,
    /// Stiffness at one fingertip, N/m; 1e6 if rigid.
    pub stiffness_n_m: f32,
    /// Crushing normal force of one finger, N; infinite for none.
    pub crush_n: f32,
}

/// Sensor bit, as in `shm_schemas::SensorBit`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bit {
    /// Contact.
    Touching,
    /// Normal force above F_1.
    AboveF1,
    /// Slip or high friction utilisation.
    Slipping,
    /// Normal force above F_2.
    AboveF2,
    /// Lifted by more than 3 mm.
    Lifted,
    /// Low friction utilisation for 100 ms.
    Spare,
}

/// Meaning of bits and levels for all tables of a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface<'a> {
    /// Sensor bits, at most six; the first is the lowest bit of the row.
    pub bits: &'a [Bit],
    /// Closing speed by level, m/s; negative opens.
    pub fingers_m_s: [f32; 4],
    /// Factor on the hand's path speed by level, −1 to 1.
    pub hand: [f32; 4],
    /// Runs Module 3 beside the table, as robots require.
    pub force_limit: bool,
    /// Time limit of a trial.
    pub time_limit: TimeLimit,
}

/// Four bits per row, row 0 lowest: finger level + 4 · hand level.
pub type Rows = [u64; 4];

/// One grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Object to grasp.
    pub object: Object,
    /// Behaviour table.
    pub rows: Rows,
    /// Seed of noise and tremble.
    pub seed: u32,
}

/// End of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The time limit expired.
    TimedOut,
    /// The hand stayed at the end of its path for 1 s.
    Arrived,
    /// The table moved the hand back too long.
    Refused,
    /// The object was crushed.
    Crushed,
    /// Contact was lost after the probe.
    Lost,
}

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// End condition.
    pub end: End,
    /// Height of the object on arrival and at the end, m.
    pub raised_m: [f32; 2],
    /// Slip in the fingers at the same instants, m.
    pub slip_m: [f32; 2],
    /// Final normal force of one finger, N.
    pub normal_n: f32,
    /// Largest normal force of one finger, N.
    pub max_n: f32,
    /// Duration without the probe, s.
    pub time_s: f32,
    /// Bit r: row r was read.
    pub rows_read: u64,
}

/// Lift height, m (`atas grasp`).
pub const LIFT_M: f32 = 0.04;
/// Hold time before the second evaluation, s (`atas grasp`).
pub const HOLD_S: f32 = 1.0;
/// Time limit: constant plus a multiple of the path's full-speed duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeLimit {
    /// Constant part, s.
    pub constant_s: f32,
    /// Multiple; a full-speed lift takes 4 s.
    pub path_factor: f32,
}

impl TimeLimit {
    /// Short limit for evolution.
    pub const SHORT: Self = Self {
        constant_s: 2.0,
        path_factor: 1.5,
    };
    /// Long limit for comparison: step timeout of the full simulation.
    pub const LONG: Self = Self {
        constant_s: 20.0,
        path_factor: 0.0,
    };
}

impl Object {
    /// Returns F_1 and F_2 for a stiffness, N, by the controller's default rule.
    #[must_use]
    pub fn thresholds_n(stiffness_n_m: f32) -> [f32; 2] {
        let f2_n = (0.0005 * stiffness_n_m).clamp(0.7, 8.0);
        let f1_n = (0.1 * f2_n + 0.2).clamp(0.35, 1.0);
        let most_n = 0.8 * f2_n;
        [if f1_n < most_n { f1_n } else { most_n }, f2_n]
    }

    /// Returns the force per finger that holds the object, N.
    #[must_use]
    pub fn required_n(&self) -> f32 {
        self.mass_kg * GRAVITY_M_S2 / (2.0 * self.friction)
    }

    /// Returns true if the force that holds the object is below F_2 and the crush force.
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        let [_, f2_n] = Self::thresholds_n(self.stiffness_n_m);
        self.required_n() < f2_n && self.required_n() < self.crush_n
    }
}

/// Gravity, m/s².
pub(crate) const GRAVITY_M_S2: f32 = 9.81;
