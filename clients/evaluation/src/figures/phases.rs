//! Timeline of a hand's steps: one bar and one name per step.
//!
//! A name that would overlap a later one is raised by a row and connected to its step by a line.
//! Later names are lower, so that no line crosses a name.

use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::figure::{Area, CHARACTER, Drawing, GREY, INK, LEFT, RIGHT, SMALL, WIDTH, text};

/// Height of a row of names, px.
const ROW: u32 = 36;
/// Height of the bars, px.
const BARS: u32 = 14;
/// Room above the names, px.
const ABOVE: u32 = 6;

/// Step: name, and time range on the axis of the panels below.
pub(super) type Step = (String, Range<f64>);

pub(super) struct Phases {
    x: Range<f64>,
    steps: Vec<(Step, u32)>,
}

impl Phases {
    /// Assigns rows to the names of the steps within `x`.
    pub(super) fn new(x: &Range<f64>, steps: &[Step]) -> Self {
        let is_seen = |(_, time): &&Step| time.start <= x.end && time.end >= x.start;
        let mut phases = Self {
            x: x.clone(),
            steps: Vec::new(),
        };
        let mut later: Vec<(f64, u32)> = Vec::new();
        for step in steps.iter().filter(is_seen).rev() {
            let from_px = phases.px(step.1.start);
            let to_px = from_px + width_px(&step.0);
            let under = later.iter().filter(|(start_px, _)| *start_px < to_px);
            let row = under.map(|(_, row)| row + 1).max().unwrap_or(0);
            later.push((from_px, row));
            phases.steps.push((step.clone(), row));
        }
        phases
    }

    pub(super) fn axis_end(x: &Range<f64>, steps: &[Step]) -> f64 {
        let plot_px = f64::from(WIDTH - LEFT - RIGHT);
        let reach = |(name, time): &Step| {
            let share = width_px(name).min(0.5 * plot_px) / plot_px;
            (time.start - share * x.start) / (1.0 - share)
        };
        steps.iter().map(reach).fold(x.end, f64::max)
    }

    pub(super) fn height(&self) -> u32 {
        let rows = self.steps.iter().map(|(_, row)| row + 1).max();
        ABOVE + rows.unwrap_or(0) * ROW + BARS
    }

    pub(super) fn draw(&self, area: &Area<'_>, label: &str, colour: RGBColor) -> Drawing {
        let bottom = self.height() as i32;
        let bars = bottom - BARS as i32;
        for (index, ((name, time), row)) in self.steps.iter().rev().enumerate() {
            let left = (f64::from(LEFT) + self.px(time.start)) as i32;
            let right = (f64::from(LEFT) + self.px(time.end)) as i32;
            let tint = colour.mix(if index % 2 == 0 { 0.75 } else { 0.4 });
            let corners = [(left, bars), (right.max(left + 2), bottom)];
            area.draw(&Rectangle::new(corners, tint.filled()))?;
            let base = bars - (*row * ROW) as i32;
            if *row > 0 {
                let line = [(left, base - 30), (left, bars)];
                area.draw(&PathElement::new(line, GREY.stroke_width(2)))?;
            }
            let style = text(SMALL, INK).pos(Pos::new(HPos::Left, VPos::Bottom));
            area.draw(&Text::new(name.clone(), (left + 6, base), style))?;
        }
        let style = text(SMALL, INK).pos(Pos::new(HPos::Right, VPos::Bottom));
        let at = (LEFT as i32 - 14, bars);
        area.draw(&Text::new(label.to_owned(), at, style))?;
        Ok(())
    }

    fn px(&self, at: f64) -> f64 {
        let within = at.clamp(self.x.start, self.x.end) - self.x.start;
        within / (self.x.end - self.x.start) * f64::from(WIDTH - LEFT - RIGHT)
    }
}

fn width_px(name: &str) -> f64 {
    name.chars().count() as f64 * SMALL * CHARACTER + 16.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(starts: &[(&str, f64)]) -> Vec<u32> {
        let steps: Vec<Step> = starts
            .iter()
            .map(|(name, at)| ((*name).to_owned(), *at..*at + 0.1))
            .collect();
        let mut rows: Vec<u32> = Phases::new(&(0.0..10.0), &steps)
            .steps
            .iter()
            .map(|(_, row)| *row)
            .collect();
        rows.reverse();
        rows
    }

    #[test]
    fn overlapping_names_are_raised_by_rows() {
        assert_eq!(rows(&[("reach", 0.0), ("lift", 5.0)]), [0, 0]);
        assert_eq!(rows(&[("reach", 0.0), ("lift", 0.1)]), [1, 0]);
        let crowded = [
            ("reach", 0.0),
            ("close", 0.1),
            ("probe", 0.2),
            ("lift", 0.3),
        ];
        assert_eq!(rows(&crowded), [3, 2, 1, 0]);
        // The first name ends before the third begins, and the second does not overlap the first.
        assert_eq!(rows(&[("a", 0.0), ("b", 3.0), ("c", 3.1)]), [0, 1, 0]);
        assert_eq!(rows(&[("gone", -3.0), ("lift", 1.0)]), [0]);
    }

    #[test]
    fn axis_leaves_room_for_last_name() {
        let steps = [
            ("approach".to_owned(), 0.0..9.9),
            ("home".to_owned(), 9.9..10.0),
        ];
        let x = 0.0..10.0;
        let end = Phases::axis_end(&x, &steps);
        assert!((10.2..11.0).contains(&end), "{end}");
        assert_eq!(Phases::axis_end(&x, &steps[..1]), 10.0);
    }
}
