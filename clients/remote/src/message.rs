//! Messages in frames of kind request and reply, as JSON.

use atas_client::StopChannel;
use atas_console::arguments::Right;
use serde::{Deserialize, Serialize};

use crate::PROTOCOL;
use crate::frame::Kind;
use crate::link::{Link, LinkError};

/// Request of a client: the first frame after the handshake.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Version of the client's protocol.
    pub protocol: u32,
    /// Work to do.
    pub work: Work,
}

/// Work of a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Work {
    /// Run `atas` with these arguments.
    Run(Vec<String>),
    /// Report the right of this client, then send back frames of kind echo.
    Check,
}

/// Reply of the server.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// The command runs. A peer that is silent for this time counts as lost.
    Started {
        /// Longest silence, milliseconds.
        silence_ms: u64,
    },
    /// The command ended with this exit code.
    Ended(u8),
    /// A signal ended the command.
    Killed(i32),
    /// The robot is stopped; the text is the name of the daemon's channel.
    Stopped(String),
    /// The request was rejected.
    Refused {
        /// Exit code of the command.
        exit: u8,
        /// Reason.
        reason: String,
    },
    /// The request failed.
    Failed {
        /// Exit code of the command.
        exit: u8,
        /// Reason.
        reason: String,
    },
    /// Answer to a check.
    Checked {
        /// Version of the server.
        version: String,
        /// Name of the client in its certificate and in the configuration.
        client: String,
        /// Right of the client.
        right: String,
    },
}

impl Request {
    /// Creates a request of this version.
    #[must_use]
    pub fn new(work: Work) -> Self {
        Self {
            protocol: PROTOCOL,
            work,
        }
    }

    /// Parses the payload of a frame.
    ///
    /// # Errors
    /// The reason as text: invalid JSON, or another version.
    pub fn parse(payload: &[u8]) -> Result<Self, String> {
        /// The version alone, readable in every later version.
        #[derive(Deserialize)]
        struct Version {
            protocol: u32,
        }
        let invalid = |error: serde_json::Error| format!("the request is invalid: {error}");
        let version: Version = serde_json::from_slice(payload).map_err(invalid)?;
        if version.protocol != PROTOCOL {
            return Err(format!(
                "the client has protocol version {}, this server has {PROTOCOL}; install the same \
                 version of ATAS on both machines",
                version.protocol
            ));
        }
        serde_json::from_slice(payload).map_err(invalid)
    }
}

/// Sends a reply.
pub(crate) fn send_reply(link: &mut Link, reply: &Reply) -> Result<(), LinkError> {
    let bytes = serde_json::to_vec(reply).map_err(std::io::Error::from)?;
    link.send(Kind::Reply, &bytes)
}

/// Returns the channel of a stop by its name.
pub(crate) fn channel(name: &str) -> Option<StopChannel> {
    [StopChannel::Socket, StopChannel::Control]
        .into_iter()
        .find(|channel| channel.name() == name)
}

/// Right of a client, as in the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ClientRight {
    /// Stop the robot.
    Stop,
    /// Also read status, events, parameters and recordings.
    Observe,
    /// Also move the robot and change parameters.
    Command,
}

impl ClientRight {
    /// Returns the same right in the vocabulary of the command line.
    pub(crate) fn right(self) -> Right {
        match self {
            Self::Stop => Right::Stop,
            Self::Observe => Right::Observe,
            Self::Command => Right::Command,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn request_of_other_version_is_refused_by_name() {
        let refused = |bytes: &[u8], part: &str| {
            let why = Request::parse(bytes).expect_err("refused");
            assert!(why.contains(part), "{why}");
        };
        refused(
            br#"{"protocol":2,"work":{"fly":[]},"more":1}"#,
            "protocol version 2",
        );
        refused(br#"{"protocol":1,"work":{"fly":[]}}"#, "unknown variant");
        refused(b"\xff\0junk", "the request is invalid");
        refused(&b"[".repeat(9_000), "the request is invalid");
        let request = Request::new(Work::Run(vec!["status".into()]));
        let bytes = serde_json::to_vec(&request).expect("JSON");
        assert_eq!(Request::parse(&bytes), Ok(request));
    }
}
