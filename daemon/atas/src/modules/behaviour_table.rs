//! Behaviour table (paper section III): "an agent refers to the current values of Table 1 in every
//! set period to decide its behavior". Here the agent is a hand with tactile sensors.
//!
//! The sensor bits of the task's table, computed in every tick, select the row that sets the
//! closing and path speed. A table cannot refuse an object; moving back for more than
//! [`BACK_MAX_S`] in total does. Without a table the module proposes nothing.

use super::force_limit::exceeds_f2;
use super::slip::{exceeds_utilisation, is_loading, is_turning, slips_grossly};
use super::{Context, Module, Proposal, Roles, Verdict};
use crate::filter::Dwell;
use crate::perception::{ContactPercept, Percept};
use robot_model::PerSide;
use shm_schemas::{ModuleId, SensorBit};

/// Total time of backward motion that refuses the object, s (design choice: longer than several
/// slip reactions; shorter refuses objects that slip briefly).
const BACK_MAX_S: f64 = 0.25;
/// Carried distance for [`SensorBit::LIFTED`], m (design choice: more than an object slips in a
/// held grasp).
const LIFTED_M: f64 = 0.003;
/// Duration of low utilisation for [`SensorBit::FRICTION_MARGIN`], s (design choice: one window of
/// dF_t).
const LOW_UTILISATION_S: f64 = 0.1;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct BehaviourTable {
    /// Per side, with hysteresis: excessive utilisation, and turning.
    slipping: PerSide<bool>,
    turning: PerSide<bool>,
    /// Remaining time of [`SensorBit::SLIPPING`], s.
    latch_s: f64,
    above_f2: bool,
    /// Duration of low utilisation on every side.
    low_utilisation: Dwell,
    back_s: f64,
}

impl Module for BehaviourTable {
    const ID: ModuleId = ModuleId::BEHAVIOUR_TABLE;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let Some(table) = context.table else {
            return Proposal::default();
        };
        self.update_bits(percept, context);
        let row = table.bits().enumerate().fold(0, |row, (index, bit)| {
            row | usize::from(self.is_set(bit, percept, context)) << index
        });
        let action = table.action(row);
        if action.hand < 0.0 {
            self.back_s += context.step_s;
        }
        let (_, strongest_n) = percept.normal_range_n();
        let thresholds = &context.object.thresholds;
        Proposal {
            active: action.fingers_m_s != 0.0 || action.hand < 1.0,
            closing_m_s: PerSide::repeat(action.fingers_m_s),
            carry_ceiling: action.hand,
            verdict: if self.back_s > BACK_MAX_S {
                Verdict::Refuse(thresholds.refusal(strongest_n, Self::ID))
            } else {
                Verdict::None
            },
            ..Proposal::default()
        }
    }
}

impl BehaviourTable {
    /// Updates the sensor bits that have state.
    fn update_bits(&mut self, percept: &Percept, context: &Context<'_>) {
        let settings = &context.settings.grasp;
        let (_, strongest_n) = percept.normal_range_n();
        self.above_f2 = exceeds_f2(strongest_n, self.above_f2, context.object.thresholds.f2_n);
        let mut slips = false;
        let fingers = percept.sides.iter();
        for ((finger, slipping), turning) in fingers.zip(&mut self.slipping).zip(&mut self.turning)
        {
            *slipping = exceeds_utilisation(finger, *slipping, context);
            *turning = is_turning(finger, *turning, context);
            slips |= *slipping
                || *turning
                || slips_grossly(finger, context)
                || is_loading(finger, context);
        }
        self.latch_s = if slips {
            settings.slip_latch_s
        } else {
            self.latch_s - context.step_s
        };
        let spare = |finger: &ContactPercept| {
            finger.utilisation > 0.0
                && finger.utilisation < settings.relax_below
                && finger.gross_slip_s == 0.0
        };
        let spares = percept.sides.iter().all(spare);
        self.low_utilisation
            .update(spares && !slips, context.step_s);
    }

    fn is_set(&self, bit: SensorBit, percept: &Percept, context: &Context<'_>) -> bool {
        let (weakest_n, _) = percept.normal_range_n();
        match bit {
            SensorBit::TOUCHING => percept.sides.iter().all(|f| f.in_contact),
            SensorBit::ABOVE_F1 => weakest_n > context.object.thresholds.f1_n,
            SensorBit::SLIPPING => self.latch_s > 0.0,
            SensorBit::ABOVE_F2 => self.above_f2,
            SensorBit::LIFTED => context.object.carried_m > LIFTED_M,
            SensorBit::FRICTION_MARGIN => self.low_utilisation.seconds() > LOW_UTILISATION_S,
            _ => false,
        }
    }
}
