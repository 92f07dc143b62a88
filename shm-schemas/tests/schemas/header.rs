//! The C header matches the schema, and a C compiler confirms every size, offset and checksum.

use shm_schemas::catalogue::{CODES, PAYLOADS};
use shm_schemas::schema::{CodeType, Field, PayloadType, Type};
use shm_schemas::{HandFrame, JointState, Layout, Payload, capacity, service};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use zerocopy::IntoBytes;

const GOLDEN: &str = include_str!("../../atas.h");

/// Fixed start of the header: `#include`s, checksum and layout hash functions.
const HEAD: &str = include_str!("head.h");

/// Converts `ModuleEvent` to `module_event`.
fn snake(name: &str) -> String {
    let mut text = String::new();
    for (i, c) in name.char_indices() {
        if c.is_uppercase() && i > 0 {
            text.push('_');
        }
        text.extend(c.to_lowercase());
    }
    text
}

/// Writes the lines of a documentation comment without Rust links.
fn comment(text: &mut String, indent: &str, about: &[&str]) {
    for line in about {
        let plain = line
            .replace("[`", "")
            .replace("`]", "")
            .replace("crate::", "");
        writeln!(text, "{indent}//{}", plain.replace('`', "").trim_end()).unwrap();
    }
}

/// Returns a C declaration: type, name, dimensions from the outermost to the innermost.
fn declaration(kind: &Type, name: &str) -> String {
    let (mut kind, mut name) = (kind, name.to_owned());
    while let Type::Array(of, count) = kind {
        write!(name, "[{count}]").unwrap();
        kind = of;
    }
    match kind {
        Type::F32 => format!("float {name}"),
        Type::F64 => format!("double {name}"),
        Type::U32 => format!("uint32_t {name}"),
        Type::U64 => format!("uint64_t {name}"),
        Type::Text(bytes) => format!("char {name}[{bytes}]"),
        Type::Code(code) => format!("uint32_t {name}; // enum atas_{}", snake(code.name)),
        Type::Payload(part) => format!("atas_{} {name}", snake(part.name)),
        Type::Array(..) => unreachable!("arrays are unwrapped above"),
    }
}

fn code(text: &mut String, code: &CodeType) {
    let prefix = format!("ATAS_{}", snake(code.name).to_uppercase());
    text.push('\n');
    comment(text, "", code.doc);
    writeln!(text, "enum atas_{} {{", snake(code.name)).unwrap();
    for value in code.values {
        comment(text, "    ", value.doc);
        writeln!(text, "    {prefix}_{} = {},", value.name, value.number).unwrap();
    }
    text.push_str("};\n");
}

fn payload(text: &mut String, payload: &PayloadType) {
    let name = format!("atas_{}", snake(payload.name));
    text.push('\n');
    comment(text, "", payload.doc);
    writeln!(text, "typedef struct {name} {{").unwrap();
    for Field {
        name,
        kind,
        doc: about,
        ..
    } in payload.fields
    {
        comment(text, "    ", about);
        let line = declaration(kind, name);
        let end = if line.contains(';') { "" } else { ";" };
        writeln!(text, "    {line}{end}").unwrap();
    }
    writeln!(text, "}} {name};").unwrap();
    writeln!(
        text,
        "#define {}_TYPE \"{}\"",
        name.to_uppercase(),
        payload.wire
    )
    .unwrap();
    let (size, align) = (payload.size, payload.align);
    writeln!(
        text,
        "_Static_assert(sizeof({name}) == {size}, \"{name}\");"
    )
    .unwrap();
    writeln!(
        text,
        "_Static_assert(_Alignof({name}) == {align}, \"{name}\");"
    )
    .unwrap();
    for field in payload.fields {
        let (field, offset) = (field.name, field.offset);
        writeln!(
            text,
            "_Static_assert(offsetof({name}, {field}) == {offset}, \"{name}.{field}\");"
        )
        .unwrap();
    }
    if payload
        .fields
        .last()
        .is_some_and(|last| last.name == "crc32")
    {
        writeln!(
            text,
            "// Call last, after every other field is final.\n\
             static inline void {name}_seal({name} *payload) {{\n    \
             payload->crc32 = atas_crc32(payload, offsetof({name}, crc32));\n}}\n\
             static inline int {name}_is_intact(const {name} *payload) {{\n    \
             return payload->crc32 == atas_crc32(payload, offsetof({name}, crc32));\n}}"
        )
        .unwrap();
    }
}

