//! Shared drawing code: colours, panels, lines, lanes, event marks. Drawn at double size because
//! the library rounds points to whole pixels.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::FontStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(super) type Drawing = Result<(), Box<dyn std::error::Error>>;

// Distinguishable without red and green (Okabe and Ito 2008).
pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const ORANGE: RGBColor = RGBColor(230, 159, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PINK: RGBColor = RGBColor(204, 121, 167);
pub(super) const SKY: RGBColor = RGBColor(86, 180, 233);
pub(super) const RED: RGBColor = RGBColor(213, 94, 0);
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GREY: RGBColor = RGBColor(120, 120, 120);
const BAND: RGBColor = RGBColor(243, 245, 248);
const GRID: RGBColor = RGBColor(224, 227, 232);

/// Width of a figure, px.
pub(super) const WIDTH: u32 = 1760;
/// Left margin of a panel, px; equal for all panels, which share the time axis.
pub(super) const LEFT: u32 = 220;
pub(super) const RIGHT: u32 = 30;
const BOTTOM: u32 = 76;
const TEXT: f64 = 30.0;
pub(super) const SMALL: f64 = 27.0;
/// Mean width of a character over the text height (sans-serif).
pub(super) const CHARACTER: f64 = 0.54;
/// Maximum number of points of a line, about one per pixel.
pub(super) const POINTS: usize = 1400;

pub(super) fn figure(
    height: u32,
    title: &str,
    draw: impl FnOnce(&Area<'_>) -> Drawing,
) -> anyhow::Result<String> {
    let mut svg = String::new();
    sheet(&mut svg, height, title, draw)
        .map_err(|error| anyhow::anyhow!("could not draw the figure: {error}; report this"))?;
    Ok(svg)
}

fn sheet(
    svg: &mut String,
    height: u32,
    title: &str,
    draw: impl FnOnce(&Area<'_>) -> Drawing,
) -> Drawing {
    let area = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(64);
    let style = text(TEXT + 4.0, INK).font_bold();
    head.draw(&Text::new(title.to_owned(), (LEFT as i32, 18), style))?;
    draw(&body)?;
    area.present()?;
    Ok(())
}

trait Bold {
    fn font_bold(self) -> Self;
}

impl Bold for TextStyle<'_> {
    fn font_bold(mut self) -> Self {
        self.font = self.font.style(FontStyle::Bold);
        self
    }
}

pub(super) fn text(size: f64, colour: RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&colour)
}

pub(super) struct Axes<'a> {
    /// Label of the x axis; empty if shared with the panel below.
    pub(super) x: &'a str,
    pub(super) y: &'a str,
}

pub(super) fn panel<'a, 'b>(
    area: &'a Area<'b>,
    x: Range<f64>,
    y: Range<f64>,
    axes: &Axes<'_>,
    steps: &[(String, Range<f64>)],
) -> Result<Chart<'a, 'b>, Box<dyn std::error::Error>> {
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_top(44)
        .margin_right(RIGHT)
        .y_label_area_size(LEFT)
        .x_label_area_size(if axes.x.is_empty() { 14 } else { BOTTOM });
    let mut chart = builder.build_cartesian_2d(x.clone(), y.clone())?;
    bands(&mut chart, &x, &y, steps)?;
    let mut mesh = chart.configure_mesh();
    mesh.disable_x_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(GREY.stroke_width(2))
        .label_style(text(SMALL, GREY))
        .axis_desc_style(text(SMALL, INK))
        .x_labels(if axes.x.is_empty() { 0 } else { 10 })
        .y_labels(5)
        .x_label_formatter(&|x| number(*x))
        .y_label_formatter(&|y| number(*y))
        .x_desc(axes.x);
    mesh.draw()?;
    // Horizontal text beside the axis is easier to read than rotated text.
    let style = text(SMALL, INK).pos(Pos::new(HPos::Right, VPos::Center));
    area.draw(&Text::new(axes.y.to_owned(), (LEFT as i32 - 14, 22), style))?;
    Ok(chart)
}

