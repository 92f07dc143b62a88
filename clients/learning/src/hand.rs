//! The acting hand under a policy: the controller's own parts, with the policy in the place of its tasks.

use atas_core::arbitration::Arbiter;
use atas_core::intake::FrameIntake;
use atas_core::kinematics::{HandCommand, HandServo};
use atas_core::modules::{Context, Modules, PoseCommand, Proposal, Selection, force_range_n};
use atas_core::path::Path;
use atas_core::perception::{self, Percept, Perception};
use atas_core::safety::Grip;
use atas_core::thresholds::Thresholds;
use atas_core::{HandWiring, Settings, Tick};
use nalgebra::{Matrix3, Vector3};
use robot_model::{GraspFrame, HandModel, HandVector, VIRTUAL_FINGERS};
use shm_schemas::{Hand, HandFrame};

use crate::observation::MODULES;

/// Numbers of one action: the hand's speed along x, y and z, the closing speed of finger 1 and of finger 2.
pub const ACTIONS: usize = 3 + VIRTUAL_FINGERS;
/// Speed of the hand along an axis for an action of 1, m/s (ours: twice what the daemon conveys with).
pub const MOVE_M_S: f64 = 0.1;
/// Closing speed of a finger for an action of 1, m/s (ours: ten times what the daemon closes with).
pub const CLOSING_M_S: f64 = 0.02;
/// How fast the hand's speed may change, m/s² (ours: full speed within 0.1 s).
const MOVE_M_S2: f64 = 1.0;
/// Length of a tick, s.
pub(crate) const TICK_S: f64 = 1e-3;
/// Half openings that can be commanded, m (ours: from touching itself to wider than every built-in object).
const HALF_OPENING_M: [f64; 2] = [0.0, 0.045];

/// Where the hand's centre may be, base frame, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    pub(crate) low_m: Vector3<f64>,
    pub(crate) high_m: Vector3<f64>,
}

/// The acting hand.
pub(crate) struct PolicyHand {
    model: HandModel,
    intake: FrameIntake,
    perception: Perception,
    modules: Modules,
    arbiter: Arbiter,
    servo: HandServo,
    room: Room,
    speed_m_s: Vector3<f64>,
    /// What the modules said last, in the order of [`MODULES`].
    pub(crate) active: [bool; MODULES.len()],
}

impl PolicyHand {
    /// A hand that stands at these joint positions, rad.
    pub(crate) fn at(hand: Hand, model: HandModel, q_rad: HandVector, room: Room) -> Self {
        let wiring = HandWiring::default();
        Self {
            intake: FrameIntake::new(hand, &wiring),
            perception: Perception::new(&wiring, &model),
            modules: Modules::default(),
            arbiter: Arbiter::default(),
            servo: HandServo::at(&model, q_rad),
            model,
            room,
            speed_m_s: Vector3::zeros(),
            active: [false; MODULES.len()],
        }
    }

    /// The commanded pose.
    pub(crate) fn frame(&self) -> &GraspFrame {
        self.servo.frame()
    }

    /// What the hand feels.
    pub(crate) fn percept(&self) -> &Percept {
        self.perception.percept()
    }

    /// What the gate must know of the grip.
    pub(crate) fn grip(&self) -> Grip {
        let fingers = &self.percept().virtual_fingers;
        Grip {
            normal_n: fingers.map(|finger| finger.normal_n),
            f2_n: None,
        }
    }

    /// Takes over what the safety gate let through of the wish.
    pub(crate) fn adopt(&mut self, q_rad: HandVector) {
        self.servo.adopt(q_rad);
    }

    /// Takes in a tick's frame, if there is one.
    pub(crate) fn feel(&mut self, frame: Option<&HandFrame>, tick: Tick, settings: &Settings) {
        self.intake.begin();
        self.perception.begin();
        if let Some(checked) = frame.and_then(|it| self.intake.check(it, tick, &settings.intake)) {
            self.perception
                .update(&checked, false, &settings.perception);
        }
    }

