//! Language check of comments, Markdown, TOML, strings and test names.
//!
//! Input: the tracked kinds of files of this checkout. A failure lists file, line and rule of every
//! finding. `cargo test -p system-tests --test language` runs only this check.

use std::fs;
use std::path::{Path, PathBuf};

use regex::Regex;

/// Kinds of files that people read.
const EXTENSIONS: [&str; 6] = ["rs", "md", "toml", "py", "pyi", "sh"];
/// Folders with generated or foreign files.
const SKIPPED: [&str; 6] = [
    "target",
    ".git",
    "node_modules",
    "golden",
    "__pycache__",
    "venv",
];
/// First words of a paragraph whose subject is a relative clause.
const OPENINGS: &str = r"^(What|How|Whether|Where|Who|Whoever|Whose|Whatever|Those (who|that|which)|That which|All that|The same|As (it|they|what)|So (that|it|they))\b";
/// Words that no engineer of the field uses.
const PRIVATE: &str = r"(?i)\b(told|tells?|telling|anew|askew|whoever|nobody|no one|lest|borne|bears?|shall|in vain|ours|hear|hears|heard|mend(s|ed|ing)?|is led|are led|wears?|worn|lies? (there|beside)|beside its|so much|of its own|of one's own|what (is|has|it|they|was|can|a|an|the|its|there|came|comes|remains|hangs|stands|slides|turns|presses)|who(ever)? (looks?|is|has|takes?|may|wants?)|whichever|in whose)\b";
/// Test names that do not state situation and expectation.
const RIDDLE: &str = r"^(what|whoever|nobody|who|whatever|no_one|those)_";
/// Widest comment line, columns.
const COLUMNS: usize = 100;
/// Most words of a sentence.
const SENTENCE: usize = 30;

/// Limits per 1,000 units of a rule.
const OPENINGS_MAX: usize = 10;
const PRIVATE_MAX: usize = 1;
const WIDE_MAX: usize = 1;
const LONG_MAX: usize = 10;

/// Size limits of the README, and the fewest documentation examples.
const README_LINES: usize = 165;
const README_WORDS: usize = 1_500;
const DOCTESTS: usize = 40;

/// Paragraph of a comment, a document or a text for users.
struct Paragraph {
    line: usize,
    text: String,
    is_document: bool,
}

/// Findings of one rule and the number of units that it examined.
#[derive(Default)]
struct Rule {
    units: usize,
    findings: Vec<String>,
}

impl Rule {
    fn add(&mut self, units: usize, findings: usize, place: &str) {
        self.units += units;
        self.findings
            .extend(std::iter::repeat_n(place.to_owned(), findings));
    }

    /// Fails if there are more than `limit` findings per 1,000 units.
    fn check(&self, rule: &str, limit: usize) {
        let found = self.findings.len();
        assert!(
            found * 1_000 <= limit * self.units,
            "{rule}: {found} in {} units, the limit is {limit} per 1,000:\n{}",
            self.units,
            self.findings.join("\n")
        );
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns all files that people read, with their contents, in a fixed order.
fn files() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    let mut folders = vec![root()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the folder is readable") {
            let path = entry.expect("the entry is readable").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() && !path.is_symlink() {
                if !SKIPPED.contains(&name.as_ref()) {
                    folders.push(path);
                }
                continue;
            }
            let extension = path.extension().unwrap_or_default().to_string_lossy();
            if EXTENSIONS.contains(&extension.as_ref()) && !name.contains("Cargo") {
                let text = fs::read_to_string(&path).expect("the file is UTF-8");
                files.push((path, text));
            }
        }
    }
    files.sort();
    files
}

fn is_rust(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "rs")
}

fn place(path: &Path, line: usize, text: &str) -> String {
    let path = path.strip_prefix(root()).unwrap_or(path);
    let start: String = text.chars().take(COLUMNS).collect();
    format!("{}:{line}: {start}", path.display())
}

