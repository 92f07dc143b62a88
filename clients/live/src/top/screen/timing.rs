//! Tick timing and service rates.

use atas_client::histogram::{BINS, Histogram};
use atas_console::number;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_schemas::{Hand, Percentiles};

use super::Palette;
use crate::top::state::ScreenState;

const HEIGHTS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, seen: &ScreenState, look: Palette) {
    let status = &seen.watch.status;
    let lines = vec![
        distribution("wake-up late", &seen.watch.wake, &status.wake, look),
        distribution("tick body", &seen.watch.body, &status.tick, look),
        Line::from(services(seen)),
        Line::raw(format!(
            "{} ticks, {} missed, {} late, {} records dropped",
            status.ticks, status.missed_ticks, status.late_ticks, status.dropped_records
        )),
    ];
    frame.render_widget(Paragraph::new(lines), area);
}

/// Draws a histogram from 1 µs to 10 ms with bins in steps of 1, 2, 5. The height is logarithmic,
/// so that a single tick is visible.
fn distribution(
    name: &str,
    counted: &Histogram,
    since: &Percentiles,
    look: Palette,
) -> Line<'static> {
    let us = |ns: u64| number(ns as f64 * 1e-3, 1);
    Line::from(vec![
        Span::raw(format!("{name:12} 1µs ")),
        Span::styled(columns(&counted.counts()), look.fingertip(0)),
        Span::raw(format!(
            " 10ms  p50 {} p99 {} max {} µs",
            us(since.p50_ns),
            us(since.p99_ns),
            us(since.max_ns)
        )),
    ])
}

fn columns(counts: &[u64; BINS]) -> String {
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let height = |count: u64| {
        let share = (count as f64).ln_1p() / (most as f64).ln_1p();
        (share * (HEIGHTS.len() - 1) as f64).ceil() as usize
    };
    counts.iter().map(|count| HEIGHTS[height(*count)]).collect()
}

fn services(seen: &ScreenState) -> String {
    let (status, rates) = (&seen.watch.status, &seen.rates);
    let hz = |hz: f64| {
        if hz < 0.0 {
            "–".into()
        } else {
            number(hz, 0)
        }
    };
    let age = |ns: u64| match ns {
        u64::MAX => "never".to_owned(),
        ns => format!("{} ms", number(ns as f64 * 1e-6, 1)),
    };
    let hands = Hand::BOTH.iter().enumerate().map(|(index, hand)| {
        let sensor = &status.hands[index];
        let lost = if sensor.lost > 0 {
            format!(" lost {}", sensor.lost)
        } else {
            String::new()
        };
        format!(
            "{hand} {}/s {}{lost}",
            hz(rates.frames_hz[index]),
            age(sensor.age_ns)
        )
    });
    let hands: Vec<String> = hands.collect();
    format!(
        "{} · joints {}/s {} · ticks {}/s",
        hands.join(" · "),
        hz(rates.joints_hz),
        age(status.joints.age_ns),
        hz(rates.ticks_hz)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_tick_is_visible_among_thousands() {
        let mut counts = [0; BINS];
        assert_eq!(columns(&counts), " ".repeat(BINS));
        counts[2] = 100_000;
        counts[BINS - 1] = 1;
        let shown: Vec<char> = columns(&counts).chars().collect();
        assert_eq!((shown[1], shown[2], shown[BINS - 1]), (' ', '█', '▁'));
    }
}
