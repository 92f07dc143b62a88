//! Objects, parsed from TOML and validated.
//!
//! ```toml
//! name = "paper-box"
//! mass_kg = 0.020
//! friction = 0.4                     # static, against a fingertip
//! stiffness_n_m = 1500.0             # under one fingertip; omit for a rigid object
//! crush_n = 1.5                      # omit if the object cannot be crushed
//! shape = { kind = "box", size_m = [0.05, 0.05, 0.05] }
//! # or: shape = { kind = "cylinder", radius_m = 0.03, height_m = 0.12 }
//! centre_of_mass_m = [0.0, 0.0, -0.01]   # from the middle of the shape; default 0
//! ```
//!
//! A cap has a `thread`, its bottle has a `neck`; both are upright cylinders:
//!
//! ```toml
//! # closes = "anticlockwise" for a left-hand thread
//! thread = { friction_n_m = 0.015, closing_deg = 240, pitch_m = 0.003 }
//! neck = { rim_m = 0.11 }   # height of the lower edge of an open cap above the bottle's foot
//! ```
//!
//! The x axis is the closing axis of a grasp; z points up. Unknown keys and values out of range are
//! rejected.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::Deserialize;

use crate::name::nearest_hint;
use crate::shape::Shape;
use crate::thread::Thread;
use parts::{NeckFile, ThreadFile};

mod parts;

/// Validated object. A rigid object has infinite stiffness, an uncrushable one infinite `crush_n`.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Name, at most 31 bytes.
    pub name: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Static friction coefficient against a fingertip.
    pub friction: f64,
    /// Stiffness under one fingertip, N/m.
    pub stiffness_n_m: f64,
    /// Normal force of one fingertip that crushes the object, N.
    pub crush_n: f64,
    /// Outline; for a bottle, the body below the shoulder.
    pub shape: Shape,
    /// Centre of mass, from the middle of the shape, m.
    pub centre_of_mass_m: Vector3<f64>,
    /// Thread, for a cap.
    pub thread: Option<Thread>,
    /// Neck, for a bottle with a cap.
    pub neck: Option<Neck>,
}

/// Neck of a bottle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neck {
    /// Height of the cap's lower edge above the bottle's foot when the threads meet, m.
    pub rim_m: f64,
}

/// Reason why an object could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum ObjectError {
    /// Unknown built-in name.
    #[error(
        "unknown object: {name:?} is not built in, needs one of {known}{hint}, or the path of a \
         file"
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Built-in names.
        known: String,
        /// Nearest name as text; empty if none is near.
        hint: String,
    },
    /// Unreadable file.
    #[error(
        "could not read the object file {path:?}: {source}; check the path and its permissions"
    )]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Invalid TOML or unknown keys.
    #[error(
        "could not parse the object {origin}: {message}; see the examples in sim-backend/objects"
    )]
    Malformed {
        /// File, or built-in name.
        origin: String,
        /// Message of the parser, with the position in the text.
        message: String,
    },
    /// Value out of range.
    #[error(
        "object {origin} rejected: {key} is {value}, needs {lower} to {upper}; correct the file"
    )]
    OutOfRange {
        /// File, or built-in name.
        origin: String,
        /// Key of the value.
        key: &'static str,
        /// Rejected value.
        value: f64,
        /// Lowest allowed value.
        lower: f64,
        /// Highest allowed value.
        upper: f64,
    },
}

