//! What is told of a recorded payload in its file: every field's place, type, shape, unit and meaning, so that the bytes can be
//! read where nothing of ATAS is at hand.

use std::collections::HashSet;

use shm_schemas::schema::{CodeType, Field, PayloadType, Type};

/// What a schema begins with.
const HEAD: &str = "\
# Plain bytes, little-endian, without gaps. A payload: its name, its bytes, then a line for each field:
#   name: offset, bytes, type, shape, unit: meaning
# A shape is [] for one value and [a, b] for a rows of b, the last index moving fastest; a unit is - where there is none.
# A code is a u32; its values stand below. A text is UTF-8, filled up with zeros.
";

/// Units by what a field's name is or ends in, the longest first.
const UNITS: [(&str, &str); 18] = [
    // Of joints: in metres where one slides.
    ("stiffness_n_m_rad", "N·m/rad; N/m of a joint that slides"),
    ("velocity_rad_s", "rad/s; m/s of a joint that slides"),
    ("commanded_rad", "rad; m of a joint that slides"),
    ("position_rad", "rad; m of a joint that slides"),
    ("stiffness_n_m", "N/m"),
    ("effort_n_m", "N·m; N of a joint that slides"),
    ("captured_ns", "ns of the sensors' clock"),
    ("started_ns", "ns of the sensors' clock"),
    ("until_ns", "ns of the sensors' clock"),
    ("_rad", "rad"),
    ("_m_s", "m/s"),
    ("_hz", "Hz"),
    ("_ns", "ns"),
    ("_m2", "m²"),
    ("_s", "s"),
    ("_m", "m"),
    ("_n", "N"),
    ("bytes", "bytes"),
];

/// The schema of a payload with those of all that is in it.
pub(crate) fn schema(of: &'static PayloadType) -> String {
    let mut text = HEAD.to_owned();
    let mut told = HashSet::new();
    describe(of, &mut text, &mut told);
    text
}

/// A payload, then what it is made of, each once.
fn describe(of: &'static PayloadType, text: &mut String, told: &mut HashSet<&'static str>) {
    *text += &format!("\n{}: {} bytes: {}\n", of.wire, of.size, words(of.about));
    let mut parts = Vec::new();
    for field in of.fields {
        let (element, shape) = element(&field.kind);
        *text += &format!(
            "  {}: {}, {}, {}, {shape:?}, {}: {}\n",
            field.name,
            field.offset,
            field.size,
            name(element),
            unit(field),
            words(field.about)
        );
        parts.push(element);
    }
    for part in parts {
        match part {
            Type::Payload(part) if told.insert(part.name) => describe(part, text, told),
            Type::Code(code) if told.insert(code.name) => values(code, text),
            _ => {}
        }
    }
}

fn values(code: &CodeType, text: &mut String) {
    *text += &format!("\n{}: a code: {}\n", code.name, words(code.about));
    for value in code.values {
        *text += &format!(
            "  {}: {}: {}\n",
            value.number,
            value.text,
            words(value.about)
        );
    }
}

/// What an array is made of in the end, and how many of it in each direction.
fn element(kind: &'static Type) -> (&'static Type, Vec<usize>) {
    let (mut kind, mut shape) = (kind, Vec::new());
    while let Type::Array(of, count) = kind {
        shape.push(*count);
        kind = of;
    }
    (kind, shape)
}

fn name(of: &Type) -> String {
    match of {
        Type::F32 => "f32".into(),
        Type::F64 => "f64".into(),
        Type::U32 => "u32".into(),
        Type::U64 => "u64".into(),
        Type::Text(bytes) => format!("text of {bytes} bytes"),
        Type::Code(code) => code.name.into(),
        Type::Payload(part) => part.wire.into(),
        Type::Array(..) => "array".into(),
    }
}

/// The unit that a field's name says.
fn unit(field: &Field) -> &'static str {
    let found = UNITS
        .iter()
        .find(|(ending, _)| field.name.ends_with(ending));
    found.map_or("-", |(_, unit)| unit)
}

fn words(lines: &[&str]) -> String {
    let lines: Vec<&str> = lines.iter().map(|line| line.trim()).collect();
    lines.join(" ").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use shm_schemas::{Payload, TickInputs};

    use super::*;
    use crate::payloads::RECORDED;

    /// Numbers that have no unit: shares, counts, directions, and values whose unit another field names.
    const PLAIN: [&str; 11] = [
        "utilisation",
        "utilisation_now",
        "friction",
        "normal",
        "tangent1",
        "tangent2",
        "hand",
        "value",
        "threshold",
        "limit",
        "progress",
    ];

    #[test]
    fn a_schema_tells_types_shapes_units_and_what_is_in_it() {
        let schema = schema(TickInputs::SCHEMA);
        let size = size_of::<TickInputs>();
        for part in [
            format!(
                "\n{}: {size} bytes: Inputs of one tick",
                TickInputs::TYPE_NAME
            ),
            "  tick: 24, 8, u64, [], -: Index of the tick".to_owned(),
            "frames: ".to_owned(),
            ", atas.HandFrame.v1, [2], -: Frame number".to_owned(),
            ", f32, [4, 64, 3], N: ".to_owned(),
            ", f64, [32], rad; m of a joint that slides: Measured positions".to_owned(),
            "\nOrderKind: a code: ".to_owned(),
            "  1: start: Start".to_owned(),
        ] {
            assert!(schema.contains(&part), "{part:?} in {schema}");
        }
        let once = schema.matches("\natas.HandFrame.v1: ").count();
        assert_eq!(once, 1, "each part once");
    }

    #[test]
    fn every_measured_number_of_a_recording_has_its_unit() {
        fn look(of: &'static PayloadType) {
            for field in of.fields {
                match element(&field.kind).0 {
                    Type::F32 | Type::F64 => assert!(
                        unit(field) != "-" || PLAIN.contains(&field.name),
                        "{}.{} has no unit in its name",
                        of.name,
                        field.name
                    ),
                    Type::Payload(part) => look(part),
                    _ => {}
                }
            }
        }
        RECORDED.iter().for_each(|payload| look(payload));
    }
}
