//! Figure of cap screwing: commanded square and actual path per cycle (Fig. 6), angle and torque of
//! the cap.

use std::ops::Range;

use nalgebra::Vector3;
use plotters::style::{Color, RGBColor};

use super::figure::{self, *};
use super::trace::{Tick, Trace};
use crate::SIDE;

pub(super) fn draw(trace: &Trace) -> anyhow::Result<String> {
    let Some(screw_s) = trace.step_s(SIDE, "screw") else {
        anyhow::bail!(
            "could not draw the screwing: it never began: {}",
            trace.progress.text()
        );
    };
    let cycles = cycles(trace, &screw_s);
    let cap = &trace.truth.objects[0];
    let title = format!(
        "Screwing: radius {:.1} mm, thread friction {:.0} mN·m, closes at {:.0}°",
        trace.goal.width_m * 500.0,
        cap.cap_friction_n_m * 1e3,
        cap.cap_closing_rad.to_degrees(),
    );
    let path = Ranges::new(trace, &cycles);
    let path_px = equal_height(&path.x, &path.y);
    figure(64 + path_px + CAP, &title, |area| {
        let (above, turning) = area.split_vertically(path_px);
        draw_path(trace, &cycles, &path, &above)?;
        let from_s = (screw_s.start - 1.0).max(0.0);
        let to_s = (screw_s.end + 1.5).min(trace.end_s());
        draw_cap(trace, from_s..to_s, &turning)
    })
}

/// Path of side 1's pole in the plane of the cap, mm: along the turn, outward from the axis.
type Path = Vec<(f64, f64)>;

fn place(trace: &Trace, tick: &Tick) -> (f64, f64) {
    let cap_m = Vector3::from(trace.truth.objects[0].position_m);
    let [first, second] = Trace::acting(tick).tips_m.into_array();
    let (sin, cos) = trace.goal.from_yaw_rad.sin_cos();
    let mut out = Vector3::new(cos, sin, 0.0);
    if (first - second).dot(&out) < 0.0 {
        out = -out;
    }
    let ahead = Vector3::new(-out.y, out.x, 0.0) * trace.goal.turn.sign();
    let from_axis_m = first - cap_m;
    (
        from_axis_m.dot(&ahead) * 1e3,
        (from_axis_m.dot(&out) - trace.dome_radius_m) * 1e3,
    )
}

/// Splits the path into the cycles of Module 0, each from the beginning of one turn to the next.
fn cycles(trace: &Trace, screw_s: &Range<f64>) -> Vec<Path> {
    let far_mm = trace.settings.screw.travel_m * 1e3 * 0.9;
    let mut cycles: Vec<Path> = vec![Vec::new()];
    let mut has_turned = false;
    for tick in trace.ticks.iter().filter(|t| screw_s.contains(&t.t_s)) {
        let (ahead_mm, out_mm) = place(trace, tick);
        has_turned |= ahead_mm > far_mm;
        if has_turned && ahead_mm < -far_mm {
            // A cycle starts at the end of the previous one, so that the line has no gap.
            let last = cycles.last().and_then(|path| path.last()).copied();
            cycles.push(last.into_iter().collect());
            has_turned = false;
        }
        if let Some(path) = cycles.last_mut() {
            path.push((ahead_mm, out_mm));
        }
    }
    cycles.retain(|path| path.len() > 100);
    cycles
}

/// Visible range of Fig. 6, mm: the square with the cap below.
struct Ranges {
    x: Range<f64>,
    y: Range<f64>,
    /// Outward position at the start of the first turn.
    start_mm: f64,
}

impl Ranges {
    fn new(trace: &Trace, cycles: &[Path]) -> Self {
        let screw = &trace.settings.screw;
        let radius_mm = trace.goal.width_m * 500.0;
        let first = cycles.first().and_then(|path| path.first());
        let start_mm = first.map_or(radius_mm, |(_, out_mm)| *out_mm);
        let points = || cycles.iter().flatten().map(|(_, out_mm)| *out_mm);
        let lowest_mm = points().fold(start_mm, f64::min) - 0.5;
        let highest_mm = points().fold(start_mm + screw.clearance_m * 1e3, f64::max) + 0.4;
        let half_mm = 1.4 * screw.travel_m * 1e3;
        Self {
            x: -half_mm..half_mm,
            y: lowest_mm..highest_mm,
            start_mm,
        }
    }
}

