//! Figure of a grasp (Fig. 4): forces between their thresholds, lift, module activity.

use plotters::style::RGBColor;
use robot_model::{GraspSide, GraspSides, PerSide};
use shm_schemas::{FingerReport, ModuleId};

use super::figure::{self, *};
use super::phases::Phases;
use super::trace::{Tick, Trace};
use crate::SIDE;

/// Modules with label and colour, lanes from top to bottom.
const LANES: [(ModuleId, &str, RGBColor); 7] = [
    (ModuleId::FIRST_TOUCH, "1 first touch", BLUE),
    (ModuleId::PROBE, "stiffness probe", PINK),
    (ModuleId::SLIP, "2 slip", RED),
    (ModuleId::FORCE_LIMIT, "3 force limit", ORANGE),
    (ModuleId::RELAX, "relax", SKY),
    (ModuleId::LIFT_VERIFICATION, "lift verification", GREEN),
    (ModuleId::CARRY, "carry", GREY),
];

pub(super) fn draw(trace: &Trace) -> anyhow::Result<String> {
    let steps = trace.steps(SIDE);
    let begin_s = trace.step_s(SIDE, "approach").map_or(0.0, |s| s.end - 0.4);
    let mut time_s = begin_s.max(0.0)..trace.end_s();
    time_s.end = Phases::axis_end(&time_s, &steps);
    let series = |value: fn(&Tick) -> f64| trace.series(&time_s, POINTS, value);
    let sides = trace.sides;
    let pressed = GraspSide::BOTH.map(|side| {
        let normal_n = |t: &Tick| per_side(t, sides, |f| f.normal_n)[side];
        trace.series(&time_s, POINTS, normal_n)
    });
    let sheared = trace.series(&time_s, POINTS, |t| mean(t, sides, |f| f.tangential_n));
    let f1 = series(|t| f64::from(Trace::acting(t).report.f1_n));
    let f2 = series(|t| f64::from(Trace::acting(t).report.f2_n));
    let needed_n = trace.truth.objects[0].needed_n;
    let needed = vec![(time_s.start, needed_n), (time_s.end, needed_n)];
    let lifted = series(|t| t.object.lifted_m * 1e3);
    let lanes: Vec<Lane> = LANES.iter().map(|lane| self::lane(trace, *lane)).collect();
    let title = format!(
        "Grasp of {}: {:.0} g, μ {:.2}",
        trace.scene.objects[0].object.name,
        trace.scene.objects[0].object.mass_kg * 1e3,
        trace.scene.objects[0].object.friction,
    );
    let phases = Phases::new(&time_s, &steps);
    let height = 64 + phases.height() + 480 + 200 + lanes_height(lanes.len());
    figure(height, &title, |area| {
        legend(
            area,
            -26,
            &[
                ("F_n finger 1", BLUE, false),
                ("F_n finger 2", SKY, false),
                ("F_t", GREEN, false),
                ("F_1", ORANGE, true),
                ("F_2", RED, true),
                ("needed", GREY, true),
            ],
        )?;
        let (strip, rest) = area.split_vertically(phases.height());
        phases.draw(&strip, "step", GREY)?;
        let (forces, rest) = rest.split_vertically(480);
        let (heights, work) = rest.split_vertically(200);
        let top_n = figure::highest(&[&pressed[0], &pressed[1], &sheared, &f1, &f2, &needed]);
        let axes = |y| Axes { x: "", y };
        let mut chart = panel(
            &forces,
            time_s.clone(),
            range_to(top_n),
            &axes("Force (N)"),
            &steps,
        )?;
        dashed(&mut chart, f1.clone(), ORANGE)?;
        dashed(&mut chart, f2, RED)?;
        dashed(&mut chart, needed, GREY)?;
        line(&mut chart, sheared, GREEN, 4)?;
        // Thinner second line on top, to keep both visible.
        for (pressed, (colour, width)) in pressed.into_iter().zip([(BLUE, 7), (SKY, 3)]) {
            line(&mut chart, pressed, colour, width)?;
        }
        let top_mm = figure::highest(&[&lifted]);
        let mut chart = panel(
            &heights,
            time_s.clone(),
            range_to(top_mm),
            &axes("Lift (mm)"),
            &[],
        )?;
        line(&mut chart, lifted, INK, 4)?;
        figure::lanes(&work, time_s.clone(), &lanes, &[], "Time (s)")
    })
}

/// Returns the sum of a measured value per grasp side.
fn per_side(tick: &Tick, sides: GraspSides, value: fn(&FingerReport) -> f32) -> PerSide<f64> {
    let fingers = &Trace::acting(tick).report.fingers;
    sides.sums(|fingertip| value(&fingers[fingertip]).into())
}

/// Returns the mean of a measured value over the grasp sides.
fn mean(tick: &Tick, sides: GraspSides, value: fn(&FingerReport) -> f32) -> f64 {
    per_side(tick, sides, value).mean()
}

fn lane(trace: &Trace, (id, name, colour): (ModuleId, &str, RGBColor)) -> Lane {
    let works = |t: &Tick| Trace::acting(t).report.modules_active >> id.0 & 1 == 1;
    Lane {
        name: name.to_owned(),
        colour,
        spans: trace.spans(works),
    }
}
