//! Where a bus lives: its own folder for iceoryx2's files and locks, its own prefix for names in `/dev/shm`.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder, Metadata, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::prelude::{FileName, Path as IoxPath, SemanticString};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

use crate::{BusError, BusName};

/// Folder of the service, made by systemd (`RuntimeDirectory=atas`).
const SERVICE_BASE: &str = "/run/atas";
/// Longest folder, bytes. Socket addresses have 108 (`unix(7)`), of which iceoryx2's file names take up to 44.
const ROOT_MAX: usize = 64;
/// Where Linux keeps POSIX shared memory.
pub(crate) const SHM: &str = "/dev/shm";

/// The place of one bus. Made, and known to be private, when this value exists.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) bus: BusName,
    /// Folder of the bus.
    pub(crate) root: PathBuf,
    /// What every name of the bus in `/dev/shm` begins with. It contains a hash of the folder, so that buses of the
    /// same name in different folders do not meet either.
    pub(crate) prefix: String,
}

impl Place {
    /// Finds or makes the place: `/run/atas/<bus>` for the service's user, else `$XDG_RUNTIME_DIR/atas/<bus>`, else
    /// `/dev/shm/atas-<uid>/<bus>`.
    pub(crate) fn of(bus: &BusName) -> Result<Self, BusError> {
        let xdg = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
        let place = Self::under(base(Path::new(SERVICE_BASE), xdg.as_deref()), bus)?;
        place.make()?;
        Ok(place)
    }

    fn under(base: PathBuf, bus: &BusName) -> Result<Self, BusError> {
        let root = base.join(bus.as_str());
        if root.as_os_str().len() > ROOT_MAX {
            let why = format!("its name has more than {ROOT_MAX} bytes");
            return Err(BusError::UnsafeRoot { path: root, why });
        }
        let hash = fnv1a(FNV_OFFSET, root.as_os_str().as_encoded_bytes()) as u32;
        Ok(Self {
            bus: bus.clone(),
            prefix: format!("{bus}_{hash:08x}_"),
            root,
        })
    }

    /// Makes the folder and the one above it where they do not exist, and checks both.
    pub(crate) fn make(&self) -> Result<(), BusError> {
        if let Some(base) = self.root.parent() {
            make_private(base)?;
        }
        make_private(&self.root)
    }

    /// iceoryx2's settings for this place.
    pub(crate) fn config(&self) -> Result<Config, BusError> {
        let why = |e| BusError::UnsafeRoot {
            path: self.root.clone(),
            why: format!("iceoryx2 refuses its name: {e:?}"),
        };
        let mut config = Config::default();
        config.global.prefix = FileName::new(self.prefix.as_bytes()).map_err(why)?;
        let root = IoxPath::new(self.root.as_os_str().as_encoded_bytes()).map_err(why)?;
        config.global.set_root_path(&root);
        Ok(config)
    }

    /// Everything of this bus in `/dev/shm`, whoever made it.
    pub(crate) fn shared_memory(&self) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
        let prefix = self.prefix.clone();
        let named = move |path: &Path| {
            path.file_name()
                .is_some_and(|name| starts_with(name, &prefix))
        };
        entries(Path::new(SHM)).filter(move |(path, _)| named(path))
    }

    /// Refuses if someone else put something under our names into `/dev/shm`, where every user may make files.
    pub(crate) fn check_shared_memory(&self) -> Result<(), BusError> {
        match self
            .shared_memory()
            .find(|(_, meta)| !meta.is_file() || meta.uid() != uid())
        {
            None => Ok(()),
            Some((path, meta)) => {
                let why = format!("user {} put it there", meta.uid());
                Err(BusError::UnsafeRoot { path, why })
            }
        }
    }

    /// Takes from others what iceoryx2 grants them: its node counter is open to all users.
    pub(crate) fn close_shared_memory(&self) -> Result<(), BusError> {
        for (path, _) in self
            .shared_memory()
            .filter(|(_, meta)| meta.mode() & 0o077 != 0)
        {
            let private = Permissions::from_mode(0o600);
            fs::set_permissions(&path, private).map_err(BusError::io("close to others", &path))?;
        }
        Ok(())
    }
}

fn starts_with(name: &OsStr, prefix: &str) -> bool {
    name.as_encoded_bytes().starts_with(prefix.as_bytes())
}

/// The files and folders in a folder; nothing if it cannot be read. Links are not followed.
pub(crate) fn entries(folder: &Path) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((entry.path(), entry.metadata().ok()?)))
}