fn draw_path(trace: &Trace, cycles: &[Path], ranges: &Ranges, area: &Area<'_>) -> Drawing {
    let screw = &trace.settings.screw;
    let (travel_mm, clear_mm) = (screw.travel_m * 1e3, screw.clearance_m * 1e3);
    let (radius_mm, start_mm) = (trace.goal.width_m * 500.0, ranges.start_mm);
    let axes = Axes {
        x: "Along the turn (mm)",
        y: "Out (mm)",
    };
    let mut chart = panel(area, ranges.x.clone(), ranges.y.clone(), &axes, &[])?;
    draw_rim(trace, &mut chart, radius_mm)?;
    let square = vec![
        (-travel_mm, start_mm),
        (travel_mm, start_mm),
        (travel_mm, start_mm + clear_mm),
        (-travel_mm, start_mm + clear_mm),
        (-travel_mm, start_mm),
    ];
    dashed(&mut chart, square, INK)?;
    for (index, path) in cycles.iter().enumerate() {
        let shade = index as f64 / (cycles.len() - 1).max(1) as f64;
        let every = path.iter().step_by(8).copied().collect();
        line(&mut chart, every, shaded(shade), 4)?;
    }
    let count = format!("cycles 1 to {}, light to dark", cycles.len());
    legend(
        area,
        22,
        &[
            ("initial square (Fig. 5)", INK, true),
            (&count, shaded(0.7), false),
            ("contact without force", ORANGE, false),
        ],
    )
}

/// Draws the pole position of a round fingertip that just touches the round cap.
fn draw_rim(trace: &Trace, chart: &mut Chart<'_, '_>, radius_mm: f64) -> Drawing {
    let dome_mm = trace.dome_radius_m * 1e3;
    let reach_mm = radius_mm + dome_mm;
    let touch = (-98..=98).map(|i| f64::from(i) * 0.1);
    let touch = touch.map(|x| (x, (reach_mm * reach_mm - x * x).sqrt() - dome_mm));
    line(chart, touch.collect(), ORANGE, 5)
}

fn shaded(share: f64) -> RGBColor {
    let mix = |light: f64, dark: f64| (light + (dark - light) * share) as u8;
    RGBColor(mix(160.0, 0.0), mix(208.0, 60.0), mix(240.0, 120.0))
}

/// Height of the panels of angle and torque, px.
pub(super) const CAP: u32 = 280 + 360;

/// Draws angle and torque of a cap over time, and the end of the screw step.
pub(super) fn draw_cap(trace: &Trace, time_s: Range<f64>, area: &Area<'_>) -> Drawing {
    let cap = &trace.truth.objects[0];
    let angle = trace.series(&time_s, POINTS, |t| t.object.cap_angle_rad.to_degrees());
    let torque = trace.series(&time_s, POINTS, |t| t.object.cap_torque_n_m * 1e3);
    let done = trace.step_s(SIDE, "screw").map(|s| Mark {
        at: s.end,
        text: "Module 4",
        colour: RED,
        share: 0.93,
        text_is_left: true,
    });
    let (angles, torques) = area.split_vertically(280);
    let axes = |x, y| Axes { x, y };
    let level = |y: f64| vec![(time_s.start, y), (time_s.end, y)];
    let closing_deg = cap.cap_closing_rad.to_degrees();
    let top_deg = figure::highest(&[&angle]).max(closing_deg);
    let mut chart = panel(
        &angles,
        time_s.clone(),
        range_to(top_deg),
        &axes("", "Angle (°)"),
        &[],
    )?;
    dashed(&mut chart, level(closing_deg), GREY)?;
    line(&mut chart, angle, BLUE, 5)?;
    if let Some(done) = &done {
        draw_mark(&mut chart, &Mark { text: "", ..*done })?;
    }
    legend(
        area,
        22,
        &[("closed (truth)", GREY, true), ("cap", BLUE, false)],
    )?;
    let friction = cap.cap_friction_n_m * 1e3;
    let top = figure::highest(&[&torque]).max(2.6 * friction);
    let axes = axes("Time (s)", "Torque (mN·m)");
    let mut chart = panel(&torques, time_s.clone(), range_to(top), &axes, &[])?;
    for multiple in [1.3, 2.5] {
        dashed(&mut chart, level(multiple * friction), GREY)?;
    }
    line(&mut chart, torque, GREEN.to_rgba(), 4)?;
    if let Some(done) = &done {
        draw_mark(&mut chart, done)?;
    }
    legend(
        &torques,
        22,
        &[
            ("1.3 and 2.5 × thread friction", GREY, true),
            ("torque on the thread", GREEN, false),
        ],
    )
}
