//! Scene: robot data for the page, with links, fingertips and element positions.

use robot_model::{Form, HandSide, Limb, ModelError, Placement, RobotFiles, Shape};
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
    scene["limbs"] = skeleton.limbs().iter().map(limb).collect();
    scene["tips"] = json!(tips);
    Ok(())
}

fn limb(limb: &Limb) -> Value {
    json!({
        "name": limb.name,
        "parent": limb.parent,
        "at": placement(&limb.origin),
        "axis": limb.axis,
        "joint": limb.joint,
        "ratio": limb.ratio,
        "offset": limb.offset,
        "slides": limb.slides,
        "shapes": limb.shapes.iter().map(shape).collect::<Vec<_>>(),
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

fn layout(layout: &Layout) -> Value {
    let count = layout.count;
    json!({
        "position_m": layout.position_m[..count],
        "normal": layout.normal[..count],
        "tangent1": layout.tangent1[..count],
        "tangent2": layout.tangent2[..count],
    })
}
