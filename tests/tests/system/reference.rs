//! Generated reference pages of the guide: commands, configuration keys, codes and the Python
//! interface.
//!
//! Sources: help of the programs, example configuration, schemas of the bus, Python type stub.
//! `ATAS_BLESS=1 cargo test -p system-tests --test system reference` writes the pages again.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use shm_schemas::catalogue::CODES;
use shm_schemas::{Cause, ReasonRecord};
use system_tests::binary;

/// Programs in the order of the page.
const PROGRAMS: [&str; 6] = [
    "atas",
    "atasd",
    "atas-sim",
    "atas-sensor",
    "atas-robot",
    "ebts",
];

/// Compares a page with its generated text, or writes it if `ATAS_BLESS` is set.
fn check_page(name: &str, text: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let path = root.join("clients/guide/src/reference").join(name);
    if std::env::var_os("ATAS_BLESS").is_some() {
        std::fs::write(&path, text).expect("the page is writable");
        return;
    }
    let page = std::fs::read_to_string(&path).unwrap_or_default();
    let different = page.lines().zip(text.lines()).position(|(a, b)| a != b);
    let line = different.unwrap_or(page.lines().count().min(text.lines().count())) + 1;
    assert!(
        page == text,
        "reference/{name}:{line} is not up to date; run `ATAS_BLESS=1 cargo test -p system-tests \
            --test system reference`"
    );
}

/// Returns the help of a command.
fn help(program: &str, subcommands: &[String]) -> String {
    let output = Command::new(binary(program))
        .args(subcommands)
        .arg("--help")
        .env("COLUMNS", "100")
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{program} {subcommands:?} --help");
    String::from_utf8(output.stdout).expect("UTF-8")
}

/// Returns the subcommands that a help text lists, except `help`.
fn subcommands(help: &str) -> Vec<String> {
    let is_command = |line: &&str| !line.starts_with("Options:") && !line.starts_with("Arguments:");
    let listed = help.lines().skip_while(|line| !line.starts_with("Usage:"));
    let names = listed
        .skip(1)
        .take_while(is_command)
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next());
    names
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// Appends a command and its subcommands.
fn add_command(page: &mut String, program: &str, path: &[String]) {
    let text = help(program, path);
    let name = [&[program.to_owned()], path].concat().join(" ");
    let level = if path.is_empty() { "##" } else { "###" };
    let lines: Vec<&str> = text.trim_end().lines().map(str::trim_end).collect();
    let _ = write!(
        page,
        "\n{level} {name}\n\n```text\n{}\n```\n",
        lines.join("\n")
    );
    for subcommand in subcommands(&text) {
        add_command(page, program, &[path, &[subcommand]].concat());
    }
}

#[test]
fn commands_page_equals_the_help() {
    let mut page = "# Commands\n\nHelp of every program and command.\n".to_owned();
    for program in PROGRAMS {
        add_command(&mut page, program, &[]);
    }
    check_page("commands.md", &page);
}

/// Entry of the example configuration: section, key, default and comment.
struct Key {
    section: String,
    key: String,
    default: String,
    comment: String,
}

/// Parses the example configuration: comments precede their key, sections are `[name]`.
fn configuration_keys(text: &str) -> Vec<Key> {
    let (mut keys, mut section, mut comment) = (Vec::new(), String::new(), Vec::new());
    for line in text.lines().map(str::trim) {
        if let Some(words) = line.strip_prefix('#') {
            comment.push(words.trim());
        } else if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            section = name.trim_matches(['[', ']']).to_owned();
            comment.clear();
        } else if let Some((key, default)) = line.split_once(" = ") {
            keys.push(Key {
                section: section.clone(),
                key: key.to_owned(),
                default: default.to_owned(),
                comment: comment.join(" "),
            });
            comment.clear();
        } else if line.is_empty() {
            comment.clear();
        }
    }
    keys
}

