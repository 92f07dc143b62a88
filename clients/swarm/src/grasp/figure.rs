//! Figure of the verdict: success of every policy with its interval.

use std::path::Path;

use plotters::prelude::*;

use super::verdict::{PolicyScores, Score};
use crate::error::{Error, Result};
use crate::files::write_atomically;

const SIZE: (u32, u32) = (760, 400);
const NAMES: u32 = 210;

/// Draws the verdict.
pub fn draw(judged: &PolicyScores, path: &Path) -> Result<()> {
    let laws = policies(judged);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(Error::from_part)?;
        let count = laws.len() as i32;
        let mut chart = ChartBuilder::on(&root)
            .margin(12)
            .set_label_area_size(LabelAreaPosition::Left, NAMES)
            .set_label_area_size(LabelAreaPosition::Bottom, 42)
            .build_cartesian_2d(0.0..100.0, (0..count - 1).into_segmented())
            .map_err(Error::from_part)?;
        let name = |place: &SegmentValue<i32>| match place {
            SegmentValue::CenterOf(row) => laws
                .get(*row as usize)
                .map_or(String::new(), |(name, _)| name.clone()),
            _ => String::new(),
        };
        chart
            .configure_mesh()
            .disable_y_mesh()
            .y_labels(laws.len())
            .y_label_formatter(&name)
            .x_desc("success on unseen members of all families, %, with 95 % interval")
            .draw()
            .map_err(Error::from_part)?;
        for (row, (_, score)) in (0..).zip(&laws) {
            let middle = SegmentValue::CenterOf(row);
            let [low, high] = score.ci95.map(|share| share * 100.0);
            let interval = PathElement::new(
                vec![(low, middle.clone()), (high, middle.clone())],
                BLUE.stroke_width(3),
            );
            let point = Circle::new((score.success * 100.0, middle), 5, BLUE.filled());
            chart
                .plotting_area()
                .draw(&interval)
                .map_err(Error::from_part)?;
            chart
                .plotting_area()
                .draw(&point)
                .map_err(Error::from_part)?;
        }
        root.present().map_err(Error::from_part)?;
    }
    write_atomically(path, text.as_bytes())
}

fn policies(judged: &PolicyScores) -> Vec<(String, &Score)> {
    let mut laws: Vec<(String, &Score)> = judged
        .without
        .iter()
        .map(|(module, score)| (format!("without {module}"), score))
        .collect();
    laws.push(("fixed force".to_owned(), &judged.fixed_force));
    laws.push(("slip reactive".to_owned(), &judged.slip_reactive));
    laws.push(("hand-written modules".to_owned(), &judged.modules));
    laws.push(("the paper's rules as a table".to_owned(), &judged.rules));
    laws.push(("fittest table, Module 3".to_owned(), &judged.with_module_3));
    if let Some(best) = judged.tables.first() {
        laws.push(("fittest evolved table".to_owned(), &best.score));
    }
    laws
}
