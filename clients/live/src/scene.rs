//! What does not change while a page is open: the robot's links and where the elements of its fingertips sit.

use robot_model::{Form, Limb, ModelError, Placement, RobotFiles, Shape, Side};
use serde_json::{Value, json};
use shm_schemas::{Layout, ModuleId};

/// A robot, its skin and its modules.
pub(crate) fn scene(files: &RobotFiles, layouts: &[Layout; 2]) -> Result<Value, ModelError> {
    let (skeleton, robot) = (files.skeleton()?, files.load()?);
    let tips = Side::BOTH.map(|side| robot.hand(side).tip_links().collect::<Vec<_>>());
    let modules = ModuleId::ALL.iter().filter(|id| **id != ModuleId::NONE);
    Ok(json!({
        "limbs": skeleton.limbs().iter().map(limb).collect::<Vec<_>>(),
        "tips": tips,
        "layouts": layouts.each_ref().map(layout),
        "modules": modules.map(|id| json!({ "id": id.0, "name": id.name() })).collect::<Vec<_>>(),
    }))
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
