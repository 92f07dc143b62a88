//! What a later file of a run begins with, so that it can be replayed without those before it.
//!
//! This crate knows no controller. Whoever records may bring one along that follows the run as it is recorded.

use mcap::Message;
use shm_schemas::{RunHeader, TickInputs};

/// Channel of the states.
pub(crate) const TOPIC: &str = "controller-state";
/// Encoding of the states: MessagePack, with the names of all fields.
pub(crate) const ENCODING: &str = "msgpack";

/// Follows a run part by part.
pub trait Follower: Send {
    /// A daemon began a run.
    ///
    /// # Errors
    /// It cannot be followed. It is still recorded.
    fn begin(&mut self, run: &RunHeader) -> anyhow::Result<()>;

    /// The next part of a tick.
    ///
    /// # Errors
    /// The run cannot be followed from here on. It is still recorded.
    fn take(&mut self, part: &TickInputs) -> anyhow::Result<()>;

    /// Whether the last part was not its tick's last: no state can be told now, but soon.
    fn is_within_tick(&self) -> bool;

    /// The state after the last tick, encoded; `None` before the first tick and when the run is not followed any more.
    ///
    /// # Errors
    /// It cannot be encoded.
    fn state(&self) -> anyhow::Result<Option<Vec<u8>>>;
}

/// The state that a message holds, encoded, if it holds one.
#[must_use]
pub fn state<'a>(message: &'a Message<'_>) -> Option<&'a [u8]> {
    (message.channel.topic == TOPIC).then_some(&*message.data)
}
