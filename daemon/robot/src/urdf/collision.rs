//! Collision shapes of a URDF as capsules, and the dome's radius.

use std::format;
use std::string::String;
use std::vec::Vec;

use nalgebra::Vector3;
use urdf_rs::Geometry;

use super::error::{ModelError, misfit};
use super::tree::{Tree, finite, transform};
use crate::capsule::{CAPSULES_MAX, Capsule, Capsules};
use crate::sizes::HAND_JOINTS;
use crate::transform::Transform;

/// Radius of the one collision sphere of a tip link, metres.
pub(super) fn dome_radius(tree: &Tree, tip_link: &str) -> Result<f64, ModelError> {
    let spheres: Vec<f64> = tree
        .link(tip_link)?
        .collision
        .iter()
        .filter_map(|collision| match collision.geometry {
            Geometry::Sphere { radius } => Some(radius),
            _ => None,
        })
        .collect();
    match spheres[..] {
        [radius] if radius.is_finite() && radius > 0.0 => Ok(radius),
        _ => Err(misfit(
            format!("the collision of link `{tip_link}`"),
            format!("spheres of radius {spheres:?}"),
            "exactly one sphere of positive radius, the dome (m)",
        )),
    }
}

/// The collision capsules of every link that a hand's joints move, each in the frame of its joint.
pub(super) fn load_capsules(
    tree: &Tree,
    names: &[&str; HAND_JOINTS],
    joint_from_link: &[Transform; HAND_JOINTS],
) -> Result<Capsules, ModelError> {
    let mut capsules = Capsules::new();
    for link in &tree.robot().links {
        let Some((mover, path)) = tree.mover(&link.name)? else {
            continue;
        };
        let Some(joint) = names.iter().position(|name| *name == mover.name) else {
            continue;
        };
        for collision in &link.collision {
            let what = || format!("the collision of link `{}`", link.name);
            let (radius_m, half_length_m) = capsule_size(&collision.geometry, what)?;
            let joint_from_shape = joint_from_link[joint]
                .then(&path)
                .then(&transform(&collision.origin, what)?);
            let end = |sign: f64| joint_from_shape.point(&(Vector3::z() * (sign * half_length_m)));
            if !capsules.push(Capsule {
                a_m: end(-1.0),
                b_m: end(1.0),
                radius_m,
                joint,
            }) {
                return Err(misfit(
                    what(),
                    format!("shape {} of its hand", CAPSULES_MAX + 1),
                    format!("at most {CAPSULES_MAX} shapes per hand"),
                ));
            }
        }
    }
    Ok(capsules)
}

/// Radius and half length of the capsule around a shape, metres.
fn capsule_size(geometry: &Geometry, what: impl Fn() -> String) -> Result<(f64, f64), ModelError> {
    let (radius, length) = match *geometry {
        Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
            (radius, length)
        }
        Geometry::Sphere { radius } => (radius, 0.0),
        Geometry::Box { .. } => {
            return Err(misfit(what(), "a box", "a cylinder, a capsule or a sphere"));
        }
        Geometry::Mesh { .. } => {
            return Err(misfit(
                what(),
                "a mesh",
                "a cylinder, a capsule or a sphere",
            ));
        }
    };
    if finite(&[radius, length]) && radius > 0.0 && length >= 0.0 {
        Ok((radius, length / 2.0))
    } else {
        Err(misfit(
            what(),
            format!("radius {radius}, length {length}"),
            "a positive radius and a length (m)",
        ))
    }
}
