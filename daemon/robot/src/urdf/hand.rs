//! Loads one hand of a URDF: chains, joint order, frames, fingertips.

use crate::grasp_sides::GraspSide;
use std::collections::BTreeMap;
use std::format;
use std::string::String;
use std::vec::Vec;

use nalgebra::{Matrix3, Vector3};

use super::collision::load_capsules;
use super::error::{Findings, ModelProblem, problem};
use super::framed::Framed;
use super::joint::{joint_axis, kind, load_joint, name, turn_z_to};
use super::tip::{skin, tip_origin_m, tip_radius_m};
use super::tree::{Chain, Step, Tree};
use crate::joint::JointKind;
use crate::model::{Frame, HandModel, Mounted, Mover};
use crate::robot_file::{HandEntry, JointEntry};
use crate::side::HandSide;
use crate::sizes::{
    ARM_JOINTS_MAX, FINGER_JOINTS_MAX, FINGERTIPS_MAX, GRASP_SIDES, HAND_JOINTS_MAX,
    TRUNK_JOINTS_MAX,
};
use crate::skin::Skin;
use crate::transform::Transform;
use crate::vector::HandVector;
use crate::workspace::Workspace;

/// Smallest cosine between a finger's joint and the closing axis at which the joint tilts the
/// finger about that axis.
const TILT_COS_MIN: f64 = 0.99;

/// Chains of a hand: to the palm and to each fingertip.
struct Chains<'a> {
    palm: Chain<'a>,
    tips: Vec<Chain<'a>>,
}

type Entries = BTreeMap<String, JointEntry>;

/// Loads a hand; `alone` if the robot has no other.
pub(super) fn load_hand(
    tree: &Tree,
    side: HandSide,
    entry: &HandEntry,
    entries: &Entries,
    alone: bool,
    findings: &mut Findings,
) -> Option<HandModel> {
    check_sides(entry, findings);
    check_down(entry, findings);
    let skin = findings.value_of(skin(entry)).unwrap_or(Skin::DOME_41);
    let chains = chains(tree, entry, findings)?;
    let mut hand = HandModel::absent(side);
    hand.skin = skin;
    hand.finger_count = chains.tips.len();
    for (finger, entry) in hand.fingers.iter_mut().zip(&entry.fingers) {
        finger.side = if entry.side == GRASP_SIDES {
            GraspSide::Second
        } else {
            GraspSide::First
        };
    }
    let order = order_joints(&mut hand, &chains, findings)?;
    load_joints(&mut hand, &order, tree, entries, findings)?;
    let frames = load_frames(&mut hand, &order, &chains, findings)?;
    let linked = load_links(&mut hand, tree, entry, &chains, &frames, findings);
    hand.capsules = load_capsules(tree, &frames, alone, findings)?;
    linked?;
    turn_tips(&mut hand, entry, findings);
    set_reference_values(&mut hand, entry);
    check_rest(&hand, entry, findings);
    Some(hand)
}

/// Checks for two to four fingertips, at least one on each side.
fn check_sides(entry: &HandEntry, findings: &mut Findings) {
    let fingers = &entry.fingers;
    let item = || format!("the fingers of palm `{}`", entry.palm);
    if !(GRASP_SIDES..=FINGERTIPS_MAX).contains(&fingers.len()) {
        let needs = format!("{GRASP_SIDES} to {FINGERTIPS_MAX}");
        findings.add(problem(item(), fingers.len(), needs).in_robot_file());
    }
    for finger in fingers {
        if !(1..=GRASP_SIDES).contains(&finger.side) {
            let item = format!("the side of fingertip `{}`", finger.tip);
            findings.add(problem(item, finger.side, "1 or 2").in_robot_file());
        }
    }
    for side in 1..=GRASP_SIDES {
        if !fingers.iter().any(|finger| finger.side == side) {
            let was = format!("none on side {side}");
            findings.add(problem(item(), was, "at least one on each side").in_robot_file());
        }
    }
}

/// Returns the pointing direction, unit length.
fn check_down(entry: &HandEntry, findings: &mut Findings) -> Option<Vector3<f64>> {
    let down = Vector3::from(entry.down);
    let is_direction = down.iter().all(|x| x.is_finite()) && down.norm() > 1e-9;
    if !is_direction {
        let item = format!("the `down` of palm `{}`", entry.palm);
        let was = format!("{:?}", entry.down);
        findings.add(problem(item, was, "a direction").in_robot_file());
        return None;
    }
    Some(down.normalize())
}

