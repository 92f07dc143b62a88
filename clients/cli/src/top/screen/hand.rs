//! One hand: each finger's forces between the thresholds, and its elements.

use atas_client::layouts;
use atas_console::number;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_schemas::{FingerReport, Hand, HandFrame, HandReport, Layout};

use super::Look;
use crate::top::seen::Seen;

/// Characters of a bar, at most.
const BAR: usize = 18;
/// Rows of a fingertip, and its columns at most.
const MAP: [usize; 2] = [5, 13];
/// Columns between two fingertips, and for the force of the strongest shade.
const GAP: usize = 2;
const SCALE: usize = 9;
/// Fingers with a line for each of their forces; more have one for both.
const ROOMY: usize = 2;
/// From nothing to the strongest.
const SHADES: [char; 8] = ['·', ':', '-', '=', '+', '*', '#', '@'];
/// Least force of the strongest shade, N (ours: above the sensors' noise).
const LEAST_N: f32 = 0.05;
/// Elements nearer to each other than this are not drawn apart to the rim, m (ours: less than any fingertip is wide).
const SPREAD_MIN_M: f64 = 0.0045;
/// Limits beyond this are none: nothing has set them yet, N.
const NO_LIMIT_N: f32 = 100.0;

/// Draws the hand with this index and so many fingers.
pub(super) fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    seen: &Seen,
    (hand, fingers): (usize, usize),
    look: Look,
) {
    let report = &seen.watch.report.hands[hand];
    let width = usize::from(area.width);
    let mut lines = vec![Line::from(vec![
        Span::styled(format!("{:5} ", Hand::BOTH[hand].name()), look.strong()),
        Span::raw(format!(
            "F_1 {} F_2 {} N  {}",
            number(report.f1_n.into(), 2),
            number(report.f2_n.into(), 2),
            stiffness(report.stiffness_n_m)
        )),
    ])];
    for finger in 0..fingers {
        if fingers > ROOMY {
            lines.push(on_one_line(report, finger, width, look));
        } else {
            lines.extend(on_two_lines(report, finger, look));
        }
    }
    lines.extend(maps(seen, hand, fingers, width, look));
    frame.render_widget(Paragraph::new(lines), area);
}

fn on_two_lines(report: &HandReport, finger: usize, look: Look) -> [Line<'static>; 2] {
    let felt = &report.fingers[finger];
    let pressed = Line::from(vec![
        Span::raw(format!("{} F_n ", finger + 1)),
        Span::styled(bar(felt.normal_n, report, BAR), look.finger(finger)),
        Span::raw(format!(" {} N", number(felt.normal_n.into(), 2))),
    ]);
    let sheared = Line::from(vec![
        Span::raw("  F_t "),
        Span::styled(bar(felt.tangential_n, report, BAR), look.soft()),
        Span::raw(format!(
            " {} N {}",
            number(felt.tangential_n.into(), 2),
            slip(felt)
        )),
    ]);
    [pressed, sheared]
}

/// Both forces of a finger, in as many characters as there are.
fn on_one_line(report: &HandReport, finger: usize, width: usize, look: Look) -> Line<'static> {
    let felt = &report.fingers[finger];
    let head = format!("{} F_n ", finger + 1);
    let tail = format!(
        " {} F_t {} N {:6}",
        number(felt.normal_n.into(), 2),
        number(felt.tangential_n.into(), 2),
        slip(felt)
    );
    let left = width.saturating_sub(head.len() + tail.len()).min(BAR);
    let bar = bar(felt.normal_n, report, left);
    Line::from(vec![
        Span::raw(head),
        Span::styled(bar, look.finger(finger)),
        Span::raw(tail),
    ])
}

/// How much of its friction a finger uses; at 1 it slides.
fn slip(felt: &FingerReport) -> String {
    if felt.utilisation >= 1.0 {
        "SLIPS".into()
    } else {
        format!("S {}", number(felt.utilisation.into(), 2))
    }
}

