//! Test bench for one module.

use atas_core::Settings;
use atas_core::executor::HandMotion;
use atas_core::held_object::HeldObject;
use atas_core::modules::{Context, IDS, Modules, Proposal, Selection};
use atas_core::path::{Path, Speeds};
use atas_core::perception::{ContactPercept, Percept};
use atas_core::tasks::BehaviourTable;
use atas_core::teleop::TeleopTarget;
use atas_core::thresholds::{ForceLimitSource, Thresholds};
use nalgebra::Vector3;
use robot_model::{GRASP_SIDES, GraspPose, GraspSide, PerSide, Transform};
use shm_schemas::{GripOrder, ModuleId};

/// Lift of 50 mm within 5 s.
pub(crate) fn path() -> Path {
    let from = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 0.0, 0.05);
    let to = GraspPose {
        centre_m: Vector3::new(0.3, 0.0, 0.15),
        ..from
    };
    Path::gripping(
        from,
        to,
        &Speeds {
            move_m_s: 0.01,
            turn_rad_s: 1.0,
            open_m_s: 0.01,
            wrist_turn_radius_m: None,
        },
    )
}

pub(crate) struct Bench {
    pub(crate) modules: Modules,
    pub(crate) id: ModuleId,
    pub(crate) settings: Settings,
    pub(crate) path: Path,
    pub(crate) table: Option<BehaviourTable>,
    /// Estimate of the object; the bench sets thresholds and vertical load.
    pub(crate) object: HeldObject,
    pub(crate) carry_scale: f64,
    pub(crate) closing_m_s: PerSide<f64>,
    pub(crate) frame: GraspPose,
    pub(crate) lowering_m: Option<f64>,
    pub(crate) lead: Option<TeleopTarget>,
}

impl Bench {
    pub(crate) fn new(id: ModuleId) -> Self {
        Self {
            modules: Modules::default(),
            id,
            settings: Settings::default(),
            path: path(),
            table: None,
            object: HeldObject {
                all_touched: true,
                suspended: true,
                min_force_n: 0.5,
                ..HeldObject::untouched(Thresholds::for_unknown_object(&Settings::default().grasp))
            },
            carry_scale: 1.0,
            closing_m_s: PerSide::repeat(0.0),
            frame: path().pose_at(0.0),
            lowering_m: None,
            lead: None,
        }
    }

    pub(crate) fn teleoperated(id: ModuleId) -> Self {
        let bench = Self::new(id);
        let lead = TeleopTarget {
            pose: bench.frame,
            grip: GripOrder::HOLD,
        };
        Self {
            lead: Some(lead),
            ..bench
        }
    }

    /// Frames of both fingertips with radius 10 mm, rotated as the base.
    pub(crate) fn base_from_tip(&self) -> [Transform; GRASP_SIDES] {
        let (frame, axis) = (&self.frame, self.frame.closing_axis());
        let along = Vector3::new(-axis.y, axis.x, 0.0);
        GraspSide::BOTH.map(|side| {
            let outwards_m = axis * (side.outward() * (frame.half_opening_m[side] + 0.01));
            Transform {
                translation_m: frame.centre_m + outwards_m + along * frame.tangential_m[side],
                ..Transform::IDENTITY
            }
        })
    }

    /// F_1 is 0.5 N, F_2 is 4 N.
    pub(crate) fn evaluate(&mut self, percept: &Percept) -> Proposal {
        let base_from_tip = self.base_from_tip();
        let motion = HandMotion {
            carry_scale: self.carry_scale,
            closing_m_s: self.closing_m_s,
            pose: &self.frame,
            closing_axis: self.frame.closing_axis(),
            turns_by_wrist: false,
            base_from_tip: &base_from_tip,
            side_m: base_from_tip.map(|tip| tip.translation_m).into(),
            compression: robot_model::Skin::DOME_41.compression,
            tactile_over_torque: 1.0,
            torque_over_tactile: 1.0,
        };
        let thresholds = Thresholds {
            f1_n: 0.5,
            f2_n: 4.0,
            source: if self.settings.grasp.f2_max_n > 4.0 {
                ForceLimitSource::Object
            } else {
                ForceLimitSource::Hand
            },
        };
        let object = HeldObject {
            thresholds,
            down_n: -percept.force_up_n(&base_from_tip),
            ..self.object
        };
        let context = Context {
            settings: &self.settings,
            step_s: 1e-3,
            object: &object,
            hand: &motion,
            path: &self.path,
            table: self.table.as_ref(),
            turning: -1.0,
            lowering_m: self.lowering_m,
            teleop_target: self.lead.as_ref(),
        };
        let proposals =
            self.modules
                .evaluate(Selection::from_modules(&[self.id]), percept, &context);
        for (id, proposal) in IDS.iter().zip(&proposals) {
            assert!(
                *id == self.id || *proposal == Proposal::default(),
                "{id} was not evaluated"
            );
        }
        proposals[IDS.iter().position(|id| *id == self.id).unwrap()]
    }

    pub(crate) fn evaluate_for(&mut self, ticks: usize, percept: &Percept) -> Proposal {
        (0..ticks).map(|_| self.evaluate(percept)).last().unwrap()
    }
}

pub(crate) fn fingertip(normal_n: f64) -> ContactPercept {
    ContactPercept {
        normal_n,
        in_contact: normal_n > 0.06,
        ..ContactPercept::default()
    }
}

pub(crate) fn percept(fingers: [ContactPercept; 2]) -> Percept {
    let [a, b] = fingers;
    Percept {
        fingertips: [a, b, ContactPercept::default(), ContactPercept::default()],
        side_of_fingertip: [
            GraspSide::First,
            GraspSide::Second,
            GraspSide::First,
            GraspSide::First,
        ],
        sides: fingers.into(),
        captured_ns: 1,
        step_s: 1e-3,
        delay_s: 1e-3,
    }
}

pub(crate) fn pressed(normal_n: f64) -> Percept {
    percept([fingertip(normal_n); 2])
}

pub(crate) fn with_utilisation(normal_n: f64, utilisation: f64) -> Percept {
    percept(
        [ContactPercept {
            utilisation,
            utilisation_now: utilisation,
            tangential_n: 0.5 * normal_n,
            ..fingertip(normal_n)
        }; 2],
    )
}
