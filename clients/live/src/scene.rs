//! Scene: robot data for the page, with links, fingertips and element positions.

use atas_meshes::{Mesh, Meshes};
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};
use robot_model::{
    Form, HandModel, HandSide, Limb, ModelError, Placement, RobotFiles, RobotModel, Shape,
    Skeleton, Transform,
};
use serde_json::{Value, json};
use shm_schemas::{Layout, ModuleId};

use crate::displayed::DisplayedRobot;

pub(crate) fn scene(shown: &DisplayedRobot) -> Result<Value, ModelError> {
    let modules = ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE);
    let mut scene = json!({
        "robot": shown.robot.as_ref().map(|robot| &robot.name),
        "note": shown.note,
        "fingers": shown.fingers,
        "limbs": [],
        "tips": [[], []],
        "tip_frames": [[], []],
        "layouts": shown.layouts.each_ref().map(layout),
        "modules": modules.map(|id| json!({ "id": id.0, "name": id.name() })).collect::<Vec<_>>(),
    });
    if let Some(robot) = &shown.robot {
        links(robot, &mut scene)?;
    }
    Ok(scene)
}

fn links(files: &RobotFiles, scene: &mut Value) -> Result<(), ModelError> {
    let (skeleton, robot) = (files.skeleton()?, files.load()?);
    let tips = HandSide::BOTH.map(|side| robot.hand(side).tip_links().collect::<Vec<_>>());
    let meshes = Meshes::load(files, &skeleton);
    let limbs = skeleton.limbs().iter().zip(&meshes.links);
    scene["limbs"] = limbs
        .map(|(limb, meshes)| self::limb(limb, meshes))
        .collect();
    scene["tips"] = json!(tips);
    scene["tip_frames"] = json!(tip_frames(&skeleton, &robot));
    Ok(())
}

/// Returns each fingertip's tip frame in its link, its grasp side, 0 or 1, and the distance of its
/// sensing face from the frame's origin, m.
fn tip_frames(skeleton: &Skeleton, robot: &RobotModel) -> [Vec<Value>; 2] {
    let reference: Vec<f64> = robot
        .sides()
        .flat_map(|side| robot.hand(side).reference().iter().copied())
        .collect();
    let base_from_limb = skeleton.base_from_limbs(&reference);
    let frames = |hand: &HandModel| {
        let pose = hand.forward(hand.reference());
        let tips = hand.tip_links().zip(pose.base_from_tip()).enumerate();
        let frame = |(finger, (link, tip)): (usize, (&str, &Transform))| {
            let limb = skeleton.limbs().iter().position(|limb| limb.name == link)?;
            let limb_from_tip = base_from_limb[limb].inverse() * pose_of(tip);
            Some(json!({
                "at": {
                    "xyz": limb_from_tip.translation.vector.as_slice(),
                    "q": limb_from_tip.rotation.coords.as_slice(),
                },
                "side": hand.grasp_side(finger).index(),
                "radius_m": hand.tip_radius_m()[finger],
            }))
        };
        tips.filter_map(frame).collect()
    };
    HandSide::BOTH.map(|side| {
        let hand = robot.hand(side);
        if hand.is_present() {
            frames(hand)
        } else {
            Vec::new()
        }
    })
}

fn pose_of(transform: &Transform) -> Isometry3<f64> {
    let rotation = Rotation3::from_matrix_unchecked(transform.rotation);
    Isometry3::from_parts(
        Translation3::from(transform.translation_m),
        UnitQuaternion::from_rotation_matrix(&rotation),
    )
}

fn limb(limb: &Limb, meshes: &[Mesh]) -> Value {
    let shapes = limb.shapes.iter().map(shape).chain(meshes.iter().map(mesh));
    json!({
        "name": limb.name,
        "parent": limb.parent,
        "at": placement(&limb.origin),
        "axis": limb.axis,
        "joint": limb.joint,
        "ratio": limb.ratio,
        "offset": limb.offset,
        "slides": limb.slides,
        "shapes": shapes.collect::<Vec<_>>(),
    })
}

fn placement(placement: &Placement) -> Value {
    json!({ "xyz": placement.translation_m, "q": placement.rotation_xyzw })
}

fn shape(shape: &Shape) -> Value {
    let form = match shape.form {
        Form::Cylinder { radius_m, length_m } => json!({ "cylinder": [radius_m, length_m] }),
        Form::Sphere { radius_m } => json!({ "sphere": radius_m }),
        Form::Box { size_m } => json!({ "box": size_m }),
    };
    json!({ "at": placement(&shape.origin), "form": form, "rgba": shape.rgba })
}

fn mesh(mesh: &Mesh) -> Value {
    json!({
        "at": { "xyz": [0, 0, 0], "q": [0, 0, 0, 1] },
        "form": { "mesh": { "points": mesh.points_m, "faces": mesh.triangles } },
        "rgba": mesh.rgba,
    })
}

fn layout(layout: &Layout) -> Value {
    let count = layout.count;
    json!({
        "position_m": layout.position_m[..count],
        "normal": layout.normal[..count],
        "tangent1": layout.tangent1[..count],
        "tangent2": layout.tangent2[..count],
    })
}

#[cfg(test)]
mod tests {
    use robot_model::{SHIPPED, TWO_HAND_ARM};

    use super::*;

    #[test]
    fn every_fingertip_has_a_tip_frame() {
        for files in SHIPPED {
            let (skeleton, robot) = (
                files.skeleton().expect("built-in"),
                files.load().expect("built-in"),
            );
            for (side, frames) in HandSide::BOTH
                .into_iter()
                .zip(tip_frames(&skeleton, &robot))
            {
                let hand = robot.hand(side);
                let count = if hand.is_present() {
                    hand.fingertip_count()
                } else {
                    0
                };
                assert_eq!(frames.len(), count, "{}", files.name);
                for (finger, frame) in frames.iter().enumerate() {
                    assert_eq!(
                        frame["side"],
                        hand.grasp_side(finger).index(),
                        "{}",
                        files.name
                    );
                    assert_eq!(frame["radius_m"], hand.tip_radius_m()[finger]);
                }
            }
        }
    }

    /// Links of the built-in robot carry their tip frames at the origin.
    #[test]
    fn tip_frame_of_the_two_hand_arm_is_its_link() {
        let (skeleton, robot) = (
            TWO_HAND_ARM.skeleton().expect("built-in"),
            TWO_HAND_ARM.load().expect("built-in"),
        );
        for frame in tip_frames(&skeleton, &robot).iter().flatten() {
            for axis in 0..3 {
                let xyz_m = frame["at"]["xyz"][axis].as_f64().expect("a number");
                assert!(xyz_m.abs() < 1e-9, "{frame}");
            }
        }
    }
}
