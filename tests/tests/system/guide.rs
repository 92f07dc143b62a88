//! Runs the commands of the guide, page by page.
//!
//! The `sh` blocks of a page run in order in one folder. A TOML block is the file named in its
//! first line. Blocks that need hardware or change the machine (`sh,hardware`, `sh,once`) are only
//! compared with the programs' help.

use std::path::{Path, PathBuf};
use std::process::Command;

use shm_bus::FreshBus;
use system_tests::{binary, lock_exclusive};

/// A fenced block: its info string and its text.
struct Block {
    kind: String,
    text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns all pages with their blocks.
fn pages() -> Vec<(String, Vec<Block>)> {
    let folder = root().join("clients/guide/src");
    let entries = std::fs::read_dir(folder).expect("the guide");
    let paths = entries.map(|entry| entry.expect("readable").path());
    let pages = paths.filter(|path| path.extension().is_some_and(|e| e == "md"));
    pages
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("UTF-8");
            let name = path.file_stem().expect("a name").to_string_lossy();
            (name.into_owned(), blocks(&text))
        })
        .collect()
}

fn blocks(text: &str) -> Vec<Block> {
    let (mut blocks, mut open) = (Vec::new(), None::<Block>);
    for line in text.lines() {
        match (line.trim_start().strip_prefix("```"), &mut open) {
            (Some(kind), None) => {
                open = Some(Block {
                    kind: kind.to_owned(),
                    text: String::new(),
                });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.text += &format!("{}\n", line.trim_start()),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

#[test]
fn guide_commands_succeed() {
    let mut run = 0;
    for (name, blocks) in pages() {
        let script: String = blocks
            .iter()
            .filter(|block| block.kind == "sh")
            .map(|block| block.text.as_str())
            .collect();
        if script.is_empty() {
            continue;
        }
        let _machine = lock_exclusive();
        let folder = tempfile::tempdir().expect("a folder");
        for block in blocks.iter().filter(|block| block.kind == "toml") {
            let first = block.text.lines().next().expect("a line");
            let file = first.strip_prefix("# ").expect("the file's name");
            std::fs::write(folder.path().join(file), &block.text).expect("written");
        }
        let bus = FreshBus::new("guide");
        let programs = binary("atas");
        let programs = programs.parent().expect("a folder").display();
        let path = std::env::var("PATH").unwrap_or_default();
        let output = Command::new("timeout")
            .args(["120", "bash", "-c"])
            .arg(format!(
                "set -e\ntrap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT\n{script}"
            ))
            .current_dir(folder.path())
            .env("PATH", format!("{programs}:{path}"))
            .env("ATAS", root())
            .env("ATAS_BUS", bus.as_str())
            .env_remove("RUST_LOG")
            .output()
            .expect("bash starts");
        assert!(
            output.status.success(),
            "{name}: {}\n{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        run += 1;
    }
    assert!(run >= 6, "the guide contains runnable pages");
}

#[test]
fn hardware_commands_of_guide_have_known_options() {
    const PROGRAMS: [&str; 6] = [
        "atas",
        "atasd",
        "atas-robot",
        "atas-sensor",
        "atas-sim",
        "ebts",
    ];
    let mut seen = 0;
    for (name, blocks) in pages() {
        let held = blocks.iter().filter(|block| block.kind.starts_with("sh,"));
        for line in held.flat_map(|block| block.text.lines()) {
            let words: Vec<&str> = line.split_whitespace().take_while(|w| *w != ">").collect();
            // A user switch precedes the program name.
            let Some(at) = words.iter().position(|w| PROGRAMS.contains(w)) else {
                continue;
            };
            let at = if words[0] == "sudo" && words[1] == "-u" {
                at.max(3)
            } else {
                at
            };
            if words[0] == "sudo" && words[1] != "-u" {
                continue;
            }
            let is_word = |w: &&&str| {
                !w.starts_with('-') && w.chars().all(|c| c.is_ascii_lowercase() || c == '-')
            };
            let verbs = words[at + 1..].iter().take_while(is_word).take(2);
            let help = Command::new(binary(words[at]))
                .args(verbs)
                .arg("--help")
                .output()
                .expect("the program starts");
            let text = String::from_utf8_lossy(&help.stdout).into_owned();
            assert!(help.status.success(), "{name}: {line}");
            for flag in words.iter().filter(|w| w.starts_with("--")) {
                assert!(text.contains(flag), "{name}: {line}: unknown option {flag}");
            }
            seen += 1;
        }
    }
    assert!(seen >= 10, "{seen}");
}

#[test]
fn guide_pages_are_listed_and_links_resolve() {
    let summary = root().join("clients/guide/src/SUMMARY.md");
    let summary = std::fs::read_to_string(summary).expect("readable");
    for (name, _) in pages().iter().filter(|(name, _)| name != "SUMMARY") {
        assert!(summary.contains(&format!("({name}.md)")), "{name}");
        let path = root().join(format!("clients/guide/src/{name}.md"));
        let text = std::fs::read_to_string(path).expect("readable");
        for link in text.split("](").skip(1) {
            let target = link.split([')', '#']).next().expect("a link");
            let file = root().join("clients/guide/src").join(target);
            assert!(
                target.starts_with("http") || file.exists(),
                "{name}: {target}"
            );
        }
        let quoted = text.split('`').skip(1).step_by(2);
        for path in quoted.filter(|path| path.contains('/') && path.ends_with(".md")) {
            assert!(root().join(path).exists(), "{name}: {path}");
        }
    }
}