pub(crate) fn uid() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// The folder that holds this user's buses.
///
/// The last resort is not `/tmp`: systemd removes from it what is ten days old, and on a disk iceoryx2's `fsync` of
/// each small file costs 3 to 5 ms (measured, ext4), 60 ms for a daemon's start-up.
fn base(service: &Path, xdg: Option<&Path>) -> PathBuf {
    let usable = |path: &Path| {
        path.is_absolute() && fs::symlink_metadata(path).is_ok_and(|m| flaw(&m).is_none())
    };
    if usable(service) {
        return service.to_owned();
    }
    match xdg.filter(|path| usable(path)) {
        Some(xdg) => xdg.join("atas"),
        None => PathBuf::from(format!("{SHM}/atas-{}", uid())),
    }
}

fn make_private(path: &Path) -> Result<(), BusError> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(e) if e.kind() != io::ErrorKind::AlreadyExists => {
            Err(BusError::io("make the folder", path)(e))
        }
        _ => {
            let meta = fs::symlink_metadata(path).map_err(BusError::io("examine", path))?;
            match flaw(&meta) {
                None => Ok(()),
                Some(why) => Err(BusError::UnsafeRoot {
                    path: path.to_owned(),
                    why,
                }),
            }
        }
    }
}

/// Why others could meddle with a folder. A group may read (systemd's `RuntimeDirectoryMode=0750`), never write.
fn flaw(meta: &Metadata) -> Option<String> {
    if !meta.is_dir() {
        return Some("it is not a folder".to_owned());
    }
    if meta.uid() != uid() {
        return Some(format!(
            "it belongs to user {}, not to user {}",
            meta.uid(),
            uid()
        ));
    }
    let open = meta.mode() & 0o027;
    (open != 0).then(|| {
        format!(
            "its mode is {:o}, and others may use it",
            meta.mode() & 0o7777
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    fn scratch(label: &str) -> PathBuf {
        let path = std::env::temp_dir().join(BusName::fresh(label).as_str());
        DirBuilder::new()
            .mode(0o700)
            .create(&path)
            .expect("a fresh folder");
        path
    }

    #[test]
    fn only_private_folders_are_used() {
        let scratch = scratch("private");
        let check = |mode: u32, safe: bool| {
            let path = scratch.join(format!("{mode:o}"));
            fs::create_dir(&path).expect("folder");
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("mode");
            assert_eq!(make_private(&path).is_ok(), safe, "mode {mode:o}");
            assert_eq!(
                base(&path, None) == path,
                safe,
                "mode {mode:o} as the service's folder"
            );
        };
        check(0o700, true);
        check(0o750, true);
        check(0o770, false);
        check(0o755, false);
        check(0o777, false);
        check(0o1777, false);
        fs::remove_dir_all(&scratch).expect("clean");
    }

    #[test]
    fn links_and_files_are_refused() {
        let scratch = scratch("links");
        let (target, link, file) = (
            scratch.join("target"),
            scratch.join("link"),
            scratch.join("file"),
        );
        make_private(&target).expect("made");
        symlink(&target, &link).expect("link");
        fs::write(&file, "").expect("file");
        for path in [&link, &file] {
            let refused = make_private(path).expect_err("unsafe");
            assert!(matches!(refused, BusError::UnsafeRoot { .. }), "{refused}");
        }
        assert!(
            make_private(&target).is_ok(),
            "an existing private folder is used again"
        );
        fs::remove_dir_all(&scratch).expect("clean");
    }

    #[test]
    fn folders_of_others_are_passed_over() {
        let none = Path::new("/nonexistent");
        let own = PathBuf::from(format!("/dev/shm/atas-{}", uid()));
        assert_eq!(base(none, None), own);
        assert_eq!(base(none, Some(Path::new("relative"))), own);
        assert_eq!(base(none, Some(Path::new("/tmp"))), own);
        let xdg = scratch("xdg");
        assert_eq!(base(none, Some(&xdg)), xdg.join("atas"));
        fs::remove_dir_all(&xdg).expect("clean");
    }

    #[test]
    fn long_folders_are_refused_and_prefixes_differ() {
        let bus = BusName::default();
        assert!(Place::under(PathBuf::from(format!("/{}", "x".repeat(ROOT_MAX))), &bus).is_err());
        let prefix = |base: &str| {
            Place::under(PathBuf::from(base), &bus)
                .expect("short")
                .prefix
        };
        assert_ne!(prefix("/run/atas"), prefix("/tmp/atas-1000"));
    }
}
