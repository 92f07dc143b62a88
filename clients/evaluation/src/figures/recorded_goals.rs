//! Figures of recorded goals: one goal, an overlay of several, or one with its key events.

use std::ops::Range;

use atas_client::goal_summary::{self, Moment};
use plotters::element::Text;
use plotters::style::RGBColor;
use robot_model::HandSide;
use shm_schemas::capacity::FINGERS;
use shm_schemas::{EventKind, FingerReport, HandReport, ModuleId};

use super::figure::{self, *};
use super::goal_trace::GoalTrace;
use super::phases::{Phases, Step};

/// Colours of overlaid runs and of a run's fingertips; their number limits an overlay.
const COLOURS: [RGBColor; 7] = [BLUE, ORANGE, GREEN, PINK, SKY, RED, INK];
/// Colour and line width per fingertip; later lines are thinner and on top, to keep all visible.
const OF_FINGERS: [(RGBColor, u32); FINGERS] = [(BLUE, 8), (SKY, 5), (PINK, 3), (INK, 2)];
/// Heights of panels, px.
const FORCES: u32 = 440;
const SMALL_PANEL: u32 = 210;
/// Event list: line height (px), column positions (px), characters in the last column.
const LINE: u32 = 40;
const COLUMNS: [i32; 4] = [60, 120, 270, 440];
const CHARACTERS: usize = 92;
/// Maximum length of a run's name beside the panels, characters.
const NAME: usize = 14;
/// Time shown before the step at which the time axis starts, s.
const BEFORE_S: f64 = 0.4;
/// Largest friction utilisation shown; above 1 the contact slides.
const S_MAX: f32 = 1.5;

/// Draws goals over each other, aligned at their beginning or first entry into a step.
///
/// # Errors
/// `courses` has no entry or too many, a goal never entered the step, or the drawing library fails.
pub fn overlay(courses: &[GoalTrace], from: Option<&str>) -> anyhow::Result<String> {
    let most = COLOURS.len();
    anyhow::ensure!(
        (1..=most).contains(&courses.len()),
        "could not draw {} runs over each other: 1 to {most} can be distinguished by colour",
        courses.len()
    );
    let view = View::new(courses, from)?;
    let title = match courses {
        [course] => headline(course),
        _ => format!("{} runs over each other", courses.len()),
    };
    draw(&title, hands(courses, &view))
}

/// Draws one goal with its key events marked and listed below.
///
/// # Errors
/// The drawing library fails.
pub fn explained(course: &GoalTrace) -> anyhow::Result<String> {
    let mut view = View::new(std::slice::from_ref(course), None)?;
    let moments = course.summary.moments.iter().filter(|m| is_key_event(m));
    let moments: Vec<&Moment> = moments.collect();
    view.marks_s = moments
        .iter()
        .map(|m| course.since_s(m.event.stamp.captured_ns))
        .collect();
    let numbered = view.marks_s.iter().enumerate();
    let marks: Vec<Step> = numbered
        .map(|(i, at_s)| ((i + 1).to_string(), *at_s..*at_s))
        .collect();
    view.x.end = Phases::axis_end(&view.x, &marks);
    let marks = Phases::new(&view.x, &marks);
    let mut stack = vec![Strip::new(marks.height(), move |area| {
        marks.draw(area, "moment", GREY)
    })];
    stack.extend(hands(std::slice::from_ref(course), &view));
    stack.push(event_list(course, &moments));
    draw(&headline(course), stack)
}

/// Excludes steps, whose names stand above the panels, and the beginning of the goal.
fn is_key_event(moment: &Moment) -> bool {
    let event = &moment.event;
    event.kind != EventKind::STEP && !goal_summary::begins(event)
}

fn headline(course: &GoalTrace) -> String {
    let account = &course.summary;
    format!(
        "{}: {}: {} after {:.2} s",
        course.name,
        course.title(),
        account.state,
        course.duration_s()
    )
}

struct View {
    x: Range<f64>,
    /// Origin of each run's time axis, s since its goal began.
    zero_s: Vec<f64>,
    /// Marked instants, s.
    marks_s: Vec<f64>,
}

