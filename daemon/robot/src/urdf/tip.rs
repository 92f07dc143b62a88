//! A hand's fingertips: what they feel with, and where their frames are in their links.

use core::ops::RangeInclusive;
use std::format;
use std::vec;
use std::vec::Vec;

use nalgebra::Vector3;
use shm_schemas::layout::NamedLayout;
use urdf_rs::Geometry;

use super::error::{Misfit, misfit};
use super::tree::Tree;
use crate::robot_file::{FingerEntry, HandEntry};
use crate::skin::{Compression, Skin};

/// Compression at 1 N that a skin may have, m: from hard rubber to foam.
const COMPRESSION_M: RangeInclusive<f64> = 1e-6..=0.01;
/// Exponent that it may have: softer than a dome to stiffer than any linear spring makes no skin.
const EXPONENT: RangeInclusive<f64> = 0.2..=1.0;

/// What the fingertips feel with.
pub(super) fn skin(entry: &HandEntry) -> Result<Skin, Misfit> {
    let Some(said) = &entry.skin else {
        return Ok(Skin::DOME_41);
    };
    let item = |what: &str| format!("the skin's {what} of palm `{}`", entry.palm);
    let layout = said.layout.parse().map_err(|_| {
        misfit(
            item("layout"),
            format!("{:?}", said.layout),
            NamedLayout::FORMS,
        )
        .of_robot_file()
    })?;
    if !COMPRESSION_M.contains(&said.compression_m) {
        let needs = format!("{COMPRESSION_M:?} m");
        let wrong = misfit(item("compression_m"), said.compression_m, needs);
        return Err(wrong.of_robot_file());
    }
    if !EXPONENT.contains(&said.exponent) {
        let needs = format!("{EXPONENT:?}");
        let wrong = misfit(item("exponent"), said.exponent, needs);
        return Err(wrong.of_robot_file());
    }
    Ok(Skin {
        layout,
        compression: Compression {
            at_1n_m: said.compression_m,
            exponent: said.exponent,
        },
    })
}

/// Where the tip frame's origin is in its link, m.
pub(super) fn tip_origin_m(entry: &FingerEntry, radius_m: f64) -> Result<Vector3<f64>, Misfit> {
    let Some(face_m) = entry.face_m.map(Vector3::from) else {
        return Ok(Vector3::from(entry.dome_m.unwrap_or_default()));
    };
    let item = || format!("the face of fingertip `{}`", entry.tip);
    let facing = entry.facing.map(Vector3::from);
    let out = facing.and_then(|facing| facing.try_normalize(1e-9));
    match out {
        Some(out) if entry.dome_m.is_none() => Ok(face_m - out * radius_m),
        Some(_) => Err(misfit(item(), "given beside `dome_m`", "one of both").of_robot_file()),
        None => Err(misfit(item(), "given without `facing`", "both").of_robot_file()),
    }
}

/// From the tip frame's origin to the middle of a fingertip's face: what the robot file says, else what the skin's layout says if it
/// is no dome, else the radius of the one collision sphere of its link, metres.
pub(super) fn tip_radius_m(
    tree: &Tree,
    entry: &FingerEntry,
    layout: NamedLayout,
) -> Result<f64, Misfit> {
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
    let said = entry
        .dome_radius_m
        .or((!layout.is_dome()).then(|| layout.depth_m()));
    let radii = said.map_or(spheres, |radius_m| vec![radius_m]);
    match radii[..] {
        [radius] if radius.is_finite() && radius > 0.0 => Ok(radius),
        _ => Err(misfit(
            format!("the collision of link `{tip_link}`"),
            format!("spheres of radius {radii:?}"),
            "exactly one sphere of positive radius, the dome (m), or `dome_radius_m` in the robot file",
        )),
    }
}
