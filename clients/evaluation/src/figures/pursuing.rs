//! Goals that were really pursued: forces between their thresholds, the hand's height, slip, and which module worked when.
//! One alone, several over each other, or one with the moments that decided and what they mean.

use std::ops::Range;

use atas_client::account::{self, Moment};
use plotters::element::Text;
use plotters::style::RGBColor;
use robot_model::Side;
use shm_schemas::capacity::FINGERS;
use shm_schemas::{EventKind, FingerReport, HandReport, ModuleId};

use super::course::Course;
use super::figure::{self, *};
use super::phases::{Phases, Step};

/// Colours of runs over each other, and of the fingers of one: as many as can be told apart.
const COLOURS: [RGBColor; 7] = [BLUE, ORANGE, GREEN, PINK, SKY, RED, INK];
/// Colours and widths of the fingers of one run. Later ones lie on earlier ones, thinner: where they agree, all are seen.
const OF_FINGERS: [(RGBColor, u32); FINGERS] = [(BLUE, 8), (SKY, 5), (PINK, 3), (INK, 2)];
/// Heights of panels, px.
const FORCES: u32 = 440;
const SMALL_PANEL: u32 = 210;
/// Height of a line of the account, px, where its columns begin, and characters in the last of them.
const LINE: u32 = 40;
const COLUMNS: [i32; 4] = [60, 120, 270, 440];
const CHARACTERS: usize = 92;
/// Characters of a name beside the panels.
const NAME: usize = 14;
/// How much is shown before the step in which the time begins, s.
const BEFORE_S: f64 = 0.4;
/// Friction utilisation that is still told apart: beyond it everything slides.
const S_MAX: f32 = 1.5;

/// Draws the goals of some runs over each other, each from its beginning, or from where it first enters a step.
///
/// # Errors
/// There are none or too many, one of them never came to the step, or the drawing library fails.
pub fn overlay(courses: &[Course], from: Option<&str>) -> anyhow::Result<String> {
    let most = COLOURS.len();
    anyhow::ensure!(
        (1..=most).contains(&courses.len()),
        "could not draw {} runs over each other, needs 1 to {most}, which can be told apart",
        courses.len()
    );
    let view = View::of(courses, from)?;
    let title = match courses {
        [course] => headline(course),
        _ => format!("{} runs over each other", courses.len()),
    };
    draw(&title, hands(courses, &view))
}

/// Draws one goal with the moments that decided, and tells them below.
///
/// # Errors
/// The drawing library fails.
pub fn explained(course: &Course) -> anyhow::Result<String> {
    let mut view = View::of(std::slice::from_ref(course), None)?;
    let moments = course.account.moments.iter().filter(|m| decides(m));
    let moments: Vec<&Moment> = moments.collect();
    view.marks_s = moments
        .iter()
        .map(|m| course.since_s(m.event.stamp.captured_ns))
        .collect();
    let numbered = view.marks_s.iter().enumerate();
    let marks: Vec<Step> = numbered
        .map(|(i, at_s)| ((i + 1).to_string(), *at_s..*at_s))
        .collect();
    view.x.end = Phases::end(&view.x, &marks);
    let marks = Phases::of(&view.x, &marks);
    let mut stack = vec![Strip::new(marks.height(), move |area| {
        marks.draw(area, "moment", GREY)
    })];
    stack.extend(hands(std::slice::from_ref(course), &view));
    stack.push(told(course, &moments));
    draw(&headline(course), stack)
}

/// Steps have names above the panels, and that a goal began needs no telling.
fn decides(moment: &Moment) -> bool {
    let event = &moment.event;
    event.kind != EventKind::STEP && !account::begins(event)
}

fn headline(course: &Course) -> String {
    let account = &course.account;
    format!(
        "{}: {}: {} after {:.2} s",
        course.name,
        course.title(),
        account.state,
        course.took_s()
    )
}

/// What is seen of the time.
struct View {
    x: Range<f64>,
    /// Where each run's time begins, s since its goal did.
    zero_s: Vec<f64>,
    /// Moments to be marked, s.
    marks_s: Vec<f64>,
}

impl View {
    fn of(courses: &[Course], from: Option<&str>) -> anyhow::Result<Self> {
        let zero_s = |course: &Course| {
            match from {
            None => Ok(0.0),
            Some(step) => course.entered_s(step).ok_or_else(|| {
                let steps = course.account.steps.iter().map(|step| step.name.as_str());
                anyhow::anyhow!(
                    "could not begin with the step {step:?} because {} never came to it; name one of: {}",
                    course.name,
                    steps.collect::<Vec<_>>().join(", ")
                )
            }),
        }
        };
        let zero_s = courses
            .iter()
            .map(zero_s)
            .collect::<Result<Vec<f64>, _>>()?;
        let ends_s = courses
            .iter()
            .zip(&zero_s)
            .map(|(c, zero_s)| c.took_s() - zero_s);
        let begin_s = if from.is_some() { -BEFORE_S } else { 0.0 };
        let mut view = Self {
            x: begin_s..ends_s.fold(begin_s + 0.1, f64::max),
            zero_s,
            marks_s: Vec::new(),
        };
        for (index, course) in courses.iter().enumerate() {
            for side in Side::BOTH {
                view.x.end = Phases::end(&view.x, &view.steps(index, course, side));
            }
        }
        Ok(view)
    }