impl View {
    fn new(courses: &[GoalTrace], from: Option<&str>) -> anyhow::Result<Self> {
        let zero_s = |course: &GoalTrace| match from {
            None => Ok(0.0),
            Some(step) => course.entered_s(step).ok_or_else(|| {
                let steps = course.summary.steps.iter().map(|step| step.name.as_str());
                anyhow::anyhow!(
                    "could not start at the step {step:?}: {} never entered it; name one of: {}",
                    course.name,
                    steps.collect::<Vec<_>>().join(", ")
                )
            }),
        };
        let zero_s = courses
            .iter()
            .map(zero_s)
            .collect::<Result<Vec<f64>, _>>()?;
        let ends_s = courses
            .iter()
            .zip(&zero_s)
            .map(|(c, zero_s)| c.duration_s() - zero_s);
        let begin_s = if from.is_some() { -BEFORE_S } else { 0.0 };
        let mut view = Self {
            x: begin_s..ends_s.fold(begin_s + 0.1, f64::max),
            zero_s,
            marks_s: Vec::new(),
        };
        for (index, course) in courses.iter().enumerate() {
            for side in HandSide::BOTH {
                view.x.end = Phases::axis_end(&view.x, &view.steps(index, course, side));
            }
        }
        Ok(view)
    }

    fn steps(&self, index: usize, course: &GoalTrace, side: HandSide) -> Vec<Step> {
        let zero_s = self.zero_s[index];
        let steps = course.steps(side).into_iter();
        steps
            .map(|(name, at)| (name, at.start - zero_s..at.end - zero_s))
            .collect()
    }

    /// Returns a value of a hand and its fingertips over time, per run.
    fn series(
        &self,
        courses: &[GoalTrace],
        side: HandSide,
        value: impl Fn(&HandReport, &[FingerReport]) -> f32,
    ) -> Vec<Vec<(f64, f64)>> {
        let of = |(course, zero_s): (&GoalTrace, &f64)| {
            let points = course.series(side, POINTS, &value).into_iter();
            let moved = points.map(|(at_s, v)| (at_s - zero_s, v));
            moved.filter(|(at_s, _)| self.x.contains(at_s)).collect()
        };
        courses.iter().zip(&self.zero_s).map(of).collect()
    }
}

struct Strip<'a> {
    height: u32,
    draw: Box<dyn Fn(&Area<'_>) -> Drawing + 'a>,
}

