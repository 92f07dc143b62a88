//! A TOML text as a flat list of keys with locations.

use std::collections::HashMap;
use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, DeValue};
use toml::{Table, Value};

use super::keys;
use super::{Config, Location, Problem};

#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) value: Value,
    pub(super) place: Location,
}

/// Keys of a file, sorted by name.
pub(super) fn read_text(path: &Path, text: &str) -> Result<Vec<Entry>, Problem> {
    let syntax = |error: toml::de::Error| Problem::Syntax {
        place: Location::File(
            path.to_owned(),
            line_of(text, error.span().map_or(0, |s| s.start)),
        ),
        why: error.message().replace('\n', ", "),
    };
    let table: Table = toml::from_str(text).map_err(syntax)?;
    let spans = DeTable::parse(text).map_err(syntax)?;
    let mut offsets = HashMap::new();
    collect_offsets("", spans.get_ref(), &mut offsets);
    let newlines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    let mut leaves = Vec::new();
    flatten("", &table, &mut |key, value| {
        let offset = offsets.get(key).copied().unwrap_or(0);
        let line = newlines.partition_point(|newline| *newline < offset) + 1;
        let place = Location::File(path.to_owned(), line);
        leaves.push(Entry {
            key: key.to_owned(),
            value: value.clone(),
            place,
        });
    });
    Ok(leaves)
}

/// Key of `--set section.key=value`. A value that is not TOML is taken as text.
pub(super) fn read_flag(flag: &str) -> Result<Entry, Problem> {
    let why = "needs the form section.key=value".to_owned();
    let (key, value) = flag.split_once('=').ok_or(Problem::Syntax {
        place: Location::Flag,
        why: format!("{flag:?} {why}"),
    })?;
    let (key, value) = (key.trim().to_owned(), value.trim());
    let parsed = toml::from_str::<Table>(&format!("value = {value}")).ok();
    let value = parsed
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(value.to_owned()));
    Ok(Entry {
        key,
        value,
        place: Location::Flag,
    })
}

/// Configuration of these keys, with defaults for the others.
pub(super) fn assemble<'a>(leaves: impl IntoIterator<Item = &'a Entry>) -> Option<Config> {
    let mut root = Table::new();
    for leaf in leaves {
        insert(&mut root, &leaf.key, leaf.value.clone())?;
    }
    Config::deserialize(root).ok()
}

pub(super) fn entries_of(config: &Config) -> Vec<(String, Value)> {
    let mut leaves = Vec::new();
    if let Ok(table) = Table::try_from(config) {
        flatten("", &table, &mut |key, value| {
            leaves.push((key.to_owned(), value.clone()))
        });
    }
    leaves
}

fn insert(table: &mut Table, key: &str, value: Value) -> Option<()> {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value);
        }
        Some((section, rest)) => {
            let inner = table
                .entry(section)
                .or_insert_with(|| Value::Table(Table::new()));
            insert(inner.as_table_mut()?, rest, value)?;
        }
    }
    Some(())
}

/// Descends into tables, except those that are the value of a known key. An empty table counts as a
/// key, so that a misspelt empty section is found.
fn flatten(prefix: &str, table: &Table, each: &mut impl FnMut(&str, &Value)) {
    for (name, value) in table {
        let key = joined(prefix, name);
        match value {
            Value::Table(inner) if inner.is_empty() && keys::is_section(&key) => {}
            Value::Table(inner) if !inner.is_empty() && !is_value(&key) => {
                flatten(&key, inner, each);
            }
            _ => each(&key, value),
        }
    }
}

fn joined(prefix: &str, name: &str) -> String {
    if prefix.is_empty() {
        name.to_owned()
    } else {
        format!("{prefix}.{name}")
    }
}

/// Returns true if a table under this key is a single value.
fn is_value(key: &str) -> bool {
    keys::permitted_values(key).is_some() || keys::task_name(key).is_some()
}

/// Collects the byte offset of each key, under the names that [`flatten`] gives.
fn collect_offsets(prefix: &str, table: &DeTable<'_>, offsets: &mut HashMap<String, usize>) {
    for (name, value) in table {
        let key = joined(prefix, name.get_ref());
        if let DeValue::Table(inner) = value.get_ref() {
            collect_offsets(&key, inner, offsets);
        }
        offsets.entry(key).or_insert(name.span().start);
    }
}

fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|b| *b == b'\n').count() + 1
}
