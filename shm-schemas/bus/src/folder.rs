//! Folder of a bus: its path and the check that it is private.

use std::ffi::OsStr;
use std::fs::{self, DirBuilder, Metadata};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use crate::error::{BusError, Unseen};
use crate::name::BusName;
use crate::user::{User, uid};

/// Folder of the system service, made by systemd (`RuntimeDirectory=atas`).
const SERVICE_BASE: &str = "/run/atas";
/// Maximum path length of the folder, bytes. A socket address has 108 (`unix(7)`); iceoryx2's file
/// names take up to 44.
const ROOT_MAX: usize = 64;
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
    pub(crate) fn of(bus: &BusName) -> Result<Self, BusError> {
        let xdg = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
        Self::under(base(Path::new(SERVICE_BASE), xdg.as_deref()), bus)
    }

    fn under(base: PathBuf, bus: &BusName) -> Result<Self, BusError> {
        let path = base.join(bus.as_str());
        if path.as_os_str().len() > ROOT_MAX {
            let why = format!("its name has more than {ROOT_MAX} bytes");
            return Err(BusError::UnsafeRoot { path, why });
        }
        Ok(Self {
            bus: bus.clone(),
            path,
        })
    }

    /// Creates the folder and its parent if they do not exist, and checks both.
    pub(crate) fn make(&self) -> Result<(), BusError> {
        if let Some(base) = self.path.parent() {
            make_private(base)?;
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
            Err(e) if e.kind() == io::ErrorKind::NotFound => Err(self.missing()),
            Err(e) => Err(BusError::io("examine", &self.path)(e)),
        }
    }

    /// The error for a folder that does not exist.
    fn missing(&self) -> BusError {
        let (bus, folder) = (self.bus.to_string(), self.path.clone());
        let bases = bases_of_others(Path::new(SERVICE_BASE), Path::new(SHM));
        match held(&self.bus, &bases, Path::new(SHM)) {
            Some((place, user)) => BusError::OtherUser {
                bus,
                folder,
                place,
                user: user.to_string(),
            },
            None => BusError::Absent {
                bus,
                folder,
                unseen: Unseen(unseen(&self.bus, &bases)),
            },
        }
    }
}

/// Folders for buses of other users, with their owners: the service's, and those below `/dev/shm`.
/// Any user may list these.
fn bases_of_others(service: &Path, shm: &Path) -> Vec<(PathBuf, User)> {
    let service = fs::symlink_metadata(service)
        .ok()
        .map(|meta| (service.to_owned(), meta));
    service
        .into_iter()
        .chain(entries_named(shm, |name| is_base(&name.to_string_lossy())))
        .filter(|(_, meta)| meta.is_dir() && meta.uid() != uid())
        .map(|(path, meta)| (path, User(meta.uid())))
        .collect()
}

/// Path and owner of another user's bus of this name: its shared memory, whose names any user may
/// list, or its folder.
fn held(bus: &BusName, bases: &[(PathBuf, User)], shm: &Path) -> Option<(PathBuf, User)> {
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
        .map(|(base, user)| (base.join(bus.as_str()), *user));
    let mut there = folders.filter(|(folder, _)| fs::symlink_metadata(folder).is_ok());
    there.next()
}

/// Folders of other users that may contain this bus but that this user may not read.
fn unseen(bus: &BusName, bases: &[(PathBuf, User)]) -> Vec<(PathBuf, String)> {
    let is_closed = |base: &Path| {
        let folder = fs::symlink_metadata(base.join(bus.as_str()));
        folder.is_err_and(|e| e.kind() == io::ErrorKind::PermissionDenied)
    };
    let closed = bases.iter().filter(|(base, _)| is_closed(base));
    closed
        .map(|(base, user)| (base.clone(), user.to_string()))
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
fn is_base(name: &str) -> bool {
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
            check_private(path, &meta)
        }
    }
}

fn check_private(path: &Path, meta: &Metadata) -> Result<(), BusError> {
    match flaw(meta) {
        None => Ok(()),
        Some(why) => Err(BusError::UnsafeRoot {
            path: path.to_owned(),
            why,
        }),
    }
}

/// Reason why other users could change the folder. A group may read (systemd's
/// `RuntimeDirectoryMode=0750`), never write.
fn flaw(meta: &Metadata) -> Option<String> {
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
            "its mode is {:o}, and others may use it",
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
    fn long_folders_are_refused() {
        let base = PathBuf::from(format!("/{}", "x".repeat(ROOT_MAX)));
        assert!(Folder::under(base, &BusName::default()).is_err());
    }

    #[test]
    fn names_in_shared_memory() {
        let bus = BusName::default();
        let check = |name: &str, expected: (Option<&str>, bool)| {
            assert_eq!((prefix_of(name, &bus), is_base(name)), expected, "{name}");
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
