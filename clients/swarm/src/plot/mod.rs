//! SVG figures: Fig. 14 (fitness over generations), Figs. 15–17 (trajectories), sensors and
//! behaviour.

mod behaviour;
mod fig14;
mod trajectories;

pub use behaviour::{BehaviourRow, behaviour_rows, behaviour_strip};
pub use fig14::fig14;
pub use trajectories::{Panel, trajectories};

use plotters::style::RGBColor;

use crate::error::Error;

/// Colours of agents or team sizes, distinguishable without red and green (Okabe and Ito 2008).
const COLOURS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];

/// Figures are drawn in memory; an error indicates a bug.
fn failed(error: impl std::fmt::Display) -> Error {
    Error::refused("draw a figure", error, "a drawable size", "report this")
}
