//! Acting hand: the controller with a policy in place of the task executor.

use atas_core::arbitration::Arbiter;
use atas_core::executor::HandMotion;
use atas_core::held_object::HeldObject;
use atas_core::intake::FrameIntake;
use atas_core::kinematics::{HandCommand, HandServo};
use atas_core::modules::{Context, Modules, PoseCommand, Proposal, Selection};
use atas_core::path::Path;
use atas_core::perception::{self, ContactPercept, Percept, Perception};
use atas_core::safety::Grip;
use atas_core::thresholds::Thresholds;
use atas_core::{HandSensorSetup, Settings, Tick};
use nalgebra::Vector3;
use robot_model::{GRASP_SIDES, GraspPose, HandModel, HandVector, PerSide};
use shm_schemas::{Hand, HandFrame};

use crate::observation::MODULES;

/// Action size: velocity of the hand along x, y and z, closing speeds of both grasp sides.
pub const ACTIONS: usize = 3 + GRASP_SIDES;
/// Hand speed along an axis for action 1, m/s (design choice: twice the daemon's carrying speed).
pub const MOVE_M_S: f64 = 0.1;
/// Closing speed of a grasp side for action 1, m/s (design choice: ten times the daemon's).
pub const CLOSING_M_S: f64 = 0.02;
/// Acceleration limit of the hand, m/s² (design choice: full speed within 0.1 s).
const MOVE_M_S2: f64 = 1.0;
pub(crate) const TICK_S: f64 = 1e-3;
/// Largest commanded half opening, m (design choice: wider than every built-in object). A hand that
/// opens less wide has its own limit.
const HALF_OPENING_MAX_M: f64 = 0.045;

/// Permitted positions of the hand's centre, base frame, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PermittedRegion {
    pub(crate) low_m: Vector3<f64>,
    pub(crate) high_m: Vector3<f64>,
}

pub(crate) struct PolicyHand {
    model: HandModel,
    intake: FrameIntake,
    perception: Perception,
    modules: Modules,
    arbiter: Arbiter,
    servo: HandServo,
    room: PermittedRegion,
    speed_m_s: Vector3<f64>,
    /// Activity of the modules at the last tick, in the order of [`MODULES`].
    pub(crate) active: [bool; MODULES.len()],
}

impl PolicyHand {
    /// Makes a stationary hand at these joint positions, rad or m.
    pub(crate) fn new(
        hand: Hand,
        model: HandModel,
        wiring: &HandSensorSetup,
        q: HandVector,
        room: PermittedRegion,
    ) -> Self {
        Self {
            intake: FrameIntake::new(hand, wiring),
            perception: Perception::new(wiring, &model),
            modules: Modules::default(),
            arbiter: Arbiter::default(),
            servo: HandServo::new(&model, q),
            model,
            room,
            speed_m_s: Vector3::zeros(),
            active: [false; MODULES.len()],
        }
    }

    pub(crate) fn grasp_pose(&self) -> &GraspPose {
        self.servo.pose()
    }

    pub(crate) fn percept(&self) -> &Percept {
        self.perception.percept()
    }

    /// Returns the grip data that the safety gate needs.
    pub(crate) fn grip(&self) -> Grip {
        let fingers = &self.percept().sides;
        Grip {
            normal_n: fingers.map(|finger| finger.normal_n),
            f2_n: None,
        }
    }

    pub(crate) fn adopt(&mut self, q: HandVector) {
        self.servo.accept(q);
    }

    pub(crate) fn process_frame(
        &mut self,
        frame: Option<&HandFrame>,
        tick: Tick,
        settings: &Settings,
    ) {
        self.intake.begin();
        self.perception.begin();
        if let Some(checked) = frame.and_then(|it| self.intake.validate(it, tick, &settings.intake))
        {
            self.perception.update(&checked, false, settings);
        }
    }

    /// Executes one tick of an action. `action` is finite and within −1 to 1.
    pub(crate) fn act(&mut self, action: &[f64; ACTIONS]) -> HandCommand {
        let [x, y, z, first, second] = *action;
        let pose = self.next_pose(&(Vector3::new(x, y, z) * MOVE_M_S));
        let proposal = Proposal {
            active: true,
            closing_m_s: self
                .within_opening([first, second].map(|share| share * CLOSING_M_S).into()),
            pose: Some(PoseCommand {
                pose,
                with_fingers: false,
                arrived: false,
            }),
            ..Proposal::default()
        };
        let intent = self.arbiter.merge(&[proposal], TICK_S);
        self.servo
            .update(&self.model, &intent, self.perception.percept(), TICK_S)
    }

    /// Returns the next pose within the permitted region; the hand stops at its boundary.
    fn next_pose(&mut self, wanted_m_s: &Vector3<f64>) -> GraspPose {
        let most_m_s = MOVE_M_S2 * TICK_S;
        let change = (wanted_m_s - self.speed_m_s).map(|it| it.clamp(-most_m_s, most_m_s));
        self.speed_m_s += change;
        let mut frame = *self.servo.pose();
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

    /// Limits closing speeds so that the opening stays within its range.
    fn within_opening(&self, closing_m_s: PerSide<f64>) -> PerSide<f64> {
        let most_m = HALF_OPENING_MAX_M.min(self.model.max_opening_m() / 2.0);
        let half_m = &self.servo.pose().half_opening_m;
        PerSide::from_fn(|side| {
            let closes = closing_m_s[side] > 0.0;
            let at_end = if closes {
                half_m[side] <= 0.0
            } else {
                half_m[side] >= most_m
            };
            if at_end { 0.0 } else { closing_m_s[side] }
        })
    }

    /// Evaluates the modules for an unknown object; their proposals are observed, not executed.
    pub(crate) fn evaluate_modules(&mut self, settings: &Settings, measured: &HandVector) {
        let measured = self.model.forward(measured);
        let percept = self.perception.percept();
        let frame = *self.servo.pose();
        let thresholds = Thresholds::for_unknown_object(&settings.grasp);
        let touches = |side: &ContactPercept| side.in_contact && side.normal_n > 0.0;
        // Without lift verification, an object never counts as carried.
        let object = HeldObject {
            all_touched: percept.sides.iter().all(touches),
            ..HeldObject::untouched(thresholds)
        };
        let motion = HandMotion {
            carry_scale: self.arbiter.carry_scale(),
            closing_m_s: self.arbiter.closing_m_s(),
            pose: &frame,
            closing_axis: frame.closing_axis(),
            turns_by_wrist: self.model.turns_by_wrist(),
            base_from_tip: measured.base_from_tip(),
            side_m: PerSide::from_fn(|side| measured.side_m(side)),
            compression: perception::compression(&settings.perception, self.model.skin()),
            tactile_over_torque: 1.0,
            torque_over_tactile: 1.0,
        };
        let context = Context {
            settings,
            step_s: TICK_S,
            object: &object,
            hand: &motion,
            path: &Path::stationary(frame),
            table: None,
            turning: 1.0,
            lowering_m: None,
            teleop_target: None,
        };
        let proposals = self
            .modules
            .evaluate(Selection::from_modules(&MODULES), percept, &context);
        let states = |id| {
            atas_core::modules::IDS
                .iter()
                .position(|known| *known == id)
        };
        self.active = MODULES.map(|id| states(id).is_some_and(|place| proposals[place].active));
    }
}