fn header() -> String {
    let mut text = HEAD.to_owned();
    let capacities = [
        ("HANDS", capacity::HANDS),
        ("FINGERS", capacity::FINGERS),
        ("ELEMENTS", capacity::ELEMENTS),
        ("JOINTS", capacity::JOINTS),
        ("AGENTS", capacity::AGENTS),
        ("STAGES", capacity::STAGES),
        ("SETTINGS", capacity::SETTINGS),
        ("STEPS", capacity::STEPS),
    ];
    text.push_str("\n// Capacities of the payloads.\n");
    for (name, number) in capacities {
        writeln!(text, "#define ATAS_{name} {number}").unwrap();
    }
    text.push_str("\n// Services.\n");
    for (name, service) in service::NAMES {
        writeln!(text, "#define ATAS_SERVICE_{name} \"{service}\"").unwrap();
    }
    text.push_str("\n// Hashes of the built-in layouts.\n");
    for name in Layout::NAMES {
        let hash = Layout::from_name(name).expect("built-in layout").hash();
        let name = name.to_uppercase().replace(['-', '.'], "_");
        writeln!(text, "#define ATAS_LAYOUT_HASH_{name} 0x{hash:016x}u").unwrap();
    }
    CODES.iter().for_each(|it| code(&mut text, it));
    PAYLOADS.iter().for_each(|it| payload(&mut text, it));
    text.push_str("\n#endif\n");
    text
}

#[test]
fn c_header_matches_the_schema() {
    let actual = header();
    if GOLDEN != actual {
        let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/atas.h");
        std::fs::write(path, actual).unwrap();
        panic!(
            "the C header differs from the schema: check {path}, then replace shm-schemas/atas.h \
             by it"
        );
    }
}

#[test]
fn nested_types_are_declared_first() {
    let mut codes = CODES.iter().map(|code| code.name).collect::<Vec<_>>();
    for payload in PAYLOADS {
        for field in payload.fields {
            let mut kind = &field.kind;
            while let Type::Array(of, _) = kind {
                kind = of;
            }
            let part = match kind {
                Type::Code(code) => code.name,
                Type::Payload(part) => part.name,
                _ => continue,
            };
            assert!(
                codes.contains(&part),
                "{part} of {}.{}",
                payload.name,
                field.name
            );
        }
        codes.push(payload.name);
    }
}

/// Creates the sealed frame that the C program also creates.
fn frame() -> HandFrame {
    let mut frame = HandFrame {
        layout_hash: Layout::dome_41().hash(),
        finger_count: 2,
        ..HandFrame::default()
    };
    frame.stamp.sequence = 7;
    frame.stamp.captured_ns = 1 << 40;
    frame.valid_mask[1] = u64::MAX >> 23;
    for (n, force_n) in frame.force_n.iter_mut().flatten().flatten().enumerate() {
        *force_n = n as f32 * 0.25;
    }
    frame.seal();
    frame
}

#[test]
fn c_program_writes_an_identical_frame() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("header");
    std::fs::create_dir_all(&folder).unwrap();
    let (source, program) = (folder.join("peer.c"), folder.join("peer"));
    let directions = |table: &[[f64; 3]]| {
        let rows = table[..41]
            .iter()
            .map(|[x, y, z]| format!("{{{x:?},{y:?},{z:?}}}"));
        rows.collect::<Vec<_>>().join(",")
    };
    let dome = Layout::dome_41();
    let text = include_str!("peer.c")
        .replace("NORMAL", &directions(&dome.normal))
        .replace("TANGENT1", &directions(&dome.tangent1))
        .replace("TANGENT2", &directions(&dome.tangent2));
    std::fs::write(&source, text).unwrap();
    let include = concat!("-I", env!("CARGO_MANIFEST_DIR"));
    let warnings = [
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        include,
    ];
    let mut compiler = Command::new("cc");
    compiler
        .args(warnings)
        .arg(&source)
        .arg("-lm")
        .arg("-o")
        .arg(&program);
    let built = compiler
        .output()
        .expect("a C compiler is installed because Rust links with it");
    assert!(
        built.status.success(),
        "{}",
        String::from_utf8_lossy(&built.stderr)
    );
    let ran = Command::new(&program).output().expect("the program starts");
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    assert_eq!(
        ran.stdout,
        frame().as_bytes(),
        "the C frame equals the Rust frame"
    );
    let ours = JointState::SCHEMA.fields.last().expect("fields");
    assert_eq!(
        (ours.name, ours.offset),
        ("crc32", size_of::<JointState>() - 4)
    );
}
