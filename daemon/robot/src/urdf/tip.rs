//! Loads the fingertips of a hand: their skin, and their frames in their links.

use core::ops::RangeInclusive;
use std::format;
use std::vec;
use std::vec::Vec;

use nalgebra::Vector3;
use shm_schemas::layout::NamedLayout;
use urdf_rs::Geometry;

use super::error::{ModelProblem, problem};
use super::tree::Tree;
use crate::robot_file::{FingerEntry, HandEntry};
use crate::skin::{Compression, Skin};

/// Permitted compression at 1 N, m: from hard rubber to foam.
const COMPRESSION_M: RangeInclusive<f64> = 1e-6..=0.01;
/// Permitted exponent of compression, from softer than a dome to a linear spring.
const EXPONENT: RangeInclusive<f64> = 0.2..=1.0;

/// Returns the skin of the fingertips.
pub(super) fn skin(entry: &HandEntry) -> Result<Skin, ModelProblem> {
    let Some(message) = &entry.skin else {
        return Ok(Skin::DOME_41);
    };
    let item = |what: &str| format!("the skin's {what} of palm `{}`", entry.palm);
    let layout = message.layout.parse().map_err(|_| {
        problem(
            item("layout"),
            format!("{:?}", message.layout),
            NamedLayout::FORMS,
        )
        .in_robot_file()
    })?;
    if !COMPRESSION_M.contains(&message.compression_m) {
        let needs = format!("{COMPRESSION_M:?} m");
        let wrong = problem(item("compression_m"), message.compression_m, needs);
        return Err(wrong.in_robot_file());
    }
    if !EXPONENT.contains(&message.exponent) {
        let needs = format!("{EXPONENT:?}");
        let wrong = problem(item("exponent"), message.exponent, needs);
        return Err(wrong.in_robot_file());
    }
    Ok(Skin {
        layout,
        compression: Compression {
            at_1n_m: message.compression_m,
            exponent: message.exponent,
        },
    })
}

/// Returns the origin of the tip frame in its link, m.
pub(super) fn tip_origin_m(
    entry: &FingerEntry,
    radius_m: f64,
) -> Result<Vector3<f64>, ModelProblem> {
    let Some(face_m) = entry.face_m.map(Vector3::from) else {
        return Ok(Vector3::from(entry.dome_m.unwrap_or_default()));
    };
    let item = || format!("the face of fingertip `{}`", entry.tip);
    let facing = entry.facing.map(Vector3::from);
    let out = facing.and_then(|facing| facing.try_normalize(1e-9));
    match out {
        Some(out) if entry.dome_m.is_none() => Ok(face_m - out * radius_m),
        Some(_) => {
            Err(problem(item(), "given together with `dome_m`", "one of both").in_robot_file())
        }
        None => Err(problem(item(), "given without `facing`", "both").in_robot_file()),
    }
}

/// Returns the distance from the tip frame's origin to the centre of the sensing face, metres.
/// Source: the robot file; else the layout of a skin without domes; else the radius of the link's
/// only collision sphere.
pub(super) fn tip_radius_m(
    tree: &Tree,
    entry: &FingerEntry,
    layout: NamedLayout,
) -> Result<f64, ModelProblem> {
    let tip_link = &entry.tip;
    let spheres: Vec<f64> = tree
        .link(tip_link)?
        .collision
        .iter()
        .filter_map(|collision| match collision.geometry {
            Geometry::Sphere { radius } => Some(radius),
            _ => None,
        })
        .collect();
    let message = entry
        .dome_radius_m
        .or((!layout.is_dome()).then(|| layout.depth_m()));
    let radii = message.map_or(spheres, |radius_m| vec![radius_m]);
    match radii[..] {
        [radius] if radius.is_finite() && radius > 0.0 => Ok(radius),
        _ => Err(problem(
            format!("the collision of link `{tip_link}`"),
            format!("spheres of radius {radii:?}"),
            "exactly one sphere of positive radius, the dome (m), or `dome_radius_m` in the robot file",
        )),
    }
}