#[test]
fn configuration_page_equals_the_example() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let example = root.join("daemon/atas.example.toml");
    let example = std::fs::read_to_string(example).expect("the example is readable");
    let mut page =
        "# Configuration\n\nKeys of `atasd` with default, unit, range and effect. The same \
        text as a file: `daemon/atas.example.toml`.\n"
            .to_owned();
    let mut section = String::new();
    for key in configuration_keys(&example) {
        if key.section != section {
            section.clone_from(&key.section);
            let _ = write!(
                page,
                "\n## {section}\n\n| key | default | meaning |\n|---|---|---|\n"
            );
        }
        let comment = key.comment.replace('|', "\\|").replace('<', "&lt;");
        let _ = writeln!(page, "| `{}` | `{}` | {comment} |", key.key, key.default);
    }
    check_page("configuration.md", &page);
}

/// Codes of the page, each with its heading.
const CODE_TABLES: [(&str, &str); 6] = [
    ("EventKind", "Events"),
    ("Mode", "Modes of the daemon"),
    ("GoalState", "Goal states"),
    ("ModuleId", "Modules"),
    ("GoalKind", "Goals"),
    ("Cause", "Causes"),
];

#[test]
fn codes_page_equals_the_schema() {
    let mut page = "# Events, modules and causes\n\nNames as in events, status and JSON. The last \
        column of *Causes* is an example of the message, with zeros for value and limit.\n"
        .to_owned();
    for (name, heading) in CODE_TABLES {
        let code = CODES.iter().find(|code| code.name == name);
        let code = code.expect("the code is in the catalogue");
        let is_cause = name == "Cause";
        let (title, ruler) = match is_cause {
            true => ("| name | meaning | message |", "|---|---|---|"),
            false => ("| name | meaning |", "|---|---|"),
        };
        let _ = write!(page, "\n## {heading}\n\n{title}\n{ruler}\n");
        for value in code.values {
            let lines: Vec<&str> = value.doc.iter().map(|line| line.trim()).collect();
            let meaning = escaped(&lines.join(" "));
            let message = match is_cause {
                true => format!(" {} |", escaped(&text_of(Cause(value.number)))),
                false => String::new(),
            };
            let _ = writeln!(page, "| `{}` | {} |{message}", value.text, meaning.trim());
        }
    }
    check_page("codes.md", &page);
}

/// Returns the message of a cause with zeros for value and limit.
fn text_of(cause: Cause) -> String {
    let record = ReasonRecord {
        cause,
        ..ReasonRecord::default()
    };
    record.to_string()
}

fn escaped(text: &str) -> String {
    text.replace('|', "\\|")
        .replace('<', "&lt;")
        .replace('\n', " ")
}

#[test]
fn python_page_equals_the_type_stub() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let stub = root.join("clients/python/python/atas/_native.pyi");
    let stub = std::fs::read_to_string(stub).expect("the stub is readable");
    let (_, declarations) = stub
        .split_once("\n]\n")
        .expect("declarations follow __all__");
    let page = format!(
        "# Python interface\n\nDeclarations of the package `atas`. Arguments are SI units; arrays \
         have the layout of the [payloads](../../../protocol.md). Examples: [Python]\
         (../../../python/README.md).\n\n```python\n{}\n```\n",
        declarations.trim()
    );
    check_page("python.md", &page);
}

#[test]
fn comment_and_default_of_a_key_are_parsed() {
    let keys = configuration_keys("# About.\n[a.b]\n# First,\n# 0 to 1.\nx_n = 0.5\ny = \"z\"\n");
    let found: Vec<[&str; 4]> = keys
        .iter()
        .map(|key| [&*key.section, &*key.key, &*key.default, &*key.comment])
        .collect();
    let expected = [
        ["a.b", "x_n", "0.5", "First, 0 to 1."],
        ["a.b", "y", "\"z\"", ""],
    ];
    assert_eq!(found, expected);
}
