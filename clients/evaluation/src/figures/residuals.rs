//! Figure of calibration errors over the known force, per axis.

use plotters::prelude::*;

use super::figure::{Axes, BLUE, GREY, figure, line, panel};

/// Height of one panel, px.
const PANEL: u32 = 420;
/// Maximum number of points per axis.
const POINTS: usize = 3000;

/// Draws pairs of known force and error, N, each with normal and two tangential components.
///
/// # Errors
/// `points` is empty, or the drawing library fails.
pub fn residuals(title: &str, points: &[([f64; 3], [f64; 3])]) -> anyhow::Result<String> {
    anyhow::ensure!(!points.is_empty(), "could not draw errors: there are none");
    figure(3 * PANEL + 64, title, |area| {
        let names = ["normal", "tangential 1", "tangential 2"];
        for (axis, (part, name)) in area.split_evenly((3, 1)).iter().zip(names).enumerate() {
            let every = points.len().div_ceil(POINTS);
            let of: Vec<(f64, f64)> = points
                .iter()
                .step_by(every)
                .map(|(known_n, error_n)| (known_n[axis], error_n[axis]))
                .collect();
            let reach = |side: fn(&(f64, f64)) -> f64| {
                of.iter().map(side).fold(1e-3, |a: f64, b| a.max(b.abs())) * 1.1
            };
            let from = of.iter().map(|p| p.0).fold(0.0, f64::min);
            let to = of.iter().map(|p| p.0).fold(1e-3, f64::max);
            let margin = 0.05 * (to - from);
            let (x, y) = (from - margin..to + margin, reach(|p| p.1));
            let axes = Axes {
                x: &format!("known force along {name}, N"),
                y: "error, N",
            };
            let mut chart = panel(part, x.clone(), -y..y, &axes, &[])?;
            line(&mut chart, vec![(x.start, 0.0), (x.end, 0.0)], GREY, 2)?;
            chart.draw_series(
                of.iter()
                    .map(|&at| Circle::new(at, 4, BLUE.mix(0.4).filled())),
            )?;
        }
        Ok(())
    })
}
