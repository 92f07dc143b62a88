//! Variations of a preset for sweeps and searches.

use field::{Model, Preset};

use crate::error::{Error, Result};
use crate::table_file::inline;

/// Returns the validated preset with these keys changed; its name lists their values. A dot selects
/// a nested key, such as `starts.distance_px`.
///
/// # Errors
/// A key or a value is invalid for a preset.
pub fn varied(base: &Preset, chosen: &[(&str, &toml::Value)]) -> Result<Preset> {
    let mut table = toml::Table::try_from(base).map_err(Error::from_part)?;
    // Fitted push factors and the friction law exclude each other: the varied one stays.
    let named = |key: &str| chosen.iter().any(|(varied, _)| *varied == key);
    if named("friction_per_stall_force") {
        table.remove("solo_push");
        table.remove("team_push");
    } else if named("solo_push") || named("team_push") {
        table.remove("friction_per_stall_force");
    }
    let mut name = base.name.to_string();
    for (key, value) in chosen {
        set(&mut table, key, value);
        name += &format!(" {key}={}", inline(value).replace('"', ""));
    }
    table.insert("name".to_owned(), name.into());
    let preset = toml::Value::Table(table).try_into();
    let preset = preset.map_err(|error: toml::de::Error| {
        let keys: Vec<&str> = chosen.iter().map(|(key, _)| *key).collect();
        Error::refused(
            format_args!("vary {}", keys.join(", ")),
            error.message(),
            "keys and values of a preset",
            "see ebts preset NAME",
        )
    })?;
    let model = Model::new(preset).map_err(Error::from_part)?;
    Ok(model.preset().clone())
}

/// Sets a key; a dot selects a nested table.
fn set(table: &mut toml::Table, key: &str, value: &toml::Value) {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value.clone());
        }
        Some((outer, inner)) => {
            let entry = table
                .entry(outer)
                .or_insert_with(|| toml::Table::new().into());
            if let toml::Value::Table(table) = entry {
                set(table, inner, value);
            }
        }
    }
}
