//! Collision shapes of a URDF as capsules, and the dome's radius.

use std::format;
use std::string::String;
use std::vec::Vec;

use nalgebra::Vector3;
use urdf_rs::Geometry;

use super::error::{Misfit, misfit};
use super::framed::Framed;
use super::tree::{Tree, finite, transform};
use crate::capsule::{CAPSULES_MAX, Capsule, Capsules};

/// Radius of the one collision sphere of a tip link, metres.
pub(super) fn dome_radius(tree: &Tree, tip_link: &str) -> Result<f64, Misfit> {
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

/// The collision capsules of every link that a hand's frames move, each in its frame.
pub(super) fn load_capsules(tree: &Tree, frames: &[Framed]) -> Result<Capsules, Misfit> {
    let mut capsules = Capsules::new();
    for link in &tree.robot().links {
        let Some((mover, path)) = tree.mover(&link.name)? else {
            continue;
        };
        let Some(index) = frames.iter().position(|it| it.joint.name == mover.name) else {
            continue;
        };
        let framed = &frames[index];
        for collision in &link.collision {
            let what = || format!("the collision of link `{}`", link.name);
            let (radius_m, half_length_m) = capsule_size(&collision.geometry, what)?;
            let frame_from_shape = framed
                .frame_from_link
                .then(&path)
                .then(&transform(&collision.origin, what)?);
            let end = |sign: f64| frame_from_shape.point(&(Vector3::z() * (sign * half_length_m)));
            let capsule = Capsule {
                a_m: end(-1.0),
                b_m: end(1.0),
                radius_m,
                joint: framed.driver,
            };
            if !capsules.push(capsule, index) {
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
fn capsule_size(geometry: &Geometry, what: impl Fn() -> String) -> Result<(f64, f64), Misfit> {
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
