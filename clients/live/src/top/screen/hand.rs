//! Block of one hand: forces of each fingertip between the thresholds, and its elements.

use atas_client::layouts;
use atas_console::number;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use shm_schemas::{FingerReport, Hand, HandFrame, HandReport, Layout};

use super::Palette;
use crate::top::state::ScreenState;

/// Largest length of a force bar, characters.
const BAR_COLUMNS_MAX: usize = 18;
/// Rows and maximum columns of a fingertip map.
const MAP: [usize; 2] = [5, 13];
/// Columns between two fingertip maps, and columns of the scale.
const GAP: usize = 2;
const SCALE: usize = 9;
/// Most fingertips with separate lines for normal and tangential force.
const TWO_LINE_FINGERTIPS_MAX: usize = 2;
/// Shades from zero to the largest force.
const SHADES: [char; 8] = ['·', ':', '-', '=', '+', '*', '#', '@'];
/// Smallest force of the darkest shade, N. Design choice: above the sensor noise.
const FULL_SCALE_MIN_N: f32 = 0.05;
/// Smallest radius of the map scale, m. Design choice: smaller than any fingertip. Keeps close
/// elements from filling the map.
const SPREAD_MIN_M: f64 = 0.0045;
/// Larger limits count as not set, N.
const NO_LIMIT_N: f32 = 100.0;

/// Draws a hand, given by its index and number of fingertips.
pub(super) fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    seen: &ScreenState,
    (hand, fingers): (usize, usize),
    look: Palette,
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
        if fingers > TWO_LINE_FINGERTIPS_MAX {
            lines.push(on_one_line(report, finger, width, look));
        } else {
            lines.extend(on_two_lines(report, finger, look));
        }
    }
    lines.extend(maps(seen, hand, fingers, width, look));
    frame.render_widget(Paragraph::new(lines), area);
}

fn on_two_lines(report: &HandReport, finger: usize, look: Palette) -> [Line<'static>; 2] {
    let measured = &report.fingers[finger];
    let pressed = Line::from(vec![
        Span::raw(format!("{} F_n ", finger + 1)),
        Span::styled(
            bar(measured.normal_n, report, BAR_COLUMNS_MAX),
            look.fingertip(finger),
        ),
        Span::raw(format!(" {} N", number(measured.normal_n.into(), 2))),
    ]);
    let sheared = Line::from(vec![
        Span::raw("  F_t "),
        Span::styled(
            bar(measured.tangential_n, report, BAR_COLUMNS_MAX),
            look.dim(),
        ),
        Span::raw(format!(
            " {} N {}",
            number(measured.tangential_n.into(), 2),
            slip(measured)
        )),
    ]);
    [pressed, sheared]
}

/// Formats both forces of a fingertip on one line of the given width.
fn on_one_line(report: &HandReport, finger: usize, width: usize, look: Palette) -> Line<'static> {
    let measured = &report.fingers[finger];
    let head = format!("{} F_n ", finger + 1);
    let tail = format!(
        " {} F_t {} N {:6}",
        number(measured.normal_n.into(), 2),
        number(measured.tangential_n.into(), 2),
        slip(measured)
    );
    let left = width
        .saturating_sub(head.len() + tail.len())
        .min(BAR_COLUMNS_MAX);
    let bar = bar(measured.normal_n, report, left);
    Line::from(vec![
        Span::raw(head),
        Span::styled(bar, look.fingertip(finger)),
        Span::raw(tail),
    ])
}

/// Formats the friction utilisation S; at 1 the fingertip slips.
fn slip(measured: &FingerReport) -> String {
    if measured.utilisation >= 1.0 {
        "SLIPS".into()
    } else {
        format!("S {}", number(measured.utilisation.into(), 2))
    }
}

fn stiffness(n_m: f32) -> String {
    match n_m {
        n_m if n_m <= 0.0 => String::new(),
        n_m if n_m >= 1e4 => format!("{} kN/m", number(f64::from(n_m) * 1e-3, 0)),
        n_m => format!("{} N/m", number(n_m.into(), 0)),
    }
}

/// Draws a force as a bar with marks at the thresholds F_1 and F_2.
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

/// Draws the fingertip maps side by side.
fn maps(
    seen: &ScreenState,
    hand: usize,
    fingers: usize,
    width: usize,
    look: Palette,
) -> Vec<Line<'static>> {
    let view = &seen.watch.view;
    let frame = &view.frames[hand];
    if view.has_frame[hand] == 0 {
        return vec![Line::styled("no frame yet", look.dim())];
    }
    let Some(layout) = layouts::named(frame.layout_hash) else {
        return vec![Line::styled("unknown element layout", look.dim())];
    };
    let tips = frame.force_n.iter().take(fingers);
    let pressed = tips.flat_map(|f| &f[..layout.count]);
    let full_n = pressed.fold(FULL_SCALE_MIN_N, |most, force| most.max(force[0]));
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
                    Span::styled(text, look.fingertip(finger)),
                    Span::raw(" ".repeat(GAP)),
                ]
            });
            let mut spans: Vec<Span<'static>> = spans.collect();
            if row == 0 {
                spans.push(Span::styled(
                    format!("@ {} N", number(full_n.into(), 2)),
                    look.dim(),
                ));
            }
            Line::from(spans)
        })
        .collect()
}

/// Returns the width of one fingertip map, columns.
fn columns(fingers: usize, width: usize) -> usize {
    let each = width.saturating_sub(SCALE) / fingers.max(1);
    each.saturating_sub(GAP).min(MAP[1])
}

/// Returns the centre of a cell, normalised to −1 to 1.
fn middle(at: usize, of: usize) -> f64 {
    (2.0 * at as f64 + 1.0) / of as f64 - 1.0
}

/// Returns the shade of the nearest element, or a space outside the skin. Up is −x of the
/// fingertip, right is y.
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
    fn bar_shows_force_and_thresholds() {
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
    fn maximum_fingertips_fit_next_to_scale() {
        for (fingers, width, expected) in [(2, 39, 13), (3, 39, 8), (4, 39, 5), (3, 80, 13)] {
            assert_eq!(columns(fingers, width), expected, "{fingers} in {width}");
            let used = fingers * (columns(fingers, width) + GAP) + SCALE;
            assert!(used <= width, "{fingers} in {width}: {used}");
        }
    }

    #[test]
    fn two_force_line_fits_half_screen() {
        let mut report = HandReport::default();
        (report.fingers[2].normal_n, report.fingers[2].tangential_n) = (12.25, 3.5);
        report.fingers[2].utilisation = 1.25;
        let look = Palette { colours: false };
        let line = on_one_line(&report, 2, 39, look).to_string();
        assert_eq!(line.chars().count(), 39, "{line}");
        assert!(
            line.starts_with("3 F_n ") && line.ends_with(" 12.25 F_t 3.50 N SLIPS "),
            "{line}"
        );
    }
}
