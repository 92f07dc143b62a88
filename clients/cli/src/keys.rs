//! The keys of a terminal, and that it may go: a line that breaks, a window that is closed.
//!
//! Whoever reads a terminal that is gone gets nothing at once, for ever, and crossterm asks again each time: so the terminal
//! itself is asked first.

use std::os::fd::AsFd;
use std::time::Duration;

use anyhow::Context;
use ratatui::crossterm::event::{self, Event, KeyEvent};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

/// What a while before a terminal brought.
pub(crate) enum Typed {
    /// No key, or something that is none.
    Nothing,
    /// A key.
    Key(KeyEvent),
    /// The terminal is gone.
    Gone,
}

/// Waits for a key for so long at most.
pub(crate) fn wait(within: Duration) -> anyhow::Result<Typed> {
    const UNREADABLE: &str = "could not read the terminal";
    let stdin = std::io::stdin();
    let mut terminal = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
    let within = Timespec::try_from(within).context(UNREADABLE)?;
    match poll(&mut terminal, Some(&within)) {
        // A signal, a window of another size: the next picture shows what came of it.
        Ok(_) | Err(Errno::INTR) => {}
        Err(error) => return Err(error).context(UNREADABLE),
    }
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    if terminal[0].revents().intersects(gone) {
        return Ok(Typed::Gone);
    }
    if !event::poll(Duration::ZERO).context(UNREADABLE)? {
        return Ok(Typed::Nothing);
    }
    Ok(match event::read().context(UNREADABLE)? {
        Event::Key(key) => Typed::Key(key),
        _ => Typed::Nothing,
    })
}