    fn steps(&self, index: usize, course: &Course, side: Side) -> Vec<Step> {
        let zero_s = self.zero_s[index];
        let steps = course.steps(side).into_iter();
        steps
            .map(|(name, at)| (name, at.start - zero_s..at.end - zero_s))
            .collect()
    }

    /// A value of every run over time, of a hand and its fingers.
    fn series(
        &self,
        courses: &[Course],
        side: Side,
        value: impl Fn(&HandReport, &[FingerReport]) -> f32,
    ) -> Vec<Vec<(f64, f64)>> {
        let of = |(course, zero_s): (&Course, &f64)| {
            let points = course.series(side, POINTS, &value).into_iter();
            let moved = points.map(|(at_s, v)| (at_s - zero_s, v));
            moved.filter(|(at_s, _)| self.x.contains(at_s)).collect()
        };
        courses.iter().zip(&self.zero_s).map(of).collect()
    }
}

/// One panel of a figure.
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

/// The panels of the hands that did something.
fn hands<'a>(courses: &'a [Course], view: &'a View) -> Vec<Strip<'a>> {
    let acted = |side: &Side| courses.iter().any(|c| !c.steps(*side).is_empty());
    let sides: Vec<Side> = Side::BOTH.into_iter().filter(acted).collect();
    let panels = sides.iter().map(|side| hand(courses, view, *side));
    panels.flatten().collect()
}

fn hand<'a>(courses: &'a [Course], view: &'a View, side: Side) -> Vec<Strip<'a>> {
    let whose = if side == Side::Left {
        "left hand"
    } else {
        "right hand"
    };
    let mut strips = Vec::new();
    for (index, course) in courses.iter().enumerate() {
        let phases = Phases::of(&view.x, &view.steps(index, course, side));
        let (name, colour) = match courses {
            [_] => (whose.to_owned(), GREY),
            _ => (shortened(&course.name), COLOURS[index]),
        };
        strips.push(Strip::new(phases.height(), move |area| {
            phases.draw(area, &name, colour)
        }));
    }
    let is_alone = courses.len() == 1;
    if courses.iter().any(Course::has_ticks) {
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

/// Forces of one run between their thresholds.
fn forces<'a>(course: &'a Course, view: &'a View, side: Side) -> Strip<'a> {
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
            up_to(top_n),
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

/// The grip of several runs, each with its F_2.
fn grips<'a>(courses: &'a [Course], view: &'a View, side: Side) -> Strip<'a> {
    let pressed = view.series(courses, side, |_, fingers| mean(fingers, |f| f.normal_n));
    let f2 = view.series(courses, side, |hand, _| hand.f2_n);
    Strip::new(FORCES, move |area| {
        legend(area, 22, &[("F_n mean", INK, false), ("F_2", INK, true)])?;
        let all: Vec<&[(f64, f64)]> = pressed.iter().chain(&f2).map(Vec::as_slice).collect();
        let y = up_to(figure::highest(&all));
        let mut chart = panel(area, view.x.clone(), y, &axes("", "Grip (N)"), &[])?;
        for ((pressed, f2), colour) in pressed.iter().zip(&f2).zip(COLOURS) {
            dashed(&mut chart, f2.clone(), colour)?;
            line(&mut chart, pressed.clone(), colour, 4)?;
        }
        Ok(())
    })
}

/// Height of the hand's centre, as commanded.
fn height<'a>(courses: &'a [Course], view: &'a View, side: Side) -> Strip<'a> {
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

/// Friction utilisation of the finger that slips most; at 1 it slides.
fn slip<'a>(courses: &'a [Course], view: &'a View, side: Side, is_last: bool) -> Strip<'a> {
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

/// A lane for every module that worked.
fn modules<'a>(course: &'a Course, view: &'a View, side: Side) -> Strip<'a> {
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

/// The account below the panels: number, time and tick of each moment, and what happened.
fn told<'a>(course: &Course, moments: &[&Moment]) -> Strip<'a> {
    let mut lines: Vec<[String; 4]> = Vec::new();
    let mut add = |head: [String; 3], sentence: &str| {
        let mut head = Some(head);
        for line in wrapped(sentence) {
            let [number, time, tick] = head.take().unwrap_or_default();
            lines.push([number, time, tick, line]);
        }
    };
    let account = &course.account;
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
            &course.sentence(moment),
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

/// Lines that fit.
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

/// A run alone is drawn in ink, several in their colours.
fn colours(courses: &[Course]) -> Vec<RGBColor> {
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
