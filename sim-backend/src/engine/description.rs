//! Scene as an engine receives it: true geometry, servos, skins and objects, base frame, SI units.
//!
//! Rotations are matrices, row by row: columns are the child's axes in the parent's frame.

use nalgebra::{Matrix3, Vector3};
use robot_model::{HandVector, JointKind, RobotVector, Transform};
use serde::Serialize;
use shm_schemas::Layout;
use shm_schemas::layout::{DOME_RADIUS_M, NamedLayout};

use crate::body::GRAVITY_M_S2;
use crate::hand_body::HandBody;
use crate::object::Object;
use crate::pad::FOUNDATION_N_M3;
use crate::scene::{Mount, Placed, Scene};
use crate::shape::Shape;

/// Version of messages and description; raised with every change.
pub const PROTOCOL: u32 = 1;

/// Scene of a world.
#[derive(Clone, Debug, Serialize)]
pub struct EngineScene {
    /// [`PROTOCOL`].
    pub protocol: u32,
    /// Length of a tick, s.
    pub tick_s: f64,
    /// Gravity along −z, m/s².
    pub gravity_m_s2: f64,
    /// Seed of the engine's own noise.
    pub seed: u64,
    /// Left hand, then right hand; a missing hand has no joints and fingertips.
    pub hands: Vec<EngineHand>,
    /// Objects.
    pub objects: Vec<EngineObject>,
    /// Plates on the table.
    pub plates: Vec<EnginePlate>,
}

/// Arm with hand.
#[derive(Clone, Debug, Serialize)]
pub struct EngineHand {
    /// Joints with a drive.
    pub joints: Vec<EngineJoint>,
    /// Moving frames, each after its parent.
    pub frames: Vec<EngineFrame>,
    /// Fingertips.
    pub fingertips: Vec<EngineFingertip>,
}

/// Joint with its drive: torque = stiffness · position error + damping · velocity error.
#[derive(Clone, Debug, Serialize)]
pub struct EngineJoint {
    /// Name in the URDF.
    pub name: String,
    /// True for a prismatic joint: all units are those of translation.
    pub slides: bool,
    /// Start position.
    pub start: f64,
    /// Lower limit.
    pub lower: f64,
    /// Upper limit.
    pub upper: f64,
    /// Largest torque of the drive, N·m.
    pub effort_max: f64,
    /// Servo stiffness, N·m/rad.
    pub stiffness: f64,
    /// Servo damping, N·m·s/rad.
    pub damping: f64,
    /// Reflected inertia, kg·m².
    pub inertia_kg_m2: f64,
}

/// Frame that moves along or about its z axis.
#[derive(Clone, Debug, Serialize)]
pub struct EngineFrame {
    /// Parent frame; `None` for the base.
    pub parent: Option<usize>,
    /// Position in the parent without motion, m.
    pub position_m: [f64; 3],
    /// Rotation in the parent without motion.
    pub rotation: [[f64; 3]; 3],
    /// Joint, within the hand, that moves it.
    pub joint: usize,
    /// Motion of the frame over that of the joint.
    pub ratio: f64,
    /// Motion at joint coordinate zero, rad or m.
    pub offset: f64,
    /// True if it slides.
    pub slides: bool,
}

/// Fingertip: a bed of pins, each sprung along its normal and both tangents.
#[derive(Clone, Debug, Serialize)]
pub struct EngineFingertip {
    /// Frame that carries it; `None` for the base.
    pub frame: Option<usize>,
    /// Origin of the tip frame in that frame, m.
    pub position_m: [f64; 3],
    /// Rotation of the tip frame in that frame.
    pub rotation: [[f64; 3]; 3],
    /// Number of sensing elements.
    pub elements: usize,
    /// Pins of the skin.
    pub pins: Vec<EnginePin>,
}

/// Pin of the skin, tip frame.
#[derive(Clone, Debug, Serialize)]
pub struct EnginePin {
    /// Element that senses the pin's force.
    pub element: usize,
    /// Point on the skin, m.
    pub position_m: [f64; 3],
    /// Outward normal.
    pub normal: [f64; 3],
    /// Tangents.
    pub tangents: [[f64; 3]; 2],
    /// Area of the skin that the pin represents, m².
    pub area_m2: f64,
    /// Stiffness along the normal, N/m.
    pub stiffness_n_m: f64,
}

