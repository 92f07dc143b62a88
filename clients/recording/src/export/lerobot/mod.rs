//! Data set of LeRobot (format v3.0): one episode per goal of the recorded runs.
//!
//! ```text
//!  Rows ─▶ Episodes (goals, frames at fps) ─▶ Writer ─▶ data/*.parquet, meta/{info,stats}.json,
//!                                                       meta/tasks.parquet, meta/episodes/*
//! ```
//!
//! | column | contents |
//! |---|---|
//! | `observation.state` | pinch pose, joints, tactile summary, grip force limits, modules |
//! | `observation.environment_state` | expected object and place of the goal; zero if unknown |
//! | `observation.taxels` | with `elements`: force components of all sensor elements, N |
//! | `action` | target of a teleoperated hand, else commanded pinch pose, one frame later |
//! | `next.done`, `next.success` | end of the episode; true if the goal succeeded |
//!
//! * **Invariants:** frames of an episode are 1/fps apart in recorded time. A value that no tick
//!   updates keeps its last value; lost ticks repeat frames. Statistics are exact, over all frames.
//! * **Not included:** videos; goals that only release; goals of the other hand, which are counted.

mod columns;
mod features;
mod statistics;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use atas_client::goal_summary::begins;
use parquet::file::metadata::KeyValue;
use robot_model::HandSide;
use serde_json::{Map, Value, json};
use shm_schemas::{EventKind, GoalKind, GoalRequest, GoalState, Hand};

use crate::origin;
use crate::rows::{Row, Rows};
use crate::runs::runs;
use columns::{Column, Table, Values};
use features::{ENVIRONMENT, Features, Newest, POSE};
use statistics::{Statistics, statistics};

/// Version of the format.
const VERSION: &str = "v3.0";
/// Ticks per second of the daemon.
const TICK_HZ: u32 = 1000;
/// Files per folder, and size of a data file, MB; as in data sets that LeRobot writes.
const FILES_PER_CHUNK: usize = 1000;
const FILE_MB: usize = 100;

/// Options of the export.
#[derive(Clone, Debug)]
pub struct DatasetChoices {
    /// Frames per second; divides 1000.
    pub fps: u32,
    /// Hand; default: that of the first goal.
    pub hand: Option<Hand>,
    /// Task text; default: a sentence per kind of goal.
    pub task: Option<String>,
    /// True to add the forces of all sensor elements.
    pub elements: bool,
}

/// Summary of an export.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dataset {
    /// Episodes.
    pub episodes: usize,
    /// Episodes whose goal succeeded.
    pub successes: usize,
    /// Frames of all episodes.
    pub frames: usize,
    /// Goals left out: of the other hand, or without a frame.
    pub skipped: usize,
}

