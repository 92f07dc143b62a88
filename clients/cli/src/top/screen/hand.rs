//! One hand: each finger's forces between the thresholds, and its elements.

use atas_client::{FINGERS, layouts};
use atas_console::number;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_schemas::{Hand, HandFrame, HandReport, Layout};

use super::Look;
use crate::top::seen::Seen;

/// Characters of a bar.
const BAR: usize = 20;
/// Rows and columns of a fingertip.
const MAP: [usize; 2] = [5, 13];
/// From nothing to the strongest.
const SHADES: [char; 8] = ['·', ':', '-', '=', '+', '*', '#', '@'];
/// Least force of the strongest shade, N (ours: above the sensors' noise).
const LEAST_N: f32 = 0.05;
/// Elements nearer to each other than this are not drawn apart to the rim, m (ours: less than any fingertip is wide).
const SPREAD_MIN_M: f64 = 0.0045;
/// Limits beyond this are none: nothing has set them yet, N.
const NO_LIMIT_N: f32 = 100.0;

pub(super) fn draw(frame: &mut Frame<'_>, area: Rect, seen: &Seen, hand: usize, look: Look) {
    let report = &seen.watch.report.hands[hand];
    let mut lines = vec![Line::from(vec![
        Span::styled(format!("{:5} ", Hand::BOTH[hand].name()), look.strong()),
        Span::raw(format!(
            "F_1 {} F_2 {} N  {}",
            number(report.f1_n.into(), 2),
            number(report.f2_n.into(), 2),
            stiffness(report.stiffness_n_m)
        )),
    ])];
    for (finger, style) in (0..FINGERS).zip([look.first(), look.second()]) {
        let felt = &report.fingers[finger];
        lines.push(Line::from(vec![
            Span::raw(format!("{} F_n ", finger + 1)),
            Span::styled(bar(felt.normal_n, report), style),
            Span::raw(format!(" {} N", number(felt.normal_n.into(), 2))),
        ]));
        let slips = if felt.utilisation >= 1.0 {
            " SLIPS"
        } else {
            ""
        };
        lines.push(Line::from(vec![
            Span::raw("  F_t "),
            Span::styled(bar(felt.tangential_n, report), look.soft()),
            Span::raw(format!(
                " {} S {}{slips}",
                number(felt.tangential_n.into(), 2),
                number(felt.utilisation.into(), 2)
            )),
        ]));
    }
    lines.extend(maps(seen, hand, look));
    frame.render_widget(Paragraph::new(lines), area);
}

fn stiffness(n_m: f32) -> String {
    match n_m {
        n_m if n_m <= 0.0 => String::new(),
        n_m if n_m >= 1e4 => format!("{} kN/m", number(f64::from(n_m) * 1e-3, 0)),
        n_m => format!("{} N/m", number(n_m.into(), 0)),
    }
}

/// A force as a bar, with a mark at each threshold.
fn bar(force_n: f32, report: &HandReport) -> String {
    let f2_n = if report.f2_n < NO_LIMIT_N {
        report.f2_n
    } else {
        0.0
    };
    let full_n = (f2_n * 1.15).max(1.0).max(force_n);
    let place = |n: f32| ((n / full_n) * BAR as f32).max(0.0) as usize;
    (0..BAR)
        .map(|column| {
            let is_mark = |limit_n: f32| limit_n > 0.0 && place(limit_n) == column;
            if is_mark(report.f1_n) || is_mark(f2_n) {
                '│'
            } else if force_n.is_finite() && column < place(force_n) {
                '█'
            } else {
                '·'
            }
        })
        .collect()
}

/// Both fingertips side by side.
fn maps(seen: &Seen, hand: usize, look: Look) -> Vec<Line<'static>> {
    let view = &seen.watch.view;
    let frame = &view.frames[hand];
    if view.has_frame[hand] == 0 {
        return vec![Line::styled("no frame yet", look.soft())];
    }
    let Some(layout) = layouts::named(frame.layout_hash) else {
        return vec![Line::styled(
            "elements of a layout that has no name",
            look.soft(),
        )];
    };
    let pressed = frame
        .force_n
        .iter()
        .take(FINGERS)
        .flat_map(|f| &f[..layout.count]);
    let full_n = pressed.fold(LEAST_N, |most, force| most.max(force[0]));
    (0..MAP[0])
        .map(|row| {
            let spans = (0..FINGERS).flat_map(|finger| {
                let text: String = (0..MAP[1])
                    .map(|column| shade(&layout, frame, finger, [row, column], full_n))
                    .collect();
                let style = if finger == 0 {
                    look.first()
                } else {
                    look.second()
                };
                [Span::styled(text, style), Span::raw("   ")]
            });
            let mut spans: Vec<Span<'static>> = spans.collect();
            if row == 0 {
                spans.push(Span::styled(
                    format!("@ {} N", number(full_n.into(), 2)),
                    look.soft(),
                ));
            }
            Line::from(spans)
        })
        .collect()
}

/// The shade of the nearest element; nothing outside the skin. Up is −x of the tip, right is y.
fn shade(
    layout: &Layout,
    frame: &HandFrame,
    finger: usize,
    [row, column]: [usize; 2],
    full_n: f32,
) -> char {
    let middle = |at: usize, of: usize| (2.0 * at as f64 + 1.0) / of as f64 - 1.0;
    let (down, right) = (middle(row, MAP[0]), middle(column, MAP[1]));
    if down * down + right * right > 1.0 {
        return ' ';
    }
    let spread_m = layout.position_m[..layout.count]
        .iter()
        .fold(SPREAD_MIN_M, |most_m, at_m| {
            most_m.max(at_m[0].hypot(at_m[1]))
        });
    let distance = |element: usize| {
        let at_m = layout.position_m[element];
        (at_m[0] / spread_m - down).hypot(at_m[1] / spread_m - right)
    };
    let nearest = (0..layout.count).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let Some(nearest) = nearest else { return ' ' };
    if frame.valid_mask[finger] >> nearest & 1 == 0 {
        return '?';
    }
    let share = (frame.force_n[finger][nearest][0] / full_n).clamp(0.0, 1.0);
    SHADES[(share * (SHADES.len() - 1) as f32).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_ends_at_its_force_and_marks_its_limits() {
        let check = |force_n, f1_n, f2_n, expected: &str| {
            let report = HandReport {
                f1_n,
                f2_n,
                ..HandReport::default()
            };
            assert_eq!(bar(force_n, &report), expected);
        };
        check(0.0, 0.0, 0.0, "····················");
        check(0.5, 0.0, 0.0, "██████████··········");
        check(4.0, 2.0, 8.0, "████│███·········│··");
        check(f32::NAN, 0.0, 1e6, "····················");
        check(50.0, 0.0, f32::INFINITY, "████████████████████");
    }
}
