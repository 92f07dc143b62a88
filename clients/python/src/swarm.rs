//! Behaviour tables of swarms: their fitness, and the genetic algorithm as ask and tell.
//!
//! A batch of genomes is an array of bytes, one genome per row, one bit per byte. The bits are read
//! in place; results are moved into arrays without copying.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ebts::condition::{Condition, GOALS};
use ebts::evaluate::{Evaluator, Individual};
use ebts::ga::{Population, Settings};
use ebts::genome::Genome;
use ebts::rng::SplitMix64;
use ebts::table_file::TableFile;
use ebts::workers::Workers;
use field::{Engine, FitnessRule, Model, TeamSize};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::compute;
use crate::errors::AtasError;

type Bits<'py> = PyReadonlyArray2<'py, u8>;

/// Fitness of behaviour tables of a team of mobile robots on a field.
///
/// `preset` is a built-in field of `ebts preset` or the path of a TOML file, `agents` the number of
/// robots (1 to 4), `threads` the number of threads (0: one per core). A genome has `bits` bits.
/// Equal genomes have equal fitness, on any number of threads.
#[pyclass(module = "atas")]
pub(crate) struct SwarmField {
    condition: Condition,
    evaluator: Evaluator,
    evaluations: u64,
}

#[pymethods]
impl SwarmField {
    #[new]
    #[pyo3(signature = (preset = "R3", agents = 2, *, threads = 0))]
    fn new(preset: &str, agents: usize, threads: usize) -> PyResult<Self> {
        let refused = |why: &dyn std::fmt::Display| PyValueError::new_err(why.to_string());
        let preset = ebts::files::preset(preset).map_err(|why| refused(&why))?;
        let rule = FitnessRule::default_for(&preset);
        let model = Model::new(preset).map_err(|why| refused(&why))?;
        let team = TeamSize::new(agents).map_err(|why| refused(&why))?;
        Self::of(Condition::new(Arc::new(model), team, rule), threads)
    }

    /// Number of bits of a genome.
    #[getter]
    fn bits(&self) -> usize {
        self.condition.genome_bits()
    }

    /// Number of goals; each earns at most 100 points.
    #[getter]
    fn goals(&self) -> usize {
        GOALS
    }

    /// Number of genomes evaluated so far.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Points per goal of a batch of genomes, an array of float32 (genomes, goals). The fitness is
    /// the sum of a row.
    ///
    /// `genomes` is an array of bool or uint8 (genomes, bits) of zeros and ones.
    fn points<'py>(
        &mut self,
        py: Python<'py>,
        genomes: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let judged = self.judge(py, genomes)?;
        let points: Vec<f32> = judged.iter().flat_map(|one| one.points).collect();
        PyArray1::from_vec(py, points).reshape([judged.len(), GOALS])
    }

    /// Fitness of a batch of genomes, an array of float32; see `points`.
    fn fitness<'py>(
        &mut self,
        py: Python<'py>,
        genomes: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let judged = self.judge(py, genomes)?;
        Ok(PyArray1::from_iter(
            py,
            judged.iter().map(Individual::fitness),
        ))
    }

    /// Writes a genome as a table file for `ebts show`, `replay` and `agents`. Replaces the file.
    fn save(&mut self, py: Python<'_>, genome: &Bound<'_, PyAny>, path: PathBuf) -> PyResult<()> {
        let genome = genome.call_method1("reshape", ((1, -1),))?;
        let mut judged = self.judge(py, &genome)?;
        let individual = judged
            .pop()
            .ok_or_else(|| PyValueError::new_err("genome rejected: it is empty"))?;
        let file = TableFile {
            condition: self.condition.clone(),
            origin: None,
            edited: false,
            code_version: env!("CARGO_PKG_VERSION").to_owned(),
            individual,
        };
        file.write(&path)
            .map_err(|why| PyValueError::new_err(why.to_string()))
    }

    /// Reads a table file; returns its field and its genome, an array of uint8 (bits).
    #[staticmethod]
    fn load<'py>(py: Python<'py>, path: PathBuf) -> PyResult<(Self, Bound<'py, PyArray1<u8>>)> {
        let file = TableFile::read(&path).map_err(|why| PyValueError::new_err(why.to_string()))?;
        let genome = &file.individual.genome;
        let bits = (0..genome.len()).map(|bit| u8::from(genome.get(bit)));
        let bits = PyArray1::from_iter(py, bits);
        Ok((Self::of(file.condition, 0)?, bits))
    }

    fn __repr__(&self) -> String {
        format!(
            "<atas.SwarmField {:?}, {} agents: genomes of {} bits, {} evaluated>",
            self.condition.model.preset().name,
            self.condition.team.get(),
            self.condition.genome_bits(),
            self.evaluations
        )
    }
}

