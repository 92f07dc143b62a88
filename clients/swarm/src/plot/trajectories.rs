//! Figs. 15–17: the paths of agents and object for every goal.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::{COLOURS, failed};
use crate::analysis::Trace;
use crate::condition::Condition;
use crate::error::Result;

/// Frames between two drawn outlines of a body.
const OUTLINE_EVERY: usize = 45;
const PANEL_PX: u32 = 280;

/// Draws one panel per trial, with the points it earned.
///
/// # Errors
/// The drawing library failed.
pub fn trajectories(condition: &Condition, traces: &[Trace], points: &[f32]) -> Result<String> {
    let mut svg = String::new();
    draw(condition, traces, points, &mut svg).map_err(failed)?;
    Ok(svg)
}

type Drawing = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw(condition: &Condition, traces: &[Trace], points: &[f32], svg: &mut String) -> Drawing {
    let rows = traces.len().div_ceil(4);
    let area = SVGBackend::with_string(svg, (4 * PANEL_PX, rows as u32 * (PANEL_PX + 24)))
        .into_drawing_area();
    area.fill(&WHITE)?;
    for (index, (panel, trace)) in area.split_evenly((rows, 4)).iter().zip(traces).enumerate() {
        let earned = points.get(index).copied().unwrap_or(0.0);
        draw_trial(
            condition,
            trace,
            &format!("goal {}: {earned:.0} points", index + 1),
            panel,
        )?;
    }
    area.present()?;
    Ok(())
}

fn draw_trial(
    condition: &Condition,
    trace: &Trace,
    title: &str,
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
) -> Drawing {
    let preset = condition.model.preset();
    let mut chart = ChartBuilder::on(panel)
        .caption(title, ("sans-serif", 14))
        .margin(6)
        .build_cartesian_2d(-400.0_f32..400.0, -400.0_f32..400.0)?;
    chart.draw_series([Rectangle::new([(-400.0, -400.0), (400.0, 400.0)], BLACK)])?;
    let to_pixels = chart.plotting_area().dim_in_pixel().0 as f32 / 800.0;
    let radius = |px: f32| (px * to_pixels) as i32;
    let goal = (trace.goal.x_px, trace.goal.y_px);
    chart.draw_series([Circle::new(
        goal,
        radius(preset.goal_radius_px),
        RED.mix(0.3).filled(),
    )])?;

    let object = |frame: &crate::analysis::Frame| (frame.object.x_px, frame.object.y_px);
    chart.draw_series(LineSeries::new(
        trace.frames.iter().map(object),
        BLACK.stroke_width(2),
    ))?;
    for frame in trace.frames.iter().step_by(OUTLINE_EVERY) {
        chart.draw_series([Circle::new(
            object(frame),
            radius(preset.object_radius_px),
            BLACK.mix(0.5),
        )])?;
    }
    for (agent, colour) in (0..trace.frames[0].agents.len()).zip(COLOURS) {
        let place =
            |frame: &crate::analysis::Frame| (frame.agents[agent].x_px, frame.agents[agent].y_px);
        chart.draw_series(LineSeries::new(
            trace.frames.iter().map(place),
            colour.stroke_width(1),
        ))?;
        for frame in trace.frames.iter().step_by(OUTLINE_EVERY) {
            chart.draw_series([Circle::new(
                place(frame),
                radius(preset.agent_radius_px),
                colour.mix(0.6),
            )])?;
        }
        let start = place(&trace.frames[0]);
        chart.draw_series([Text::new(
            (agent + 1).to_string(),
            start,
            ("sans-serif", 14),
        )])?;
    }
    Ok(())
}
