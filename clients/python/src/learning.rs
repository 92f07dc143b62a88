//! Learning environments; `atas.environments` adds spaces and wrappers.

use std::sync::{Arc, OnceLock};

use atas_evaluation::drawing::{Links, SceneView};
use atas_learning::{ACTIONS, End, Outcome, Task};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{RobotFiles, TWO_HAND_ARM};

use crate::compute;
use crate::errors::AtasError;
use crate::picture::{self, Picture};
use crate::rows::{numbers, shape_of};

/// Name, shape, lower and upper bound of each number of a part of an observation.
type PartRow = (&'static str, Vec<usize>, Vec<f32>, Vec<f32>);

fn parts_of(environment: &atas_learning::Environment) -> Vec<PartRow> {
    let each = environment.layout().parts().iter().map(|part| {
        let (low, high) = part.each_bound().unzip();
        (part.name, part.shape.clone(), low, high)
    });
    each.collect()
}

fn task_of(name: &str) -> PyResult<Task> {
    match name {
        "grasp" => Ok(Task::Grasp),
        "pick-place" => Ok(Task::PickPlace),
        _ => Err(PyValueError::new_err(format!(
            "unknown task {name:?}; needs \"grasp\" or \"pick-place\""
        ))),
    }
}

fn new_environment(
    task: &str,
    objects: Option<Vec<String>>,
    noise: f64,
    robot: Option<&str>,
) -> PyResult<atas_learning::Environment> {
    let task = task_of(task)?;
    let files = RobotFiles::find(robot.unwrap_or(&TWO_HAND_ARM.name));
    let files = files.map_err(|why| PyValueError::new_err(why.to_string()))?;
    atas_learning::Environment::with_robot(files, task, objects.as_deref(), noise)
        .map_err(learning_error)
}

/// Links of the robot for pictures, loaded by the first one.
#[derive(Default)]
struct DrawnLinks(OnceLock<Arc<Links>>);

impl DrawnLinks {
    fn get(&self, files: &RobotFiles) -> PyResult<Arc<Links>> {
        match self.0.get() {
            Some(links) => Ok(Arc::clone(links)),
            None => {
                let links = picture::load_links(files)?;
                Ok(Arc::clone(self.0.get_or_init(|| links)))
            }
        }
    }
}

/// Draws the current episode of an environment.
fn render<'py>(
    py: Python<'py>,
    environment: &atas_learning::Environment,
    links: &DrawnLinks,
    size_px: [u32; 2],
) -> PyResult<Picture<'py>> {
    let (scene, position, truth) = environment.state().ok_or_else(|| {
        PyValueError::new_err("could not draw: no episode is running; call reset first")
    })?;
    let robot = environment.robot();
    let links = links.get(environment.files())?;
    let view = SceneView::new(links, robot, robot.acting_side(), scene);
    picture::draw(py, &view, position, &truth, size_px)
}

/// Returns an environment's task, robot and objects: `"grasp", robot "two-hand-arm", …`.
fn words(environment: &atas_learning::Environment) -> String {
    let objects: Vec<&str> = environment.objects().collect();
    let task = match environment.task() {
        Task::Grasp => "grasp",
        Task::PickPlace => "pick-place",
    };
    format!(
        "{task:?}, robot {:?}, objects {objects:?}",
        environment.files().name
    )
}

fn learning_error(why: atas_learning::LearningError) -> PyErr {
    match why {
        atas_learning::LearningError::World(fault) => AtasError::new_err(fault.to_string()),
        why => PyValueError::new_err(why.to_string()),
    }
}

fn end_of(end: End) -> &'static str {
    match end {
        End::None => "",
        End::Success => "success",
        End::Crushed => "crushed",
        End::Dropped => "dropped",
        End::Tipped => "tipped",
    }
}

/// One environment, with flat arrays.
#[pyclass(module = "atas")]
pub(crate) struct Environment {
    environment: atas_learning::Environment,
    links: DrawnLinks,
}

