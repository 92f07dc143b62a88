//! Sensor layout of a hand: from the robot file, by name, or defined by the user.

use robot_model::HandModel;
use serde::{Deserialize, Serialize};
use shm_schemas::Layout;

const ROBOT_LAYOUT: &str = "robot";

/// Layout of a hand's fingertips.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum LayoutChoice {
    /// `robot`, or a [`shm_schemas::layout::NamedLayout`].
    Named(String),
    /// Defined by the user.
    Custom(CustomLayout),
}

/// Layout defined by its elements. Tangents follow from the normals by the rule of
/// [`shm_schemas::layout`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CustomLayout {
    /// Outward normals of the elements, unit vectors in the fingertip frame.
    pub normals: Vec<[f64; 3]>,
    /// Dome: distance of the elements from its centre, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Other shapes: positions of the elements in the fingertip frame, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub positions_m: Option<Vec<[f64; 3]>>,
    /// Sensing area of one element, m².
    pub element_area_m2: f64,
}

impl LayoutChoice {
    /// The layout of the robot file.
    #[must_use]
    pub fn from_robot() -> Self {
        Self::Named(ROBOT_LAYOUT.to_owned())
    }

    /// The layout, if it is valid.
    #[must_use]
    pub fn resolve(&self, hand: &HandModel) -> Option<Layout> {
        match self {
            Self::Named(name) if name == ROBOT_LAYOUT => Some(hand.skin().layout.layout()),
            Self::Named(name) => Layout::from_name(name),
            Self::Custom(custom) => custom.resolve(),
        }
    }

    /// Returns true if the choice is valid for any robot.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        match self {
            Self::Named(name) => name == ROBOT_LAYOUT || Layout::from_name(name).is_some(),
            Self::Custom(custom) => custom.resolve().is_some(),
        }
    }
}

impl CustomLayout {
    fn resolve(&self) -> Option<Layout> {
        let is_size = |size: f64| size > 0.0 && size < 1.0;
        if !is_size(self.element_area_m2) {
            return None;
        }
        let normals = self.normals.iter().copied();
        match (self.radius_m, &self.positions_m) {
            (Some(radius_m), None) if is_size(radius_m) => {
                let elements = normals.map(|normal| (normal, normal.map(|d| d * radius_m)));
                Layout::from_elements(elements, self.element_area_m2)
            }
            (None, Some(positions_m)) if positions_m.len() == self.normals.len() => {
                let elements = normals.zip(positions_m.iter().copied());
                Layout::from_elements(elements, self.element_area_m2)
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::capacity::ELEMENTS;

    fn dome(normals: &[[f64; 3]]) -> CustomLayout {
        CustomLayout {
            normals: normals.to_vec(),
            radius_m: Some(0.015),
            positions_m: None,
            element_area_m2: 1e-4,
        }
    }

    fn custom(normals: &[[f64; 3]], positions_m: &[[f64; 3]]) -> CustomLayout {
        CustomLayout {
            radius_m: None,
            positions_m: Some(positions_m.to_vec()),
            ..dome(normals)
        }
    }

    #[test]
    fn custom_copy_of_built_in_layout_hashes_equally() {
        for name in ["dome-41", "flat-3x4-4.5", "cylinder-2x5-3-8"] {
            let layout = Layout::from_name(name).expect("known");
            let (normals, positions_m) = (
                &layout.normal[..layout.count],
                &layout.position_m[..layout.count],
            );
            let own = custom(normals, positions_m).resolve().expect("sound");
            assert_eq!(own.hash(), layout.hash(), "{name}");
        }
        let built_in = Layout::dome_41();
        let own = dome(&built_in.normal[..built_in.count]).resolve();
        assert_eq!(own.expect("sound").hash(), built_in.hash());
    }

    #[test]
    fn invalid_layout_is_rejected() {
        for normals in [
            vec![],
            vec![[0.0, 0.0, 0.9]],
            vec![[f64::NAN, 0.0, 1.0]],
            vec![[1.0, 0.0, 0.0]],
            vec![[0.0, 0.0, 1.0]; ELEMENTS + 1],
        ] {
            assert_eq!(dome(&normals).resolve(), None, "{normals:?}");
        }
        let out = [[0.0, 0.0, 1.0]];
        assert_eq!(custom(&out, &[]).resolve(), None);
        assert_eq!(custom(&out, &[[0.0, f64::INFINITY, 0.01]]).resolve(), None);
        let both = CustomLayout {
            radius_m: Some(0.015),
            ..custom(&out, &[[0.0, 0.0, 0.015]])
        };
        assert_eq!(both.resolve(), None);
    }
}
