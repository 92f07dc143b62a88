//! Location of a bus: its folder and the prefix of its names in `/dev/shm`.
//!
//! In `/dev/shm` any user can create files and list names. Each life of the bus therefore draws a
//! random prefix and keeps it in the private folder. No other user can create a file in advance;
//! one created later is neither opened nor counted.

use std::ffi::OsStr;
use std::fs::{self, Metadata, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, Path as IoxPath, SemanticString};

use crate::clock::nonce;
use crate::error::BusError;
use crate::folder::{Folder, SHM, entries_named};
use crate::name::BusName;
use crate::user::uid;

/// File in the bus's folder that contains the prefix.
pub(crate) const PREFIX: &str = "prefix";
/// File in the bus's folder with the version of the program that created the bus.
pub(crate) const VERSION_FILE: &str = "version";

/// Location of one bus during one life.
#[derive(Clone, Debug)]
pub(crate) struct Location {
    pub(crate) folder: Folder,
    /// Prefix of all names of the bus in `/dev/shm`.
    pub(crate) prefix: String,
}

impl Location {
    /// The location stored in the folder, if any. Call under the start-up lock only.
    pub(crate) fn read(folder: &Folder) -> Result<Option<Self>, BusError> {
        let path = folder.path.join(PREFIX);
        match fs::read_to_string(&path) {
            Ok(text) => Ok(is_prefix(&text, &folder.bus).then(|| Self {
                folder: folder.clone(),
                prefix: text,
            })),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(BusError::io("read", &path)(e)),
        }
    }

    /// Draws and stores a new prefix. Call under the start-up lock only, when no process is on the
    /// bus.
    pub(crate) fn create(folder: &Folder) -> Result<Self, BusError> {
        let prefix = format!("{}_{:016x}_", folder.bus, nonce());
        replace(folder, PREFIX, &prefix)?;
        Ok(Self {
            folder: folder.clone(),
            prefix,
        })
    }

    pub(crate) fn bus(&self) -> &BusName {
        &self.folder.bus
    }

    pub(crate) fn root(&self) -> &Path {
        &self.folder.path
    }

    /// iceoryx2's settings for this location.
    pub(crate) fn config(&self) -> Result<Config, BusError> {
        let why = |e| BusError::UnsafeRoot {
            path: self.root().to_owned(),
            why: format!("iceoryx2 rejects its name: {e:?}"),
        };
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(why)?;
        let root = IoxPath::new(self.root().as_os_str().as_encoded_bytes()).map_err(why)?;
        config.global.set_root_path(&root);
        Ok(config)
    }

    /// All files of this bus in `/dev/shm`.
    pub(crate) fn shared_memory(&self) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
        self.entries_with_prefix().filter(|(_, meta)| is_own(meta))
    }

    /// Path and owner of a foreign file in `/dev/shm` with the bus's prefix.
    pub(crate) fn foreign_file(&self) -> Option<(PathBuf, u32)> {
        let stranger = self.entries_with_prefix().find(|(_, meta)| !is_own(meta));
        stranger.map(|(path, meta)| (path, meta.uid()))
    }

    fn entries_with_prefix(&self) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
        let prefix = self.prefix.clone();
        entries_named(Path::new(SHM), move |name| starts_with(name, &prefix))
    }
}

fn is_own(meta: &Metadata) -> bool {
    meta.is_file() && meta.uid() == uid()
}

fn starts_with(name: &OsStr, prefix: &str) -> bool {
    name.as_encoded_bytes().starts_with(prefix.as_bytes())
}

fn is_prefix(text: &str, bus: &BusName) -> bool {
    let drawn = text
        .strip_prefix(bus.as_str())
        .and_then(|rest| rest.strip_prefix('_'))
        .and_then(|rest| rest.strip_suffix('_'));
    drawn.is_some_and(|drawn| drawn.len() == 16 && drawn.bytes().all(|b| b.is_ascii_hexdigit()))
}

/// Writes a file of the folder. Writes to a temporary name first, so that the final file is always
/// complete.
pub(crate) fn replace(folder: &Folder, name: &str, text: &str) -> Result<(), BusError> {
    let path = folder.path.join(name);
    let new = folder.path.join(format!("{name}.new"));
    write(&new, text)
        .and_then(|()| fs::rename(&new, &path))
        .map_err(BusError::io("write", &path))
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true).mode(0o600);
    options.open(path)?.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefix_format_is_validated() {
        let check = |text: &str, valid: bool| {
            assert_eq!(is_prefix(text, &BusName::default()), valid, "{text:?}");
        };
        check("atas_0123456789abcdef_", true);
        check("atas_0123456789abcdef", false);
        check("other_0123456789abcdef_", false);
        check("atas_0123456789abcde/_", false);
        check("atas_", false);
        check("", false);
    }
}
