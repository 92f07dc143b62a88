//! User tasks: sections `[tasks.NAME]`, one line per step, with the keywords of the events.
//!
//! Parsed by hand instead of derived, so that an error names task, step and suggestion.
//! [`Tasks::text`] writes the format that [`read`] reads. The built-in tasks are printed in the
//! same format, as a starting point.

mod keywords;
mod table;

use std::collections::BTreeMap;
use std::fmt::Write as _;

use atas_core::tasks::{
    BUILT_IN, Motion, Part, RuleViolation, Step, StepSequence, Task, Transition,
};
use serde::{Deserialize, Deserializer, de};
use toml::{Table, Value};

/// Prefix of printed built-in tasks, because a user task needs another name.
const USER_PREFIX: &str = "my-";
const TASK_KEYS: [&str; 3] = ["acting", "helping", "table"];
const STEP_KEYS: [&str; 7] = [
    "step",
    "motion",
    "waypoint",
    "modules",
    "transition",
    "point",
    "timeout_s",
];

/// User tasks, sorted by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tasks(Vec<Task>);

/// Error of a task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TaskProblem {
    /// Step, for example `helping step 2 (grip)`; empty for the whole task.
    pub at: String,
    /// Cause.
    pub why: String,
}

impl Tasks {
    /// The tasks.
    #[must_use]
    pub fn as_slice(&self) -> &[Task] {
        &self.0
    }

    /// The tasks as TOML.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        for task in &self.0 {
            write_task(&mut text, &task.name, task);
        }
        text
    }

    /// The built-in tasks as TOML of user tasks, except teleoperation tasks, which users cannot
    /// define.
    #[must_use]
    pub fn built_in_text() -> String {
        let mut text = String::new();
        let follows = |task: &Task| task.acting.iter().any(|s| s.motion == Motion::Teleop);
        for task in BUILT_IN.into_iter().filter(|task| !follows(task)) {
            write_task(&mut text, &format!("{USER_PREFIX}{}", task.name), task);
        }
        text
    }
}

impl<'de> Deserialize<'de> for Tasks {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let sections = BTreeMap::<String, Value>::deserialize(deserializer)?;
        let read = |(name, value): (&String, &Value)| {
            read(name, value).map_err(|problem| de::Error::custom(problem.why))
        };
        sections
            .iter()
            .map(read)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

/// Reads the task of a section.
///
/// # Errors
/// The first [`TaskProblem`].
pub(super) fn read(name: &str, value: &Value) -> Result<Task, TaskProblem> {
    let whole = |why: String| TaskProblem {
        at: String::new(),
        why,
    };
    let table = value.as_table().ok_or_else(|| {
        whole(format!(
            "is {value}, needs to be a section with acting = [ steps ]"
        ))
    })?;
    check_keys(table, &TASK_KEYS).map_err(whole)?;
    let acting = read_steps(table.get("acting"), Part::Acting)?;
    let helping = table
        .get("helping")
        .map(|steps| read_steps(Some(steps), Part::Helping))
        .transpose()?;
    let table = table.get("table").map(table::read).transpose();
    let table = table.map_err(|why| TaskProblem {
        at: "table".to_owned(),
        why,
    })?;
    Task::validated_with_table(name, &acting, helping.as_deref(), table).map_err(|fault| {
        let steps = match fault.part {
            Part::Acting => &acting[..],
            Part::Helping => helping.as_deref().unwrap_or_default(),
        };
        describe(&fault, steps)
    })
}

fn describe(fault: &RuleViolation, steps: &[Step]) -> TaskProblem {
    let name = |index: usize| steps.get(index).map_or("", |step| step.name.as_str());
    TaskProblem {
        at: fault.step.map_or_else(
            || part_word(fault.part).trim_end().to_owned(),
            |index| place(fault.part, index, name(index)),
        ),
        why: fault.rule.to_string(),
    }
}

/// Step number from 1.
fn place(part: Part, index: usize, name: &str) -> String {
    format!("{}step {} ({name})", part_word(part), index + 1)
}

fn part_word(part: Part) -> &'static str {
    match part {
        Part::Acting => "",
        Part::Helping => "helping ",
    }
}

