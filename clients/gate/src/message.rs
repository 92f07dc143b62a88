//! What passes the socket: packets, whole or not at all (`SOCK_SEQPACKET`), bounded.
//!
//! One [`Request`] with three descriptors; then a byte for each signal, its number. Back come [`Reply`]s as JSON. The end of
//! either side is the end of the visit.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, ReturnFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, send, sendmsg,
};
use rustix::process::Signal;
use serde::{Deserialize, Serialize};

/// Where the gate is, as its systemd unit has it.
pub const SOCKET: &str = "/run/atas-gate.sock";
/// The environment variable that names another place.
pub const SOCKET_ENV: &str = "ATAS_GATE";
/// Longest packet, bytes: many times the longest command line that means something. Ours.
pub const PACKET_MAX: usize = 32 << 10;
/// Standard input, output and error.
pub const STREAMS: usize = 3;

/// Words of the caller's environment that the command sees: how the terminal is, which bus, and nothing else.
pub const WORDS: [&str; 7] = [
    "TERM",
    "COLORTERM",
    "NO_COLOR",
    "COLUMNS",
    "LINES",
    "LANG",
    shm_bus::BusName::ENV,
];
/// Longest value of a word, bytes. Ours.
const WORD_MAX: usize = 64;

/// Signals that are passed on: those that ask a command to end, and the one that tells it of its terminal's size.
pub const SIGNALS: [Signal; 4] = [Signal::INT, Signal::TERM, Signal::HUP, Signal::WINCH];

/// What a visitor wants.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// The words after `atas`.
    pub arguments: Vec<String>,
    /// Names out of [`WORDS`] with their values.
    pub environment: Vec<(String, String)>,
}

/// What the gate says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// The command runs on the visitor's streams.
    Started,
    /// It ended with this exit code.
    Ended(u8),
    /// A signal ended it.
    Killed(i32),
    /// It does not run, and why.
    Refused(String),
    /// It does not run now: this user's places are taken. And how many there are.
    Busy(usize),
}

impl Request {
    /// Whether a variable of the environment may be handed over: one of [`WORDS`], short, and never a path, which a library
    /// might follow.
    #[must_use]
    pub fn takes(name: &str, value: &str) -> bool {
        let plain = |b: u8| b.is_ascii_alphanumeric() || b"._:@+-".contains(&b);
        WORDS.contains(&name) && value.len() <= WORD_MAX && value.bytes().all(plain)
    }
}

/// Sends the request with the streams.
///
/// # Errors
/// [`io::Error`] as the kernel says; [`io::ErrorKind::ArgumentListTooLong`] for more than [`PACKET_MAX`].
pub fn ask(
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

/// Receives a request with its streams; why not, in the words of a visitor's error.
///
/// # Errors
/// A sentence's reason: a packet that is none, without its streams, or too long.
pub fn hear(socket: impl AsFd) -> Result<(Request, [OwnedFd; STREAMS]), String> {
    let mut packet = vec![0; PACKET_MAX];
    // Room for no more descriptors than belong to it: the kernel closes what is beyond.
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(STREAMS))];
    let mut control = RecvAncillaryBuffer::new(&mut space);
    let flags = RecvFlags::CMSG_CLOEXEC;
    let received = recvmsg(
        socket,
        &mut [IoSliceMut::new(&mut packet)],
        &mut control,
        flags,
    )
    .map_err(|error| format!("the request did not come: {error}"))?;
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
        return Err(format!(
            "the request carries more than {STREAMS} descriptors"
        ));
    }
    let request = serde_json::from_slice(&packet[..received.bytes]).map_err(|error| {
        format!("the request cannot be read ({error}); is `atas` of another version?")
    })?;
    let streams = streams.try_into().map_err(|streams: Vec<_>| {
        format!(
            "the request carries {} descriptors, needs {STREAMS}",
            streams.len()
        )
    })?;
    Ok((request, streams))
}

/// Sends a reply, without waiting: a visitor that does not read loses it.
///
/// # Errors
/// [`io::Error`] if the visitor is gone or does not read.
pub fn reply(socket: impl AsFd, reply: &Reply) -> io::Result<()> {
    let packet = serde_json::to_vec(reply)?;
    send(socket, &packet, SendFlags::NOSIGNAL | SendFlags::DONTWAIT)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_words_of_the_list_pass() {
        let check = |name: &str, value: &str, passes: bool| {
            assert_eq!(Request::takes(name, value), passes, "{name}={value}");
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