impl SwarmField {
    fn of(condition: Condition, threads: usize) -> PyResult<Self> {
        let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let threads = if threads == 0 { cores() } else { threads };
        let workers = Workers::new(Engine::fastest(), threads, Arc::new(AtomicBool::new(false)));
        let workers = workers.map_err(|why| PyValueError::new_err(why.to_string()))?;
        let evaluator = Evaluator::new(condition.clone(), workers, 1);
        Ok(Self {
            condition,
            evaluator,
            evaluations: 0,
        })
    }

    fn judge(&mut self, py: Python<'_>, genomes: &Bound<'_, PyAny>) -> PyResult<Vec<Individual>> {
        let genomes = genomes_of(genomes, self.condition.genome_bits())?;
        self.evaluations += genomes.len() as u64;
        let evaluator = &mut self.evaluator;
        let judged = compute(py, || evaluator.evaluate(vec![genomes]))?;
        judged
            .and_then(|mut runs| runs.pop())
            .ok_or_else(|| AtasError::new_err("the evaluation was stopped"))
    }
}

/// The genetic algorithm of the paper as ask and tell: roulette selection, uniform crossover,
/// mutation, elites.
///
/// Call `ask` for a batch of genomes and `tell` with their fitness, in turn. `stream` selects the
/// random numbers together with `seed`; `ebts evolve` uses the number of agents, so that equal
/// fitness gives the run of `ebts evolve --seed`.
#[pyclass(module = "atas")]
pub(crate) struct SwarmSearch {
    population: Population,
    bits: usize,
    asked: Option<Vec<Genome>>,
    generation: u64,
}

#[pymethods]
impl SwarmSearch {
    #[new]
    #[pyo3(signature = (bits, *, seed = 0, stream = 2, population = 10, elite = 2, mutation_rate = 0.01))]
    fn new(
        bits: usize,
        seed: u64,
        stream: u64,
        population: usize,
        elite: usize,
        mutation_rate: f64,
    ) -> PyResult<Self> {
        if !(1..=BITS_MAX).contains(&bits) {
            return Err(PyValueError::new_err(format!(
                "search rejected: a genome of {bits} bits, needs 1 to {BITS_MAX}"
            )));
        }
        let settings = Settings {
            population,
            elite,
            mutation_rate,
        };
        let numbers = SplitMix64::stream(&[seed, stream, 0]);
        let population = Population::new(settings, bits, numbers);
        Ok(Self {
            population: population.map_err(|why| PyValueError::new_err(why.to_string()))?,
            bits,
            asked: None,
            generation: 0,
        })
    }

