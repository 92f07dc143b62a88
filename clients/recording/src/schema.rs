//! Schemas of recorded payloads: place, type, shape, unit and meaning of every field, as text in
//! the file. A reader can decode the bytes without ATAS.

use std::collections::HashSet;

use shm_schemas::schema::{CodeType, Field, PayloadType, Type};

/// Header of a schema.
const HEAD: &str = "\
# Plain bytes, little-endian, without gaps. A payload: its name, its bytes, then a line for each field:
#   name: offset, bytes, type, shape, unit: meaning
# A shape is [] for one value and [a, b] for a rows of b, the last index moving fastest; a unit is - where there is none.
# A code is a u32; its values stand below. A text is UTF-8, filled up with zeros.
";

/// Units by name or suffix of a field, the longest first.
const UNITS: [(&str, &str); 18] = [
    // Joint values: in metres for a prismatic joint.
    ("stiffness", "N·m/rad; N/m of a joint that slides"),
    ("velocity", "rad/s; m/s of a joint that slides"),
    ("commanded_position", "rad; m of a joint that slides"),
    ("position", "rad; m of a joint that slides"),
    ("stiffness_n_m", "N/m"),
    ("effort", "N·m; N of a joint that slides"),
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

/// Returns the schema of a payload and of all its parts.
pub(crate) fn schema(of: &'static PayloadType) -> String {
    let mut text = HEAD.to_owned();
    let mut reported = HashSet::new();
    describe(of, &mut text, &mut reported);
    text
}

/// Describes a payload, then its parts, each once.
fn describe(of: &'static PayloadType, text: &mut String, reported: &mut HashSet<&'static str>) {
    *text += &format!("\n{}: {} bytes: {}\n", of.wire, of.size, words(of.doc));
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
            words(field.doc)
        );
        parts.push(element);
    }
    for part in parts {
        match part {
            Type::Payload(part) if reported.insert(part.name) => describe(part, text, reported),
            Type::Code(code) if reported.insert(code.name) => values(code, text),
            _ => {}
        }
    }
}

fn values(code: &CodeType, text: &mut String) {
    *text += &format!("\n{}: a code: {}\n", code.name, words(code.doc));
    for value in code.values {
        *text += &format!("  {}: {}: {}\n", value.number, value.text, words(value.doc));
    }
}

/// Returns the element type of an array and its dimensions.
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

/// Returns the unit from the name of a field.
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

    /// Numbers without a unit: fractions, counts, directions, and values whose unit another field
    /// names.
    const UNITLESS: [&str; 11] = [
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
    fn schema_lists_types_shapes_units_and_meaning() {
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
    fn every_measured_number_has_a_unit() {
        fn look(of: &'static PayloadType) {
            for field in of.fields {
                match element(&field.kind).0 {
                    Type::F32 | Type::F64 => assert!(
                        unit(field) != "-" || UNITLESS.contains(&field.name),
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