impl Environment {
    fn info<'py>(&self, py: Python<'py>, outcome: &Outcome) -> PyResult<Bound<'py, PyDict>> {
        let info = PyDict::new(py);
        info.set_item("end", end_of(outcome.end))?;
        info.set_item("success", outcome.end == End::Success)?;
        info.set_item("lifted_m", outcome.lifted_m)?;
        info.set_item("over_grip", outcome.over_grip)?;
        info.set_item("object", self.environment.objects().nth(outcome.object))?;
        info.set_item("seed", outcome.seed)?;
        Ok(info)
    }

    fn row<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let mut row = vec![0.0; self.environment.layout().size()];
        self.environment.observe(&mut row);
        PyArray1::from_vec(py, row)
    }
}

type Stepped<'py> = (
    Bound<'py, PyArray1<f32>>,
    f64,
    bool,
    bool,
    Bound<'py, PyDict>,
);

#[pymethods]
impl Environment {
    #[new]
    #[pyo3(signature = (task, objects = None, noise = 1.0, robot = None))]
    fn new(
        task: &str,
        objects: Option<Vec<String>>,
        noise: f64,
        robot: Option<&str>,
    ) -> PyResult<Self> {
        Ok(Self {
            environment: new_environment(task, objects, noise, robot)?,
            links: DrawnLinks::default(),
        })
    }

    /// Parts of an observation, in order: name, shape, lower and upper bound of each number.
    fn parts(&self) -> Vec<PartRow> {
        parts_of(&self.environment)
    }

    /// Picture of the current episode; see `Simulation.render`.
    fn render<'py>(&self, py: Python<'py>, width: u32, height: u32) -> PyResult<Picture<'py>> {
        render(py, &self.environment, &self.links, [width, height])
    }

    fn __repr__(&self) -> String {
        words(&self.environment)
    }

    /// Starts an episode: the first of a series with this seed, or the next of the current series.
    #[pyo3(signature = (seed = None))]
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seed: Option<u64>,
    ) -> PyResult<(Bound<'py, PyArray1<f32>>, Bound<'py, PyDict>)> {
        let environment = &mut self.environment;
        let outcome = compute(py, || environment.reset(seed))?.map_err(learning_error)?;
        Ok((self.row(py), self.info(py, &outcome)?))
    }

    /// Runs one step of 20 ms: observation, reward, terminated, truncated, info.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        action: PyArrayLike1<'py, f32, AllowTypeChange>,
    ) -> PyResult<Stepped<'py>> {
        let action: [f32; ACTIONS] = numbers(&action).try_into().map_err(|values: Vec<f32>| {
            PyValueError::new_err(format!(
                "action rejected: {} numbers, needs {ACTIONS}",
                values.len()
            ))
        })?;
        let environment = &mut self.environment;
        let outcome = compute(py, || environment.step(&action))?.map_err(learning_error)?;
        let info = self.info(py, &outcome)?;
        Ok((
            self.row(py),
            outcome.reward,
            outcome.end != End::None,
            outcome.truncated,
            info,
        ))
    }
}

/// Several environments of one kind on all cores; other Python threads run meanwhile.
#[pyclass(module = "atas")]
pub(crate) struct Batch {
    batch: atas_learning::Batch,
    /// Environment of the same kind, without an episode.
    like: atas_learning::Environment,
    links: DrawnLinks,
}

type Rows<'py> = Bound<'py, PyArray2<f32>>;

