//! Which sensor layout a hand has: a built-in one by name, or the user's own by its directions.

use serde::{Deserialize, Serialize};
use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// How far from 1 the length of a direction may be: rounding in hand-written files, nothing more. Ours.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The layout of one fingertip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum LayoutChoice {
    /// One of [`Layout::NAMES`].
    Named(String),
    /// The user's own.
    Custom(CustomLayout),
}

/// A layout given by its elements. Tangents follow from the normals by the rule of [`shm_schemas::layout`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CustomLayout {
    /// Outward normal of each element, unit vectors in the tip frame.
    pub normals: Vec<[f64; 3]>,
    /// Distance of the elements from the dome centre, m.
    pub radius_m: f64,
    /// Sensing area of one element, m².
    pub element_area_m2: f64,
}

impl LayoutChoice {
    /// The layout, if the name is known or the user's own is sound.
    #[must_use]
    pub fn resolve(&self) -> Option<Layout> {
        match self {
            Self::Named(name) => Layout::named(name),
            Self::Custom(custom) => custom.resolve(),
        }
    }
}

impl CustomLayout {
    fn resolve(&self) -> Option<Layout> {
        let count = self.normals.len();
        let sizes_make_sense = [self.radius_m, self.element_area_m2]
            .iter()
            .all(|size| *size > 0.0 && *size < 1.0);
        if !(1..=ELEMENTS).contains(&count) || !sizes_make_sense {
            return None;
        }
        let mut layout = Layout {
            count,
            normal: [[0.0; 3]; ELEMENTS],
            tangent1: [[0.0; 3]; ELEMENTS],
            tangent2: [[0.0; 3]; ELEMENTS],
            radius_m: self.radius_m,
            element_area_m2: self.element_area_m2,
        };
        for (element, normal) in self.normals.iter().enumerate() {
            let (tangent1, tangent2) = tangents(*normal)?;
            layout.normal[element] = *normal;
            layout.tangent1[element] = tangent1;
            layout.tangent2[element] = tangent2;
        }
        Some(layout)
    }
}

/// t2 is up (−x) made normal to d, t1 = t2 × d. `None` if d is not a unit vector or points along x.
fn tangents(d: [f64; 3]) -> Option<([f64; 3], [f64; 3])> {
    let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
    // False for NaN as well.
    let is_unit = (length - 1.0).abs() <= UNIT_TOLERANCE;
    let across = (1.0 - d[0] * d[0]).max(0.0).sqrt();
    if !is_unit || across <= UNIT_TOLERANCE {
        return None;
    }
    let t2 = [
        (d[0] * d[0] - 1.0) / across,
        d[0] * d[1] / across,
        d[0] * d[2] / across,
    ];
    let t1 = [
        t2[1] * d[2] - t2[2] * d[1],
        t2[2] * d[0] - t2[0] * d[2],
        t2[0] * d[1] - t2[1] * d[0],
    ];
    Some((t1, t2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn custom(normals: &[[f64; 3]]) -> LayoutChoice {
        LayoutChoice::Custom(CustomLayout {
            normals: normals.to_vec(),
            radius_m: 0.015,
            element_area_m2: 1e-4,
        })
    }

    #[test]
    fn own_layout_with_the_directions_of_a_built_in_one_hashes_equally() {
        let dome = Layout::dome_41();
        let own = custom(&dome.normal[..dome.count]).resolve().expect("sound");
        assert_eq!(own.hash(), dome.hash());
    }

    #[test]
    fn unsound_layouts_are_refused() {
        for normals in [
            vec![],
            vec![[0.0, 0.0, 0.9]],
            vec![[f64::NAN, 0.0, 1.0]],
            vec![[1.0, 0.0, 0.0]],
            vec![[0.0, 0.0, 1.0]; ELEMENTS + 1],
        ] {
            assert_eq!(custom(&normals).resolve(), None, "{normals:?}");
        }
    }
}
