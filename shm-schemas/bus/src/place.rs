//! The place of a bus: its folder, and what its names in `/dev/shm` begin with.
//!
//! `/dev/shm` belongs to everybody: any user may make files there and read the names of ours. So the prefix is drawn at
//! random for each life of the bus and kept in the private folder. Nobody can prepare a file for it, and what a stranger
//! makes under it later is no part of the bus: it is neither opened nor counted.

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

/// File in the bus's folder that holds the prefix.
pub(crate) const PREFIX: &str = "prefix";

/// The place of one bus, for as long as it lives.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) folder: Folder,
    /// What every name of the bus in `/dev/shm` begins with.
    pub(crate) prefix: String,
}

impl Place {
    /// The place whose prefix stands in the folder, if one does. Call under the start-up lock only.
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

    /// A place with a new prefix. Call under the start-up lock only, when nobody is on the bus.
    pub(crate) fn draw(folder: &Folder) -> Result<Self, BusError> {
        let prefix = format!("{}_{:016x}_", folder.bus, nonce());
        // A name of its own first: a file that is there is whole, whenever its maker is killed.
        let (path, new) = (folder.path.join(PREFIX), folder.path.join("prefix.new"));
        write(&new, &prefix)
            .and_then(|()| fs::rename(&new, &path))
            .map_err(BusError::io("write", &path))?;
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

    /// iceoryx2's settings for this place.
    pub(crate) fn config(&self) -> Result<Config, BusError> {
        let why = |e| BusError::UnsafeRoot {
            path: self.root().to_owned(),
            why: format!("iceoryx2 refuses its name: {e:?}"),
        };
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(why)?;
        let root = IoxPath::new(self.root().as_os_str().as_encoded_bytes()).map_err(why)?;
        config.global.set_root_path(&root);
        Ok(config)
    }

    /// Everything of this bus in `/dev/shm`.
    pub(crate) fn shared_memory(&self) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
        self.named().filter(|(_, meta)| is_ours(meta))
    }

    /// What a stranger put under our names into `/dev/shm`.
    pub(crate) fn squatted(&self) -> Option<(PathBuf, u32)> {
        let stranger = self.named().find(|(_, meta)| !is_ours(meta));
        stranger.map(|(path, meta)| (path, meta.uid()))
    }

    fn named(&self) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
        let prefix = self.prefix.clone();
        entries_named(Path::new(SHM), move |name| starts_with(name, &prefix))
    }
}

fn is_ours(meta: &Metadata) -> bool {
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

fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true).mode(0o600);
    options.open(path)?.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_drawn_is_a_prefix() {
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
