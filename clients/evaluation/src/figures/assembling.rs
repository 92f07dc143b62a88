//! Figure of an assembly (Fig. 8): steps of both hands, grips, angle and torque of the cap.

use plotters::style::RGBColor;
use robot_model::HandSide;

use super::figure::{self, *};
use super::phases::Phases;
use super::screwing::{CAP, draw_cap};
use super::trace::Trace;
use crate::SIDE;

/// Colours of the acting and the helping hand.
const HANDS: [RGBColor; 2] = [BLUE, ORANGE];

pub(super) fn draw(trace: &Trace) -> anyhow::Result<String> {
    let mut time_s = 0.0..trace.end_s();
    let sides = [SIDE, HandSide::BOTH[1 - SIDE.index()]];
    for side in sides {
        time_s.end = Phases::axis_end(&time_s, &trace.steps(side));
    }
    let grip = |side: HandSide| {
        trace.series(&time_s, POINTS, |t| {
            t.hands[side.index()].pressed_n.iter().sum::<f64>() / 2.0
        })
    };
    let grips = sides.map(grip);
    let title =
        "Assembly: the left hand holds the bottle, the right hand places and screws the cap";
    let steps = sides.map(|side| Phases::new(&time_s, &trace.steps(side)));
    let strips_px = steps.iter().map(Phases::height).sum::<u32>();
    figure(64 + strips_px + 300 + CAP, title, |area| {
        let mut rest = area.clone();
        for ((side, steps), colour) in sides.into_iter().zip(&steps).zip(HANDS) {
            let (strip, below) = rest.split_vertically(steps.height());
            let name = if side == HandSide::Right {
                "right hand"
            } else {
                "left hand"
            };
            steps.draw(&strip, name, colour)?;
            rest = below;
        }
        let (forces, cap) = rest.split_vertically(300);
        legend(
            &forces,
            22,
            &[("right", BLUE, false), ("left", ORANGE, false)],
        )?;
        let top_n = figure::highest(&[&grips[0], &grips[1]]);
        let axes = Axes {
            x: "",
            y: "Grip (N)",
        };
        let mut chart = panel(&forces, time_s.clone(), range_to(top_n), &axes, &[])?;
        for (grip, colour) in grips.into_iter().zip(HANDS) {
            line(&mut chart, grip, colour, 4)?;
        }
        draw_cap(trace, time_s.clone(), &cap)
    })
}