fn chains<'a>(tree: &Tree<'a>, entry: &HandEntry, findings: &mut Findings) -> Option<Chains<'a>> {
    let palm = findings.value_of(tree.chain(&entry.palm));
    let tips: Vec<_> = entry
        .fingers
        .iter()
        .filter_map(|finger| Some((&finger.tip, findings.value_of(tree.chain(&finger.tip))?)))
        .collect();
    let palm = palm?;
    if tips.len() != entry.fingers.len() || tips.len() > FINGERTIPS_MAX {
        return None;
    }
    let carries = |tip: &Chain| {
        let names = |chain: &Chain| -> Vec<String> {
            chain.steps.iter().map(|it| it.joint.name.clone()).collect()
        };
        names(tip).starts_with(&names(&palm))
    };
    let mut chains = Vec::new();
    for (link, tip) in tips {
        if !carries(&tip) {
            let was = format!("not carried by palm `{}`", entry.palm);
            findings.add(problem(
                format!("fingertip `{link}`"),
                was,
                "a link behind the palm",
            ));
            return None;
        }
        if tip.steps.len() - palm.steps.len() > FINGER_JOINTS_MAX {
            let was = format!("moved by {} joints", tip.steps.len() - palm.steps.len());
            let needs = format!("at most {FINGER_JOINTS_MAX} behind the palm");
            findings.add(problem(format!("fingertip `{link}`"), was, needs));
            return None;
        }
        chains.push(tip);
    }
    Some(Chains { palm, tips: chains })
}

/// Returns the joints with a coordinate, by name, in the hand's order.
fn order_joints(
    hand: &mut HandModel,
    chains: &Chains,
    findings: &mut Findings,
) -> Option<Vec<String>> {
    let arm_steps = chains.palm.steps.len();
    let mut order: Vec<String> = Vec::new();
    for step in &chains.palm.steps {
        if step.joint.mimic.is_some() {
            let item = format!("joint `{}` of the arm", step.joint.name);
            findings.add(problem(item, "a mimic joint", "an independent joint"));
        }
        order.push(step.joint.name.clone());
    }
    hand.arm_joints = order.len();
    let drivers: Vec<Vec<String>> = chains
        .tips
        .iter()
        .map(|tip| tip.steps[arm_steps..].iter().map(driver).collect())
        .collect();
    let moves = |joint: &String| drivers.iter().filter(|of| of.contains(joint)).count();
    let shared = drivers.iter().flatten().filter(|joint| moves(joint) > 1);
    for joint in shared {
        if !order.contains(joint) {
            order.push(joint.clone());
        }
    }
    hand.trunk_joints = order.len();
    for (finger, drivers) in hand.fingers.iter_mut().zip(&drivers) {
        finger.first_joint = order.len();
        for joint in drivers {
            if !order.contains(joint) {
                order.push(joint.clone());
            }
        }
        finger.joint_count = order.len() - finger.first_joint;
    }
    hand.joint_count = order.len();
    for (what, count, most) in [
        ("joints of the arm", hand.arm_joints, ARM_JOINTS_MAX),
        (
            "drives that fingers share",
            hand.trunk_joints - hand.arm_joints,
            TRUNK_JOINTS_MAX - ARM_JOINTS_MAX,
        ),
        ("joints of the hand", hand.joint_count, HAND_JOINTS_MAX),
    ] {
        if count > most {
            let item = format!("the number of {what} on the {:?} side", hand.side);
            findings.add(problem(item, count, format!("at most {most}")));
            return None;
        }
    }
    Some(order)
}

/// Returns the joint whose coordinate moves a step.
fn driver(step: &Step) -> String {
    let mimic = step.joint.mimic.as_ref();
    mimic.map_or(&step.joint.name, |mimic| &mimic.joint).clone()
}

fn load_joints(
    hand: &mut HandModel,
    order: &[String],
    tree: &Tree,
    entries: &Entries,
    findings: &mut Findings,
) -> Option<()> {
    let mut rest = HandVector::zeros(order.len());
    let mut complete = true;
    for (index, label) in order.iter().enumerate() {
        let urdf = findings.value_of(tree.joint(label));
        let independent = urdf.filter(|urdf| match &urdf.mimic {
            None => true,
            Some(mimic) => {
                let was = format!("a mimic of `{}`", mimic.joint);
                let needs = "an independent joint: a mimic joint cannot mimic another";
                findings.add(problem(format!("joint `{label}`"), was, needs));
                false
            }
        });
        let loaded = independent.and_then(|it| load_joint(it, entries.get(label), findings));
        match loaded {
            Some((joint, at)) => (hand.joints[index], rest[index]) = (joint, at),
            None => complete = false,
        }
    }
    hand.reference = rest;
    complete.then_some(())
}