macro_rules! built_in {
    ($(#[$doc:meta])* $list:ident: $($name:literal),* $(,)?) => {
        $(#[$doc])*
        const $list: &[(&str, &str)] = &[$(($name, include_str!(concat!("../objects/", $name, ".toml")))),*];
    };
}
built_in!(
    /// Built-in objects to grasp: name and file.
    BUILT_IN:
    "wood",
    "slippery-200",
    "slippery-50",
    "paper-box",
    "sponge",
    "bottle",
    "heavy-block",
    "filled-paper-box",
);
built_in!(
    /// Built-in parts to assemble: name and file.
    PARTS: "cap", "open-bottle",
);

/// Allowed ranges. Design choice: they cover what two fingertips can hold and keep the simulation
/// stable.
mod range {
    pub(super) const MASS_KG: [f64; 2] = [0.0125, 5.0];
    /// Lighter than other objects: the simulation raises a cap's inertia.
    pub(super) const CAP_MASS_KG: [f64; 2] = [0.008, 0.1];
    pub(super) const FRICTION: [f64; 2] = [0.05, 2.0];
    pub(super) const STIFFNESS_N_M: [f64; 2] = [100.0, 1e6];
    pub(super) const CRUSH_N: [f64; 2] = [0.1, 1e3];
    pub(super) const LENGTH_M: [f64; 2] = [0.01, 0.3];
    /// Largest offset of the centre of mass, as a share of the distance to the surface. Objects
    /// beyond it tip over.
    pub(super) const CENTRE_OFFSET_SHARE_MAX: f64 = 0.9;
    pub(super) const NAME_BYTES: [f64; 2] = [1.0, 31.0];
}

const CENTRE_KEYS: [&str; 3] = [
    "centre_of_mass_m[0]",
    "centre_of_mass_m[1]",
    "centre_of_mass_m[2]",
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    name: String,
    mass_kg: f64,
    friction: f64,
    stiffness_n_m: Option<f64>,
    crush_n: Option<f64>,
    shape: ShapeFile,
    #[serde(default)]
    centre_of_mass_m: [f64; 3],
    thread: Option<ThreadFile>,
    neck: Option<NeckFile>,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum ShapeFile {
    Box { size_m: [f64; 3] },
    Cylinder { radius_m: f64, height_m: f64 },
}

impl Object {
    /// Returns the names of the built-in objects to grasp: six can be held, two must be refused.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// Returns the names of the built-in parts to assemble: a cap and its bottle.
    pub fn part_names() -> impl Iterator<Item = &'static str> {
        PARTS.iter().map(|(name, _)| *name)
    }

    /// Returns a built-in object.
    ///
    /// # Errors
    /// [`ObjectError::Unknown`] if the name is not built in.
    ///
    /// ```
    /// # use sim_backend::Object;
    /// let wood = Object::built_in("wood").expect("a built-in object");
    /// assert!(wood.required_normal_n() < wood.crush_n, "friction holds it without crushing");
    /// assert!(Object::built_in("cloud").is_err());
    /// ```
    pub fn built_in(name: &str) -> Result<Self, ObjectError> {
        match BUILT_IN
            .iter()
            .chain(PARTS)
            .find(|(known, _)| *known == name)
        {
            Some((_, text)) => Self::parse(text, name),
            None => Err(unknown(name)),
        }
    }

    /// Reads an object from a file.
    ///
    /// # Errors
    /// If the file is unreadable or malformed, or a value is out of range.
    pub fn from_file(path: &Path) -> Result<Self, ObjectError> {
        let text = atas_text_file::read(path).map_err(|source| ObjectError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Returns a built-in object, or reads a file if the text looks like a path.
    ///
    /// # Errors
    /// As [`Object::built_in`] and [`Object::from_file`].
    pub fn from_name_or_file(text: &str) -> Result<Self, ObjectError> {
        let is_path = text.contains(std::path::MAIN_SEPARATOR) || text.ends_with(".toml");
        if is_path {
            Self::from_file(Path::new(text))
        } else {
            Self::built_in(text)
        }
    }

    /// Parses the text of an object file; errors name its `origin`.
    ///
    /// # Errors
    /// [`ObjectError::Malformed`], [`ObjectError::OutOfRange`].
    pub fn parse(text: &str, origin: &str) -> Result<Self, ObjectError> {
        let malformed = |e: toml::de::Error| ObjectError::Malformed {
            origin: origin.into(),
            message: e.to_string(),
        };
        let file: ObjectFile = toml::from_str(text).map_err(malformed)?;
        let check = |key, value, range| check_range(origin, key, value, range);
        check(
            "the length of name in bytes",
            file.name.len() as f64,
            range::NAME_BYTES,
        )?;
        let shape = file.shape.validate(origin)?;
        let centre_of_mass_m = check_centre_m(&shape, file.centre_of_mass_m, origin)?;
        let masses_kg = match file.thread {
            Some(_) => range::CAP_MASS_KG,
            None => range::MASS_KG,
        };
        Ok(Self {
            mass_kg: check("mass_kg", file.mass_kg, masses_kg)?,
            friction: check("friction", file.friction, range::FRICTION)?,
            stiffness_n_m: or_infinite(file.stiffness_n_m, |k| {
                check("stiffness_n_m", k, range::STIFFNESS_N_M)
            })?,
            crush_n: or_infinite(file.crush_n, |force| {
                check("crush_n", force, range::CRUSH_N)
            })?,
            thread: file
                .thread
                .map(|thread| thread.validate(&shape, origin))
                .transpose()?,
            neck: file
                .neck
                .map(|neck| neck.validate(&shape, origin))
                .transpose()?,
            shape,
            centre_of_mass_m,
            name: file.name,
        })
    }

    /// Returns the normal force per fingertip that two fingertips need to carry the object, m·g /
    /// (2·μ), N.
    #[must_use]
    pub fn required_normal_n(&self) -> f64 {
        self.mass_kg * crate::body::GRAVITY_M_S2 / (2.0 * self.friction)
    }
}

impl ShapeFile {
    fn validate(self, origin: &str) -> Result<Shape, ObjectError> {
        let length = |key, value| check_range(origin, key, value, range::LENGTH_M);
        match self {
            Self::Box { size_m: [x, y, z] } => {
                let size_m = Vector3::new(
                    length("shape.size_m[0]", x)?,
                    length("shape.size_m[1]", y)?,
                    length("shape.size_m[2]", z)?,
                );
                Ok(Shape::Box {
                    half_m: size_m / 2.0,
                })
            }
            Self::Cylinder { radius_m, height_m } => Ok(Shape::Cylinder {
                radius_m: length("twice shape.radius_m", 2.0 * radius_m)? / 2.0,
                half_height_m: length("shape.height_m", height_m)? / 2.0,
            }),
        }
    }
}

/// Returns the centre of mass; rejects one too close to the surface.
fn check_centre_m(
    shape: &Shape,
    centre_m: [f64; 3],
    origin: &str,
) -> Result<Vector3<f64>, ObjectError> {
    let width_m = shape.width_m() / 2.0;
    let reach_m = [width_m, width_m, shape.half_height_m()];
    for ((key, centre_m), reach_m) in CENTRE_KEYS.into_iter().zip(centre_m).zip(reach_m) {
        let most_m = range::CENTRE_OFFSET_SHARE_MAX * reach_m;
        check_range(origin, key, centre_m, [-most_m, most_m])?;
    }
    Ok(centre_m.into())
}

/// Returns the value; rejects values outside the range, and NaN.
fn check_range(
    origin: &str,
    key: &'static str,
    value: f64,
    [lower, upper]: [f64; 2],
) -> Result<f64, ObjectError> {
    if value >= lower && value <= upper {
        return Ok(value);
    }
    Err(ObjectError::OutOfRange {
        origin: origin.into(),
        key,
        value,
        lower,
        upper,
    })
}

fn or_infinite(
    value: Option<f64>,
    check: impl FnOnce(f64) -> Result<f64, ObjectError>,
) -> Result<f64, ObjectError> {
    value.map_or(Ok(f64::INFINITY), check)
}

fn unknown(name: &str) -> ObjectError {
    let known: Vec<&str> = Object::names().chain(Object::part_names()).collect();
    ObjectError::Unknown {
        name: name.into(),
        hint: nearest_hint(name, &known),
        known: known.join(", "),
    }
}