/// Returns the paragraphs of a Markdown file without code blocks.
fn markdown(text: &str) -> Vec<Paragraph> {
    let bullet = Regex::new(r"^\s*([-*+]|\d+\.|#+|>|\|)\s*").expect("valid");
    let ruler = Regex::new(r"^\s*\|?[\s:|-]*$").expect("valid");
    let mut paragraphs: Vec<Paragraph> = Vec::new();
    let (mut is_code, mut is_open) = (false, false);
    for (index, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            (is_code, is_open) = (!is_code, false);
        } else if is_code || ruler.is_match(line) {
            is_open = false;
        } else if is_open && !bullet.is_match(line) {
            let last = paragraphs.last_mut().expect("an open paragraph");
            last.text += " ";
            last.text += line.trim();
        } else {
            is_open = true;
            paragraphs.push(Paragraph {
                line: index + 1,
                text: bullet.replace(line, "").trim().to_owned(),
                is_document: true,
            });
        }
    }
    paragraphs
}

/// Returns the comments of a source file, and the texts of a Rust file with four words or more.
fn source(text: &str, is_rust: bool) -> Vec<Paragraph> {
    let mark = if is_rust {
        r"^\s*//[/!]?\s?(.*)$"
    } else {
        r"^\s*#\s?(.*)$"
    };
    let mark = Regex::new(mark).expect("valid");
    let string = Regex::new(r#""((?:[^"\\]|\\.){12,})""#).expect("valid");
    let mut paragraphs: Vec<Paragraph> = Vec::new();
    let mut is_open = false;
    for (index, line) in text.lines().enumerate() {
        let comment = mark.captures(line).map(|found| found[1].trim().to_owned());
        let comment = comment.filter(|comment| !comment.is_empty() && !comment.starts_with('!'));
        if let (Some(comment), true) = (&comment, is_open) {
            let last = paragraphs.last_mut().expect("an open paragraph");
            last.text += " ";
            last.text += comment;
        } else if let Some(comment) = &comment {
            paragraphs.push(Paragraph {
                line: index + 1,
                text: comment.clone(),
                is_document: true,
            });
        } else if is_rust {
            let texts = string.captures_iter(line).map(|found| found[1].to_owned());
            paragraphs.extend(
                texts
                    .filter(|text| text.matches(' ').count() >= 3)
                    .map(|text| Paragraph {
                        line: index + 1,
                        text,
                        is_document: false,
                    }),
            );
        }
        is_open = comment.is_some();
    }
    paragraphs
}

/// Returns all paragraphs with the places of their first lines.
fn paragraphs() -> Vec<(String, Paragraph)> {
    let mut all = Vec::new();
    for (path, text) in files() {
        // The patterns of this file contain the words that they find.
        if path.ends_with("tests/tests/language.rs") {
            continue;
        }
        let found = if path.extension().is_some_and(|extension| extension == "md") {
            markdown(&text)
        } else {
            source(&text, is_rust(&path))
        };
        all.extend(
            found
                .into_iter()
                .map(|paragraph| (place(&path, paragraph.line, &paragraph.text), paragraph)),
        );
    }
    all
}

#[test]
fn paragraphs_begin_with_their_subject() {
    let opening = Regex::new(OPENINGS).expect("valid");
    let mut rule = Rule::default();
    for (place, paragraph) in paragraphs() {
        let units = usize::from(paragraph.is_document);
        let found = usize::from(paragraph.is_document && opening.is_match(&paragraph.text));
        rule.add(units, found, &place);
    }
    rule.check(
        "begin with what the item is or does, not with a relative clause",
        OPENINGS_MAX,
    );
}

#[test]
fn texts_use_words_of_the_field() {
    let private = Regex::new(PRIVATE).expect("valid");
    let mut rule = Rule::default();
    for (place, paragraph) in paragraphs() {
        let words = paragraph.text.split_whitespace().count();
        for found in private.find_iter(&paragraph.text) {
            rule.add(0, 1, &format!("{}: {place}", found.as_str()));
        }
        rule.add(words, 0, &place);
    }
    rule.check(
        "replace private words by terms of the glossary",
        PRIVATE_MAX,
    );
}

#[test]
fn sentences_are_short() {
    let code = Regex::new("`[^`]*`").expect("valid");
    let end = Regex::new(r"[.!?]\s+").expect("valid");
    let mut rule = Rule::default();
    for (place, paragraph) in paragraphs() {
        let text = code.replace_all(&paragraph.text, "x");
        for sentence in end.split(&text).filter(|_| paragraph.is_document) {
            let is_long = sentence.split_whitespace().count() > SENTENCE;
            rule.add(1, usize::from(is_long), &place);
        }
    }
    rule.check("split sentences of more than 30 words", LONG_MAX);
}

#[test]
fn comment_lines_are_at_most_100_columns_wide() {
    let mut rule = Rule::default();
    for (path, text) in files().iter().filter(|(path, _)| is_rust(path)) {
        for (index, line) in text.lines().enumerate() {
            if line.trim_start().starts_with("//") {
                let is_wide = line.chars().count() > COLUMNS;
                rule.add(
                    1,
                    usize::from(is_wide),
                    &place(path, index + 1, line.trim()),
                );
            }
        }
    }
    rule.check("wrap comment lines at 100 columns", WIDE_MAX);
}

#[test]
fn test_names_state_situation_and_expectation() {
    let test = Regex::new(r"#\[test\]\s*(?:#\[[^\]]*\]\s*)*fn (\w+)").expect("valid");
    let riddle = Regex::new(RIDDLE).expect("valid");
    let mut rule = Rule::default();
    for (path, text) in files().iter().filter(|(path, _)| is_rust(path)) {
        for found in test.captures_iter(text) {
            let line = text[..found.get(1).expect("a name").start()]
                .lines()
                .count();
            rule.add(
                1,
                usize::from(riddle.is_match(&found[1])),
                &place(path, line, &found[1]),
            );
        }
    }
    assert!(rule.units > 1_000, "only {} tests found", rule.units);
    rule.check("name tests by situation and expectation", 0);
}

#[test]
fn readme_is_readable_in_ten_minutes() {
    let readme = fs::read_to_string(root().join("README.md")).expect("README.md is readable");
    let lines = readme.lines().count();
    let words = readme.split_whitespace().count();
    assert!(
        lines <= README_LINES,
        "README.md has {lines} lines, the limit is {README_LINES}"
    );
    assert!(
        words <= README_WORDS,
        "README.md has {words} words, the limit is {README_WORDS}"
    );
}

#[test]
fn libraries_have_documentation_examples() {
    let fence = Regex::new(r"(?m)^\s*//[/!] ```(\w*)").expect("valid");
    let mut examples = 0;
    for (_, text) in files().iter().filter(|(path, _)| is_rust(path)) {
        let fences = fence.captures_iter(text).step_by(2);
        examples += fences
            .filter(|found| ["", "no_run", "compile_fail", "rust"].contains(&&found[1]))
            .count();
    }
    assert!(
        examples >= DOCTESTS,
        "{examples} documentation examples, at least {DOCTESTS}"
    );
}

#[test]
fn check_finds_each_kind_of_fault() {
    let opening = Regex::new(OPENINGS).expect("valid");
    let private = Regex::new(PRIVATE).expect("valid");
    let text = "/// What a hand\n/// is told.\nlet x = \"nobody has told it anything\";\n";
    let found = source(text, true);
    assert_eq!(found.len(), 2);
    assert!(found[0].is_document && opening.is_match(&found[0].text));
    assert_eq!(found[0].text, "What a hand is told.");
    assert!(!found[1].is_document && private.is_match(&found[1].text));
    let found =
        markdown("# Title\n\nFirst line\nsecond line.\n\n```sh\nwhat is this\n```\n- item\n");
    let texts: Vec<&str> = found.iter().map(|found| found.text.as_str()).collect();
    assert_eq!(texts, ["Title", "First line second line.", "item"]);
    assert!(Regex::new(RIDDLE).expect("valid").is_match("what_hangs"));
}
