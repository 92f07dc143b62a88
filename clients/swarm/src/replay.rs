//! Replay: a self-contained web page with an animation of a team.

use serde::Serialize;

use field::{EXECUTION_FRAMES, Post, Wall};

use crate::analysis::{Trace, trace};
use crate::condition::{Condition, GOALS};
use crate::error::{Error, Result};
use crate::table_file::TableFile;

/// Page template; the marker is replaced by the data.
const PAGE: &str = include_str!("replay.html");
const MARKER: &str = "/*DATA*/null";

#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    half_side: f32,
    judged_from: u32,
    agent_radius: f32,
    object_radius: f32,
    goal_radius: f32,
    object_light: f32,
    goal_light: f32,
    walls: &'a [Wall],
    posts: &'a [Post],
    trials: Vec<Trial>,
}

#[derive(Serialize)]
struct Trial {
    goal: [f32; 2],
    points: f32,
    /// Per frame: object x, y; then per agent x, y, heading, table row, left and right level.
    frames: Vec<Vec<f32>>,
}

/// Simulates the eight trials of a table file, goal 1 first.
#[must_use]
pub fn traces(file: &TableFile) -> [Trace; GOALS] {
    let condition = &file.condition;
    let responses = condition.responses(&file.individual.genome);
    condition
        .layouts()
        .map(|layout| trace(condition, responses, &layout))
}

/// Builds the page of a table file.
pub fn page(file: &TableFile) -> Result<String> {
    let condition = &file.condition;
    let title = format!(
        "EBTS, preset {}, {} agents, fitness {:.1} by the rule {}",
        condition.model.preset().name,
        condition.team.get(),
        file.individual.fitness(),
        condition.fitness
    );
    replay(condition, &title, &traces(file), &file.points_on_field())
}

/// Builds the page of any trials.
pub fn replay(
    condition: &Condition,
    title: &str,
    traces: &[Trace],
    points: &[f32],
) -> Result<String> {
    let preset = condition.model.preset();
    let data = Data {
        title,
        half_side: preset.half_side_px,
        judged_from: EXECUTION_FRAMES,
        agent_radius: preset.agent_radius_px,
        object_radius: preset.object_radius_px,
        goal_radius: preset.goal_radius_px,
        object_light: preset.object_light_px,
        goal_light: preset.goal_light_px,
        walls: condition.model.walls(),
        posts: condition.model.posts(),
        trials: traces
            .iter()
            .zip(points)
            .map(|(trace, &points)| trial(trace, points))
            .collect(),
    };
    let json = serde_json::to_string(&data).map_err(Error::from_part)?;
    // A script ends at the first "</", even in a string.
    Ok(PAGE.replace(MARKER, &json.replace("</", "<\\/")))
}

fn trial(trace: &Trace, points: f32) -> Trial {
    let tenth = |px: f32| (px * 10.0).round() / 10.0;
    let frame = |frame: &crate::analysis::Frame| {
        let mut numbers = vec![tenth(frame.object.x_px), tenth(frame.object.y_px)];
        for ((agent, row), wheels) in frame.agents.iter().zip(&frame.rows).zip(&frame.wheels) {
            numbers.extend([
                tenth(agent.x_px),
                tenth(agent.y_px),
                f32::from(agent.heading),
                *row as f32,
            ]);
            numbers.extend([f32::from(wheels.left), f32::from(wheels.right)]);
        }
        numbers
    };
    Trial {
        goal: [trace.goal.x_px, trace.goal.y_px],
        points,
        frames: trace.frames.iter().map(frame).collect(),
    }
}
