//! Screen layout: header, one block per hand, module lanes, timing and services, events.

mod hand;
mod lanes;
mod timing;

use std::path::Path;
use std::rc::Rc;

use atas_client::{standstill, text};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_bus::now_ns;
use shm_schemas::capacity::FINGERS;
use shm_schemas::{Mode, StatusFlags};

use super::state::ScreenState;
use atas_client::rejections;

/// Smallest screen.
const COLUMNS: u16 = 80;
const ROWS: u16 = 24;

/// Styles by meaning; each also has a word or mark.
#[derive(Clone, Copy)]
struct Palette {
    colours: bool,
}

impl Palette {
    /// Okabe-Ito colours (2008) for any colour vision, as the nearest terminal colours.
    fn tint(self, colour: u8) -> Style {
        let style = Style::new();
        if self.colours {
            style.fg(Color::Indexed(colour))
        } else {
            style
        }
    }

    fn fingertip(self, finger: usize) -> Style {
        const TINTS: [u8; FINGERS] = [32, 74, 36, 175];
        self.tint(TINTS[finger % FINGERS])
    }

    fn limit(self) -> Style {
        self.tint(214)
    }

    fn dim(self) -> Style {
        self.tint(245)
    }

    fn fault(self) -> Style {
        self.tint(209).add_modifier(Modifier::BOLD)
    }

    fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }
}

pub(super) fn draw(frame: &mut Frame<'_>, seen: &ScreenState, colours: bool) {
    let look = Palette { colours };
    let area = frame.area();
    if area.width < COLUMNS || area.height < ROWS {
        let text = format!(
            "needs {COLUMNS} × {ROWS} characters, has {} × {}; enlarge the window, or press q",
            area.width, area.height
        );
        frame.render_widget(Paragraph::new(text), area);
        return;
    }
    // Extra rows go to module lanes and events.
    let more = area.height - ROWS;
    let heights = [2, 10, 4 + more / 2, 4, 4 + more - more / 2].map(Constraint::Length);
    let [head, hands, work, timing, events] = Layout::vertical(heights).areas(area);
    header(frame, head, seen, look);
    let there = seen.hands();
    for ((index, fingers), area) in there.iter().zip(equal_columns(hands, there.len()).iter()) {
        hand::draw(frame, *area, seen, (*index, *fingers), look);
    }
    for ((index, _), area) in there.iter().zip(equal_columns(work, there.len()).iter()) {
        lanes::draw(frame, *area, seen, *index, look);
    }
    timing::draw(frame, timing, seen, look);
    draw_events(frame, events, seen, look);
}

/// Splits an area into columns of equal width.
fn equal_columns(area: Rect, count: usize) -> Rc<[Rect]> {
    Layout::horizontal(vec![Constraint::Fill(1); count])
        .spacing(2)
        .split(area)
}

fn header(frame: &mut Frame<'_>, area: Rect, seen: &ScreenState, look: Palette) {
    let status = &seen.watch.status;
    if !seen.watch.is_alive() {
        let reported = format!(
            "atas top · bus {} · no daemon reports: start `atasd`",
            seen.bus
        );
        frame.render_widget(Paragraph::new(Line::styled(reported, look.fault())), area);
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
        // Least important part last: narrow terminals cut it off.
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
        let reported = format!(
            "no tick for {:.1} s: the control loop has stopped",
            frozen.as_secs_f64()
        );
        Line::styled(reported, look.fault())
    } else if status.reason.is_some() {
        let why = rejections::mode_reason([&seen.rates.before, status]);
        Line::styled(why, look.fault())
    } else {
        Line::raw(text::goal(status))
    };
    frame.render_widget(Paragraph::new(vec![first, second]), area);
}

/// Returns the name of the robot, if known.
fn robot(seen: &ScreenState) -> String {
    seen.run.header().map_or_else(String::new, |header| {
        let name = Path::new(header.robot.as_str());
        let short = name.file_stem().unwrap_or_default().to_string_lossy();
        format!(" · {short}")
    })
}

fn draw_events(frame: &mut Frame<'_>, area: Rect, seen: &ScreenState, look: Palette) {
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
        lines.push(Line::styled("no events yet", look.dim()));
    }
    frame.render_widget(Paragraph::new(lines), area);
}
