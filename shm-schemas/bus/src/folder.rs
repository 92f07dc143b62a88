//! Folder of a bus: its path and the check that it is private.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder, Metadata};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use crate::error::{BusError, HiddenFolders};
use crate::name::BusName;
use crate::user::{User, uid};

/// Folder of the system service, made by systemd (`RuntimeDirectory=atas`).
const SERVICE_BASE: &str = "/run/atas";
/// Maximum path length of the folder, bytes. A socket address has 108 (`unix(7)`); iceoryx2's file
/// names take up to 44.
const ROOT_BYTES_MAX: usize = 64;
/// Directory of POSIX shared memory on Linux.
pub(crate) const SHM: &str = "/dev/shm";

/// Folder of one bus. It need not exist.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    pub(crate) bus: BusName,
    pub(crate) path: PathBuf,
}

impl Folder {
    /// `/run/atas/<bus>` for the service's user, else `$XDG_RUNTIME_DIR/atas/<bus>`, else
    /// `/dev/shm/atas-<uid>/<bus>`.
    pub(crate) fn for_bus(bus: &BusName) -> Result<Self, BusError> {
        let xdg = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
        Self::under(base_folder(Path::new(SERVICE_BASE), xdg.as_deref()), bus)
    }

    fn under(base: PathBuf, bus: &BusName) -> Result<Self, BusError> {
        let path = base.join(bus.as_str());
        if path.as_os_str().len() > ROOT_BYTES_MAX {
            let why = format!("its path has more than {ROOT_BYTES_MAX} bytes");
            return Err(BusError::UnsafeRoot { path, why });
        }
        Ok(Self {
            bus: bus.clone(),
            path,
        })
    }

    /// Creates the folder and its parent if they do not exist, and checks both.
    pub(crate) fn make(&self) -> Result<(), BusError> {
        if let Some(base_folder) = self.path.parent() {
            make_private(base_folder)?;
        }
        make_private(&self.path)
    }

    /// Checks the folder without creating it.
    ///
    /// Fails with [`BusError::OtherUser`] if another user has this bus, else with
    /// [`BusError::Absent`].
    pub(crate) fn find(&self) -> Result<(), BusError> {
        match fs::symlink_metadata(&self.path) {
            Ok(meta) => check_private(&self.path, &meta),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Err(self.missing_error()),
            Err(e) => Err(BusError::io("examine", &self.path)(e)),
        }
    }

    /// The error for a folder that does not exist.
    fn missing_error(&self) -> BusError {
        let (bus, folder) = (self.bus.to_string(), self.path.clone());
        let bases = other_users_folders(Path::new(SERVICE_BASE), Path::new(SHM));
        match other_users_bus(&self.bus, &bases, Path::new(SHM)) {
            Some((place, user)) => BusError::OtherUser {
                bus,
                folder,
                place,
                user: user.to_string(),
            },
            None => BusError::Absent {
                bus,
                folder,
                unseen: HiddenFolders(hidden_folders(&self.bus, &bases)),
            },
        }
    }
}

/// Folders for buses of other users, with their owners: the service's, and those below `/dev/shm`.
/// Any user may list these.
fn other_users_folders(service: &Path, shm: &Path) -> Vec<(PathBuf, User)> {
    let service = fs::symlink_metadata(service)
        .ok()
        .map(|meta| (service.to_owned(), meta));
    service
        .into_iter()
        .chain(entries_named(shm, |name| {
            is_user_folder(&name.to_string_lossy())
        }))
        .filter(|(_, meta)| meta.is_dir() && meta.uid() != uid())
        .map(|(path, meta)| (path, User(meta.uid())))
        .collect()
}

/// Path and owner of another user's bus of this name: its shared memory, whose names any user may
/// list, or its folder.
fn other_users_bus(
    bus: &BusName,
    bases: &[(PathBuf, User)],
    shm: &Path,
) -> Option<(PathBuf, User)> {
    let mut memory = entries_named(shm, |name| {
        prefix_of(&name.to_string_lossy(), bus).is_some()
    });
    let memory = memory.find(|(_, meta)| meta.uid() != uid());
    if let Some((path, meta)) = memory {
        // Shows the common prefix; the rest of each name is long and carries no information.
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let all = format!("{}*", prefix_of(&name, bus).unwrap_or_default());
        return Some((shm.join(all), User(meta.uid())));
    }
    let folders = bases
        .iter()
        .map(|(base_folder, user)| (base_folder.join(bus.as_str()), *user));
    let mut there = folders.filter(|(folder, _)| fs::symlink_metadata(folder).is_ok());
    there.next()
}

/// Folders of other users that may contain this bus but that this user may not read.
fn hidden_folders(bus: &BusName, bases: &[(PathBuf, User)]) -> Vec<(PathBuf, String)> {
    let is_closed = |base: &Path| {
        let folder = fs::symlink_metadata(base.join(bus.as_str()));
        folder.is_err_and(|e| e.kind() == io::ErrorKind::PermissionDenied)
    };
    let closed = bases
        .iter()
        .filter(|(base_folder, _)| is_closed(base_folder));
    closed
        .map(|(base_folder, user)| (base_folder.clone(), user.to_string()))
        .collect()
}

