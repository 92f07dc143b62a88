//! Figure of the release in placing (Fig. 7): support force, grip, opening and height around the
//! contact.

use anyhow::Context;

use super::figure::{self, *};
use super::trace::{Tick, Trace};

/// Time shown before and after the support carries the object, ms.
const BEFORE_MS: f64 = 80.0;
const AFTER_MS: f64 = 140.0;

pub(super) fn draw(trace: &Trace) -> anyhow::Result<String> {
    let truth = &trace.truth.objects[0];
    let carried_s = (truth.carried_ns > 0).then(|| trace.at_s(truth.carried_ns));
    let carried_s = carried_s.with_context(|| {
        format!(
            "could not draw the release: the object never stood at its destination: {}",
            trace.progress.text()
        )
    })?;
    let ms = |s: f64| (s - carried_s) * 1e3;
    let window_s = carried_s - BEFORE_MS * 1e-3..carried_s + AFTER_MS * 1e-3;
    let series = |value: &dyn Fn(&Tick) -> f64| -> Vec<(f64, f64)> {
        let points = trace.series(&window_s, POINTS, value);
        points.into_iter().map(|(t_s, v)| (ms(t_s), v)).collect()
    };
    let rest_m = truth.position_m[2];
    let support = series(&|t| t.object.table_n);
    let pressed = series(&|t| Trace::acting(t).pressed_n.mean());
    let height = series(&|t| (t.object.position_m[2] - rest_m) * 1e3);
    let width_m = trace.goal.width_m + 2.0 * trace.dome_radius_m;
    let opening = series(&|t| {
        let [a, b] = Trace::acting(t).tips_m.into_array();
        ((a - b).norm() - width_m) * 1e3
    });
    let moments = moments(trace, carried_s);
    let title = format!(
        "Setting down {}, {:+.1} mm from where its place was expected",
        trace.scene.objects[0].object.name,
        (trace.scene.plates[1].height_m - trace.scene.plates[0].height_m) * 1e3,
    );
    let x = -BEFORE_MS..AFTER_MS;
    figure(64 + 440 + 380, &title, |area| {
        let (forces, motions) = area.split_vertically(440);
        legend(
            &forces,
            22,
            &[
                ("support's force", GREEN, false),
                ("grip per finger", BLUE, false),
            ],
        )?;
        let top_n = figure::highest(&[&support, &pressed]);
        let axes = Axes {
            x: "",
            y: "Force (N)",
        };
        let mut chart = panel(&forces, x.clone(), range_to(top_n), &axes, &[])?;
        moments.iter().try_for_each(|m| draw_mark(&mut chart, m))?;
        line(&mut chart, support, GREEN, 5)?;
        line(&mut chart, pressed, BLUE, 5)?;
        legend(
            &motions,
            22,
            &[
                ("height over its place", INK, false),
                ("opening commanded", ORANGE, false),
            ],
        )?;
        let lowest = opening.iter().map(|p| p.1).fold(0.0, f64::min);
        let top_mm = figure::highest(&[&height, &opening]).min(6.0);
        let axes = Axes {
            x: "Time after the support carries (ms)",
            y: "Way (mm)",
        };
        let y = (lowest * 1.1 - 0.1)..top_mm * 1.08;
        let mut chart = panel(&motions, x.clone(), y, &axes, &[])?;
        for m in &moments {
            draw_mark(&mut chart, &Mark { text: "", ..*m })?;
        }
        let seen = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
            points
                .into_iter()
                .filter(|p| p.1 <= top_mm * 1.08)
                .collect()
        };
        line(&mut chart, seen(height), INK, 5)?;
        line(&mut chart, seen(opening), ORANGE, 5)
    })
}

fn moments(trace: &Trace, carried_s: f64) -> Vec<Mark> {
    let ms = |ns: u64| (trace.at_s(ns) - carried_s) * 1e3;
    let released_ns = trace.truth.objects[0].released_ns;
    let opens = trace.progress.released_ns().map(|ns| Mark {
        at: ms(ns),
        text: "Module 4: hand opens",
        colour: RED,
        share: 0.92,
        text_is_left: false,
    });
    let parts = (released_ns > 0).then(|| Mark {
        at: ms(released_ns),
        text: "fingertips off",
        colour: INK,
        share: 0.78,
        text_is_left: false,
    });
    let carries = Mark {
        at: 0.0,
        text: "support carries",
        colour: GREEN,
        share: 0.92,
        text_is_left: true,
    };
    [Some(carries), opens, parts]
        .into_iter()
        .flatten()
        .collect()
}
