//! Figs. 15–17: paths of agents and object, one panel per trial, with lights, scale and start of
//! evaluation.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf32;
use plotters::prelude::*;

use super::{COLOURS, failed};
use crate::analysis::{Frame, Trace};
use crate::condition::Condition;
use crate::error::Result;
use field::{EXECUTION_FRAMES, Model};

/// Frames between two drawn outlines of a body.
const OUTLINE_EVERY: usize = 45;
const PANEL_PX: u32 = 280;
const LEGEND_PX: u32 = 46;
const SCALE_PX: f32 = 200.0;
const OBJECT_LIGHT: RGBColor = RGBColor(240, 190, 0);
const GOAL: RGBColor = RGBColor(213, 94, 0);

/// Trial to draw.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title above the panel.
    pub title: String,
    /// Trace of the trial.
    pub trace: Trace,
}

/// Draws one panel per trial, four in a row.
pub fn trajectories(condition: &Condition, panels: &[Panel]) -> Result<String> {
    let mut svg = String::new();
    draw(condition, panels, &mut svg).map_err(failed)?;
    Ok(svg)
}

type Drawing = std::result::Result<(), Box<dyn std::error::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf32, RangedCoordf32>>;

fn draw(condition: &Condition, panels: &[Panel], svg: &mut String) -> Drawing {
    let columns = panels.len().clamp(1, 4);
    let rows = panels.len().div_ceil(4);
    // The legend needs the width of 2.5 panels.
    let width = (columns as u32 * PANEL_PX).max(740);
    let height = rows as u32 * (PANEL_PX + 24);
    let area = SVGBackend::with_string(svg, (width, height + LEGEND_PX)).into_drawing_area();
    area.fill(&WHITE)?;
    let (above, below) = area.split_vertically(height);
    let (above, _) = above.split_horizontally(columns as u32 * PANEL_PX);
    for (panel, area) in panels
        .iter()
        .zip(above.split_evenly((rows.max(1), columns)))
    {
        draw_trial(&condition.model, panel, &area)?;
    }
    legend(&below, condition.team.get())?;
    area.present()?;
    Ok(())
}

fn draw_trial(model: &Model, Panel { title, trace }: &Panel, area: &Area<'_>) -> Drawing {
    let preset = model.preset();
    let half = preset.half_side_px;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 14))
        .margin(6)
        .build_cartesian_2d(-half..half, -half..half)?;
    let to_pixels = chart.plotting_area().dim_in_pixel().0 as f32 / (2.0 * half);
    let radius = |px: f32| (px * to_pixels) as i32;
    let end = trace.frames.last().map_or((0.0, 0.0), object);
    let goal = (trace.goal.x_px, trace.goal.y_px);
    let lights = [
        (goal, preset.goal_light_px, GOAL),
        (end, preset.object_light_px, OBJECT_LIGHT),
    ];
    for (centre, range, colour) in lights {
        // The plotting area clips circles at the border of the field.
        chart.draw_series([Polygon::new(inside(centre, range, half), colour.mix(0.10))])?;
    }
    chart.draw_series([Rectangle::new([(-half, -half), (half, half)], BLACK)])?;
    for wall in model.walls() {
        let line = [wall.from_px, wall.to_px].map(|[x, y]| (x, y));
        chart.draw_series([PathElement::new(line, BLACK.stroke_width(3))])?;
    }
    for post in model.posts() {
        let ([x, y], size) = (post.at_px, radius(post.radius_px));
        chart.draw_series([Circle::new((x, y), size, BLACK.mix(0.7).filled())])?;
    }
    chart.draw_series([Circle::new(
        goal,
        radius(preset.goal_radius_px),
        GOAL.mix(0.35).filled(),
    )])?;
    path(
        &mut chart,
        trace,
        object,
        radius(preset.object_radius_px),
        BLACK,
        2,
    )?;
    for (agent, colour) in (0..trace.frames[0].agents.len()).zip(COLOURS) {
        let place = |frame: &Frame| (frame.agents[agent].x_px, frame.agents[agent].y_px);
        path(
            &mut chart,
            trace,
            place,
            radius(preset.agent_radius_px),
            colour,
            1,
        )?;
        let number = (agent + 1).to_string();
        chart.draw_series([Text::new(
            number,
            place(&trace.frames[0]),
            ("sans-serif", 14),
        )])?;
    }
    scale(&mut chart, half)
}

fn object(frame: &Frame) -> (f32, f32) {
    (frame.object.x_px, frame.object.y_px)
}

fn inside((x, y): (f32, f32), radius: f32, half: f32) -> Vec<(f32, f32)> {
    let corner = |k: u8| {
        let (cos, sin) = field::cos_sin(k);
        (
            (x + radius * cos).clamp(-half, half),
            (y + radius * sin).clamp(-half, half),
        )
    };
    (0..64).map(corner).collect()
}

fn path(
    chart: &mut Chart<'_, '_>,
    trace: &Trace,
    place: impl Fn(&Frame) -> (f32, f32),
    radius: i32,
    colour: RGBColor,
    width: u32,
) -> Drawing {
    let places: Vec<(f32, f32)> = trace.frames.iter().map(place).collect();
    chart.draw_series(LineSeries::new(
        places.iter().copied(),
        colour.stroke_width(width),
    ))?;
    for &at in places.iter().step_by(OUTLINE_EVERY) {
        chart.draw_series([Circle::new(at, radius, colour.mix(0.6))])?;
    }
    if let Some(&judged) = places.get(EXECUTION_FRAMES as usize) {
        chart.draw_series([Circle::new(judged, 4, colour.filled())])?;
    }
    Ok(())
}

fn scale(chart: &mut Chart<'_, '_>, half: f32) -> Drawing {
    let (x, y) = (-0.95 * half, -0.95 * half);
    let bar = [(x, y), (x + SCALE_PX, y)];
    chart.draw_series([PathElement::new(bar, BLACK.stroke_width(2))])?;
    let label = format!("{SCALE_PX} px");
    chart.draw_series([Text::new(
        label,
        (x + SCALE_PX + 0.02 * half, y + 0.02 * half),
        ("sans-serif", 11),
    )])?;
    Ok(())
}

fn legend(area: &Area<'_>, agents: usize) -> Drawing {
    let text = |label: &str, x: i32, y: i32| {
        area.draw(&Text::new(label.to_owned(), (x, y), ("sans-serif", 12)))
    };
    let entry = |label: &str, colour: RGBColor, x: i32| {
        area.draw(&PathElement::new(
            [(x, 12), (x + 18, 12)],
            colour.stroke_width(2),
        ))?;
        text(label, x + 22, 6)
    };
    entry("object", BLACK, 8)?;
    for (agent, colour) in (0..agents).zip(COLOURS) {
        entry(
            &format!("agent {}", agent + 1),
            colour,
            90 + 85 * agent as i32,
        )?;
    }
    let shade = |label: &str, colour: RGBAColor, x: i32| {
        area.draw(&Rectangle::new([(x, 26), (x + 18, 38)], colour.filled()))?;
        text(label, x + 22, 26)
    };
    shade("goal", GOAL.mix(0.35), 8)?;
    shade("goal's light", GOAL.mix(0.15), 90)?;
    shade("object's light, at the end", OBJECT_LIGHT.mix(0.2), 200)?;
    area.draw(&Circle::new((390, 32), 4, BLACK.filled()))?;
    text(
        &format!(
            "evaluation begins (frame {EXECUTION_FRAMES}); outlines every {OUTLINE_EVERY} frames"
        ),
        400,
        26,
    )?;
    Ok(())
}
