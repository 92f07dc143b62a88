//! Atomic file writes and exclusive folders.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use field::{Model, Preset};
use hmac_sha256::Hash;
use serde::Serialize;

use crate::error::{Error, Result};

/// Replaces a file atomically: readers get the old or the new content.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<()> {
    stream_atomically(path, |file| file.write_all(content))
}

/// Writes a value as TOML atomically.
pub(crate) fn write_toml(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = toml::to_string(value).map_err(Error::from_part)?;
    write_atomically(path, text.as_bytes())
}

pub(crate) fn is_of_kind(text: &str, kind: &str) -> bool {
    text.lines()
        .any(|line| line.replace(' ', "") == format!("kind=\"{kind}\""))
}

/// Writes as [`write_atomically`], for content that does not fit in memory.
pub fn stream_atomically(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<()> {
    let temporary = sibling(path, ".tmp");
    let write = || {
        let mut file = BufWriter::new(File::create(&temporary)?);
        content(&mut file)?;
        file.into_inner()
            .map_err(|error| error.into_error())?
            .sync_all()?;
        std::fs::rename(&temporary, path)?;
        sync_folder(path)
    };
    write().map_err(|error| {
        // If the temporary file cannot be removed either, the error below gives the cause.
        let _ = std::fs::remove_file(&temporary);
        Error::io("write", path)(error)
    })
}

/// Replaces a file atomically without waiting for the disk. For files with their own hash that may
/// be lost in a power cut.
pub fn replace_unsynced(path: &Path, content: &[u8]) -> Result<()> {
    let temporary = sibling(path, ".tmp");
    std::fs::write(&temporary, content)
        .and_then(|()| std::fs::rename(&temporary, path))
        .map_err(Error::io("write", path))
}

/// Returns the path with a suffix appended to the file name.
#[must_use]
pub fn sibling(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(suffix);
    path.with_file_name(name)
}

/// A rename survives a power cut only if the folder is synced.
fn sync_folder(path: &Path) -> std::io::Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// Reads a text file.
pub fn read_text(path: &Path) -> Result<String> {
    atas_text_file::read(path).map_err(|error| {
        Error::refused(
            format_args!("read {}", path.display()),
            format_args!("{error}"),
            "a readable text file",
            "check the path",
        )
    })
}

/// Returns a field: a built-in preset by name, or one from a TOML file.
///
/// # Errors
/// There is none of this name, or the file or its values are invalid.
pub fn preset(name: &str) -> Result<Preset> {
    let path = Path::new(name);
    let preset = match Preset::named(name) {
        Some(preset) => preset,
        None if path.exists() => toml::from_str(&read_text(path)?).map_err(|error| {
            Error::refused(
                format_args!("use preset {}", path.display()),
                error.message(),
                "a preset as printed by ebts preset, or base and the keys that differ",
                "correct the file",
            )
        })?,
        None => {
            let names = Preset::ALL
                .map(|preset| preset.name.into_owned())
                .join(", ");
            return Err(Error::refused(
                "choose a preset",
                format_args!("{name:?} is neither a preset nor a file"),
                format_args!("one of {names}, or a TOML file"),
                "correct the preset",
            ));
        }
    };
    Model::new(preset)
        .map(|model| model.preset().clone())
        .map_err(Error::from_part)
}

/// Removes a file if it exists.
pub fn remove_if_exists(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::io("remove", path)(error)),
        _ => Ok(()),
    }
}

/// Renames an unusable file to `.damaged`, replacing an older one of that name; returns the new
/// path.
pub(crate) fn rename_damaged(path: &Path) -> Result<PathBuf> {
    let kept = sibling(path, ".damaged");
    std::fs::rename(path, &kept).map_err(Error::io("rename", path))?;
    Ok(kept)
}

/// Returns a file name that stays inside its folder: characters other than letters, digits, dots,
/// dashes and underscores become underscores, and a leading dot is escaped.
#[must_use]
pub fn plain_name(text: &str) -> String {
    let plain = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' | '_' | '.' => c,
        _ => '_',
    };
    let name: String = text.chars().take(60).map(plain).collect();
    match name.strip_prefix('.') {
        Some(rest) => format!("_{rest}"),
        None => name,
    }
}

/// Exclusive lock of a folder; the system releases it when the process ends.
#[derive(Debug)]
pub struct FolderLock(#[expect(dead_code, reason = "held for its lock")] File);

impl FolderLock {
    /// Creates the folder if necessary and locks it.
    ///
    /// # Errors
    /// [`Error::Busy`] if another process holds the lock.
    pub fn take(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(Error::io("create folder", folder))?;
        let path = folder.join(".lock");
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(&path)
            .map_err(Error::io("open", &path))?;
        match file.try_lock() {
            Ok(()) => Ok(Self(file)),
            Err(TryLockError::WouldBlock) => Err(Error::Busy(folder.to_owned())),
            Err(TryLockError::Error(error)) => Err(Error::io("lock", &path)(error)),
        }
    }
}

/// Returns the SHA-256 in hexadecimal.
#[must_use]
pub fn sha256(content: &[u8]) -> String {
    Hash::hash(content)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_name_stays_in_its_folder() {
        for (text, expected) in [
            ("R3", "R3"),
            ("../../etc/passwd", "_._.._etc_passwd"),
            ("..", "_."),
            ("/tmp/x", "_tmp_x"),
            ("a b\nc\0", "a_b_c_"),
            ("größer", "gr__er"),
        ] {
            assert_eq!(plain_name(text), expected, "{text:?}");
        }
    }
}
