//! What a client takes for granted where it is told nothing: the scenes that `atas-sim run --scene` sets.
//!
//! In: a task's scene and a hand. Out: places and sizes as that scene tells its clients. The numbers live in
//! [`sim_backend::Scene`] and nowhere else, so that a command without arguments fits a scene without arguments.

use anyhow::Context;
use robot_model::Side;
use sim_backend::{GraspHint, Object, ObjectError, Scene};

/// The scenes of tasks, with the simulator's usual objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Usual {
    PickPlace,
    Screw,
    Assembly,
}

/// What a client is told of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nominal {
    /// The first object: what is carried or turned.
    pub(crate) object: GraspHint,
    /// Where it shall go.
    pub(crate) place: GraspHint,
    /// Width of the second object, the bottle, m; 0 if there is none.
    pub(crate) bottle_width_m: f64,
}

impl Nominal {
    /// Of a scene with an object. An object without a place stays where it is.
    pub(crate) fn of(scene: &Scene) -> anyhow::Result<Self> {
        let object = scene
            .grasp_hint(0)
            .context("a task's scene has an object")?;
        Ok(Self {
            object,
            place: scene.place.unwrap_or(object),
            bottle_width_m: scene.grasp_hint(1).map_or(0.0, |hint| hint.width_m),
        })
    }
}

impl Usual {
    /// Its name for `atas-sim run --scene`.
    fn name(self) -> &'static str {
        match self {
            Self::PickPlace => "pick-place",
            Self::Screw => "screw",
            Self::Assembly => "assembly",
        }
    }

    fn scene(self, side: Side) -> Result<Scene, ObjectError> {
        let built_in = Object::built_in;
        Ok(match self {
            Self::PickPlace => Scene::pick_place(built_in(Scene::OBJECT)?, side),
            Self::Screw => Scene::screw(built_in(Scene::CAP)?, built_in(Scene::BOTTLE)?, side),
            Self::Assembly => {
                Scene::assembly(built_in(Scene::CAP)?, built_in(Scene::BOTTLE)?, side)
            }
        })
    }

    /// What a client is told of it when this hand acts.
    pub(crate) fn nominal(self, side: Side) -> anyhow::Result<Nominal> {
        Nominal::of(&self.scene(side)?)
    }

    /// The defaults in words, for `--help`.
    pub(crate) fn help(self) -> String {
        // The built-in scenes are whole: a test reads this text.
        let Ok(nominal) = self.nominal(Side::Right) else {
            return String::new();
        };
        let at = |hint: &GraspHint| {
            let [x, y, z] = hint.from_m;
            format!("{x:.2},{y:.2},{z:.4}")
        };
        let mut text = format!(
            "What is not given is taken to be as `atas-sim run --scene {}` sets it. For the right hand, the left one being \
             its mirror image:\n  the fingertips close at {}, yaw {:.0}°, on {:.0} mm",
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
