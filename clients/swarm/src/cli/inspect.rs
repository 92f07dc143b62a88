//! `ebts show`, `ebts plot` and `ebts replay`: inspection of tables and experiments.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use ebts::analysis::{HeldOut, held_out};
use ebts::error::{Error, Result};
use ebts::evaluate::{Evaluator, GoalPoints};
use ebts::experiment::read_folder;
use ebts::files::write_atomically;
use ebts::plot::{BehaviourRow, Panel, behaviour_rows, behaviour_strip, fig14, trajectories};
use ebts::replay::traces;
use ebts::scoring::Scoring;
use ebts::table::behaviour;
use ebts::table_file::TableFile;
use field::{Engine, SENSORS, run_trial};

use super::options::html_file;
use super::{Format, answer, course, grasp};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts show table.toml")]
pub(crate) struct ShowArgs {
    /// Table file.
    table: PathBuf,
    /// Accept rows edited by hand.
    ///
    /// Evaluates the table, marks the file as edited and writes its new hash.
    #[arg(long)]
    rehash: bool,
    /// Print a grasp table as a task with this name for the configuration of the daemon.
    #[arg(long, value_name = "NAME", conflicts_with = "rehash")]
    task: Option<String>,
}

#[derive(Serialize)]
struct Shown {
    agents: usize,
    preset: String,
    fitness_rule: Scoring,
    seed: Option<u64>,
    generations: Option<u32>,
    edited: bool,
    hash: String,
    fitness: f32,
    points: GoalPoints,
    /// True if this version reproduces the stored points; null if it lacks the rule.
    fitness_repeats: Option<bool>,
    /// Held-out fitness; null if this version lacks the rule.
    held_out: Option<HeldOut>,
    tables: Vec<Vec<ShownRow>>,
}

#[derive(Serialize)]
struct ShownRow {
    sensors: [u8; SENSORS],
    motors: [u8; 4],
    behaviour: &'static str,
    /// True if any agent read this row in the eight training trials.
    read: bool,
}

pub(super) fn show(args: ShowArgs, format: Format) -> Result<()> {
    if grasp::is_grasp_file(&args.table)? {
        return grasp::show(&args.table, args.task.as_deref(), format);
    }
    if course::is_course_file(&args.table)? {
        return course::show(&args.table, format);
    }
    let file = if args.rehash {
        rehash(&args.table)?
    } else {
        TableFile::read(&args.table)?
    };
    let shown = shown(&file);
    answer(format, &shown, || describe(&args.table, &shown))
}

fn rehash(path: &Path) -> Result<TableFile> {
    let mut file = TableFile::read_edited(path)?;
    let before = TableFile::read(path).ok().map(|intact| intact.hash());
    if before.is_none() {
        let cure = "evaluate it with the program that evolved it, or set fitness_rule to a \
            built-in rule";
        file.condition.fitness.check_available(path, cure)?;
        file.edited = true;
        file.code_version = env!("CARGO_PKG_VERSION").to_owned();
        file.individual.points = Evaluator::points_of(&file.condition, &file.individual.genome);
    }
    file.write(path)?;
    Ok(file)
}

fn shown(file: &TableFile) -> Shown {
    let condition = &file.condition;
    let genome = &file.individual.genome;
    let rows_read = rows_read(file);
    let row = |table: &ebts::table::Table, row: usize| ShownRow {
        sensors: std::array::from_fn(|s| (row >> s & 1) as u8),
        motors: std::array::from_fn(|bit| (table.output(row) >> bit & 1) as u8),
        behaviour: behaviour(table.level(row, 0), table.level(row, 1)),
        read: rows_read >> row & 1 == 1,
    };
    let tables = condition.tables_of(genome);
    Shown {
        agents: condition.team.get(),
        preset: condition.model.preset().name.to_string(),
        fitness_rule: condition.fitness.clone(),
        seed: file.origin.map(|origin| origin.seed),
        generations: file.origin.map(|origin| origin.generations),
        edited: file.edited,
        hash: file.hash(),
        fitness: file.individual.fitness(),
        points: file.individual.points,
        fitness_repeats: condition
            .fitness
            .is_available()
            .then(|| Evaluator::points_of(condition, genome) == file.individual.points),
        held_out: condition
            .fitness
            .is_available()
            .then(|| held_out(condition, Engine::fastest(), genome)),
        tables: tables
            .iter()
            .map(|table| (0..table.shape().rows()).map(|r| row(table, r)).collect())
            .collect(),
    }
}

fn rows_read(file: &TableFile) -> u32 {
    let condition = &file.condition;
    let tables = condition.responses(&file.individual.genome);
    let read = |layout| {
        run_trial(
            &condition.model,
            condition.team,
            &field::Trial { layout, tables },
        )
        .rows_read
    };
    condition.sensors.table_rows(
        condition
            .layouts()
            .into_iter()
            .fold(0, |rows, layout| rows | read(layout)),
    )
}