/// Returns the outcomes of a batch as columns.
fn columns<'py>(py: Python<'py>, outcomes: &[Outcome]) -> PyResult<Bound<'py, PyDict>> {
    let fields = PyDict::new(py);
    let floats = |of: fn(&Outcome) -> f64| PyArray1::from_iter(py, outcomes.iter().map(of));
    let flags = |of: fn(&Outcome) -> bool| PyArray1::from_iter(py, outcomes.iter().map(of));
    fields.set_item("reward", floats(|it| it.reward))?;
    fields.set_item("lifted_m", floats(|it| it.lifted_m))?;
    fields.set_item("over_grip", floats(|it| it.over_grip))?;
    fields.set_item("terminated", flags(|it| it.end != End::None))?;
    fields.set_item("truncated", flags(|it| it.truncated))?;
    fields.set_item("success", flags(|it| it.end == End::Success))?;
    fields.set_item(
        "end",
        outcomes.iter().map(|it| end_of(it.end)).collect::<Vec<_>>(),
    )?;
    fields.set_item(
        "object",
        PyArray1::from_iter(py, outcomes.iter().map(|it| it.object as u64)),
    )?;
    fields.set_item(
        "seed",
        PyArray1::from_iter(py, outcomes.iter().map(|it| it.seed)),
    )?;
    Ok(fields)
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (task, count, objects = None, noise = 1.0, threads = 0, autoreset = true, robot = None))]
    fn new(
        task: &str,
        count: usize,
        objects: Option<Vec<String>>,
        noise: f64,
        threads: usize,
        autoreset: bool,
        robot: Option<&str>,
    ) -> PyResult<Self> {
        let like = new_environment(task, objects, noise, robot)?;
        let batch = atas_learning::Batch::new(&like, count, threads, autoreset);
        Ok(Self {
            batch: batch.map_err(learning_error)?,
            like,
            links: DrawnLinks::default(),
        })
    }

    /// Parts of an observation; see `Environment.parts`.
    fn parts(&self) -> Vec<PartRow> {
        parts_of(&self.like)
    }

    /// Picture of the current episode of one environment; see `Simulation.render`.
    fn render<'py>(
        &self,
        py: Python<'py>,
        index: usize,
        width: u32,
        height: u32,
    ) -> PyResult<Picture<'py>> {
        let environment = self.batch.environment(index).ok_or_else(|| {
            PyValueError::new_err(format!(
                "could not draw environment {index}: there are {}",
                self.batch.len()
            ))
        })?;
        render(py, environment, &self.links, [width, height])
    }

    fn __repr__(&self) -> String {
        words(&self.like)
    }

    /// Starts an episode in each environment; `seeds` contains a number or None for each.
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seeds: Vec<Option<u64>>,
    ) -> PyResult<(Rows<'py>, Bound<'py, PyDict>)> {
        let count = self.batch.len();
        if seeds.len() != count {
            return Err(PyValueError::new_err(format!(
                "{} seeds given, needs {count}",
                seeds.len()
            )));
        }
        let mut rows = vec![0.0; count * self.like.layout().size()];
        let batch = &mut self.batch;
        let outcomes = compute(py, || batch.reset(&seeds, &mut rows))?.map_err(learning_error)?;
        Ok((table(py, rows, count)?, columns(py, &outcomes)?))
    }

    /// Runs one step of each environment. After the end of an episode, the environment starts the
    /// next one instead, or does nothing without `autoreset`.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        actions: PyArrayLike2<'py, f32, AllowTypeChange>,
    ) -> PyResult<(Rows<'py>, Bound<'py, PyDict>)> {
        let count = self.batch.len();
        let view = actions.as_array();
        if view.dim() != (count, ACTIONS) {
            return Err(PyValueError::new_err(format!(
                "actions rejected: shape {}, needs ({count}, {ACTIONS})",
                shape_of(&actions)
            )));
        }
        let actions: Vec<[f32; ACTIONS]> = view
            .outer_iter()
            .map(|row| std::array::from_fn(|n| row[n]))
            .collect();
        let mut rows = vec![0.0; count * self.like.layout().size()];
        let batch = &mut self.batch;
        let outcomes = compute(py, || batch.step(&actions, &mut rows))?.map_err(learning_error)?;
        Ok((table(py, rows, count)?, columns(py, &outcomes)?))
    }
}

fn table(py: Python<'_>, rows: Vec<f32>, count: usize) -> PyResult<Rows<'_>> {
    let size = rows.len() / count.max(1);
    PyArray1::from_vec(py, rows).reshape([count, size])
}