    /// One tick towards what the policy asks for. `action` is finite and within −1 to 1.
    pub(crate) fn act(&mut self, action: &[f64; ACTIONS]) -> HandCommand {
        let [x, y, z, first, second] = *action;
        let pose = self.carried(&(Vector3::new(x, y, z) * MOVE_M_S));
        let proposal = Proposal {
            active: true,
            closing_m_s: self.within_opening([first, second].map(|share| share * CLOSING_M_S)),
            pose: Some(PoseCommand {
                frame: pose,
                with_fingers: false,
                arrived: false,
            }),
            ..Proposal::default()
        };
        let intent = self.arbiter.merge(&[proposal], TICK_S);
        self.servo
            .follow(&self.model, &intent, self.perception.percept(), TICK_S)
    }

    /// The pose one tick on, within the room; at a wall the hand stands.
    fn carried(&mut self, wanted_m_s: &Vector3<f64>) -> GraspFrame {
        let most_m_s = MOVE_M_S2 * TICK_S;
        let change = (wanted_m_s - self.speed_m_s).map(|it| it.clamp(-most_m_s, most_m_s));
        self.speed_m_s += change;
        let mut frame = *self.servo.frame();
        let (low_m, high_m) = (self.room.low_m, self.room.high_m);
        for axis in 0..3 {
            let wanted_m = frame.centre_m[axis] + self.speed_m_s[axis] * TICK_S;
            let kept_m = wanted_m.clamp(low_m[axis], high_m[axis]);
            if kept_m != wanted_m {
                self.speed_m_s[axis] = 0.0;
            }
            frame.centre_m[axis] = kept_m;
        }
        frame
    }

    /// Closing speeds that do not lead beyond the openings that can be commanded.
    fn within_opening(&self, closing_m_s: [f64; VIRTUAL_FINGERS]) -> [f64; VIRTUAL_FINGERS] {
        let [least_m, most_m] = HALF_OPENING_M;
        let half_m = &self.servo.frame().half_opening_m;
        core::array::from_fn(|finger| {
            let closes = closing_m_s[finger] > 0.0;
            let at_end = if closes {
                half_m[finger] <= least_m
            } else {
                half_m[finger] >= most_m
            };
            if at_end { 0.0 } else { closing_m_s[finger] }
        })
    }

    /// What the modules say of what the hand feels, for an object that is not known yet.
    pub(crate) fn ask_modules(&mut self, settings: &Settings, base_from_tip: &[Matrix3<f64>]) {
        let percept = self.perception.percept();
        let frame = *self.servo.frame();
        let thresholds = Thresholds::unknown(&settings.grasp);
        let (weakest_n, _) = force_range_n(percept);
        let context = Context {
            settings,
            step_s: TICK_S,
            thresholds,
            least_n: thresholds.f1_n,
            all_touched: weakest_n > 0.0 && percept.virtual_fingers.iter().all(|it| it.in_contact),
            closing_m: 0.0,
            tips: perception::compression(&settings.perception, self.model.skin()),
            carried_m: 0.0,
            path: &Path::stay(frame),
            carry_scale: self.arbiter.carry_scale(),
            closing_m_s: self.arbiter.closing_m_s(),
            frame: &frame,
            closing_axis: frame.closing_axis(),
            turns_by_wrist: self.model.turns_by_wrist(),
            turning: 1.0,
            lowering_m: None,
            base_from_tip,
            overread: 1.0,
            underread: 1.0,
            // Nobody has tugged at it to prove that.
            hangs: false,
            tries: false,
            proved: false,
            table: None,
            lead: None,
        };
        let proposals = self
            .modules
            .evaluate(Selection::of(&MODULES), percept, &context);
        let says = |id| {
            atas_core::modules::IDS
                .iter()
                .position(|known| *known == id)
        };
        self.active = MODULES.map(|id| says(id).is_some_and(|place| proposals[place].active));
    }

    /// Measured orientation of the fingertips.
    pub(crate) fn orientations(&self, q_rad: &HandVector) -> Vec<Matrix3<f64>> {
        let pose = self.model.forward(q_rad);
        pose.base_from_tip()
            .iter()
            .map(|tip| tip.rotation)
            .collect()
    }
}
