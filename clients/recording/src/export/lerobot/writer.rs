//! Files of a data set: frames, episodes, tasks, statistics and description.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use parquet::file::metadata::KeyValue;
use serde_json::{Map, Value, json};
use shm_schemas::{GoalState, Hand};

use super::Dataset;
use super::columns::{Column, Table, Values};
use super::episode::Episode;
use super::features::{ENVIRONMENT, Features, POSE};
use super::statistics::{Statistics, statistics};

/// Version of the format.
const VERSION: &str = "v3.0";
/// Files per folder, and size of a data file, MB; as in data sets that LeRobot writes.
const FILES_PER_CHUNK: usize = 1000;
const FILE_MB: usize = 100;

/// Data set being written.
pub(super) struct Writer {
    folder: PathBuf,
    fps: u32,
    pub(super) hand: Option<Hand>,
    pub(super) dataset: Dataset,
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
    pub(super) fn new(folder: PathBuf, fps: u32) -> Self {
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
    pub(super) fn use_features(&mut self, features: &Features) -> anyhow::Result<()> {
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

    /// Writes one episode.
    pub(super) fn write(
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

    /// Writes the frames of an episode as one row group; begins a file when the present one is
    /// full.
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

    /// Writes tables of episodes and tasks, statistics and description.
    pub(super) fn finish(mut self) -> anyhow::Result<Dataset> {
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
