//! Default positions and sizes for clients: those of the scenes of `atas-sim run --scene`.
//!
//! Inputs: the scene of a task and a hand. Outputs: positions and sizes. The numbers are copied
//! here so that a client needs no simulator; a test compares them with the simulator.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use shm_schemas::Hand;

use crate::goal::Target;

/// Scenes of tasks with the default objects of the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefaultScene {
    /// A block on a plate, and an empty plate next to it.
    PickPlace,
    /// A cap on the neck of a clamped bottle.
    Screw,
    /// A cap on a stand, and a free bottle between the hands.
    Assembly,
}

/// Data of a scene for clients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nominal {
    /// First object, which is carried or turned.
    pub object: Target,
    /// Destination; an object without one stays at its position.
    pub place: Target,
    /// Width of the second object, the bottle, m; 0 if there is none.
    pub bottle_width_m: f64,
}

impl DefaultScene {
    /// All scenes.
    pub const ALL: [Self; 3] = [Self::PickPlace, Self::Screw, Self::Assembly];

    /// Returns the name for `atas-sim run --scene`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PickPlace => "pick-place",
            Self::Screw => "screw",
            Self::Assembly => "assembly",
        }
    }

    /// Returns the data for this hand. Positions of the two hands mirror each other.
    ///
    /// ```
    /// use atas_client::scenes::DefaultScene;
    /// use shm_schemas::Hand;
    ///
    /// let place = |hand| DefaultScene::PickPlace.nominal(hand).object.at_m;
    /// assert_eq!(place(Hand::LEFT)[1], -place(Hand::RIGHT)[1], "the hands mirror each other");
    /// ```
    #[must_use]
    pub fn nominal(self, hand: Hand) -> Nominal {
        let side = if hand == Hand::LEFT { 1.0 } else { -1.0 };
        let at = |[x_m, out_m, z_m]: [f64; 3], yaw_rad, width_m| Target {
            // The sum avoids a negative zero in the middle.
            at_m: [x_m, side * out_m + 0.0, z_m],
            yaw_rad,
            width_m,
            ..Target::default()
        };
        match self {
            Self::PickPlace => Nominal {
                object: at([0.32, 0.15, 0.0445], FRAC_PI_2, 0.05),
                place: at([0.32, 0.27, 0.0445], FRAC_PI_2, 0.05),
                bottle_width_m: 0.0,
            },
            Self::Screw => {
                let cap = at([0.34, 0.12, 0.12], FRAC_PI_2, 0.03);
                Nominal {
                    object: cap,
                    place: cap,
                    bottle_width_m: 0.06,
                }
            }
            Self::Assembly => {
                let yaw_rad = -side * FRAC_PI_3;
                Nominal {
                    object: at([0.32, 0.18, 0.05], yaw_rad, 0.03),
                    place: at([0.38, 0.0, 0.12], yaw_rad, 0.03),
                    bottle_width_m: 0.06,
                }
            }
        }
    }

    /// Returns the defaults as text for `--help`.
    #[must_use]
    pub fn help(self) -> String {
        let nominal = self.nominal(Hand::RIGHT);
        let at = |target: &Target| {
            let [x, y, z] = target.at_m;
            format!("{x:.2},{y:.2},{z:.4}")
        };
        let mut text = format!(
            "What is not given is taken to be as `atas-sim run --scene {}` sets it before the two-hand arm; before another robot, \
             give what the simulator prints. For the right hand, the left one being its mirror image:\n  the fingertips close at {}, yaw {:.0}°, on {:.0} mm",
            self.name(),
            at(&nominal.object),
            nominal.object.yaw_rad.to_degrees(),
            nominal.object.width_m * 1e3,
        );
        if self != Self::Screw {
            text += &format!("\n  they let go at {}", at(&nominal.place));
        }
        if self == Self::Assembly {
            let width_mm = nominal.bottle_width_m * 1e3;
            text += &format!("\n  the bottle is {width_mm:.0} mm wide");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::HandSide;
    use sim_backend::{GraspHint, Object, Scene};

    #[test]
    fn defaults_equal_the_simulator() {
        let object = |name| Object::built_in(name).expect("built in");
        let scene = |usual, side| match usual {
            DefaultScene::PickPlace => Scene::pick_place(object(Scene::OBJECT), side),
            DefaultScene::Screw => Scene::screw(object(Scene::CAP), object(Scene::BOTTLE), side),
            DefaultScene::Assembly => {
                Scene::assembly(object(Scene::CAP), object(Scene::BOTTLE), side)
            }
        };
        let check = |usual: DefaultScene, reported: &Target, set: &GraspHint| {
            let reported = [
                reported.at_m.as_slice(),
                &[reported.yaw_rad, reported.width_m],
            ]
            .concat();
            let set = [set.from_m.as_slice(), &[set.yaw_rad, set.width_m]].concat();
            for (reported, set) in reported.iter().zip(&set) {
                assert!(
                    (reported - set).abs() < 1e-9,
                    "{usual:?}: {reported} and {set}"
                );
            }
        };
        for (usual, side) in DefaultScene::ALL
            .into_iter()
            .flat_map(|u| HandSide::BOTH.map(|s| (u, s)))
        {
            let nominal = usual.nominal(Hand::BOTH[side.index()]);
            let scene = scene(usual, side);
            let first = scene.grasp_hint(0).expect("an object");
            check(usual, &nominal.object, &first);
            if usual != DefaultScene::Screw {
                check(usual, &nominal.place, &scene.place.expect("a place"));
                let bottle = scene.grasp_hint(1).map_or(0.0, |hint| hint.width_m);
                assert!((nominal.bottle_width_m - bottle).abs() < 1e-9, "{usual:?}");
            }
        }
    }
}