/// Object with its start pose.
#[derive(Clone, Debug, Serialize)]
pub struct EngineObject {
    /// Name.
    pub name: String,
    /// Shape.
    pub shape: EngineShape,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Friction coefficient against a fingertip.
    pub friction: f64,
    /// Stiffness under one fingertip, N/m; `None` if rigid.
    pub stiffness_n_m: Option<f64>,
    /// Centre of mass from the middle of the shape, m.
    pub centre_of_mass_m: [f64; 3],
    /// Position on the table, m; the engine stands it on the highest support.
    pub position_m: [f64; 2],
    /// Direction of its x axis, rad.
    pub yaw_rad: f64,
    /// True if a clamp holds it.
    pub clamped: bool,
    /// True for a cap on the neck of the scene's bottle.
    pub on_neck: bool,
    /// Thread of a cap.
    pub thread: Option<EngineThread>,
    /// Neck of a bottle.
    pub neck: Option<EngineNeck>,
}

/// Shape of an object.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EngineShape {
    /// Box with these half edges, m.
    Box([f64; 3]),
    /// Upright cylinder: radius, half height, m.
    Cylinder([f64; 2]),
}

/// Thread of a cap.
#[derive(Clone, Debug, Serialize)]
pub struct EngineThread {
    /// Friction torque, N·m.
    pub friction_n_m: f64,
    /// Rise of the torque beyond the closing angle, N·m/rad.
    pub rise_n_m_rad: f64,
    /// Angle from engagement to closed, rad.
    pub closing_rad: f64,
    /// Axial travel per revolution, m.
    pub pitch_m: f64,
    /// Sign of a closing rotation about the upward axis.
    pub sign: f64,
    /// Inertia of the cap about its axis, kg·m².
    pub inertia_kg_m2: f64,
}

/// Neck of a bottle.
#[derive(Clone, Debug, Serialize)]
pub struct EngineNeck {
    /// Height of the cap's lower edge above the bottle's foot when the threads meet, m.
    pub rim_m: f64,
}

/// Level plate on the table.
#[derive(Clone, Debug, Serialize)]
pub struct EnginePlate {
    /// Middle, m.
    pub centre_m: [f64; 2],
    /// Half edges, m.
    pub half_m: [f64; 2],
    /// Height of the top, m.
    pub height_m: f64,
}

impl EngineScene {
    /// Describes a world: bodies of both hands, their start, and the scene.
    pub(crate) fn new(
        bodies: &[HandBody; 2],
        start: &RobotVector,
        scene: &Scene,
        tick_s: f64,
        seed: u64,
    ) -> Self {
        let [left, right] = bodies;
        let of_left = left.model.joints().len();
        let of_hand = |range| HandVector::from_slice(&start[range]);
        let hands = vec![
            EngineHand::new(left, &of_hand(0..of_left)),
            EngineHand::new(right, &of_hand(of_left..start.len())),
        ];
        let plate = |plate: &crate::Plate| EnginePlate {
            centre_m: plate.centre_m,
            half_m: plate.half_m,
            height_m: plate.height_m,
        };
        Self {
            protocol: PROTOCOL,
            tick_s,
            gravity_m_s2: GRAVITY_M_S2,
            seed,
            hands,
            objects: scene.objects.iter().map(EngineObject::new).collect(),
            plates: scene.plates.iter().map(plate).collect(),
        }
    }
}

