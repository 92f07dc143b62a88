//! Checks that the protocol page for peers in other languages matches the code: tables and quoted
//! numbers.

use std::fmt::Write;

use shm_bus::{BORROWED_MAX, EXCHANGES, STREAMS};
use shm_schemas::catalogue::{CODES, PAYLOADS};
use shm_schemas::schema::{PayloadType, Type};

const PAGE: &str = include_str!("../../../clients/protocol.md");

fn streams() -> String {
    let mut table = "| service | payload | buffer | history | publishers | subscribers | nodes |\n\
                     |---|---|---|---|---|---|---|\n"
        .to_owned();
    for line in &STREAMS {
        let [service, payload] = [line.service, line.payload];
        let numbers = [
            line.buffer,
            line.history,
            line.publishers,
            line.subscribers,
            line.nodes(),
        ];
        let numbers = numbers.map(|number| number.to_string()).join(" | ");
        writeln!(table, "| `{service}` | `{payload}` | {numbers} |").expect("text");
    }
    table
}

fn exchanges() -> String {
    let mut table =
        "| service | request | response | open requests | responses | clients | nodes |\n\
                     |---|---|---|---|---|---|---|\n"
            .to_owned();
    for line in &EXCHANGES {
        let [request, response] = line.payloads;
        let numbers = [
            line.open_requests,
            line.responses,
            line.clients,
            line.nodes(),
        ];
        let numbers = numbers.map(|number| number.to_string()).join(" | ");
        writeln!(
            table,
            "| `{}` | `{request}` | `{response}` | {numbers} |",
            line.service
        )
        .expect("text");
    }
    table
}

/// Type of a field in C notation, dimensions last.
fn c_type(kind: &Type) -> String {
    let (mut kind, mut dimensions) = (kind, String::new());
    while let Type::Array(of, count) = kind {
        write!(dimensions, "[{count}]").expect("text");
        kind = of;
    }
    let base = match kind {
        Type::F32 => "f32".to_owned(),
        Type::F64 => "f64".to_owned(),
        Type::U32 => "u32".to_owned(),
        Type::U64 => "u64".to_owned(),
        Type::Text(bytes) => format!("char[{bytes}]"),
        Type::Code(code) => format!("u32 {}", code.name),
        Type::Payload(part) => part.name.to_owned(),
        Type::Array(..) => unreachable!("arrays are resolved above"),
    };
    base + &dimensions
}

fn payload(text: &mut String, payload: &PayloadType) {
    writeln!(text, "\n**`{}`**, {} bytes\n", payload.wire, payload.size).expect("text");
    text.push_str("| offset | field | type | |\n|---|---|---|---|\n");
    for field in payload.fields {
        let about = field
            .doc
            .iter()
            .map(|line| line.trim())
            .collect::<Vec<_>>()
            .join(" ");
        let about = about
            .replace("[`crate::", "`")
            .replace("[`", "`")
            .replace("`]", "`")
            .replace('|', "\\|");
        let (name, kind) = (field.name, c_type(&field.kind));
        writeln!(text, "| {} | `{name}` | {kind} | {about} |", field.offset).expect("text");
    }
}

/// Payloads of the control loop, goals and requests; the C header contains all.
const SHOWN: [&str; 16] = [
    "Stamp",
    "HandFrame",
    "JointState",
    "JointCommand",
    "GoalRequest",
    "GoalUpdate",
    "GraspTarget",
    "Reason",
    "GraspFigures",
    "ControlRequest",
    "ControlReply",
    "StopRequest",
    "StopAnswer",
    "SensorStatus",
    "ModuleEvent",
    "Status",
];

fn payloads() -> String {
    let mut text = String::new();
    for shown in SHOWN {
        let known = PAYLOADS
            .iter()
            .find(|known| known.name == shown)
            .expect("it exists");
        payload(&mut text, known);
    }
    text
}

fn codes() -> String {
    let mut text = "| code | values |\n|---|---|\n".to_owned();
    for code in CODES {
        let values = code
            .values
            .iter()
            .map(|value| format!("{} {}", value.number, value.name));
        writeln!(
            text,
            "| `{}` | {} |",
            code.name,
            values.collect::<Vec<_>>().join(", ")
        )
        .expect("text");
    }
    text
}

fn page() -> String {
    let mut page = PAGE.to_owned();
    let tables = [
        ("streams", streams()),
        ("exchanges", exchanges()),
        ("payloads", payloads()),
        ("codes", codes()),
    ];
    for (name, table) in tables {
        let (begin, end) = (
            format!("<!-- {name}: made by a test -->\n"),
            format!("<!-- end of {name} -->"),
        );
        let first = page
            .find(&begin)
            .unwrap_or_else(|| panic!("the page has no {begin}"))
            + begin.len();
        let last = page
            .find(&end)
            .unwrap_or_else(|| panic!("the page has no {end}"));
        page.replace_range(first..last, &format!("\n{}\n\n", table.trim()));
    }
    page
}

#[test]
fn page_tables_match_the_schema() {
    let actual = page();
    if actual != PAGE {
        let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/protocol.md");
        std::fs::write(path, actual).expect("writable");
        panic!(
            "the protocol page differs from the schema: check {path}, then replace \
             clients/protocol.md by it"
        );
    }
}

#[test]
fn page_quotes_current_numbers() {
    let check = |sentence: &str| {
        assert!(
            PAGE.contains(sentence),
            "the page should contain: {sentence}"
        )
    };
    check(&format!(
        "`subscriber_max_borrowed_samples({BORROWED_MAX})`"
    ));
    for hash in ["dome-41", "dome-1", "flat-4x4-4.5"] {
        let layout = shm_schemas::Layout::from_name(hash).expect("built in");
        check(&format!("`{hash}` is `0x{:016x}`", layout.hash()));
    }
    let fnv = shm_schemas::layout::FNV_OFFSET;
    check(&format!("`0x{fnv:016x}`"));
}