fn describe(path: &Path, shown: &Shown) -> String {
    let run = match (shown.seed, shown.generations) {
        (Some(seed), Some(generations)) => format!("seed {seed}, {generations} generations"),
        _ => "made by hand".to_owned(),
    };
    let edited = if shown.edited { ", edited since" } else { "" };
    let plural = if shown.agents == 1 { "" } else { "s" };
    let mut text = format!(
        "{}: {} agent{plural} on {}, {run}{edited}\n",
        path.display(),
        shown.agents,
        shown.preset
    );
    let repeats = match shown.fitness_repeats {
        Some(true) => "repeats to the bit",
        Some(false) => "DOES NOT REPEAT with this version",
        None => "not evaluated again: its custom rule is not part of this program",
    };
    let points = shown.points.map(|points| format!("{points:.1}")).join("  ");
    let _ = writeln!(
        text,
        "fitness {:.1} of 800 by the rule {} ({repeats})\npoints per goal: {points}",
        shown.fitness, shown.fitness_rule
    );
    if let Some(HeldOut {
        goals,
        starts,
        goals_and_starts,
        ..
    }) = shown.held_out
    {
        let _ = writeln!(
            text,
            "held out: other goals {goals:.1}, other starts {starts:.1}, both {goals_and_starts:.1}"
        );
    }
    let _ = writeln!(text, "hash {}", shown.hash);
    for (index, table) in shown.tables.iter().enumerate() {
        if shown.tables.len() > 1 {
            let _ = writeln!(text, "\nagent {}", index + 1);
        }
        let _ = writeln!(text, "\nS1 S2 S3 S4 S5  L1 L2 R1 R2  read  behaviour");
        for row in table {
            let digits = |bits: &[u8]| {
                bits.iter()
                    .map(|bit| format!("{bit:>2}"))
                    .collect::<Vec<_>>()
                    .join(" ")
            };
            let read = if row.read { "yes" } else { "" };
            let _ = writeln!(
                text,
                "{}  {}  {read:<4}  {}",
                digits(&row.sensors),
                digits(&row.motors),
                row.behaviour
            );
        }
    }
    text
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  ebts plot fig14\n  ebts plot table.toml --goal 3")]
pub(crate) struct PlotArgs {
    /// Folder of an experiment, or a table file.
    what: PathBuf,
    /// Folder for the figures [default: folder of the experiment or table].
    #[arg(long)]
    out: Option<PathBuf>,
    /// Goal of the behaviour figure, 1 to 8.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=8))]
    goal: u8,
}

#[derive(Serialize)]
struct Plotted {
    figures: Vec<PathBuf>,
    behaviour: Vec<BehaviourRow>,
}

/// Frames of the paper's table of sensors and behaviour (after Fig. 15).
const PAPER_FRAMES: [usize; 6] = [0, 100, 200, 219, 225, 250];

pub(super) fn plot(args: PlotArgs, format: Format) -> Result<()> {
    let plotted = if args.what.is_dir() {
        let (plan, records) = read_folder(&args.what)?;
        let figure = args.out.as_ref().unwrap_or(&args.what).join("fig14.svg");
        write_atomically(&figure, fig14(&plan, &records)?.as_bytes())?;
        Plotted {
            figures: vec![figure],
            behaviour: Vec::new(),
        }
    } else {
        plot_table(&args)?
    };
    answer(format, &plotted, || {
        let mut text = String::new();
        for figure in &plotted.figures {
            let _ = writeln!(text, "figure: {}", figure.display());
        }
        if !plotted.behaviour.is_empty() {
            let _ = writeln!(
                text,
                "\ngoal {}\nframe  agent  S1 S2 S3 S4 S5  behaviour",
                args.goal
            );
        }
        for row in &plotted.behaviour {
            let sensors = row.sensors.map(|bit| format!("{bit:>2}")).join(" ");
            let _ = writeln!(
                text,
                "{:>5}  {:>5}  {sensors}  {}",
                row.frame, row.agent, row.behaviour
            );
        }
        text
    })
}

fn plot_table(args: &PlotArgs) -> Result<Plotted> {
    let file = TableFile::read(&args.what)?;
    let traces = traces(&file);
    let stem = args
        .what
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let folder = args
        .out
        .as_deref()
        .or(args.what.parent())
        .unwrap_or(Path::new(""));
    let figure = |kind: &str| folder.join(format!("{stem}.{kind}.svg"));
    let (paths, strip) = (
        figure("trajectories"),
        figure(&format!("behaviour-{}", args.goal)),
    );
    let shown = &traces[usize::from(args.goal) - 1];
    write_atomically(&strip, behaviour_strip(shown)?.as_bytes())?;
    let behaviour = behaviour_rows(shown, &PAPER_FRAMES);
    let rule = file.condition.fitness.short_name();
    let panel = |(goal, (trace, points))| Panel {
        title: format!("goal {}: {points:.0} points ({rule})", goal + 1),
        trace,
    };
    let earned = traces.into_iter().zip(file.points_on_field());
    let panels: Vec<Panel> = earned.enumerate().map(panel).collect();
    write_atomically(&paths, trajectories(&file.condition, &panels)?.as_bytes())?;
    Ok(Plotted {
        figures: vec![paths, strip],
        behaviour,
    })
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts replay table.toml")]
pub(crate) struct ReplayArgs {
    /// Table file.
    table: PathBuf,
    /// Web page to write [default: next to the table].
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Replayed {
    page: PathBuf,
}

pub(super) fn replay(args: ReplayArgs, format: Format) -> Result<()> {
    let file = TableFile::read(&args.table)?;
    let page = args
        .out
        .unwrap_or_else(|| args.table.with_extension("html"));
    if page == args.table {
        return Err(Error::refused(
            "write the page",
            "its name is that of the table",
            "another name",
            "choose another --out",
        ));
    }
    let html = ebts::replay::page(&file)?;
    write_atomically(&page, html.as_bytes())?;
    answer(format, &Replayed { page: page.clone() }, || {
        format!("animation: {}", page.display())
    })
}
