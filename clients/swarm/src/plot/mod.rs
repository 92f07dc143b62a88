//! Figures as SVG: Fig. 14 (fitness over generations), Figs. 15–17 (trajectories), sensors and behaviour over frames.

mod behaviour;
mod fig14;
mod trajectories;

pub use behaviour::{BehaviourRow, behaviour_rows, behaviour_strip};
pub use fig14::fig14;
pub use trajectories::{Panel, trajectories};

use plotters::style::RGBColor;

use crate::error::Error;

/// One colour per agent or team size, distinguishable without red and green (Okabe and Ito 2008).
const COLOURS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];

/// A drawing that did not work out; drawings go to memory, so this is a defect, told as a refusal.
fn failed(error: impl std::fmt::Display) -> Error {
    Error::refused("draw a figure", error, "a drawable size", "report this")
}
