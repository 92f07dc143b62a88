//! One lane per recently active module.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::Palette;
use crate::top::state::ScreenState;

/// Width of a module name, characters.
const NAME_COLUMNS: usize = 15;

pub(super) fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    seen: &ScreenState,
    hand: usize,
    look: Palette,
) {
    let columns = usize::from(area.width).saturating_sub(NAME_COLUMNS + 1);
    let mut lines: Vec<Line<'_>> = seen
        .modules(hand, columns)
        .into_iter()
        .take(area.height.into())
        .map(|id| {
            let name = id.name().trim_start_matches("module ");
            let lane = &seen.lanes[hand];
            let skipped = lane.len().saturating_sub(columns);
            let shown = lane.iter().skip(skipped);
            let marks: String = shown
                .map(|bits| if bits >> id.0 & 1 == 1 { '█' } else { '·' })
                .collect();
            let is_on = lane.back().is_some_and(|bits| bits >> id.0 & 1 == 1);
            Line::from(vec![
                Span::styled(
                    format!("{name:NAME_COLUMNS$.NAME_COLUMNS$} "),
                    if is_on { look.strong() } else { look.dim() },
                ),
                Span::styled(format!("{marks:>columns$}"), look.limit()),
            ])
        })
        .collect();
    if lines.is_empty() {
        lines.push(Line::styled("no module active recently", look.dim()));
    }
    frame.render_widget(Paragraph::new(lines), area);
}
