//! Sensors and behaviour over frames: the paper's table after Fig. 15, and a strip chart.

use plotters::prelude::*;
use serde::Serialize;

use super::{COLOURS, failed};
use crate::analysis::Trace;
use crate::error::Result;
use crate::table::behaviour;
use field::EXECUTION_FRAMES;

/// Row of the paper's table: sensors and behaviour of an agent in a frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BehaviourRow {
    /// Frame within the trial.
    pub frame: usize,
    /// Agent, from 1.
    pub agent: usize,
    /// Sensors S1–S5.
    pub sensors: [u8; 5],
    /// Behaviour in the paper's words.
    pub behaviour: &'static str,
}

/// Returns the rows of some frames, agent by agent.
#[must_use]
pub fn behaviour_rows(trace: &Trace, frames: &[usize]) -> Vec<BehaviourRow> {
    let row = |frame: usize, agent: usize| {
        let at = &trace.frames[frame];
        let wheels = at.wheels[agent];
        BehaviourRow {
            frame,
            agent: agent + 1,
            sensors: std::array::from_fn(|s| (at.rows[agent] >> s & 1) as u8),
            behaviour: behaviour(usize::from(wheels.left), usize::from(wheels.right)),
        }
    };
    let known = frames
        .iter()
        .copied()
        .filter(|&frame| frame < trace.frames.len());
    known
        .flat_map(|frame| (0..trace.frames[frame].agents.len()).map(move |agent| row(frame, agent)))
        .collect()
}

/// Lines of one agent: S1–S5, turning left, straight, turning right, stopped.
const LINES: [&str; 9] = [
    "S1", "S2", "S3", "S4", "S5", "left", "straight", "right", "stop",
];

/// Draws sensors and behaviour of every agent over the frames.
pub fn behaviour_strip(trace: &Trace) -> Result<String> {
    let mut svg = String::new();
    draw(trace, &mut svg).map_err(failed)?;
    Ok(svg)
}

type Drawing = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw(trace: &Trace, svg: &mut String) -> Drawing {
    let agents = trace.frames[0].agents.len();
    let area = SVGBackend::with_string(svg, (960, 200 * agents as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for ((agent, colour), panel) in (0..agents).zip(COLOURS).zip(area.split_evenly((agents, 1))) {
        let lines = LINES.len();
        let mut chart = ChartBuilder::on(&panel)
            .caption(format!("agent {}", agent + 1), ("sans-serif", 14))
            .margin(6)
            .x_label_area_size(34)
            .y_label_area_size(64)
            .build_cartesian_2d(0..trace.frames.len(), 0.0..lines as f64)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .y_labels(0)
            .x_labels(10)
            .x_desc("frame")
            .draw()?;
        // Evaluation begins here (paper III.b.3: 180 frames of execution, then 90 of evaluation).
        let judged = EXECUTION_FRAMES as usize;
        let border = [(judged, 0.0), (judged, lines as f64)];
        chart.draw_series([PathElement::new(border, BLACK.stroke_width(1))])?;
        chart.draw_series([Text::new(
            "evaluation begins",
            (judged + 2, lines as f64),
            ("sans-serif", 11),
        )])?;
        for (line, name) in LINES.iter().enumerate() {
            let y = (lines - 1 - line) as f64;
            let spans = spans(trace, agent, line);
            let bar = |&(from, to): &(usize, usize)| {
                Rectangle::new([(from, y + 0.15), (to, y + 0.85)], colour.filled())
            };
            chart.draw_series(spans.iter().map(bar))?;
            let left = chart.plotting_area().map_coordinate(&(0, y + 0.8));
            area_text(&panel, name, left)?;
        }
    }
    area.present()?;
    Ok(())
}

fn area_text(
    panel: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    name: &str,
    at: (i32, i32),
) -> Drawing {
    let (left, top) = panel.strip_coord_spec().get_base_pixel();
    panel.draw(&Text::new(
        name.to_owned(),
        (at.0 - left - 58, at.1 - top),
        ("sans-serif", 11),
    ))?;
    Ok(())
}

/// Returns the frame ranges, end exclusive, in which a line is set.
fn spans(trace: &Trace, agent: usize, line: usize) -> Vec<(usize, usize)> {
    let set = |frame: &crate::analysis::Frame| {
        let (left, right) = (frame.wheels[agent].left, frame.wheels[agent].right);
        match line {
            5 => left < right,
            6 => left == right && left > 0,
            7 => left > right,
            8 => left == 0 && right == 0,
            sensor => frame.rows[agent] >> sensor & 1 == 1,
        }
    };
    let mut spans: Vec<(usize, usize)> = Vec::new();
    for (number, frame) in trace.frames.iter().enumerate() {
        if set(frame) {
            match spans.last_mut() {
                Some((_, end)) if *end == number => *end += 1,
                _ => spans.push((number, number + 1)),
            }
        }
    }
    spans
}
