//! What a user lacks who cannot reach the gate, each with the command that cures it.

use std::ffi::CString;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use nix::unistd::{Gid, Group, User, getegid, geteuid, getgrouplist, getgroups};
use rustix::fs::{Access, access};

use crate::message;

/// Where the gate is for this process.
pub(crate) fn socket() -> PathBuf {
    std::env::var_os(message::SOCKET_ENV).map_or_else(|| message::SOCKET.into(), PathBuf::from)
}

/// What this user lacks to knock at the gate, and the cure; `None` if nothing. Does not knock.
#[must_use]
pub fn missing() -> Option<String> {
    let socket = socket();
    let refused = access(&socket, Access::WRITE_OK).err()?;
    Some(sentence(&socket, &refused.into()))
}

/// Why a connection to the gate at `socket` failed, as the end of a sentence.
pub(crate) fn sentence(socket: &Path, error: &io::Error) -> String {
    let place = socket.display();
    match error.kind() {
        io::ErrorKind::NotFound => format!(
            "its gate for members of group atas is closed (there is no {place}): `sudo systemctl enable --now atas-gate.socket` opens it"
        ),
        io::ErrorKind::ConnectionRefused => {
            format!("nobody answers at its gate {place}: `sudo systemctl restart atas-gate.socket`")
        }
        io::ErrorKind::PermissionDenied => not_a_member(socket),
        _ => format!(
            "its gate {place} cannot be reached because of: {error}; see `systemctl status atas-gate`"
        ),
    }
}

fn not_a_member(socket: &Path) -> String {
    let Ok(meta) = fs::metadata(socket) else {
        return format!("this user may not see its gate {}", socket.display());
    };
    let gid = Gid::from_raw(meta.gid());
    let group = Group::from_gid(gid).ok().flatten();
    let group = group.map_or_else(|| gid.to_string(), |group| group.name);
    let user = User::from_uid(geteuid()).ok().flatten();
    let name = user.map_or_else(|| geteuid().to_string(), |user| user.name);
    if in_effect(gid) {
        return format!(
            "its gate {} is closed to group {group} by its mode or its folder's",
            socket.display()
        );
    }
    if is_listed(&name, gid) {
        format!(
            "user {name} is in group {group} since after this login: log in again, or `newgrp {group}`"
        )
    } else {
        format!(
            "user {name} is not in group {group}: `sudo usermod -aG {group} {name}`, then log in again"
        )
    }
}

/// Whether this process has the group.
fn in_effect(gid: Gid) -> bool {
    getegid() == gid || getgroups().is_ok_and(|groups| groups.contains(&gid))
}

/// Whether the system's tables have the user in the group.
fn is_listed(user: &str, gid: Gid) -> bool {
    CString::new(user)
        .is_ok_and(|user| getgrouplist(&user, getegid()).is_ok_and(|groups| groups.contains(&gid)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_lack_is_told_with_its_cure() {
        let check = |kind: io::ErrorKind, part: &str| {
            let told = sentence(Path::new("/nonexistent/gate"), &kind.into());
            assert!(told.contains(part), "{told}");
        };
        check(
            io::ErrorKind::NotFound,
            "systemctl enable --now atas-gate.socket",
        );
        check(
            io::ErrorKind::ConnectionRefused,
            "systemctl restart atas-gate.socket",
        );
        check(io::ErrorKind::TimedOut, "systemctl status atas-gate");
    }
}