impl EngineHand {
    fn new(body: &HandBody, start: &HandVector) -> Self {
        let model = &body.model;
        let joints = model.joints().iter().enumerate().map(|(index, joint)| {
            let critical = libm::sqrt(joint.stiffness * joint.inertia_kg_m2);
            EngineJoint {
                name: joint.name.as_str().to_owned(),
                slides: joint.kind == JointKind::Prismatic,
                start: start[index],
                lower: joint.lower,
                upper: joint.upper,
                effort_max: joint.effort_max,
                stiffness: joint.stiffness * body.servo_factor[index],
                damping: 2.0 * critical,
                inertia_kg_m2: joint.inertia_kg_m2,
            }
        });
        let frames = model.frames().iter().map(|frame| {
            let (position_m, rotation) = parts(&frame.parent_from_frame);
            EngineFrame {
                parent: frame.parent,
                position_m,
                rotation,
                joint: frame.mover.joint,
                ratio: frame.mover.ratio,
                offset: frame.offset,
                slides: frame.mover.slides,
            }
        });
        let fingertips = model.tip_mounts().enumerate().map(|(finger, mount)| {
            let (position_m, rotation) = parts(&mount.frame_from_link);
            let layout = model.skin().layout;
            EngineFingertip {
                frame: mount.frame,
                position_m,
                rotation,
                elements: layout.layout().count,
                pins: pins(
                    layout,
                    model.tip_radius_m()[finger],
                    body.pads[finger].stiffness_factor(),
                ),
            }
        });
        Self {
            joints: joints.collect(),
            frames: frames.collect(),
            fingertips: fingertips.collect(),
        }
    }
}

/// Returns one pin per element; 41 pins for the dome with one element.
fn pins(named: NamedLayout, tip_radius_m: f64, stiffness_factor: f64) -> Vec<EnginePin> {
    let is_dome = matches!(named, NamedLayout::Dome41 | NamedLayout::Dome1);
    let layout = match named {
        NamedLayout::Dome1 => Layout::dome_41(),
        _ => named.layout(),
    };
    let scale = if is_dome {
        tip_radius_m / DOME_RADIUS_M
    } else {
        1.0
    };
    let ahead_m = if is_dome {
        0.0
    } else {
        tip_radius_m - named.depth_m()
    };
    let area_m2 = layout.element_area_m2 * scale * scale;
    let pin = |index: usize| EnginePin {
        element: if named == NamedLayout::Dome1 {
            0
        } else {
            index
        },
        position_m: (Vector3::from(layout.position_m[index]) * scale + Vector3::z() * ahead_m)
            .into(),
        normal: layout.normal[index],
        tangents: [layout.tangent1[index], layout.tangent2[index]],
        area_m2,
        stiffness_n_m: FOUNDATION_N_M3 * area_m2 * stiffness_factor,
    };
    (0..layout.count).map(pin).collect()
}

impl EngineObject {
    fn new(placed: &Placed) -> Self {
        let object: &Object = &placed.object;
        Self {
            name: object.name.clone(),
            shape: match object.shape {
                Shape::Box { half_m } => EngineShape::Box(half_m.into()),
                Shape::Cylinder {
                    radius_m,
                    half_height_m,
                } => EngineShape::Cylinder([radius_m, half_height_m]),
            },
            mass_kg: object.mass_kg,
            friction: object.friction,
            stiffness_n_m: Some(object.stiffness_n_m).filter(|n_m| n_m.is_finite()),
            centre_of_mass_m: object.centre_of_mass_m.into(),
            position_m: placed.position_m,
            yaw_rad: placed.yaw_rad,
            clamped: placed.mount == Mount::Clamped,
            on_neck: placed.mount == Mount::OnNeck,
            thread: object.thread.map(|thread| EngineThread {
                friction_n_m: thread.friction_n_m,
                rise_n_m_rad: crate::thread::RISE_N_M_RAD,
                closing_rad: thread.closing_rad,
                pitch_m: thread.pitch_m,
                sign: thread.closes.sign(),
                inertia_kg_m2: crate::thread::INERTIA_KG_M2,
            }),
            neck: object.neck.map(|neck| EngineNeck { rim_m: neck.rim_m }),
        }
    }
}

fn parts(transform: &Transform) -> ([f64; 3], [[f64; 3]; 3]) {
    let rotation: &Matrix3<f64> = &transform.rotation;
    let rows = core::array::from_fn(|row| core::array::from_fn(|column| rotation[(row, column)]));
    (transform.translation_m.into(), rows)
}