/// The prefix of a name in `/dev/shm` if it is shared memory of this bus.
fn prefix_of<'a>(name: &'a str, bus: &BusName) -> Option<&'a str> {
    let rest = name.strip_prefix(bus.as_str())?.strip_prefix('_')?;
    let (drawn, rest) = rest.split_once('_')?;
    let is_drawn = drawn.len() == 16 && drawn.bytes().all(|b| b.is_ascii_hexdigit());
    is_drawn.then(|| &name[..name.len() - rest.len()])
}

/// Checks for the name of a user's bus folder in `/dev/shm`.
fn is_user_folder(name: &str) -> bool {
    name.strip_prefix("atas-")
        .is_some_and(|uid| uid.parse::<u32>().is_ok())
}

/// Entries of a folder; empty if it cannot be read. Links are not followed.
pub(crate) fn entries(folder: &Path) -> impl Iterator<Item = (PathBuf, Metadata)> + use<> {
    entries_named(folder, |_| true)
}

/// Entries whose name matches. Others are not examined: `/dev/shm` is shared and may hold hundreds.
pub(crate) fn entries_named<F: Fn(&OsStr) -> bool>(
    folder: &Path,
    wanted: F,
) -> impl Iterator<Item = (PathBuf, Metadata)> + use<F> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let wanted = entries.filter(move |entry| wanted(&entry.file_name()));
    wanted.filter_map(|entry| Some((entry.path(), entry.metadata().ok()?)))
}

/// Folder that contains this user's buses.
///
/// The fallback is not `/tmp`: systemd removes files older than ten days there. On a disk,
/// iceoryx2's `fsync` of each small file takes 3 to 5 ms (measured, ext4), 60 ms per daemon start.
fn base_folder(service: &Path, xdg: Option<&Path>) -> PathBuf {
    let usable = |path: &Path| {
        path.is_absolute() && fs::symlink_metadata(path).is_ok_and(|m| privacy_fault(&m).is_none())
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
            Err(BusError::io("create the folder", path)(e))
        }
        _ => {
            let meta = fs::symlink_metadata(path).map_err(BusError::io("examine", path))?;
            check_private(path, &meta)
        }
    }
}

fn check_private(path: &Path, meta: &Metadata) -> Result<(), BusError> {
    match privacy_fault(meta) {
        None => Ok(()),
        Some(why) => Err(BusError::UnsafeRoot {
            path: path.to_owned(),
            why,
        }),
    }
}

/// Reason why other users could change the folder. A group may read (systemd's
/// `RuntimeDirectoryMode=0750`), never write.
fn privacy_fault(meta: &Metadata) -> Option<String> {
    if !meta.is_dir() {
        return Some("it is not a folder".to_owned());
    }
    if meta.uid() != uid() {
        return Some(format!(
            "it belongs to user {}, not to user {}",
            User(meta.uid()),
            User(uid())
        ));
    }
    let open = meta.mode() & 0o027;
    (open != 0).then(|| {
        format!(
            "its mode {:o} gives access to other users",
            meta.mode() & 0o7777
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    fn scratch(label: &str) -> PathBuf {
        let path = std::env::temp_dir().join(BusName::fresh(label).as_str());
        DirBuilder::new()
            .mode(0o700)
            .create(&path)
            .expect("folder is created");
        path
    }

    #[test]
    fn non_private_folder_is_rejected() {
        let scratch = scratch("private");
        let check = |mode: u32, safe: bool| {
            let path = scratch.join(format!("{mode:o}"));
            fs::create_dir(&path).expect("folder");
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("mode");
            assert_eq!(make_private(&path).is_ok(), safe, "mode {mode:o}");
            assert_eq!(
                base_folder(&path, None) == path,
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
    fn link_or_file_as_folder_is_rejected() {
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
            "existing private folder is reused"
        );
        fs::remove_dir_all(&scratch).expect("clean");
    }

    #[test]
    fn foreign_base_folder_is_skipped() {
        let none = Path::new("/nonexistent");
        let own = PathBuf::from(format!("/dev/shm/atas-{}", uid()));
        assert_eq!(base_folder(none, None), own);
        assert_eq!(base_folder(none, Some(Path::new("relative"))), own);
        assert_eq!(base_folder(none, Some(Path::new("/tmp"))), own);
        let xdg = scratch("xdg");
        assert_eq!(base_folder(none, Some(&xdg)), xdg.join("atas"));
        fs::remove_dir_all(&xdg).expect("clean");
    }

    #[test]
    fn long_folder_path_is_rejected() {
        let base = PathBuf::from(format!("/{}", "x".repeat(ROOT_BYTES_MAX)));
        assert!(Folder::under(base, &BusName::default()).is_err());
    }

    #[test]
    fn shared_memory_names_are_recognised() {
        let bus = BusName::default();
        let check = |name: &str, expected: (Option<&str>, bool)| {
            assert_eq!(
                (prefix_of(name, &bus), is_user_folder(name)),
                expected,
                "{name}"
            );
        };
        let prefix = "atas_0123456789abcdef_";
        check(&format!("{prefix}x.dynamic"), (Some(prefix), false));
        check("atas-2_0123456789abcdef_x.dynamic", (None, false));
        check("atas_0123456789abcde_x", (None, false));
        check("atas", (None, false));
        check("atas-1000", (None, true));
        check("atas-x", (None, false));
    }
}
