//! `atas recordings`: lists the recordings of a folder and copies one of them.
//!
//! A server for other machines runs these commands with its own folder. Names come from foreign
//! clients: the argument parser rejects folders, and only regular files are opened.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::Context;
use atas_console::arguments::Recordings;
use atas_console::{Exit, ExitError, Output, print_fetched, table};
use rustix::fs::{Mode, OFlags, open};
use serde_json::json;

/// Bytes per copied piece.
const PIECE: usize = 64 << 10;

/// A recording in a folder.
struct Entry {
    name: String,
    bytes: u64,
    age_s: u64,
}

pub(crate) fn recordings(action: &Recordings, output: &mut Output) -> anyhow::Result<()> {
    match action {
        Recordings::List { folder } => list(folder_or_current(folder.as_ref()), output),
        Recordings::Fetch {
            name,
            out,
            folder,
            stdout,
        } => {
            let mut file = open_recording(folder_or_current(folder.as_ref()), name)?;
            if *stdout {
                return copy(&mut file, &mut |piece| output.bytes(piece)).map(|_| ());
            }
            let out = out.clone().unwrap_or_else(|| name.into());
            fetch(&mut file, &out, output)
        }
    }
}

fn folder_or_current(folder: Option<&PathBuf>) -> &Path {
    folder.map_or(Path::new("."), PathBuf::as_path)
}

fn list(folder: &Path, output: &mut Output) -> anyhow::Result<()> {
    let entries = entries(folder).map_err(|error| {
        let sentence = format!("could not list {}: {error}", folder.display());
        ExitError::with_code(Exit::Input, sentence)
    })?;
    if output.is_json() {
        let rows: Vec<_> = entries
            .iter()
            .map(|entry| json!({"name": entry.name, "bytes": entry.bytes, "age_s": entry.age_s}))
            .collect();
        return output.json(&json!({ "recordings": rows }));
    }
    if entries.is_empty() {
        return output.line("no recordings");
    }
    let mut rows = table(&["recording", "MB", "age"]);
    for entry in entries {
        let megabytes = format!("{:.1}", entry.bytes as f64 * 1e-6);
        rows.add_row([entry.name, megabytes, age_text(entry.age_s)]);
    }
    output.table(rows)
}

/// Returns the recordings of a folder, the newest first.
fn entries(folder: &Path) -> io::Result<Vec<Entry>> {
    let now = SystemTime::now();
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(name) = entry.file_name().into_string() else {
            continue;
        };
        // Another process may have removed the file.
        let Ok(meta) = entry.metadata() else { continue };
        if !meta.is_file() || !name.ends_with(".mcap") || name.starts_with('.') {
            continue;
        }
        let age = now.duration_since(meta.modified()?).unwrap_or_default();
        found.push((age, name, meta.len()));
    }
    found.sort();
    let entry = |(age, name, bytes): (std::time::Duration, String, u64)| Entry {
        name,
        bytes,
        age_s: age.as_secs(),
    };
    Ok(found.into_iter().map(entry).collect())
}

fn age_text(seconds: u64) -> String {
    match seconds {
        0..120 => format!("{seconds} s"),
        120..7_200 => format!("{} min", seconds / 60),
        7_200..172_800 => format!("{} h", seconds / 3_600),
        _ => format!("{} days", seconds / 86_400),
    }
}

/// Opens a regular file of the folder. A link could lead out of the folder, and a pipe could block.
fn open_recording(folder: &Path, name: &str) -> anyhow::Result<File> {
    let rejected = |why: String| {
        let sentence = format!(
            "could not read recording {name}: {why}; `atas recordings list` prints the names"
        );
        ExitError::with_code(Exit::Input, sentence)
    };
    let flags = OFlags::RDONLY | OFlags::CLOEXEC | OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let file = open(folder.join(name), flags, Mode::empty())
        .map_err(|error| rejected(io::Error::from(error).to_string()))?;
    let file = File::from(file);
    match file.metadata() {
        Ok(meta) if meta.is_file() => Ok(file),
        _ => Err(rejected("it is not a regular file".into())),
    }
}

fn fetch(file: &mut File, out: &Path, output: &mut Output) -> anyhow::Result<()> {
    let mut created = File::create_new(out).map_err(|error| {
        let sentence = format!("could not create {}: {error}", out.display());
        ExitError::with_code(Exit::Failed, sentence)
    })?;
    let bytes = copy(file, &mut |piece| {
        created
            .write_all(piece)
            .with_context(|| format!("could not write {}", out.display()))
    })?;
    print_fetched(out, bytes, output)
}

/// Copies the length that the file has now: a recorder may append to it.
fn copy(
    file: &mut File,
    write: &mut dyn FnMut(&[u8]) -> anyhow::Result<()>,
) -> anyhow::Result<u64> {
    let length = file
        .metadata()
        .context("could not read the recording")?
        .len();
    let mut rest = file.take(length);
    let (mut piece, mut copied) = (vec![0; PIECE], 0);
    loop {
        let bytes = rest
            .read(&mut piece)
            .context("could not read the recording")?;
        if bytes == 0 {
            return Ok(copied);
        }
        write(&piece[..bytes])?;
        copied += bytes as u64;
    }
}
