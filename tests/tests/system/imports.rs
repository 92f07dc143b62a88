//! Checks that the modules of each crate have no import cycles, so every file can be read after the
//! files it imports.
//!
//! Searches the text for `crate::…` and `super::…` paths in all files under `src/`, except tests.
//! Declarations and re-exports of a `mod.rs` do not count as imports.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Imported modules by module path.
type Imports = BTreeMap<Vec<String>, BTreeSet<Vec<String>>>;

#[test]
fn crates_have_no_import_cycles() {
    let mut found = Vec::new();
    for package in &crate::architecture::packages() {
        let folder = package.manifest_path.parent().expect("a folder");
        for source in roots(folder.join("src").as_std_path()) {
            let circles = cycles(&imports(&source));
            if !circles.is_empty() {
                found.push((source, circles));
            }
        }
    }
    assert!(
        found.is_empty(),
        "import cycles found: {found:?}; move the common part into a separate lower-level file"
    );
}

#[test]
fn import_cycle_is_found() {
    let check = |files: &[(&str, &str)], circle: &[&str]| {
        let known: Vec<_> = files.iter().map(|(path, _)| module(path)).collect();
        let named = files.iter().map(|(path, text)| {
            let own = module(path);
            (own.clone(), named(text, &own, &known))
        });
        let found = cycles(&named.collect());
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

/// Returns the source folders of a package's library and of its multi-file programs.
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

/// Returns the module path: `a::b` for `a/b.rs` and `a/b/mod.rs`, empty for the root.
fn module(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs").split('/');
    path.filter(|part| !["mod", "lib", "main"].contains(part))
        .map(str::to_string)
        .collect()
}

/// Returns the modules that a text imports, except its own parents and children.
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

/// Visits all leaves of a use tree.
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
            // Not a path: a macro repetition or a glob.
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

/// Returns the strongly connected sets of modules.
fn cycles(imports: &Imports) -> Vec<Vec<String>> {
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