fn stiffness(n_m: f32) -> String {
    match n_m {
        n_m if n_m <= 0.0 => String::new(),
        n_m if n_m >= 1e4 => format!("{} kN/m", number(f64::from(n_m) * 1e-3, 0)),
        n_m => format!("{} N/m", number(n_m.into(), 0)),
    }
}

/// A force as a bar of so many characters, with a mark at each threshold.
fn bar(force_n: f32, report: &HandReport, columns: usize) -> String {
    let f2_n = if report.f2_n < NO_LIMIT_N {
        report.f2_n
    } else {
        0.0
    };
    let full_n = (f2_n * 1.15).max(1.0).max(force_n);
    let place = |n: f32| ((n / full_n) * columns as f32).max(0.0) as usize;
    (0..columns)
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

/// The fingertips side by side.
fn maps(seen: &Seen, hand: usize, fingers: usize, width: usize, look: Look) -> Vec<Line<'static>> {
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
    let tips = frame.force_n.iter().take(fingers);
    let pressed = tips.flat_map(|f| &f[..layout.count]);
    let full_n = pressed.fold(LEAST_N, |most, force| most.max(force[0]));
    let columns = columns(fingers, width);
    (0..MAP[0])
        .map(|row| {
            let spans = (0..fingers).flat_map(|finger| {
                let text: String = (0..columns)
                    .map(|column| {
                        let at = [middle(row, MAP[0]), middle(column, columns)];
                        shade(&layout, frame, finger, at, full_n)
                    })
                    .collect();
                [
                    Span::styled(text, look.finger(finger)),
                    Span::raw(" ".repeat(GAP)),
                ]
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

/// Columns of a fingertip beside the others.
fn columns(fingers: usize, width: usize) -> usize {
    let each = width.saturating_sub(SCALE) / fingers.max(1);
    each.saturating_sub(GAP).min(MAP[1])
}

/// The middle of a cell, from −1 to 1 over all of them.
fn middle(at: usize, of: usize) -> f64 {
    (2.0 * at as f64 + 1.0) / of as f64 - 1.0
}

/// The shade of the nearest element; nothing outside the skin. Up is −x of the tip, right is y.
fn shade(
    layout: &Layout,
    frame: &HandFrame,
    finger: usize,
    [down, right]: [f64; 2],
    full_n: f32,
) -> char {
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
            assert_eq!(bar(force_n, &report, 20), expected);
        };
        check(0.0, 0.0, 0.0, "····················");
        check(0.5, 0.0, 0.0, "██████████··········");
        check(4.0, 2.0, 8.0, "████│███·········│··");
        check(f32::NAN, 0.0, 1e6, "····················");
        check(50.0, 0.0, f32::INFINITY, "████████████████████");
    }

    #[test]
    fn as_many_fingertips_as_a_hand_may_have_fit_beside_their_scale() {
        for (fingers, width, expected) in [(2, 39, 13), (3, 39, 8), (4, 39, 5), (3, 80, 13)] {
            assert_eq!(columns(fingers, width), expected, "{fingers} in {width}");
            let used = fingers * (columns(fingers, width) + GAP) + SCALE;
            assert!(used <= width, "{fingers} in {width}: {used}");
        }
    }

    #[test]
    fn a_line_for_both_forces_fits_into_half_a_screen() {
        let mut report = HandReport::default();
        (report.fingers[2].normal_n, report.fingers[2].tangential_n) = (12.25, 3.5);
        report.fingers[2].utilisation = 1.25;
        let look = Look { colours: false };
        let line = on_one_line(&report, 2, 39, look).to_string();
        assert_eq!(line.chars().count(), 39, "{line}");
        assert!(
            line.starts_with("3 F_n ") && line.ends_with(" 12.25 F_t 3.50 N SLIPS "),
            "{line}"
        );
    }
}