fn number(value: f64) -> String {
    let rounded = (value * 100.0).round() / 100.0;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

fn bands(
    chart: &mut Chart<'_, '_>,
    x: &Range<f64>,
    y: &Range<f64>,
    steps: &[(String, Range<f64>)],
) -> Drawing {
    let px = (x.end - x.start) / f64::from(WIDTH - LEFT - RIGHT);
    for (_, time_s) in steps.iter().step_by(2) {
        let (from, to) = (time_s.start.max(x.start), time_s.end.min(x.end));
        if to - from > px {
            let band = Rectangle::new([(from, y.start), (to, y.end)], BAND.filled());
            chart.draw_series([band])?;
        }
    }
    Ok(())
}

pub(super) fn line(
    chart: &mut Chart<'_, '_>,
    points: Vec<(f64, f64)>,
    colour: impl Color,
    width: u32,
) -> Drawing {
    chart.draw_series(LineSeries::new(points, colour.stroke_width(width)))?;
    Ok(())
}

pub(super) fn dashed(
    chart: &mut Chart<'_, '_>,
    points: Vec<(f64, f64)>,
    colour: RGBColor,
) -> Drawing {
    let style = colour.stroke_width(3);
    chart.draw_series(DashedLineSeries::new(points, 12, 8, style))?;
    Ok(())
}

#[derive(Clone, Copy)]
pub(super) struct Mark {
    pub(super) at: f64,
    pub(super) text: &'static str,
    pub(super) colour: RGBColor,
    pub(super) share: f64,
    /// True: text left of the line.
    pub(super) text_is_left: bool,
}

pub(super) fn draw_mark(chart: &mut Chart<'_, '_>, moment: &Mark) -> Drawing {
    let (x, y) = (chart.x_range(), chart.y_range());
    let ends = vec![(moment.at, y.start), (moment.at, y.end)];
    chart.draw_series(LineSeries::new(ends, moment.colour.stroke_width(3)))?;
    let (side, sign) = if moment.text_is_left {
        (HPos::Right, -1.0)
    } else {
        (HPos::Left, 1.0)
    };
    let style = text(SMALL, moment.colour).pos(Pos::new(side, VPos::Center));
    let at = (
        moment.at + sign * 0.006 * (x.end - x.start),
        y.start + moment.share * (y.end - y.start),
    );
    chart.draw_series([Text::new(moment.text, at, style)])?;
    Ok(())
}

pub(super) fn legend(area: &Area<'_>, top: i32, entries: &[(&str, RGBColor, bool)]) -> Drawing {
    let widths = entries
        .iter()
        .map(|(name, _, _)| 64 + (name.chars().count() as f64 * SMALL * CHARACTER) as i32);
    let mut x = WIDTH as i32 - RIGHT as i32 - widths.clone().sum::<i32>();
    for ((name, colour, is_dashed), width) in entries.iter().zip(widths) {
        let spans: &[(i32, i32)] = if *is_dashed {
            &[(0, 10), (15, 25), (30, 40)]
        } else {
            &[(0, 40)]
        };
        for (from, to) in spans {
            let ends = [(x + from, top), (x + to, top)];
            area.draw(&PathElement::new(ends, colour.stroke_width(5)))?;
        }
        let style = text(SMALL, INK).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new((*name).to_owned(), (x + 48, top), style))?;
        x += width;
    }
    Ok(())
}

pub(super) fn equal_height(x: &Range<f64>, y: &Range<f64>) -> u32 {
    let per_unit = f64::from(WIDTH - LEFT - RIGHT) / (x.end - x.start);
    ((y.end - y.start) * per_unit) as u32 + BOTTOM + 44
}

/// Lane of a timeline: name and active spans.
pub(super) struct Lane {
    pub(super) name: String,
    pub(super) colour: RGBColor,
    pub(super) spans: Vec<Range<f64>>,
}

/// Height of a lane, px.
const LANE: u32 = 38;

pub(super) fn lanes_height(count: usize) -> u32 {
    LANE * count as u32 + BOTTOM + 44
}

pub(super) fn lanes(
    area: &Area<'_>,
    x: Range<f64>,
    lanes: &[Lane],
    steps: &[(String, Range<f64>)],
    x_desc: &str,
) -> Drawing {
    let count = lanes.len() as f64;
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_top(44)
        .margin_right(RIGHT)
        .y_label_area_size(LEFT)
        .x_label_area_size(BOTTOM);
    let mut chart = builder.build_cartesian_2d(x.clone(), 0.0..count)?;
    bands(&mut chart, &x, &(0.0..count), steps)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_y_axis()
        .axis_style(GREY.stroke_width(2))
        .label_style(text(SMALL, GREY))
        .axis_desc_style(text(SMALL, INK))
        .x_label_formatter(&|x| number(*x))
        .x_labels(10)
        .x_desc(x_desc)
        .draw()?;
    let per_px = (x.end - x.start) / f64::from(WIDTH - LEFT - RIGHT);
    for (index, lane) in lanes.iter().enumerate() {
        let y = count - 1.0 - index as f64;
        let axis = vec![(x.start, y + 0.5), (x.end, y + 0.5)];
        line(&mut chart, axis, GRID, 2)?;
        // Spans shorter than two pixels are drawn two pixels wide, to stay visible.
        let bars = lane.spans.iter().map(|span| {
            let to = span.end.max(span.start + 2.0 * per_px);
            Rectangle::new(
                [(span.start, y + 0.18), (to, y + 0.82)],
                lane.colour.filled(),
            )
        });
        chart.draw_series(bars)?;
        let (left, middle) = chart.plotting_area().map_coordinate(&(x.start, y + 0.5));
        let (base_x, base_y) = area.get_base_pixel();
        let style = text(SMALL, INK).pos(Pos::new(HPos::Right, VPos::Center));
        let at = (left - base_x - 14, middle - base_y);
        area.draw(&Text::new(lane.name.clone(), at, style))?;
    }
    Ok(())
}

pub(super) fn range_to(largest: f64) -> Range<f64> {
    0.0..(largest * 1.08).max(1e-6)
}

pub(super) fn highest(lines: &[&[(f64, f64)]]) -> f64 {
    let values = lines.iter().flat_map(|points| points.iter());
    values.fold(0.0, |highest, (_, y)| y.max(highest))
}
