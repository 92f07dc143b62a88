//! Private keys: files that only their user can read.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use crate::rejection::rejected;

/// Permissions of all users except the owner.
const OTHERS: u32 = 0o077;

/// Reads a private key. Rejects a file that other users can read or change.
pub(crate) fn read_private(file: &Path) -> anyhow::Result<String> {
    let meta = fs::metadata(file).map_err(|error| rejected(file, &error))?;
    let mode = meta.permissions().mode() & 0o777;
    if mode & OTHERS != 0 {
        let why = format!(
            "other users can read this private key (mode {mode:04o}); run `chmod 600 {}`",
            file.display()
        );
        return Err(rejected(file, &why));
    }
    let user = rustix::process::geteuid().as_raw();
    if ![user, 0].contains(&meta.uid()) {
        let why = format!(
            "this private key belongs to user {}; it needs to belong to user {user} or root",
            meta.uid()
        );
        return Err(rejected(file, &why));
    }
    atas_text_file::read(file).map_err(|error| rejected(file, &error))
}

/// Writes a new file; a private one only for its user.
pub(crate) fn write_new(file: &Path, text: &str, is_private: bool) -> anyhow::Result<()> {
    let mode = if is_private { 0o600 } else { 0o644 };
    let created = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(mode)
        .open(file);
    created
        .and_then(|mut created| created.write_all(text.as_bytes()))
        .map_err(|error| anyhow::anyhow!("could not write {}: {error}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn key_readable_by_others_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let key = folder.path().join("key.pem");
        write_new(&key, "secret", true).expect("written");
        assert_eq!(read_private(&key).expect("private"), "secret");
        for mode in [0o640, 0o604, 0o620, 0o644] {
            fs::set_permissions(&key, fs::Permissions::from_mode(mode)).expect("set");
            let why = read_private(&key).expect_err("refused").to_string();
            assert!(why.contains("chmod 600"), "{mode:o}: {why}");
        }
    }
}
