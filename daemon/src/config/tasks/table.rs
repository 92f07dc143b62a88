//! Reads and writes a task's behaviour table.

use atas_core::tasks::BehaviourTable;
use shm_schemas::SensorBit;
use toml::{Table, Value};

use super::keywords::unknown;

const KEYS: [&str; 5] = ["bits", "fingers_m_s", "hand", "rows", "hash"];

/// Reads `table = { bits = […], fingers_m_s = […], hand = […], rows = "…" }`. A hash, if given,
/// must match the content.
pub(super) fn read(value: &Value) -> Result<BehaviourTable, String> {
    let table = value.as_table().ok_or_else(|| {
        format!("is {value}, needs {{ bits = …, fingers_m_s = …, hand = …, rows = … }}")
    })?;
    super::check_keys(table, &KEYS)?;
    let names = list(table, "bits", "names in quotes", Value::as_str)?;
    let bits: Vec<SensorBit> = names.into_iter().map(bit).collect::<Result<_, _>>()?;
    let numbers = |key| list(table, key, "numbers", number);
    let rows = super::text(table, "rows")?;
    let rows: Vec<[usize; 2]> = rows.split_whitespace().map(row).collect::<Result<_, _>>()?;
    let checked = BehaviourTable::validated(
        &bits,
        &numbers("fingers_m_s")?,
        &numbers("hand")?,
        rows.into_iter(),
    )
    .map_err(|fault| fault.to_string())?;
    let hash = format!("{:016x}", checked.hash());
    match super::optional_text(table, "hash")? {
        Some(reported) if reported != hash => Err(format!(
            "has hash = \"{reported}\", but its content has {hash}; leave the hash out after changing \
             a table"
        )),
        _ => Ok(checked),
    }
}

fn bit(name: &str) -> Result<SensorBit, String> {
    let known = || SensorBit::ALL.iter().filter(|bit| **bit != SensorBit::NONE);
    let found = known().find(|bit| bit.name() == name);
    let names: Vec<&'static str> = known().map(|bit| bit.name()).collect();
    found
        .copied()
        .ok_or_else(|| unknown("sensor bit", name, names.iter().copied()))
}

fn row(text: &str) -> Result<[usize; 2], String> {
    let digit = |byte: u8| byte.is_ascii_digit().then(|| usize::from(byte - b'0'));
    match *text.as_bytes() {
        [fingers, hand] => digit(fingers)
            .zip(digit(hand))
            .map(|(fingers, hand)| [fingers, hand]),
        _ => None,
    }
    .ok_or_else(|| {
        format!(
            "has the row \"{text}\", needs two digits: the levels of the fingers and of the \
            hand"
        )
    })
}

fn number(value: &Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn list<'a, T>(
    table: &'a Table,
    key: &str,
    of: &str,
    get: impl Fn(&'a Value) -> Option<T>,
) -> Result<Vec<T>, String> {
    let value = table.get(key).ok_or_else(|| format!("has no {key}"))?;
    let values = value
        .as_array()
        .and_then(|list| list.iter().map(get).collect());
    values.ok_or_else(|| format!("{key} is {value}, needs a list of {of}"))
}

/// The table in the format that `read` reads.
pub(super) fn table_text(table: &BehaviourTable) -> String {
    let bits: Vec<String> = table.bits().map(|bit| format!("\"{bit}\"")).collect();
    let levels = |levels: [f64; shm_schemas::capacity::LEVELS]| {
        levels.map(|level| format!("{level:?}")).join(", ")
    };
    let rows: Vec<String> = (0..table.rows())
        .map(|row| table.levels(row).map(|level| level.to_string()).concat())
        .collect();
    format!(
        "{{ bits = [{}], fingers_m_s = [{}], hand = [{}], rows = \"{}\", hash = \"{:016x}\" }}",
        bits.join(", "),
        levels(table.fingers_m_s()),
        levels(table.hand()),
        rows.join(" "),
        table.hash()
    )
}
