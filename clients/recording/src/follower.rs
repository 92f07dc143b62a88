//! Follower of a run: provides the state with which a later file of the run begins, so that it can
//! be replayed without the earlier files.
//!
//! This crate contains no controller. The recording program supplies the follower.

use mcap::Message;
use shm_schemas::{RunHeader, TickInputs};

/// Channel of the states.
pub(crate) const TOPIC: &str = "controller-state";
/// Encoding of the states: MessagePack, with the names of all fields.
pub(crate) const ENCODING: &str = "msgpack";

/// Follows a run part by part.
pub trait Follower: Send {
    /// Begins a run.
    ///
    /// # Errors
    /// The run cannot be followed. It is still recorded.
    fn begin(&mut self, run: &RunHeader) -> anyhow::Result<()>;

    /// Processes the next part of a tick.
    ///
    /// # Errors
    /// The run cannot be followed any longer. It is still recorded.
    fn update(&mut self, part: &TickInputs) -> anyhow::Result<()>;

    /// Returns true if more parts of the tick follow; the state is then incomplete.
    fn is_within_tick(&self) -> bool;

    /// Returns the encoded state after the last tick; `None` before the first tick and when the run
    /// is no longer followed.
    ///
    /// # Errors
    /// The state cannot be encoded.
    fn state(&self) -> anyhow::Result<Option<Vec<u8>>>;
}

/// Returns the encoded state in a message, if it contains one.
#[must_use]
pub fn state<'a>(message: &'a Message<'_>) -> Option<&'a [u8]> {
    (message.channel.topic == TOPIC).then_some(&*message.data)
}
