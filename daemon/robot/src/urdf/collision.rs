//! Collision shapes of a URDF as capsules.

use std::format;
use std::string::String;
use std::vec::Vec;

use nalgebra::Vector3;
use urdf_rs::Geometry;

use super::error::{Findings, ModelProblem, problem};
use super::framed::Framed;
use super::tree::{Tree, finite, transform};
use crate::capsule::{CAPSULES_MAX, Capsule, Capsules};
use crate::robot_file::{HandEntry, RobotFile};

/// Returns the collision capsules of all links that a hand's frames move, each in its frame. A
/// single hand has no other hand to keep apart from, so other shapes are ignored there. If a hand
/// has too many capsules, the closest ones are merged.
pub(super) fn load_capsules(
    tree: &Tree,
    frames: &[Framed],
    alone: bool,
    findings: &mut Findings,
) -> Option<Capsules> {
    let mut bodies: Vec<(Capsule, usize)> = Vec::new();
    for link in &tree.robot().links {
        let Some((mover, path)) = findings.value_of(tree.mover(&link.name))? else {
            continue;
        };
        let Some(index) = frames.iter().position(|it| it.joint.name == mover.name) else {
            continue;
        };
        let framed = &frames[index];
        for collision in &link.collision {
            let what = || format!("the collision of link `{}`", link.name);
            if alone && matches!(collision.geometry, Geometry::Mesh { .. }) {
                continue;
            }
            let size = findings.value_of(capsule_size(&collision.geometry, what));
            let origin = findings.value_of(transform(&collision.origin, what));
            let (Some((radius_m, along_m)), Some(origin)) = (size, origin) else {
                continue;
            };
            let frame_from_shape = framed.frame_from_link.then(&path).then(&origin);
            let end = |sign: f64| frame_from_shape.point(&(along_m * sign));
            let capsule = Capsule {
                a_m: end(-1.0),
                b_m: end(1.0),
                radius_m,
                joint: framed.driver,
            };
            bodies.push((capsule, index));
            // One by one, so that the time per shape is bounded.
            if bodies.len() > CAPSULES_MAX {
                join_two(&mut bodies)?;
            }
        }
    }
    let mut capsules = Capsules::new();
    let fit = bodies
        .into_iter()
        .all(|(body, frame)| capsules.push(body, frame));
    fit.then_some(capsules)
}

/// Merges the two bodies of one frame that add the least volume. Returns `None` if no two share a
/// frame; a hand has too few frames for that.
fn join_two(bodies: &mut Vec<(Capsule, usize)>) -> Option<()> {
    let mut least: Option<(f64, usize, usize, Capsule)> = None;
    for (second, (body, frame)) in bodies.iter().enumerate() {
        for (first, (other, other_frame)) in bodies[..second].iter().enumerate() {
            if frame != other_frame {
                continue;
            }
            let joined = other.enclosing(body);
            let added_m3 = joined.volume_m3() - other.volume_m3() - body.volume_m3();
            if least.is_none_or(|(least_m3, ..)| added_m3 < least_m3) {
                least = Some((added_m3, first, second, joined));
            }
        }
    }
    let (_, first, second, joined) = least?;
    bodies[first].0 = joined;
    bodies.remove(second);
    Some(())
}

/// Returns a sentence for each collision shape that is ignored or approximated.
pub(super) fn remarks(tree: &Tree, file: &RobotFile) -> Vec<String> {
    let hands = [&file.hands.left, &file.hands.right].map(|hand| hand.as_ref());
    let hands = hands.into_iter().flatten().map(|hand| movers(tree, hand));
    let hands: Vec<Vec<&str>> = hands.collect();
    let moved: Vec<&str> = hands.iter().flatten().copied().collect();
    let mut remarks = Vec::new();
    for moved in &hands {
        let shapes = shapes_of(tree, moved);
        if shapes > CAPSULES_MAX {
            remarks.push(format!(
                "{shapes} collision shapes of one hand are approximated by {CAPSULES_MAX} capsules \
                 around them"
            ));
        }
    }
    for link in &tree.robot().links {
        let mover = tree.mover(&link.name).ok().flatten();
        let moves = mover.is_some_and(|(joint, _)| moved.contains(&&*joint.name));
        let shapes = |is: fn(&Geometry) -> bool| {
            let shapes = link.collision.iter();
            shapes.filter(|it| is(&it.geometry)).count()
        };
        let meshes = shapes(|it| matches!(it, Geometry::Mesh { .. }));
        let boxes = shapes(|it| matches!(it, Geometry::Box { .. }));
        let name = &link.name;
        if !moves && !link.collision.is_empty() {
            remarks.push(format!(
                "collision of link `{name}` is ignored: it does not move with a fingertip"
            ));
        } else if meshes > 0 {
            remarks.push(format!(
                "mesh in the collision of link `{name}` is ignored: a single hand has no other \
                 hand to avoid"
            ));
        } else if boxes > 0 {
            remarks.push(format!(
                "collision of link `{name}` is a box, approximated by the capsule around it"
            ));
        }
    }
    remarks
}

/// Returns the joints that move a hand's fingertips.
fn movers<'a>(tree: &Tree<'a>, hand: &HandEntry) -> Vec<&'a str> {
    let tips = hand.fingers.iter();
    let chains = tips.filter_map(|finger| tree.chain(&finger.tip).ok());
    let steps = chains.flat_map(|chain| chain.steps);
    steps.map(|step| &*step.joint.name).collect()
}

/// Returns the number of shapes, except meshes, that these joints move.
fn shapes_of(tree: &Tree, moved: &[&str]) -> usize {
    let links = tree.robot().links.iter().filter(|link| {
        let mover = tree.mover(&link.name).ok().flatten();
        mover.is_some_and(|(joint, _)| moved.contains(&&*joint.name))
    });
    let shapes = links.flat_map(|link| &link.collision);
    let capsules = shapes.filter(|it| !matches!(it.geometry, Geometry::Mesh { .. }));
    capsules.count()
}

/// Returns the radius of the capsule around a shape, and the vector from its centre to an end, in
/// the shape's frame, metres.
fn capsule_size(
    geometry: &Geometry,
    what: impl Fn() -> String,
) -> Result<(f64, Vector3<f64>), ModelProblem> {
    let (radius, length, axis) = match *geometry {
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            (radius, length, 2)
        }
        Geometry::Sphere { radius } => (radius, 0.0, 2),
        Geometry::Box { size } => around_box(size.0),
        Geometry::Mesh { .. } => {
            let needs =
                "a cylinder, a capsule, a box or a sphere, because the arms must keep apart";
            return Err(problem(what(), "a mesh", needs));
        }
    };
    if finite(&[radius, length]) && radius > 0.0 && length >= 0.0 {
        let mut along_m = Vector3::zeros();
        along_m[axis] = length / 2.0;
        Ok((radius, along_m))
    } else {
        Err(problem(
            what(),
            format!("radius {radius}, length {length}"),
            "a positive radius and a length (m)",
        ))
    }
}

/// Returns radius, length and axis of the capsule around a box: along its longest edge.
fn around_box(edges_m: [f64; 3]) -> (f64, f64, usize) {
    let axis = (0..3)
        .max_by(|a, b| edges_m[*a].total_cmp(&edges_m[*b]))
        .unwrap_or(2);
    let [across_m, other_m] = [edges_m[(axis + 1) % 3], edges_m[(axis + 2) % 3]];
    (libm::hypot(across_m, other_m) / 2.0, edges_m[axis], axis)
}
