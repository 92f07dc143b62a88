//! How it is drawn: header, a block per hand, a lane per module, ticks and services, what happened.

mod hand;
mod lanes;
mod timing;

use std::path::Path;
use std::rc::Rc;

use atas_client::{standstill, words};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_bus::now_ns;
use shm_schemas::capacity::FINGERS;
use shm_schemas::{Mode, StatusFlags};

use super::seen::Seen;
use crate::refusals;

/// Smallest screen that has room for everything.
const COLUMNS: u16 = 80;
const ROWS: u16 = 24;

/// Styles, by what they mean. Every one is also told by a word or a mark.
#[derive(Clone, Copy)]
struct Look {
    colours: bool,
}

impl Look {
    /// Okabe and Ito 2008, as near as the 256 colours of terminals come: told apart with any colour vision.
    fn tint(self, colour: u8) -> Style {
        let style = Style::new();
        if self.colours {
            style.fg(Color::Indexed(colour))
        } else {
            style
        }
    }

    fn finger(self, finger: usize) -> Style {
        const TINTS: [u8; FINGERS] = [32, 74, 36, 175];
        self.tint(TINTS[finger % FINGERS])
    }

    fn limit(self) -> Style {
        self.tint(214)
    }

    fn soft(self) -> Style {
        self.tint(245)
    }

    fn fault(self) -> Style {
        self.tint(209).add_modifier(Modifier::BOLD)
    }

    fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }
}

/// Draws everything.
pub(super) fn draw(frame: &mut Frame<'_>, seen: &Seen, colours: bool) {
    let look = Look { colours };
    let area = frame.area();
    if area.width < COLUMNS || area.height < ROWS {
        let text = format!(
            "needs {COLUMNS} × {ROWS} characters, has {} × {}; enlarge the window, or q",
            area.width, area.height
        );
        frame.render_widget(Paragraph::new(text), area);
        return;
    }
    // What a larger screen has more goes to lanes and events.
    let more = area.height - ROWS;
    let heights = [2, 10, 4 + more / 2, 4, 4 + more - more / 2].map(Constraint::Length);
    let [head, hands, work, timing, events] = Layout::vertical(heights).areas(area);
    header(frame, head, seen, look);
    let there = seen.hands();
    for ((index, fingers), area) in there.iter().zip(shares(hands, there.len()).iter()) {
        hand::draw(frame, *area, seen, (*index, *fingers), look);
    }
    for ((index, _), area) in there.iter().zip(shares(work, there.len()).iter()) {
        lanes::draw(frame, *area, seen, *index, look);
    }
    timing::draw(frame, timing, seen, look);
    happened(frame, events, seen, look);
}

/// So many areas of the same width.
fn shares(area: Rect, count: usize) -> Rc<[Rect]> {
    Layout::horizontal(vec![Constraint::Fill(1); count])
        .spacing(2)
        .split(area)
}

fn header(frame: &mut Frame<'_>, area: Rect, seen: &Seen, look: Look) {
    let status = &seen.watch.status;
    if !seen.watch.is_alive() {
        let told = format!(
            "atas top · bus {} · no daemon reports: start `atasd`",
            seen.bus
        );
        frame.render_widget(Paragraph::new(Line::styled(told, look.fault())), area);
        return;
    }
    let is_stopped = matches!(status.mode, Mode::HOLD | Mode::SAFE_STOP | Mode::FAULT);
    let mode = status.mode.name().to_uppercase();
    let flag = |flag, word| if status.flags & flag != 0 { word } else { "" };
    let first = Line::from(vec![
        Span::raw(format!("atas top · bus {} · ", seen.bus)),
        Span::styled(
            mode,
            if is_stopped {
                look.fault()
            } else {
                look.strong()
            },
        ),
        // What a narrow terminal cuts off is told last.
        Span::raw(format!(
            " · {} Hz{}{}{} · atasd {} ({})",
            status.rate_hz,
            flag(StatusFlags::LOCKSTEP, " lock-step"),
            flag(StatusFlags::DEGRADED, " DEGRADED"),
            robot(seen),
            status.version,
            status.pid,
        )),
    ]);
    let second = if let Some(frozen) = standstill(status, now_ns()) {
        let told = format!(
            "no tick for {:.1} s: the loop stands still",
            frozen.as_secs_f64()
        );
        Line::styled(told, look.fault())
    } else if status.reason.is_some() {
        let why = refusals::why_so([&seen.rates.before, status]);
        Line::styled(why, look.fault())
    } else {
        Line::raw(words::goal(status))
    };
    frame.render_widget(Paragraph::new(vec![first, second]), area);
}

/// What the robot is called, if that is known.
fn robot(seen: &Seen) -> String {
    seen.run.header().map_or_else(String::new, |header| {
        let name = Path::new(header.robot.as_str());
        let short = name.file_stem().unwrap_or_default().to_string_lossy();
        format!(" · {short}")
    })
}

fn happened(frame: &mut Frame<'_>, area: Rect, seen: &Seen, look: Look) {
    let rows = usize::from(area.height);
    let lines = seen
        .events
        .iter()
        .rev()
        .take(rows)
        .map(|(at_s, sentence, is_fault)| {
            let style = if *is_fault {
                look.fault()
            } else {
                Style::new()
            };
            let mark = if *is_fault { '!' } else { ' ' };
            Line::styled(format!("{mark}{at_s:9.2} s  {sentence}"), style)
        });
    let mut lines: Vec<Line<'_>> = lines.collect();
    lines.reverse();
    if lines.is_empty() {
        lines.push(Line::styled("nothing has happened yet", look.soft()));
    }
    frame.render_widget(Paragraph::new(lines), area);
}