/// Loads the frames: of the arm, then the remaining ones of each fingertip's chain.
fn load_frames<'a>(
    hand: &mut HandModel,
    order: &[String],
    chains: &Chains<'a>,
    findings: &mut Findings,
) -> Option<Vec<Framed<'a>>> {
    let mut frames: Vec<Framed<'a>> = Vec::new();
    for chain in [&chains.palm].into_iter().chain(&chains.tips) {
        let mut parent: Option<usize> = None;
        for step in &chain.steps {
            let known = frames
                .iter()
                .position(|it| it.joint.name == step.joint.name);
            let index = match known {
                Some(index) => index,
                None => {
                    let driver = order.iter().position(|name| *name == driver(step))?;
                    let (frame, framed) =
                        findings.value_of(load_frame(step, parent, driver, &frames))?;
                    hand.frames[frames.len()] = frame;
                    frames.push(framed);
                    frames.len() - 1
                }
            };
            parent = Some(index);
        }
    }
    hand.frame_count = frames.len();
    Some(frames)
}

fn load_frame<'a>(
    step: &Step<'a>,
    parent: Option<usize>,
    driver: usize,
    frames: &[Framed],
) -> Result<(Frame, Framed<'a>), ModelProblem> {
    let joint = step.joint;
    let link_from_frame = turn_z_to(joint_axis(joint)?);
    let parent_from_link =
        parent.map_or(Transform::IDENTITY, |parent| frames[parent].frame_from_link);
    let (ratio, offset) = joint.mimic.as_ref().map_or((1.0, 0.0), |mimic| {
        (mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0))
    });
    if !(ratio.is_finite() && offset.is_finite()) {
        let was = format!("multiplier {ratio}, offset {offset}");
        let item = format!("the mimic of joint `{}`", joint.name);
        return Err(problem(item, was, "finite numbers"));
    }
    let frame = Frame {
        parent,
        parent_from_frame: parent_from_link.then(&step.origin).then(&link_from_frame),
        mover: Mover {
            frame: frames.len(),
            joint: driver,
            ratio,
            slides: kind(joint)? == JointKind::Prismatic,
        },
        offset,
    };
    let frame_from_link = Transform {
        rotation: link_from_frame.rotation.transpose(),
        ..link_from_frame
    };
    Ok((
        frame,
        Framed {
            joint,
            frame_from_link,
            driver,
        },
    ))
}

/// Loads the palm and the fingertips.
fn load_links(
    hand: &mut HandModel,
    tree: &Tree,
    entry: &HandEntry,
    chains: &Chains,
    frames: &[Framed],
    findings: &mut Findings,
) -> Option<()> {
    hand.pointing = check_down(entry, findings)?;
    hand.palm = mounted(&chains.palm, frames).0;
    let mut complete = true;
    for (index, (chain, entry)) in chains.tips.iter().zip(&entry.fingers).enumerate() {
        let link = findings.value_of(name(&entry.tip));
        let radius_m = findings.value_of(tip_radius_m(tree, entry, hand.skin.layout));
        let origin_m = findings.value_of(tip_origin_m(entry, radius_m.unwrap_or_default()));
        let finger = &mut hand.fingers[index];
        let (Some(link), Some(radius_m), Some(origin_m)) = (link, radius_m, origin_m) else {
            complete = false;
            continue;
        };
        (finger.link, hand.tip_radius_m[index]) = (link, radius_m);
        let (tip, moved_by) = mounted(chain, frames);
        finger.tip = tip;
        finger.tip.frame_from_link.translation_m = tip.frame_from_link.point(&origin_m);
        for frame in moved_by {
            finger.moved_by[frame] = true;
        }
    }
    complete.then_some(())
}

