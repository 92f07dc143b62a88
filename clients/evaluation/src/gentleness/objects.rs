//! Reference objects, from egg-like to brick-like. The files name the source of every value.

use sim_backend::{Object, ObjectError};

macro_rules! references {
    ($($name:literal),* $(,)?) => {
        /// Name and file of each object, from the gentlest to the hardest.
        const REFERENCES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../objects/", $name, ".toml")))),*];
    };
}
references!(
    "paper-cup",
    "foam",
    "strawberry",
    "plastic-cup",
    "tomato",
    "egg",
    "wood",
    "brick",
);

/// Returns all reference objects.
///
/// # Errors
/// A file is invalid, which a test excludes.
pub fn reference_objects() -> Result<Vec<Object>, ObjectError> {
    let parse = |(name, text): &(&str, &str)| Object::parse(text, name);
    REFERENCES.iter().map(parse).collect()
}

/// Returns a reference object, or a built-in one, or reads a file.
///
/// # Errors
/// The name is unknown, or the file is unreadable or invalid.
pub fn reference_or_other(name: &str) -> Result<Object, ObjectError> {
    match REFERENCES.iter().find(|(known, _)| *known == name) {
        Some((_, text)) => Object::parse(text, name),
        None => Object::from_name_or_file(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_can_hold_every_reference_object() {
        let objects = reference_objects().expect("valid files");
        for (object, (name, _)) in objects.iter().zip(REFERENCES) {
            assert_eq!(object.name, *name);
            let needed_n = object.required_normal_n();
            assert!(
                needed_n < object.crush_n.min(8.0) / 1.5,
                "{name}: {needed_n} N"
            );
        }
        assert_eq!(reference_or_other("egg").expect("known").name, "egg");
        assert!(reference_or_other("moon").is_err());
    }
}
