//! Key input of a terminal that can disconnect, for example by a lost connection or closed window.
//!
//! Reading a disconnected terminal returns nothing at once, and crossterm then retries without end.
//! Hence the terminal itself is polled first.

use std::os::fd::AsFd;
use std::time::Duration;

use anyhow::Context;
use ratatui::crossterm::event::{self, Event, KeyEvent};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// Result of waiting for a key.
pub(crate) enum KeyInput {
    Nothing,
    Key(KeyEvent),
    /// The terminal is disconnected.
    Disconnected,
}

/// Waits for a key, at most `within`.
pub(crate) fn wait(within: Duration) -> anyhow::Result<KeyInput> {
    const UNREADABLE: &str = "could not read the terminal";
    let stdin = std::io::stdin();
    let mut terminal = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
    let within = Timespec::try_from(within).context(UNREADABLE)?;
    match poll(&mut terminal, Some(&within)) {
        // A signal or a resize; the next redraw shows the effect.
        Ok(_) | Err(Errno::INTR) => {}
        Err(error) => return Err(error).context(UNREADABLE),
    }
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    if terminal[0].revents().intersects(gone) {
        return Ok(KeyInput::Disconnected);
    }
    if !event::poll(Duration::ZERO).context(UNREADABLE)? {
        return Ok(KeyInput::Nothing);
    }
    Ok(match event::read().context(UNREADABLE)? {
        Event::Key(key) => KeyInput::Key(key),
        _ => KeyInput::Nothing,
    })
}