/// Turns the tip frames of links with a sensing direction, so that they follow
/// [`crate::HandPose::base_from_tip`].
fn turn_tips(hand: &mut HandModel, entry: &HandEntry, findings: &mut Findings) {
    let straight = hand.forward(&HandVector::zeros(hand.joint_count));
    let pointing = straight.hand_axis();
    for (index, finger) in entry.fingers.iter().enumerate() {
        let Some(facing) = finger.facing.map(Vector3::from) else {
            continue;
        };
        let base_from_link = straight.base_from_tip()[index].rotation;
        let along = base_from_link.transpose() * pointing;
        let axis = facing.try_normalize(1e-9).unwrap_or_default();
        let down = (along - axis * axis.dot(&along)).try_normalize(1e-6);
        let (Some(down), true) = (down, axis.iter().all(|x| x.is_finite())) else {
            let item = format!("the facing of fingertip `{}`", finger.tip);
            let needs = "a direction that is not parallel to the pointing direction of the hand";
            let was = format!("{:?}", facing.as_slice());
            findings.add(problem(item, was, needs).in_robot_file());
            continue;
        };
        let link_from_tip = Matrix3::from_columns(&[down, axis.cross(&down), axis]);
        let tip = &mut hand.fingers[index].tip.frame_from_link;
        tip.rotation *= link_from_tip;
    }
}

/// Returns the end of a chain, and the frames that move it.
fn mounted(chain: &Chain, frames: &[Framed]) -> (Mounted, Vec<usize>) {
    let index = |step: &Step| {
        frames
            .iter()
            .position(|it| it.joint.name == step.joint.name)
    };
    let moved_by: Vec<usize> = chain.steps.iter().filter_map(index).collect();
    let last = moved_by.last().copied();
    let frame_from_last = last.map_or(Transform::IDENTITY, |last| frames[last].frame_from_link);
    let mounted = Mounted {
        frame: last,
        frame_from_link: frame_from_last.then(&chain.end),
    };
    (mounted, moved_by)
}

/// Sets all values that follow from the reference posture.
fn set_reference_values(hand: &mut HandModel, entry: &HandEntry) {
    hand.find_turning();
    let pose = hand.forward(&hand.reference);
    let across_m = pose.across_m();
    let closing = across_m.try_normalize(0.0).unwrap_or_default();
    let beside = closing.cross(&pose.hand_axis());
    for index in 0..hand.finger_count {
        let finger = hand.fingers[index];
        let from_middle_m = pose.tip_m(index) - pose.side_m(finger.side);
        hand.fingers[index].offset_m = from_middle_m.dot(&beside);
        for joint in hand.finger_joints(index) {
            let own = hand.movers(index).find(|mover| mover.joint == joint);
            hand.tilts[joint] = own.is_some_and(|mover| {
                !mover.slides && pose.frame_axis(mover.frame).dot(&closing).abs() > TILT_COS_MIN
            });
        }
    }
    let radius_m = |side| hand.mean_of_side(side, |finger| hand.tip_radius_m[finger]);
    let open_m = across_m.norm() - radius_m(GraspSide::First) - radius_m(GraspSide::Second);
    let middle_m = pose.middle_m();
    hand.home_m = entry.home_m.map_or(middle_m, Vector3::from);
    hand.home_opening_m = entry.home_opening_m.unwrap_or(open_m);
    let reference_yaw_rad = hand.yaw_of_joints_rad(&hand.reference, &hand.home_m);
    hand.home_yaw_rad = entry
        .home_yaw_deg
        .map_or(reference_yaw_rad, f64::to_radians);
    hand.object_m = entry.object_m.unwrap_or([hand.home_m.x, hand.home_m.y]);
    hand.workspace = entry.workspace.map(|entry| Workspace {
        x_m: entry.x_m,
        y_m: entry.y_m,
        z_m: entry.z_m,
        opening_m: entry.opening_m,
    });
}

/// Checks that home and workspace are valid.
fn check_rest(hand: &HandModel, entry: &HandEntry, findings: &mut Findings) {
    let item = |what: &str| format!("the {what} of palm `{}`", entry.palm);
    let numbers = [
        hand.home_m.as_slice(),
        &[hand.home_opening_m, hand.home_yaw_rad],
        &hand.object_m,
    ];
    if numbers.concat().iter().any(|value| !value.is_finite()) {
        findings.add(problem(item("home"), "not finite", "finite numbers").in_robot_file());
        return;
    }
    if hand
        .workspace
        .is_some_and(|workspace| !workspace.is_valid())
    {
        let needs = "finite numbers, the least before the greatest";
        let was = format!("{:?}", entry.workspace);
        findings.add(problem(item("workspace"), was, needs).in_robot_file());
    }
}