impl<'a> Strip<'a> {
    fn new(height: u32, draw: impl Fn(&Area<'_>) -> Drawing + 'a) -> Self {
        let draw = Box::new(draw);
        Self { height, draw }
    }
}

fn draw(title: &str, stack: Vec<Strip<'_>>) -> anyhow::Result<String> {
    let height = 64 + stack.iter().map(|strip| strip.height).sum::<u32>();
    figure(height, title, |area| {
        let mut rest = area.clone();
        for strip in &stack {
            let (own, below) = rest.split_vertically(strip.height);
            (strip.draw)(&own)?;
            rest = below;
        }
        Ok(())
    })
}

fn hands<'a>(courses: &'a [GoalTrace], view: &'a View) -> Vec<Strip<'a>> {
    let acted = |side: &HandSide| courses.iter().any(|c| !c.steps(*side).is_empty());
    let sides: Vec<HandSide> = HandSide::BOTH.into_iter().filter(acted).collect();
    let panels = sides.iter().map(|side| hand(courses, view, *side));
    panels.flatten().collect()
}

fn hand<'a>(courses: &'a [GoalTrace], view: &'a View, side: HandSide) -> Vec<Strip<'a>> {
    let whose = if side == HandSide::Left {
        "left hand"
    } else {
        "right hand"
    };
    let mut strips = Vec::new();
    for (index, course) in courses.iter().enumerate() {
        let phases = Phases::new(&view.x, &view.steps(index, course, side));
        let (name, colour) = match courses {
            [_] => (whose.to_owned(), GREY),
            _ => (shortened(&course.name), COLOURS[index]),
        };
        strips.push(Strip::new(phases.height(), move |area| {
            phases.draw(area, &name, colour)
        }));
    }
    let is_alone = courses.len() == 1;
    if courses.iter().any(GoalTrace::has_ticks) {
        strips.push(match courses {
            [course] => forces(course, view, side),
            _ => grips(courses, view, side),
        });
        strips.push(height(courses, view, side));
        strips.push(slip(courses, view, side, !is_alone));
    }
    if let [course] = courses {
        strips.push(modules(course, view, side));
    }
    strips
}

fn shortened(name: &str) -> String {
    match name.char_indices().nth(NAME) {
        None => name.to_owned(),
        Some((at, _)) => format!("{}…", &name[..at]),
    }
}

fn forces<'a>(course: &'a GoalTrace, view: &'a View, side: HandSide) -> Strip<'a> {
    let series = |value: &dyn Fn(&HandReport, &[FingerReport]) -> f32| {
        let one = view.series(std::slice::from_ref(course), side, value);
        one.into_iter().next().unwrap_or_default()
    };
    let pressed: Vec<_> = (0..course.fingers(side))
        .map(|f| series(&|hand, _| hand.fingers[f].normal_n))
        .collect();
    let sheared = series(&|_, fingers| mean(fingers, |f| f.tangential_n));
    let [f1, f2] = [series(&|hand, _| hand.f1_n), series(&|hand, _| hand.f2_n)];
    let steps = view.steps(0, course, side);
    Strip::new(FORCES, move |area| {
        let names: Vec<String> = (1..=pressed.len())
            .map(|f| format!("F_n finger {f}"))
            .collect();
        let fingers = names.iter().zip(OF_FINGERS);
        let fingers = fingers.map(|(name, (colour, _))| (name.as_str(), colour, false));
        let others = [
            ("F_t mean", GREEN, false),
            ("F_1", ORANGE, true),
            ("F_2", RED, true),
        ];
        legend(area, 22, &fingers.chain(others).collect::<Vec<_>>())?;
        let lines = pressed.iter().chain([&sheared, &f1, &f2]);
        let top_n = figure::highest(&lines.map(Vec::as_slice).collect::<Vec<_>>());
        let mut chart = panel(
            area,
            view.x.clone(),
            range_to(top_n),
            &axes("", "Force (N)"),
            &steps,
        )?;
        marks(&mut chart, view)?;
        dashed(&mut chart, f1.clone(), ORANGE)?;
        dashed(&mut chart, f2.clone(), RED)?;
        line(&mut chart, sheared.clone(), GREEN, 4)?;
        for (pressed, (colour, width)) in pressed.iter().zip(OF_FINGERS) {
            line(&mut chart, pressed.clone(), colour, width)?;
        }
        Ok(())
    })
}

fn grips<'a>(courses: &'a [GoalTrace], view: &'a View, side: HandSide) -> Strip<'a> {
    let pressed = view.series(courses, side, |_, fingers| mean(fingers, |f| f.normal_n));
    let f2 = view.series(courses, side, |hand, _| hand.f2_n);
    Strip::new(FORCES, move |area| {
        legend(area, 22, &[("F_n mean", INK, false), ("F_2", INK, true)])?;
        let all: Vec<&[(f64, f64)]> = pressed.iter().chain(&f2).map(Vec::as_slice).collect();
        let y = range_to(figure::highest(&all));
        let mut chart = panel(area, view.x.clone(), y, &axes("", "Grip (N)"), &[])?;
        for ((pressed, f2), colour) in pressed.iter().zip(&f2).zip(COLOURS) {
            dashed(&mut chart, f2.clone(), colour)?;
            line(&mut chart, pressed.clone(), colour, 4)?;
        }
        Ok(())
    })
}

fn height<'a>(courses: &'a [GoalTrace], view: &'a View, side: HandSide) -> Strip<'a> {
    let heights = view.series(courses, side, |hand, _| (hand.centre_m[2] * 1e3) as f32);
    let values = || heights.iter().flatten().map(|(_, mm)| *mm);
    let lowest = values().fold(f64::INFINITY, f64::min);
    let highest = values().fold(f64::NEG_INFINITY, f64::max);
    let y = if lowest < highest {
        let room = 0.06 * (highest - lowest);
        lowest - room..highest + room
    } else {
        0.0..1.0
    };
    Strip::new(SMALL_PANEL, move |area| {
        let mut chart = panel(
            area,
            view.x.clone(),
            y.clone(),
            &axes("", "Height (mm)"),
            &[],
        )?;
        marks(&mut chart, view)?;
        for (heights, colour) in heights.iter().zip(colours(courses)) {
            line(&mut chart, heights.clone(), colour, 4)?;
        }
        Ok(())
    })
}

/// Draws the largest friction utilisation of all fingertips; at 1 the contact slides.
fn slip<'a>(courses: &'a [GoalTrace], view: &'a View, side: HandSide, is_last: bool) -> Strip<'a> {
    let most = |_: &HandReport, fingers: &[FingerReport]| {
        let used = fingers.iter().map(|f| f.utilisation);
        used.fold(0.0, f32::max).min(S_MAX)
    };
    let used = view.series(courses, side, most);
    let (x_word, more) = if is_last { ("Time (s)", 62) } else { ("", 0) };
    Strip::new(SMALL_PANEL + more, move |area| {
        let y = 0.0..f64::from(S_MAX);
        let mut chart = panel(area, view.x.clone(), y, &axes(x_word, "Slip S"), &[])?;
        marks(&mut chart, view)?;
        let slides = vec![(view.x.start, 1.0), (view.x.end, 1.0)];
        dashed(&mut chart, slides, GREY)?;
        for (used, colour) in used.iter().zip(colours(courses)) {
            line(&mut chart, used.clone(), colour, 3)?;
        }
        Ok(())
    })
}

fn modules<'a>(course: &'a GoalTrace, view: &'a View, side: HandSide) -> Strip<'a> {
    let zero_s = view.zero_s[0];
    let lane = |(index, id): (usize, &ModuleId)| Lane {
        name: id.name().trim_start_matches("module ").replace(',', ""),
        colour: COLOURS[index % COLOURS.len()],
        spans: course
            .spans(side, *id)
            .into_iter()
            .map(|span| (span.start - zero_s).max(view.x.start)..span.end - zero_s)
            .filter(|span| span.end >= view.x.start)
            .collect(),
    };
    let lanes = ModuleId::ALL.iter().enumerate().map(lane);
    let lanes: Vec<Lane> = lanes.filter(|lane| !lane.spans.is_empty()).collect();
    let steps = view.steps(0, course, side);
    Strip::new(lanes_height(lanes.len()), move |area| {
        figure::lanes(area, view.x.clone(), &lanes, &steps, "Time (s)")
    })
}

fn event_list<'a>(course: &GoalTrace, moments: &[&Moment]) -> Strip<'a> {
    let mut lines: Vec<[String; 4]> = Vec::new();
    let mut add = |head: [String; 3], sentence: &str| {
        let mut head = Some(head);
        for line in wrapped(sentence) {
            let [number, time, tick] = head.take().unwrap_or_default();
            lines.push([number, time, tick, line]);
        }
    };
    let account = &course.summary;
    if account.reason.is_some() {
        let head = ["".into(), "".into(), account.state.clone()];
        add(head, &account.reason.to_string());
    }
    for (index, moment) in moments.iter().enumerate() {
        let at_s = course.since_s(moment.event.stamp.captured_ns);
        let number = (index + 1).to_string();
        let tick = format!("tick {}", moment.event.tick);
        add(
            [number, format!("{at_s:.3} s"), tick],
            &course.event_text(moment),
        );
    }
    let height = LINE * (lines.len() as u32 + 1);
    Strip::new(height, move |area| {
        for (index, line) in lines.iter().enumerate() {
            let y = (LINE * index as u32) as i32 + 12;
            for (word, x) in line.iter().zip(COLUMNS).filter(|(w, _)| !w.is_empty()) {
                area.draw(&Text::new(word.clone(), (x, y), text(SMALL, INK)))?;
            }
        }
        Ok(())
    })
}

fn wrapped(sentence: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in sentence.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].is_empty() {
            lines[last] = word.to_owned();
        } else if lines[last].chars().count() + 1 + word.chars().count() > CHARACTERS {
            lines.push(word.to_owned());
        } else {
            lines[last] += &format!(" {word}");
        }
    }
    lines
}

fn marks(chart: &mut Chart<'_, '_>, view: &View) -> Drawing {
    let y = chart.y_range();
    view.marks_s.iter().try_for_each(|at_s| {
        let ends = vec![(*at_s, y.start), (*at_s, y.end)];
        line(chart, ends, GREY, 1)
    })
}

fn colours(courses: &[GoalTrace]) -> Vec<RGBColor> {
    match courses {
        [_] => vec![INK],
        _ => COLOURS.to_vec(),
    }
}

fn axes<'a>(x: &'a str, y: &'a str) -> Axes<'a> {
    Axes { x, y }
}

fn mean(fingers: &[FingerReport], value: fn(&FingerReport) -> f32) -> f32 {
    fingers.iter().map(value).sum::<f32>() / fingers.len() as f32
}
