//! The example configuration contains every key with its default and range.

use std::fmt::Write as _;
use std::path::PathBuf;

use atas_core::settings::PARAMETERS;
use atasd::config::{Config, Source, known_keys};

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("atas.example.toml")
}

fn text() -> String {
    std::fs::read_to_string(path()).expect("atas.example.toml is readable")
}

/// Tunable part of the file, generated from the controller's table.
fn rendered_parameters() -> String {
    let mut text = String::new();
    let mut section = "";
    for parameter in PARAMETERS {
        let (own_section, key) = parameter.name.split_once('.').expect("section.key");
        if own_section != section {
            section = own_section;
            writeln!(text, "\n[{section}]").expect("writing to a string");
        }
        let (doc, lower, upper) = (parameter.doc.trim(), parameter.lower, parameter.upper);
        writeln!(
            text,
            "# {doc}\n# Allowed: {lower} to {upper}.\n{key} = {:?}",
            parameter.default
        )
        .expect("writing to a string");
    }
    text
}

/// Compares line by line, so that a failure shows the line.
fn check_lines(have: &str, want: &str) {
    for (have, want) in have.lines().zip(want.lines()) {
        assert_eq!(have, want, "run `ATAS_BLESS=1 cargo test -p atasd example`");
    }
    assert_eq!(
        have.lines().count(),
        want.lines().count(),
        "run `ATAS_BLESS=1 cargo test -p atasd example`"
    );
}

#[test]
fn example_parses_to_the_defaults() {
    let source = Source {
        files: vec![path()],
        flags: vec![],
    };
    let config = source.load().expect("the example is valid");
    check_lines(&config.text(), &Config::default().text());
}

#[test]
fn example_contains_every_key() {
    let text = text();
    for key in known_keys() {
        let (_, last) = key.rsplit_once('.').expect("section.key");
        assert!(
            text.contains(&format!("\n{last} = ")),
            "atas.example.toml lacks {key}"
        );
    }
}

/// `ATAS_BLESS=1 cargo test -p atasd example` regenerates this part after a change of the
/// controller's table.
#[test]
fn example_documents_every_parameter() {
    let text = text();
    let at = text
        .find("\n[intake]")
        .expect("the tunable part begins with [intake]");
    let (fixed, rendered) = (&text[..at], rendered_parameters());
    if std::env::var_os("ATAS_BLESS").is_some() {
        std::fs::write(path(), format!("{fixed}{rendered}"))
            .expect("atas.example.toml is writable");
    } else {
        check_lines(&text[at..], &rendered);
    }
}

#[test]
fn example_task_is_valid() {
    let text = text();
    let (_, task) = text.split_once("#\n# [tasks").expect("has a task");
    let (task, _) = task.split_once("# ]\n").expect("has an end");
    let task = format!("[tasks{task}# ]").replace("\n# ", "\n");
    let (_folder, source) = crate::config::source(&[&task], &[]);
    let config = source.load().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(config.tasks.as_slice()[0].name, "show");
}
