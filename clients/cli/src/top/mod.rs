//! `atas top`: the running system on one screen of a terminal, 80 × 24 or larger, also over ssh.
//!
//! ```text
//!  Watch (status, reports, view, events), Run (robot) ─▶ Seen ─▶ screen ─▶ terminal
//! ```
//!
//! * **Invariants:** what a colour says, a word or a mark says too. `NO_COLOR` leaves the colours out. The terminal is given
//!   back as it was, whatever ends the program. A daemon that dies or comes back is shown, not an end.

mod screen;
mod seen;

use std::io::IsTerminal;
use std::time::Duration;

use anyhow::Context;
use atas_client::{Session, Watch};
use atas_console::arguments::BusArgument;
use atas_console::{Ended, Exit, Interrupt};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::keys::{self, Typed};
use seen::Seen;

/// Pause between two pictures: ten a second, which is what a slow line carries.
const PICTURE: Duration = Duration::from_millis(100);

/// `atas top`.
pub(crate) fn top(bus: &BusArgument, interrupt: &Interrupt) -> anyhow::Result<()> {
    if !std::io::stdout().is_terminal() {
        return Err(Ended::with(
            Exit::Usage,
            "could not draw because standard output is no terminal; programs read `atas status --watch --format json`",
        ));
    }
    let session = Session::existing(&bus.bus)?;
    let mut seen = Seen::new(Watch::join(&session)?, session.bus().name().as_str());
    let colours = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let mut terminal = ratatui::try_init().context("could not prepare the terminal")?;
    let shown = show(&mut terminal, &mut seen, &session, colours, interrupt);
    let restored = ratatui::try_restore().context("could not give the terminal back");
    shown.and(restored)
}

fn show(
    terminal: &mut ratatui::DefaultTerminal,
    seen: &mut Seen,
    session: &Session,
    colours: bool,
    interrupt: &Interrupt,
) -> anyhow::Result<()> {
    while !interrupt.is_set() {
        seen.look(session)?;
        terminal
            .draw(|frame| screen::draw(frame, seen, colours))
            .context("could not draw on the terminal")?;
        match keys::wait(PICTURE)? {
            Typed::Key(key) if ends(key) => break,
            Typed::Gone => break,
            Typed::Key(_) | Typed::Nothing => {}
        }
    }
    Ok(())
}

fn ends(key: KeyEvent) -> bool {
    let is_ctrl_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    key.kind == KeyEventKind::Press
        && (is_ctrl_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc))
}