/// Exports recordings of one or several runs into a new folder, until the end or until `stop` is
/// set.
///
/// # Errors
/// A recording cannot be read to its end, has no goal or no joint states, or the folder cannot be
/// written. No folder is created then.
pub fn export_dataset(
    files: &[PathBuf],
    out: &Path,
    choices: &DatasetChoices,
    stop: &AtomicBool,
) -> anyhow::Result<Dataset> {
    anyhow::ensure!(
        choices.fps > 0 && TICK_HZ.is_multiple_of(choices.fps),
        "could not export: {} frames per second do not divide the {TICK_HZ} ticks per second; use \
         for example 20, 50 or 100",
        choices.fps
    );
    let draft = DraftFolder::next_to(out)?;
    let mut writer = Writer::new(draft.path.clone(), choices.fps);
    for run in runs(files)? {
        export_run(&run, choices, &mut writer, stop)
            .with_context(|| format!("could not export {}", run[0].display()))?;
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    let dataset = writer.finish().context("could not export")?;
    draft.publish()?;
    Ok(dataset)
}

fn export_run(
    files: &[PathBuf],
    choices: &DatasetChoices,
    writer: &mut Writer,
    stop: &AtomicBool,
) -> anyhow::Result<()> {
    let rows = Rows::open(files)?;
    let robot = origin::robot(rows.header(), rows.robot())?;
    let robot = robot.load().context("could not load the recorded robot")?;
    let fingers = origin::fingers(rows.header());
    let layouts = origin::layouts(rows.header());
    let mut state: Option<Run> = None;
    let mut has_inputs = false;
    for row in rows {
        let row = row?;
        if stop.load(Ordering::Relaxed) {
            break;
        }
        has_inputs |= row.inputs.is_some();
        let goal = row.inputs.as_deref().and_then(|inputs| inputs.goal);
        if state.is_none() {
            let Some(goal) = goal.filter(|goal| goal.kind != GoalKind::RELEASE) else {
                continue;
            };
            let hand = writer.hand.or(choices.hand).unwrap_or(goal.hand);
            writer.hand = Some(hand);
            let side = HandSide::BOTH[usize::from(hand != Hand::LEFT)];
            anyhow::ensure!(
                robot.hand(side).is_present(),
                "the recorded robot has no {hand} hand; choose the other one with --hand"
            );
            let elements = if choices.elements {
                layouts[side.index()].count
            } else {
                0
            };
            let count = fingers[side.index()].min(robot.hand(side).fingertip_count());
            let features = Features::new(robot.clone(), side, count, elements);
            writer.use_features(&features)?;
            state = Some(Run::new(features, hand, TICK_HZ / choices.fps));
        }
        if let Some(run) = &mut state {
            run.tick(&row, goal, choices, writer)?;
        }
    }
    anyhow::ensure!(
        has_inputs,
        "it has no joint states and commands; start the daemon with `atasd --record-stream`"
    );
    match &mut state {
        Some(run) => run.end(None, choices, writer),
        None => Ok(()),
    }
}

/// Goals of a run, read tick by tick.
struct Run {
    features: Features,
    hand: Hand,
    stride: u64,
    newest: Newest,
    episode: Option<Episode>,
}

/// Goal being read.
struct Episode {
    goal: GoalRequest,
    next_tick: u64,
    states: Vec<f32>,
    taxels: Vec<f32>,
    actions: Vec<f32>,
    frames: usize,
}

impl Run {
    fn new(features: Features, hand: Hand, stride: u32) -> Self {
        Self {
            features,
            hand,
            stride: stride.into(),
            newest: Newest::default(),
            episode: None,
        }
    }

    fn tick(
        &mut self,
        row: &Row,
        goal: Option<GoalRequest>,
        choices: &DatasetChoices,
        writer: &mut Writer,
    ) -> anyhow::Result<()> {
        if let Some(goal) = goal {
            // A goal without a recorded end has ended before the next one begins.
            self.end(None, choices, writer)?;
            self.newest.begin_goal();
            if goal.kind != GoalKind::RELEASE {
                let is_own = goal.hand == self.hand || goal.kind == GoalKind::TELEOP_BOTH;
                writer.dataset.skipped += usize::from(!is_own);
                self.episode = is_own.then(|| Episode {
                    goal,
                    next_tick: row.tick,
                    states: Vec::new(),
                    taxels: Vec::new(),
                    actions: Vec::new(),
                    frames: 0,
                });
            }
        }
        self.features.update(&mut self.newest, row)?;
        if let Some(episode) = &mut self.episode
            && row.tick >= episode.next_tick
        {
            let state = self.features.state(&self.newest);
            let action = self.features.action(&self.newest);
            if let (Some(state), Some(action)) = (state, action) {
                // Frames of lost ticks repeat the next known values, so that time stays uniform.
                let due = (row.tick - episode.next_tick) / self.stride + 1;
                for _ in 0..due {
                    episode.add_action(action);
                    episode.states.extend(&state);
                    episode.taxels.extend(self.features.taxels(&self.newest));
                    episode.frames += 1;
                }
                episode.next_tick += self.stride * due;
            }
        }
        let is_end = |event: &&shm_schemas::ModuleEvent| {
            event.kind == EventKind::GOAL && !begins(event) && self.episode.is_some()
        };
        if let Some(end) = row.events.iter().find(is_end) {
            self.end(Some(end.text.as_str()), choices, writer)?;
        }
        Ok(())
    }

    /// Writes the episode, if one is being read.
    fn end(
        &mut self,
        end: Option<&str>,
        choices: &DatasetChoices,
        writer: &mut Writer,
    ) -> anyhow::Result<()> {
        let Some(mut episode) = self.episode.take() else {
            return Ok(());
        };
        match self.features.action(&self.newest) {
            Some(action) if episode.frames > 0 => episode.add_action(action),
            _ => {
                writer.dataset.skipped += 1;
                return Ok(());
            }
        }
        let task = choices.task.clone().unwrap_or_else(|| text(&episode.goal));
        writer.write(
            &self.features,
            &episode,
            &task,
            end.unwrap_or("not recorded"),
        )
    }
}

impl Episode {
    /// Adds the action of the newest frame, if it has none yet.
    fn add_action(&mut self, action: [f32; 5]) {
        if self.actions.len() < self.frames * action.len() {
            self.actions.extend(action);
        }
    }
}

/// Returns the default task text.
fn text(goal: &GoalRequest) -> String {
    match goal.kind {
        GoalKind::GRASP => "Grasp the object and lift it.".to_owned(),
        GoalKind::PICK_PLACE => "Pick the object up and place it.".to_owned(),
        GoalKind::SCREW => "Screw the cap.".to_owned(),
        GoalKind::ASSEMBLE => "Screw the cap onto the bottle.".to_owned(),
        GoalKind::CUSTOM => goal.task.to_string(),
        kind => kind.name().to_owned(),
    }
}

/// Data set being written.
struct Writer {
    folder: PathBuf,
    fps: u32,
    hand: Option<Hand>,
    dataset: Dataset,
    /// Names of the components of each vector feature.
    names: Vec<(&'static str, Vec<String>)>,
    tasks: Vec<String>,
    /// Columns of all frames so far, for the statistics.
    all: Vec<Column>,
    episodes: Vec<Column>,
    data: Option<Table>,
    /// Index of the data file, and its size so far, bytes.
    file: usize,
    file_bytes: usize,
}

impl Writer {
    fn new(folder: PathBuf, fps: u32) -> Self {
        Self {
            folder,
            fps,
            hand: None,
            dataset: Dataset::default(),
            names: Vec::new(),
            tasks: Vec::new(),
            all: Vec::new(),
            episodes: Vec::new(),
            data: None,
            file: 0,
            file_bytes: 0,
        }
    }

    /// Sets the features of the first run; those of later runs must be equal.
    fn use_features(&mut self, features: &Features) -> anyhow::Result<()> {
        let mut names = vec![
            ("observation.state", features.state_names()),
            (
                "observation.environment_state",
                ENVIRONMENT.map(str::to_owned).into(),
            ),
        ];
        let taxels = features.taxel_names();
        if !taxels.is_empty() {
            names.push(("observation.taxels", taxels));
        }
        names.push(("action", POSE.map(str::to_owned).into()));
        anyhow::ensure!(
            self.names.is_empty() || self.names == names,
            "its robot or sensors differ from those of the first recording; export them separately"
        );
        self.names = names;
        Ok(())
    }

    fn write(
        &mut self,
        features: &Features,
        episode: &Episode,
        task: &str,
        end: &str,
    ) -> anyhow::Result<()> {
        let frames = episode.frames;
        let task_index = match self.tasks.iter().position(|known| known == task) {
            Some(index) => index,
            None => {
                self.tasks.push(task.to_owned());
                self.tasks.len() - 1
            }
        };
        let succeeded = end == GoalState::SUCCEEDED.name();
        let first = self.dataset.frames;
        let vector = |values: &[f32]| Values::Shorts(values.len() / frames, values.to_vec());
        let last_only = |value: bool| (0..frames).map(|at| value && at + 1 == frames).collect();
        let constant = |value: usize| vec![value as i64; frames];
        let environment = Features::environment(&episode.goal).repeat(frames);
        let mut columns = vec![
            Column::new("observation.state", vector(&episode.states)),
            Column::new("observation.environment_state", vector(&environment)),
        ];
        if !features.taxel_names().is_empty() {
            columns.push(Column::new("observation.taxels", vector(&episode.taxels)));
        }
        let times = (0..frames).map(|at| at as f32 / self.fps as f32);
        columns.extend([
            Column::new("action", vector(&episode.actions)),
            Column::new("next.done", Values::Flag(last_only(true))),
            Column::new("next.success", Values::Flag(last_only(succeeded))),
            Column::new("timestamp", Values::Short(times.collect())),
            Column::new("frame_index", Values::Whole((0..frames as i64).collect())),
            Column::new(
                "episode_index",
                Values::Whole(constant(self.dataset.episodes)),
            ),
            Column::new(
                "index",
                Values::Whole((first as i64..(first + frames) as i64).collect()),
            ),
            Column::new("task_index", Values::Whole(constant(task_index))),
        ]);
        self.write_frames(&columns)?;
        let place = self.file;
        let whole = |value: usize| Values::Whole(vec![value as i64]);
        let mut about = vec![
            Column::new("episode_index", whole(self.dataset.episodes)),
            Column::new("tasks", Values::Texts(1, vec![task.to_owned()])),
            Column::new("length", whole(frames)),
            Column::new("data/chunk_index", whole(place / FILES_PER_CHUNK)),
            Column::new("data/file_index", whole(place % FILES_PER_CHUNK)),
            Column::new("dataset_from_index", whole(first)),
            Column::new("dataset_to_index", whole(first + frames)),
            Column::new("meta/episodes/chunk_index", whole(0)),
            Column::new("meta/episodes/file_index", whole(0)),
            Column::new("success", Values::Flag(vec![succeeded])),
            Column::new("goal_state", Values::Text(vec![end.to_owned()])),
        ];
        for column in &columns {
            for (name, values) in statistics(column).into_iter().flatten() {
                let name = format!("stats/{}/{name}", column.name);
                about.push(Column::new(name, Values::Numbers(values.len(), values)));
            }
        }
        append(&mut self.episodes, about);
        append(&mut self.all, columns);
        self.dataset.episodes += 1;
        self.dataset.successes += usize::from(succeeded);
        self.dataset.frames += frames;
        Ok(())
    }

    /// Writes the frames of an episode as one row group; begins a file when the present one is full.
    fn write_frames(&mut self, columns: &[Column]) -> anyhow::Result<()> {
        let bytes: usize = columns.iter().map(Column::bytes).sum();
        if self.file_bytes > 0 && self.file_bytes + bytes > FILE_MB * 1_000_000 {
            if let Some(full) = self.data.take() {
                full.finish()?;
            }
            self.file += 1;
            self.file_bytes = 0;
        }
        let mut data = match self.data.take() {
            Some(data) => data,
            None => {
                let [chunk, file] = [self.file / FILES_PER_CHUNK, self.file % FILES_PER_CHUNK];
                let name = format!("data/chunk-{chunk:03}/file-{file:03}.parquet");
                Table::create(&self.folder.join(name), columns, Vec::new())?
            }
        };
        data.write(columns)?;
        self.file_bytes += bytes;
        self.data = Some(data);
        Ok(())
    }

    fn finish(mut self) -> anyhow::Result<Dataset> {
        anyhow::ensure!(
            self.dataset.episodes > 0,
            "the recordings have no goal of the hand (of {} goals); name recordings with goals, or \
             another hand with --hand",
            self.dataset.skipped
        );
        if let Some(data) = self.data.take() {
            data.finish()?;
        }
        let episodes = self.folder.join("meta/episodes/chunk-000/file-000.parquet");
        one_table(&episodes, &self.episodes, Vec::new())?;
        let tasks = [
            Column::new(
                "task_index",
                Values::Whole((0..self.tasks.len() as i64).collect()),
            ),
            Column::new("task", Values::Text(self.tasks.clone())),
        ];
        let noted = KeyValue::new("pandas".to_owned(), task_index().to_string());
        one_table(&self.folder.join("meta/tasks.parquet"), &tasks, vec![noted])?;
        let mut stats = Map::new();
        for column in &self.all {
            if let Some(found) = statistics(column) {
                stats.insert(column.name.clone(), statistics_json(&found));
            }
        }
        self.write_json("meta/stats.json", &Value::Object(stats))?;
        self.write_json("meta/info.json", &self.info())?;
        Ok(self.dataset)
    }

    fn write_json(&self, name: &str, value: &Value) -> anyhow::Result<()> {
        let path = self.folder.join(name);
        let text = format!("{value:#}\n");
        fs::write(&path, text).with_context(|| format!("could not write {}", path.display()))
    }

    fn info(&self) -> Value {
        let mut features = Map::new();
        for (name, names) in &self.names {
            features.insert(
                (*name).to_owned(),
                json!({ "dtype": "float32", "shape": [names.len()], "names": names }),
            );
        }
        for (name, form) in [
            ("next.done", "bool"),
            ("next.success", "bool"),
            ("timestamp", "float32"),
            ("frame_index", "int64"),
            ("episode_index", "int64"),
            ("index", "int64"),
            ("task_index", "int64"),
        ] {
            features.insert(
                name.to_owned(),
                json!({ "dtype": form, "shape": [1], "names": null }),
            );
        }
        json!({
            "codebase_version": VERSION,
            "robot_type": "atas",
            "total_episodes": self.dataset.episodes,
            "total_frames": self.dataset.frames,
            "total_tasks": self.tasks.len(),
            "chunks_size": FILES_PER_CHUNK,
            "data_files_size_in_mb": FILE_MB,
            "video_files_size_in_mb": 200,
            "fps": self.fps,
            "splits": { "train": format!("0:{}", self.dataset.episodes) },
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": null,
            "features": features,
        })
    }
}

/// Appends the rows of columns with the same names and types.
fn append(all: &mut Vec<Column>, more: Vec<Column>) {
    if all.is_empty() {
        *all = more;
        return;
    }
    for (column, more) in all.iter_mut().zip(more) {
        match (&mut column.values, more.values) {
            (Values::Whole(values), Values::Whole(more)) => values.extend(more),
            (Values::Short(values), Values::Short(more)) => values.extend(more),
            (Values::Flag(values), Values::Flag(more)) => values.extend(more),
            (Values::Text(values), Values::Text(more)) => values.extend(more),
            (Values::Shorts(_, values), Values::Shorts(_, more)) => values.extend(more),
            (Values::Numbers(_, values), Values::Numbers(_, more)) => values.extend(more),
            (Values::Texts(_, values), Values::Texts(_, more)) => values.extend(more),
            _ => unreachable!("every episode has the columns of the first"),
        }
    }
}

fn one_table(path: &Path, columns: &[Column], noted: Vec<KeyValue>) -> anyhow::Result<()> {
    let mut table = Table::create(path, columns, noted)?;
    table.write(columns)?;
    table.finish()
}

fn statistics_json(statistics: &Statistics) -> Value {
    let values = statistics.iter();
    Value::Object(
        values
            .map(|(name, of)| ((*name).to_owned(), json!(of)))
            .collect(),
    )
}

/// Metadata that make pandas use the task texts as index of the table.
fn task_index() -> Value {
    let column = |name: &str, pandas: &str, numpy: &str| {
        json!({ "name": name, "field_name": name, "pandas_type": pandas, "numpy_type": numpy,
                "metadata": null })
    };
    json!({
        "index_columns": ["task"],
        "column_indexes": [{ "name": null, "field_name": null, "pandas_type": "unicode",
                             "numpy_type": "object", "metadata": { "encoding": "UTF-8" } }],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "creator": { "library": "atas", "version": env!("CARGO_PKG_VERSION") },
        "pandas_version": "2.0.0",
    })
}

/// Incomplete folder next to its final path. Dropping it removes it unless it was published.
struct DraftFolder {
    path: PathBuf,
    out: PathBuf,
}

impl DraftFolder {
    fn next_to(out: &Path) -> anyhow::Result<Self> {
        reject_existing(out)?;
        let name = out.file_name().map(|name| name.to_string_lossy());
        let name = name.with_context(|| {
            format!(
                "could not make the folder {} because it has no name; name a folder",
                out.display()
            )
        })?;
        // The process id separates two simultaneous exports.
        let path = out.with_file_name(format!(".{name}.{}.part", std::process::id()));
        fs::create_dir(&path)
            .with_context(|| format!("could not make the folder {}", out.display()))?;
        Ok(Self {
            path,
            out: out.to_owned(),
        })
    }

    fn publish(self) -> anyhow::Result<()> {
        reject_existing(&self.out)?;
        fs::rename(&self.path, &self.out)
            .with_context(|| format!("could not make the folder {}", self.out.display()))
    }
}

impl Drop for DraftFolder {
    fn drop(&mut self) {
        // The folder is published or not needed.
        let _ = fs::remove_dir_all(&self.path);
    }
}

fn reject_existing(out: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        !out.exists(),
        "could not make the folder {} because it exists; name another with --out, or remove it",
        out.display()
    );
    Ok(())
}