fn read_steps(value: Option<&Value>, part: Part) -> Result<Vec<Step>, TaskProblem> {
    let list = value.and_then(Value::as_array).ok_or_else(|| TaskProblem {
        at: part_word(part).trim_end().to_owned(),
        why: "needs a list of steps, { step = …, motion = …, transition = …, … }".to_owned(),
    })?;
    let read = |(index, value): (usize, &Value)| {
        let name = value.get("step").and_then(Value::as_str).unwrap_or("?");
        read_step(value).map_err(|why| TaskProblem {
            at: place(part, index, name),
            why,
        })
    };
    list.iter().enumerate().map(read).collect()
}

fn read_step(value: &Value) -> Result<Step, String> {
    let table = value.as_table().ok_or_else(|| {
        format!("is {value}, needs {{ step = …, motion = …, transition = …, … }}")
    })?;
    check_keys(table, &STEP_KEYS)?;
    let name = atas_core::tasks::validated_step_name(text(table, "step")?)
        .map_err(|rule| rule.to_string())?;
    let motion = keywords::motion(text(table, "motion")?, optional_text(table, "waypoint")?)?;
    let until = keywords::transition(text(table, "transition")?, table.get("point"))?;
    let modules = keywords::modules(table.get("modules"))?;
    let timeout_s = match table.get("timeout_s") {
        None => f64::INFINITY,
        Some(Value::Float(s)) if s.is_finite() => *s,
        Some(Value::Integer(s)) => *s as f64,
        Some(other) => return Err(format!("timeout_s is {other}, needs a number of seconds")),
    };
    Ok(Step::new(&name, motion, modules, until, timeout_s))
}

fn check_keys(table: &Table, known: &[&'static str]) -> Result<(), String> {
    let unknown = table.keys().find(|key| !known.contains(&key.as_str()));
    unknown.map_or(Ok(()), |key| {
        Err(keywords::unknown("key", key, known.iter().copied()))
    })
}

fn text<'a>(table: &'a Table, key: &str) -> Result<&'a str, String> {
    optional_text(table, key)?.ok_or_else(|| format!("has no {key}"))
}

fn optional_text<'a>(table: &'a Table, key: &str) -> Result<Option<&'a str>, String> {
    let word = |value: &'a Value| {
        let word = value.as_str();
        word.ok_or_else(|| format!("{key} is {value}, needs a word in quotes"))
    };
    table.get(key).map(word).transpose()
}

fn write_task(text: &mut String, name: &str, task: &Task) {
    // Writing to a string cannot fail.
    let _ = write!(text, "\n[tasks.{name}]\n");
    write_sequence(text, "acting", &task.acting);
    if let Some(helping) = &task.helping {
        write_sequence(text, "helping", helping);
    }
    if let Some(table) = &task.table {
        let _ = writeln!(text, "table = {}", table::table_text(table));
    }
}

fn write_sequence(text: &mut String, key: &str, track: &StepSequence) {
    let _ = writeln!(text, "{key} = [");
    for step in track.iter() {
        let _ = writeln!(text, "    {{ {} }},", step_text(step));
    }
    let _ = writeln!(text, "]");
}

fn step_text(step: &Step) -> String {
    let mut text = format!(
        "step = \"{}\", motion = \"{}\"",
        step.name,
        step.motion.name()
    );
    if let Some(waypoint) = step.motion.waypoint() {
        let _ = write!(text, ", waypoint = \"{}\"", waypoint.name());
    }
    let modules: Vec<_> = step.modules.ids().map(|id| format!("\"{id}\"")).collect();
    if !modules.is_empty() {
        let _ = write!(text, ", modules = [{}]", modules.join(", "));
    }
    let _ = write!(text, ", transition = \"{}\"", step.transition.name());
    if let Transition::Met(point) = step.transition {
        let _ = write!(text, ", point = {point}");
    }
    if step.timeout_s.is_finite() {
        let _ = write!(text, ", timeout_s = {:?}", step.timeout_s);
    }
    text
}