    /// Genomes to evaluate next, an array of uint8 (population, bits) of zeros and ones.
    fn ask<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        if self.asked.is_some() {
            return Err(PyRuntimeError::new_err(
                "the last batch has no fitness yet; call `tell` first",
            ));
        }
        let genomes = self.population.propose();
        let array = array_of(py, &genomes, self.bits);
        self.asked = Some(genomes);
        array
    }

    /// Takes the fitness of the genomes of the last `ask`, in their order: finite numbers of at
    /// least 0, float32 or float64. Selects the next population.
    fn tell(&mut self, fitness: &Bound<'_, PyAny>) -> PyResult<()> {
        let fitness = fitness_of(fitness)?;
        let Some(asked) = &self.asked else {
            return Err(PyRuntimeError::new_err(
                "no batch waits for its fitness; call `ask` first",
            ));
        };
        if fitness.len() != asked.len() {
            return Err(PyValueError::new_err(format!(
                "fitness rejected: {} numbers for {} genomes",
                fitness.len(),
                asked.len()
            )));
        }
        let is_valid = |value: &f32| value.is_finite() && *value >= 0.0;
        if let Some(index) = fitness.iter().position(|value| !is_valid(value)) {
            return Err(PyValueError::new_err(format!(
                "fitness rejected: number {index} is {}, needs a finite number of at least 0",
                fitness[index]
            )));
        }
        let genomes = self.asked.take().unwrap_or_default();
        let judged = genomes.into_iter().zip(fitness).map(|(genome, fitness)| {
            let mut points = [0.0; GOALS];
            points[0] = fitness;
            Individual { genome, points }
        });
        self.population.select(judged.collect());
        self.generation += 1;
        Ok(())
    }

    /// Best genome so far, an array of uint8 (bits), and its fitness.
    #[getter]
    fn best<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray1<u8>>, f32)> {
        let best = self.population.members().first().ok_or_else(|| {
            PyRuntimeError::new_err("no genome has a fitness yet; call `ask` and `tell` first")
        })?;
        let bits = (0..self.bits).map(|bit| u8::from(best.genome.get(bit)));
        Ok((PyArray1::from_iter(py, bits), best.fitness()))
    }

    /// Number of calls of `tell`.
    #[getter]
    fn generation(&self) -> u64 {
        self.generation
    }

    /// Number of bits of a genome.
    #[getter]
    fn bits(&self) -> usize {
        self.bits
    }

    fn __repr__(&self) -> String {
        let best = self.population.members().first();
        let best = best.map_or_else(
            || "no fitness yet".to_owned(),
            |best| format!("best fitness {:.1}", best.fitness()),
        );
        format!(
            "<atas.SwarmSearch of {} bits: generation {}, {best}>",
            self.bits, self.generation
        )
    }
}

/// Largest genome of a search, bits. Design choice: a thousand times that of a team of four.
const BITS_MAX: usize = 512_000;

/// Reads a batch of genomes in place.
fn genomes_of(genomes: &Bound<'_, PyAny>, bits: usize) -> PyResult<Vec<Genome>> {
    // A bool is one byte of 0 or 1: a view, not a copy.
    let viewed = match genomes.getattr("dtype") {
        Ok(form) if form.str()? == "bool" => genomes.call_method1("view", ("uint8",))?,
        _ => genomes.clone(),
    };
    let array: Bits<'_> = viewed.extract().map_err(|_| {
        PyTypeError::new_err(
            "genomes rejected: needs an array of bool or uint8 with the shape (genomes, bits)",
        )
    })?;
    let view = array.as_array();
    let (count, given) = view.dim();
    if given != bits {
        return Err(PyValueError::new_err(format!(
            "genomes rejected: shape ({count}, {given}), needs ({count}, {bits})"
        )));
    }
    let read = view.outer_iter().enumerate().map(|(row, values)| {
        let mut genome = Genome::zero(bits);
        for (bit, value) in values.iter().enumerate() {
            match value {
                0 => {}
                1 => genome.set(bit, true),
                other => {
                    return Err(PyValueError::new_err(format!(
                        "genomes rejected: bit {bit} of genome {row} is {other}, needs 0 or 1"
                    )));
                }
            }
        }
        Ok(genome)
    });
    read.collect()
}

fn array_of<'py>(
    py: Python<'py>,
    genomes: &[Genome],
    bits: usize,
) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let values = genomes
        .iter()
        .flat_map(|genome| (0..bits).map(|bit| u8::from(genome.get(bit))));
    PyArray1::from_vec(py, values.collect()).reshape([genomes.len(), bits])
}

fn fitness_of(fitness: &Bound<'_, PyAny>) -> PyResult<Vec<f32>> {
    if let Ok(short) = fitness.extract::<PyReadonlyArray1<'_, f32>>() {
        return Ok(short.as_array().to_vec());
    }
    let long: PyReadonlyArray1<'_, f64> = fitness.extract().map_err(|_| {
        PyTypeError::new_err("fitness rejected: needs a one-dimensional array of numbers")
    })?;
    Ok(long.as_array().iter().map(|value| *value as f32).collect())
}
