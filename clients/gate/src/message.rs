//! Messages of the socket: bounded packets, complete or not at all (`SOCK_SEQPACKET`).
//!
//! The client sends one [`Request`] with three descriptors, then one byte per signal. The gate
//! answers with [`Reply`]s as JSON. Either side ends the connection by closing it.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use atas_console::arguments::{Access, Arguments, Right, command};
use clap::FromArgMatches;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, ReturnFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, send, sendmsg,
};
use rustix::process::Signal;
use serde::{Deserialize, Serialize};

/// Path of the socket, as in its systemd unit.
pub const SOCKET: &str = "/run/atas-gate.sock";
/// Environment variable with another path.
pub const SOCKET_ENV: &str = "ATAS_GATE";
/// Longest packet, bytes. Design choice: many times the longest useful command line.
pub const PACKET_MAX: usize = 32 << 10;
/// Standard input, output and error.
pub const STREAMS: usize = 3;

/// Environment variables of the client that the command receives: terminal properties and bus,
/// nothing else.
pub const VARIABLES: [&str; 7] = [
    "TERM",
    "COLORTERM",
    "NO_COLOR",
    "COLUMNS",
    "LINES",
    "LANG",
    shm_bus::BusName::ENV,
];
/// Longest value of a variable, bytes. Design choice.
const VARIABLE_MAX: usize = 64;

/// Forwarded signals: those that end a command, and the one for changes of the terminal size.
pub const SIGNALS: [Signal; 4] = [Signal::INT, Signal::TERM, Signal::HUP, Signal::WINCH];

/// Request of a client.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Arguments after `atas`.
    pub arguments: Vec<String>,
    /// Names of [`VARIABLES`] with their values.
    pub environment: Vec<(String, String)>,
}

/// Reply of the gate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// The command runs on the client's streams.
    Started,
    /// The command ended with this exit code.
    Ended(u8),
    /// A signal ended the command.
    Killed(i32),
    /// The command was rejected; the text is the reason.
    Refused(String),
    /// The user's connections are all in use; the number is their limit.
    Busy(usize),
}

impl Request {
    /// Parses a packet.
    ///
    /// # Errors
    /// The reason as text.
    pub fn parse(packet: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(packet).map_err(|error| {
            format!("the request is invalid ({error}); `atas` may have another version")
        })
    }

    /// Returns the permission that the command needs, from the definition of the command line.
    ///
    /// # Errors
    /// The reason as text: an invalid command line, or a command that needs no gate.
    pub fn right(&self) -> Result<Right, String> {
        if self.arguments.iter().any(|word| word.contains('\0')) {
            return Err("a word of the command line contains a zero byte".into());
        }
        let words = std::iter::once("atas").chain(self.arguments.iter().map(String::as_str));
        let parsed = command()
            .try_get_matches_from(words)
            .and_then(|matches| Arguments::from_arg_matches(&matches));
        let arguments = parsed.map_err(|_| "the command line is invalid".to_owned())?;
        match arguments.command.access() {
            Access::Right(right, _) => Ok(right),
            Access::Owner(_, why) => Err(format!("this command {why}; run it as the bus's user")),
            Access::Caller | Access::Recordings => {
                Err("this command does not need another user's bus; run it as yourself".into())
            }
        }
    }

    /// Returns true if an environment variable may be forwarded: listed in [`VARIABLES`], short,
    /// and not a path, which a library could follow.
    #[must_use]
    pub fn is_permitted(name: &str, value: &str) -> bool {
        let plain = |b: u8| b.is_ascii_alphanumeric() || b"._:@+-".contains(&b);
        VARIABLES.contains(&name) && value.len() <= VARIABLE_MAX && value.bytes().all(plain)
    }
}

/// Sends the request with the streams.
///
/// # Errors
/// [`io::Error`] of the kernel; [`io::ErrorKind::ArgumentListTooLong`] for more than [`PACKET_MAX`]
/// bytes.
pub fn send_request(
    socket: impl AsFd,
    request: &Request,
    streams: [BorrowedFd<'_>; STREAMS],
) -> io::Result<()> {
    let packet = serde_json::to_vec(request)?;
    if packet.len() > PACKET_MAX {
        return Err(io::ErrorKind::ArgumentListTooLong.into());
    }
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(STREAMS))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    control.push(SendAncillaryMessage::ScmRights(&streams));
    sendmsg(
        socket,
        &[IoSlice::new(&packet)],
        &mut control,
        SendFlags::NOSIGNAL,
    )?;
    Ok(())
}

/// Receives a request with its streams.
///
/// # Errors
/// The reason as text: an invalid packet, missing streams, or too long.
pub fn receive_request(socket: impl AsFd) -> Result<(Request, [OwnedFd; STREAMS]), String> {
    let mut packet = vec![0; PACKET_MAX];
    // Space for exactly the expected descriptors: the kernel closes all others.
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(STREAMS))];
    let mut control = RecvAncillaryBuffer::new(&mut space);
    let flags = RecvFlags::CMSG_CLOEXEC;
    let received = recvmsg(
        socket,
        &mut [IoSliceMut::new(&mut packet)],
        &mut control,
        flags,
    )
    .map_err(|error| format!("no request arrived: {error}"))?;
    let streams: Vec<OwnedFd> = control
        .drain()
        .filter_map(|message| match message {
            RecvAncillaryMessage::ScmRights(descriptors) => Some(descriptors),
            _ => None,
        })
        .flatten()
        .collect();
    if received.flags.intersects(ReturnFlags::TRUNC) {
        return Err(format!("the request is longer than {PACKET_MAX} bytes"));
    }
    if received.flags.intersects(ReturnFlags::CTRUNC) {
        return Err(format!("the request has more than {STREAMS} descriptors"));
    }
    let request = Request::parse(&packet[..received.bytes])?;
    let streams = streams.try_into().map_err(|streams: Vec<_>| {
        format!(
            "the request has {} descriptors, needs {STREAMS}",
            streams.len()
        )
    })?;
    Ok((request, streams))
}

/// Sends a reply without waiting. A client that does not read loses it.
///
/// # Errors
/// [`io::Error`] if the client is gone or does not read.
pub fn reply(socket: impl AsFd, reply: &Reply) -> io::Result<()> {
    let packet = serde_json::to_vec(reply)?;
    send(socket, &packet, SendFlags::NOSIGNAL | SendFlags::DONTWAIT)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_plain_variables_pass() {
        let check = |name: &str, value: &str, passes: bool| {
            assert_eq!(Request::is_permitted(name, value), passes, "{name}={value}");
        };
        check("TERM", "xterm-256color", true);
        check("LANG", "de_DE.UTF-8@euro", true);
        check("LANG", "C.UTF-8", true);
        check("NO_COLOR", "", true);
        check("ATAS_BUS", "left-arm", true);
        check("TERM", "../../../tmp/evil", false);
        check("TERM", "a b", false);
        check("TERM", "x\n", false);
        check("COLUMNS", &"8".repeat(65), false);
        for name in [
            "LD_PRELOAD",
            "PATH",
            "RUST_LOG",
            "XDG_RUNTIME_DIR",
            "TERMINFO",
            "HOME",
            "",
        ] {
            check(name, "x", false);
        }
    }
}
