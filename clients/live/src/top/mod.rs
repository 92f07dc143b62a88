//! `atas top`: live view of the running system in a terminal of at least 80 × 24 characters.
//!
//! ```text
//!  Observer (status, reports, view, events), Run (robot) ─▶ ScreenState ─▶ screen ─▶ terminal
//! ```
//!
//! * **Invariants:** each colour also has a word or mark; `NO_COLOR` disables colours. The terminal
//!   is restored at every end. The view continues when the daemon ends or restarts.

mod screen;
mod state;

use std::io::IsTerminal;
use std::time::Duration;

use anyhow::Context;
use atas_client::{Observer, Session};
use atas_console::arguments::BusArgument;
use atas_console::{Exit, ExitError, Interrupt};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::keys::{self, KeyInput};
use state::ScreenState;

/// Pause between two updates: 10 Hz, suitable for slow connections.
const UPDATE_PERIOD: Duration = Duration::from_millis(100);

pub(crate) fn top(bus: &BusArgument, interrupt: &Interrupt) -> anyhow::Result<()> {
    if !std::io::stdout().is_terminal() {
        return Err(ExitError::with_code(
            Exit::Usage,
            "could not draw: standard output is no terminal; use `atas status --watch --format \
             json` in programs",
        ));
    }
    let session = Session::existing(&bus.bus)?;
    let mut seen = ScreenState::new(Observer::join(&session)?, session.bus().name().as_str());
    let colours = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let mut terminal = ratatui::try_init().context("could not prepare the terminal")?;
    let shown = show(&mut terminal, &mut seen, &session, colours, interrupt);
    let restored = ratatui::try_restore().context("could not restore the terminal");
    shown.and(restored)
}

fn show(
    terminal: &mut ratatui::DefaultTerminal,
    seen: &mut ScreenState,
    session: &Session,
    colours: bool,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    while !interrupt.is_set() {
        seen.poll(session)?;
        terminal
            .draw(|frame| screen::draw(frame, seen, colours))
            .context("could not draw on the terminal")?;
        match keys::wait(UPDATE_PERIOD)? {
            KeyInput::Key(key) if ends(key) => break,
            KeyInput::Disconnected => break,
            KeyInput::Key(_) | KeyInput::Nothing => {}
        }
    }
    Ok(())
}

fn ends(key: KeyEvent) -> bool {
    let is_ctrl_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press
        && (is_ctrl_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc))
}
