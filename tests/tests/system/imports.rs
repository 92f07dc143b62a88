//! No circles: inside a crate, imports run one way, so that every file can be read after those that it names.
//!
//! Read off the text, without a compiler: `crate::…` and `super::…` paths of every file under `src/`, tests left out. What a
//! folder's own `mod.rs` declares and re-exports belongs to the folder and is no import.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Module path of a file, and the modules that it names.
type Imports = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

#[test]
fn no_crate_imports_in_a_circle() {
    let mut found = Vec::new();
    for package in &crate::architecture::packages() {
        let folder = package.manifest_path.parent().expect("a folder");
        for source in roots(folder.join("src").as_std_path()) {
            let circles = circles(&imports(&source));
            if !circles.is_empty() {
                found.push((source, circles));
            }
        }
    }
    assert!(
        found.is_empty(),
        "these files import each other: {found:?}; move what both need into a file of its own below them"
    );
}

#[test]
fn a_circle_is_found_and_a_ladder_is_none() {
    let check = |files: &[(&str, &str)], circle: &[&str]| {
        let known: Vec<_> = files.iter().map(|(path, _)| module(path)).collect();
        let named = files.iter().map(|(path, text)| {
            let own = module(path);
            (own.clone(), named(text, &own, &known))
        });
        let found = circles(&named.collect());
        let expected: Vec<Vec<String>> = if circle.is_empty() {
            vec![]
        } else {
            vec![circle.iter().map(ToString::to_string).collect()]
        };
        assert_eq!(found, expected, "{files:?}");
    };
    let (a, b) = ("use crate::b::B;", "use crate::{c, a::{A, Z}};");
    check(&[("a.rs", a), ("b.rs", b), ("c.rs", "")], &["a", "b"]);
    check(&[("a.rs", a), ("b.rs", "// crate::a"), ("c.rs", a)], &[]);
    let (x, y) = ("use super::y::Y;", "fn f() { super::x::g() }");
    check(
        &[("f/mod.rs", "mod x;"), ("f/x.rs", x), ("f/y.rs", y)],
        &["f::x", "f::y"],
    );
    check(
        &[("f/mod.rs", "pub use x::X;"), ("f/x.rs", "use super::Y;")],
        &[],
    );
    let tested = "#[cfg(test)]\nmod tests { use crate::b::B; }";
    check(&[("a.rs", tested), ("b.rs", "use crate::a::A;")], &[]);
}

/// The folders of a package's library and of its programs that have one.
fn roots(source: &Path) -> Vec<PathBuf> {
    let programs = std::fs::read_dir(source.join("bin")).into_iter().flatten();
    let programs = programs.map(|entry| entry.expect("readable").path());
    let mut roots: Vec<_> = programs.filter(|path| path.is_dir()).collect();
    roots.push(source.to_owned());
    roots
}

fn imports(source: &Path) -> Imports {
    let mut files = Vec::new();
    collect(source, source, &mut files);
    let known: Vec<_> = files.iter().map(|file| module(file)).collect();
    let named = files.iter().map(|file| {
        let text = std::fs::read_to_string(source.join(file)).expect("readable");
        let own = module(file);
        (own.clone(), named(&text, &own, &known))
    });
    named.collect()
}

fn collect(source: &Path, folder: &Path, files: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        let is_tests = path.file_stem().is_some_and(|stem| stem == "tests");
        if path.is_dir() && !path.ends_with("bin") {
            collect(source, &path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") && !is_tests {
            let inside = path.strip_prefix(source).expect("inside");
            files.push(inside.to_str().expect("UTF-8").to_string());
        }
    }
}

/// `a/b.rs` and `a/b/mod.rs` are both `a::b`; the root is empty.
fn module(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs").split('/');
    path.filter(|part| !["mod", "lib", "main"].contains(part))
        .map(str::to_string)
        .collect()
}

/// The files that a text names, own folders and own children left out.
fn named(text: &str, own: &[String], known: &[Vec<String>]) -> BTreeSet<Vec<String>> {
    let code: String = text
        .split("#[cfg(test)]\nmod tests")
        .next()
        .unwrap_or_default()
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .fold(String::new(), |code, line| code + line + "\n");
    let mut found = BTreeSet::new();
    for (start, root) in ["crate::", "super::"]
        .iter()
        .flat_map(|root| code.match_indices(root))
    {
        if code[..start].ends_with("::") {
            continue;
        }
        let base = match root {
            "crate::" => Vec::new(),
            _ => own[..own.len().saturating_sub(1)].to_vec(),
        };
        let mut rest = &code[start + root.len()..];
        expand(&mut rest, &base, &mut |path| {
            let file = (1..=path.len())
                .rev()
                .map(|n| &path[..n])
                .find(|p| known.iter().any(|k| k == p));
            let file = file.unwrap_or_default();
            if !own.starts_with(file) && !file.starts_with(own) {
                found.insert(file.to_vec());
            }
        });
    }
    found
}

/// Follows a path of a use tree to all of its ends.
fn expand(rest: &mut &str, base: &[String], visit: &mut dyn FnMut(&[String])) {
    let mut path = base.to_vec();
    loop {
        *rest = rest.trim_start();
        if let Some(inner) = rest.strip_prefix('{') {
            *rest = inner;
            while !rest.is_empty() && !rest.starts_with('}') {
                expand(rest, &path, visit);
                *rest = rest.trim_start().trim_start_matches(',').trim_start();
            }
            *rest = rest.strip_prefix('}').unwrap_or(rest);
            return;
        }
        let end = rest
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(rest.len());
        if end == 0 {
            // Not a path after all: a macro's repetition, a glob.
            *rest = rest.get(1..).unwrap_or_default();
            return visit(&path);
        }
        match &rest[..end] {
            "super" => drop(path.pop()),
            part => path.push(part.to_string()),
        }
        *rest = &rest[end..];
        match rest.strip_prefix("::") {
            Some(more) => *rest = more,
            None => {
                *rest = rest.strip_prefix(" as ").map_or(*rest, |more| {
                    more.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_')
                });
                return visit(&path);
            }
        }
    }
}

/// Sets of files of which each leads back to itself.
fn circles(imports: &Imports) -> Vec<Vec<String>> {
    let reach = |from: &Vec<String>| {
        let mut seen = BTreeSet::new();
        let mut open = vec![from];
        while let Some(file) = open.pop() {
            for next in imports.get(file).into_iter().flatten() {
                if seen.insert(next) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<_, _> = imports.keys().map(|file| (file, reach(file))).collect();
    let mut found = BTreeSet::new();
    for (file, beyond) in reached
        .iter()
        .filter(|(file, beyond)| beyond.contains(**file))
    {
        let together = beyond
            .iter()
            .filter(|other| reached.get(**other).is_some_and(|r| r.contains(*file)));
        found.insert(together.map(|path| path.join("::")).collect::<Vec<_>>());
    }
    found.into_iter().collect()
}
