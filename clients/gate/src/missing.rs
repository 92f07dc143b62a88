//! Diagnosis of a user who cannot reach the gate: missing permissions, each with a remedy.

use std::ffi::CString;
use std::fs;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use nix::unistd::{Gid, Group, User, getegid, geteuid, getgrouplist, getgroups};
use rustix::fs::{Access, access};

use crate::message;

/// Returns the path of the gate's socket.
pub(crate) fn socket() -> PathBuf {
    std::env::var_os(message::SOCKET_ENV).map_or_else(|| message::SOCKET.into(), PathBuf::from)
}

/// Returns the missing permission and its remedy; `None` if nothing is missing. Does not connect.
#[must_use]
pub fn missing() -> Option<String> {
    let socket = socket();
    let refused = access(&socket, Access::WRITE_OK).err()?;
    Some(connection_error(&socket, &refused.into()))
}

/// Returns the cause of a failed connection to the gate at `socket`, as the end of a sentence.
pub(crate) fn connection_error(socket: &Path, error: &io::Error) -> String {
    let place = socket.display();
    match error.kind() {
        io::ErrorKind::NotFound => format!(
            "its gate for members of group atas is not running (there is no {place}); start it \
             with `sudo systemctl enable --now atas-gate.socket`"
        ),
        io::ErrorKind::ConnectionRefused => {
            format!(
                "its gate {place} does not answer; run `sudo systemctl restart \
                atas-gate.socket`"
            )
        }
        io::ErrorKind::PermissionDenied => not_a_member(socket),
        _ => format!(
            "its gate {place} is not reachable because of: {error}; see `systemctl status \
             atas-gate`"
        ),
    }
}

fn not_a_member(socket: &Path) -> String {
    let Ok(meta) = fs::metadata(socket) else {
        return format!(
            "this user has no permission for its gate {}",
            socket.display()
        );
    };
    let gid = Gid::from_raw(meta.gid());
    let group = Group::from_gid(gid).ok().flatten();
    let group = group.map_or_else(|| gid.to_string(), |group| group.name);
    let user = User::from_uid(geteuid()).ok().flatten();
    let name = user.map_or_else(|| geteuid().to_string(), |user| user.name);
    if in_effect(gid) {
        return format!(
            "its gate {} rejects group {group} by its mode or that of its folder",
            socket.display()
        );
    }
    if is_listed(&name, gid) {
        format!(
            "user {name} joined group {group} after this login; log in again, or run `newgrp \
             {group}`"
        )
    } else {
        format!(
            "user {name} is not in group {group}; run `sudo usermod -aG {group} {name}`, then log \
             in again"
        )
    }
}

/// Returns true if this process has the group.
fn in_effect(gid: Gid) -> bool {
    getegid() == gid || getgroups().is_ok_and(|groups| groups.contains(&gid))
}

/// Returns true if the system lists the user in the group.
fn is_listed(user: &str, gid: Gid) -> bool {
    CString::new(user)
        .is_ok_and(|user| getgrouplist(&user, getegid()).is_ok_and(|groups| groups.contains(&gid)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_permission_has_a_remedy() {
        let check = |kind: io::ErrorKind, part: &str| {
            let reported = connection_error(Path::new("/nonexistent/gate"), &kind.into());
            assert!(reported.contains(part), "{reported}");
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
