//! A lane per module that was active in the last seconds.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use super::Look;
use crate::top::seen::Seen;

/// Characters of a module's name.
const NAME: usize = 15;

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, seen: &Seen, hand: usize, look: Look) {
    let columns = usize::from(area.width).saturating_sub(NAME + 1);
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
                    format!("{name:NAME$.NAME$} "),
                    if is_on { look.strong() } else { look.soft() },
                ),
                Span::styled(format!("{marks:>columns$}"), look.limit()),
            ])
        })
        .collect();
    if lines.is_empty() {
        lines.push(Line::styled("no module was active lately", look.soft()));
    }
    frame.render_widget(Paragraph::new(lines), area);
}
