//! Hand-written tables: the paper's modules as rows, complete and with rules removed.

use atas_core::tasks::BehaviourTable;
use shm_schemas::SensorBit;

use super::course::{BITS, FINGERS_M_S, HAND_SPEED_FACTORS};

pub(super) const HOLD: usize = 0;
pub(super) const OPEN: usize = 1;
pub(super) const CLOSE: usize = 2;
pub(super) const STAND: usize = 0;
pub(super) const BACK: usize = 1;
pub(super) const SLOWLY: usize = 2;
pub(super) const FULL: usize = 3;

/// Rules of a hand-written table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Rules {
    /// Module 1: close until F_n > F_1 before the lift.
    pub first_touch: bool,
    /// Module 2: close while slipping, and move slowly.
    pub slip: bool,
    /// Module 3: never close above F_2.
    pub force_limit: bool,
    /// Refuse an object that slips above F_2 (not in the paper).
    pub refuse: bool,
    /// Open if friction is in excess (grip relaxation, not in the paper).
    pub relax: bool,
}

impl Rules {
    /// The paper's rules, with refusal.
    pub const PAPER: Self = Self {
        first_touch: true,
        slip: true,
        force_limit: true,
        refuse: true,
        relax: false,
    };

    /// Returns every combination of rules.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let has = |choice: usize, rule: usize| choice >> rule & 1 == 1;
        let rules = |choice: usize| Self {
            first_touch: !has(choice, 0),
            slip: !has(choice, 1),
            force_limit: !has(choice, 2),
            refuse: !has(choice, 3),
            relax: has(choice, 4),
        };
        (0..32).map(rules).collect()
    }

    /// Returns the name: the list of rules.
    #[must_use]
    pub fn name(&self) -> String {
        let pieces = [
            (self.first_touch, "module 1"),
            (self.slip, "module 2"),
            (self.force_limit, "module 3"),
            (self.refuse, "refusing"),
            (self.relax, "giving back"),
        ];
        let has = pieces.iter().filter(|(has, _)| *has);
        let names: Vec<&str> = has.map(|(_, name)| *name).collect();
        match names.is_empty() {
            true => "nothing".to_owned(),
            false => names.join(", "),
        }
    }

    /// Returns the table of these rules.
    #[must_use]
    pub fn table(&self) -> BehaviourTable {
        let rows: Vec<_> = (0..1 << BITS.len()).map(|row| self.row(row)).collect();
        BehaviourTable::validated(&BITS, &FINGERS_M_S, &HAND_SPEED_FACTORS, rows.into_iter())
            .expect("the levels of the course")
    }

    fn row(&self, row: usize) -> [usize; 2] {
        let reports = |bit: SensorBit| is_set(row, bit);
        let full = reports(SensorBit::ABOVE_F2) && self.force_limit;
        let slips = reports(SensorBit::SLIPPING);
        let weak = self.first_touch && !reports(SensorBit::ABOVE_F1);
        if weak || !reports(SensorBit::TOUCHING) {
            [CLOSE, STAND]
        } else if slips && reports(SensorBit::ABOVE_F2) && self.refuse {
            [HOLD, BACK]
        } else if slips && self.slip {
            [if full { HOLD } else { CLOSE }, SLOWLY]
        } else if reports(SensorBit::FRICTION_MARGIN) && self.relax {
            [OPEN, FULL]
        } else {
            [HOLD, FULL]
        }
    }
}

pub(super) fn is_set(row: usize, bit: SensorBit) -> bool {
    let place = BITS.iter().position(|known| *known == bit);
    place.is_some_and(|place| row >> place & 1 == 1)
}
