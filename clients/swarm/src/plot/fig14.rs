//! Fig. 14: maximum fitness over generations. Per team size a line (median of the runs) with a band
//! (first to third quartile).

use plotters::prelude::*;

use super::{COLOURS, failed};
use crate::error::Result;
use crate::experiment::Plan;
use crate::run::Record;
use crate::stats::{quantile, sorted};

/// Returns the generations between two points of a curve; a curve has about 400 points.
fn step(generations: u32) -> usize {
    (generations as usize / 400).max(1)
}

struct Point {
    generation: u32,
    quartiles: [f32; 3],
}

/// Draws the figure.
pub fn fig14(plan: &Plan, records: &[Record]) -> Result<String> {
    let mut svg = String::new();
    draw(plan, records, &mut svg).map_err(failed)?;
    Ok(svg)
}

type Drawing = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw(plan: &Plan, records: &[Record], svg: &mut String) -> Drawing {
    let area = SVGBackend::with_string(svg, (900, 560)).into_drawing_area();
    area.fill(&WHITE)?;
    let highest = records.iter().map(Record::fitness).fold(100.0, f32::max);
    let title = format!(
        "Preset {}, rule {}: maximum fitness, median and quartiles of {} runs",
        plan.preset.name, plan.fitness_rule, plan.seeds
    );
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(0..plan.generations.max(1), 0.0..highest * 1.05)?;
    chart
        .configure_mesh()
        .x_desc("generation")
        .y_desc("fitness, of 800")
        .y_label_formatter(&|fitness| format!("{fitness:.0}"))
        .light_line_style(WHITE)
        .draw()?;
    for (agents, colour) in plan.agents.iter().zip(COLOURS) {
        let points = curve(plan, records, *agents);
        let upper = points.iter().map(|p| (p.generation, p.quartiles[2]));
        let lower = points.iter().rev().map(|p| (p.generation, p.quartiles[0]));
        chart.draw_series(std::iter::once(Polygon::new(
            upper.chain(lower).collect::<Vec<_>>(),
            colour.mix(0.18),
        )))?;
        let medians = points.iter().map(|p| (p.generation, p.quartiles[1]));
        let plural = if *agents == 1 { "" } else { "s" };
        chart
            .draw_series(LineSeries::new(medians, colour.stroke_width(2)))?
            .label(format!("{agents} agent{plural}"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    area.present()?;
    Ok(())
}

fn curve(plan: &Plan, records: &[Record], agents: usize) -> Vec<Point> {
    let runs: Vec<&Record> = records
        .iter()
        .filter(|record| record.agents == agents)
        .collect();
    let generations = (0..plan.generations)
        .step_by(step(plan.generations))
        .chain([plan.generations]);
    let point = |generation| {
        let fitness = sorted(
            &runs
                .iter()
                .map(|run| run.fitness_at(generation))
                .collect::<Vec<_>>(),
        );
        Point {
            generation,
            quartiles: [0.25, 0.5, 0.75].map(|q| quantile(&fitness, q)),
        }
    };
    generations.map(point).collect()
}
