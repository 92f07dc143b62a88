//! Reads text files of limited size.
//!
//! A pipe would block its reader until a writer comes, and a device may never end. Foreign files
//! are therefore regular files of limited size.
#![forbid(unsafe_code)]

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Largest text file, bytes. Design choice: ten times the largest public URDF.
pub const BYTES_MAX: u64 = 4 << 20;

/// Most problems of a file that its loader reports. Design choice: more than a user repairs at
/// once.
pub const PROBLEMS_MAX: usize = 100;

/// Reads a regular file of at most [`BYTES_MAX`] bytes as UTF-8 text.
///
/// # Errors
/// As [`read_at_most`].
pub fn read(path: impl AsRef<Path>) -> io::Result<String> {
    read_at_most(path, BYTES_MAX)
}

/// Reads a regular file of at most `bytes_max` bytes as UTF-8 text.
///
/// # Errors
/// The file cannot be read, is not a regular file, is larger or is not UTF-8.
pub fn read_at_most(path: impl AsRef<Path>, bytes_max: u64) -> io::Result<String> {
    let path = path.as_ref();
    // By convention, `/dev/null` is the empty file.
    if !fs::metadata(path)?.is_file() && path != Path::new("/dev/null") {
        return Err(refused("it is not a regular file"));
    }
    let mut text = String::new();
    // The file may grow after the check.
    File::open(path)?
        .take(bytes_max.saturating_add(1))
        .read_to_string(&mut text)
        .map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => {
                refused("it is not UTF-8; convert it, for example with `iconv -t UTF-8`")
            }
            _ => error,
        })?;
    if text.len() as u64 > bytes_max {
        return Err(refused(&format!("it has more than {bytes_max} bytes")));
    }
    Ok(text)
}

fn refused(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pipes_folders_and_large_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let made = std::process::Command::new("mkfifo")
            .arg(path("pipe"))
            .status();
        assert!(made.expect("mkfifo starts").success());
        fs::write(path("full"), vec![b'#'; BYTES_MAX as usize]).expect("written");
        fs::write(path("large"), vec![b'#'; BYTES_MAX as usize + 1]).expect("written");
        fs::write(path("binary"), [0xff]).expect("written");
        let check = |name: &str, expected: &str| {
            let outcome = read(path(name)).map_or_else(|e| e.to_string(), |_| String::new());
            assert!(outcome.contains(expected), "{name}: {outcome}");
            assert_eq!(outcome.is_empty(), expected.is_empty(), "{name}: {outcome}");
        };
        check("pipe", "not a regular file");
        check(".", "not a regular file");
        check("full", "");
        check("/dev/null", "");
        check("large", "more than 4194304 bytes");
        check("binary", "UTF-8");
        check("missing", "No such file");
    }
}
