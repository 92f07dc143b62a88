//! Fits a calibration to presses of known total force; estimates its error by cross-validation.

use shm_schemas::Layout;

use super::least_squares::NormalEquations;
use super::{AXES, Calibration, FORMAT, Model, Quality, Silence};

/// Known force and error of the calibrated force, N.
type Pair = ([f64; AXES], [f64; AXES]);

/// Cross-validation folds.
const FOLDS: usize = 5;
/// Expected deviation of element matrices from the shared one, relative to its size. Design choice:
/// gains vary by 3 %, crosstalk is a few per cent.
const ELEMENT_DEVIATION: f64 = 0.05;
/// Candidate ridges of a resultant model, relative to each term's sum of squares, ascending. Design
/// choice: from just resolving undetermined terms to suppressing the measured ones.
const RIDGES: [f64; 7] = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
const ENTRIES: usize = AXES * AXES;

/// One frame of a press.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Values of the fingertip in device units, element by element.
    pub values: Vec<f64>,
    /// Known force `[f_n, f_t1, f_t2]`, N, along the element axes at the fingertip's pole.
    pub force_n: [f64; AXES],
}

/// One press, from contact to release; cross-validation keeps it whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Press {
    /// Frames.
    pub points: Vec<Point>,
}

/// Calibration with its cross-validation errors.
#[derive(Clone, Debug)]
pub struct FitResult {
    /// Calibration.
    pub calibration: Calibration,
    /// Known force and cross-validation error per frame, N.
    pub residuals: Vec<([f64; AXES], [f64; AXES])>,
}

/// Reason why presses cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too few presses.
    #[error(
        "could not calibrate with {0} presses: needs {FOLDS} or more; add presses in different \
         directions and places"
    )]
    TooFewPresses(usize),
    /// Wrong number of values per frame.
    #[error(
        "could not calibrate {found} values per frame: needs {needed}, {AXES} for each element of \
         the layout"
    )]
    Width {
        /// Number found.
        found: usize,
        /// Number needed.
        needed: usize,
    },
    /// A value is not finite.
    #[error(
        "could not calibrate: press {0} holds a number that is not finite; leave that press out"
    )]
    NotFinite(usize),
    /// Missing press directions.
    #[error(
        "could not determine all axes: the presses do not cover every direction; press along the \
         normal and push along both tangential axes"
    )]
    Undetermined,
}

/// Fits a calibration and estimates its error.
///
/// # Errors
/// [`FitError`] with the missing or invalid presses.
pub fn fit(
    presses: &[Press],
    silence: &Silence,
    model: Model,
    layout: &Layout,
    source: &str,
) -> Result<FitResult, FitError> {
    check(presses, silence, model, layout)?;
    let all: Vec<usize> = (0..presses.len()).collect();
    let ridge = select_ridge(presses, &all, silence, model)?;
    let newtons = fit_subset(presses, &all, silence, model, layout, ridge)?;
    let mut calibration = Calibration {
        format: FORMAT,
        source: source.to_owned(),
        model,
        zero: silence.zero.clone(),
        newtons,
        quality: Quality::default(),
        drift: None,
    };
    let mut residuals = Vec::new();
    for fold in 0..FOLDS {
        let (left_out, others) = split_fold(&all, fold);
        // Exclude the left-out presses from fit and ridge.
        let ridge = self::select_ridge(presses, &others, silence, model)?;
        let judged = Calibration {
            newtons: fit_subset(presses, &others, silence, model, layout, ridge)?,
            ..calibration.clone()
        };
        for point in left_out.iter().flat_map(|&press| &presses[press].points) {
            let fitted_n = total_n(&judged, layout, &point.values);
            let error_n = core::array::from_fn(|axis| fitted_n[axis] - point.force_n[axis]);
            residuals.push((point.force_n, error_n));
        }
    }
    let root = |of: fn(&Pair) -> &[f64; AXES], axis: usize| {
        let squares: f64 = residuals.iter().map(|pair| of(pair)[axis].powi(2)).sum();
        (squares / residuals.len() as f64).sqrt()
    };
    let quality = &mut calibration.quality;
    quality.presses = presses.len() as u32;
    quality.ridge = ridge;
    quality.error_n = core::array::from_fn(|axis| root(|pair| &pair.1, axis));
    quality.error_share = core::array::from_fn(|axis| {
        let known_n = root(|pair| &pair.0, axis);
        if known_n > 0.0 {
            quality.error_n[axis] / known_n
        } else {
            0.0
        }
    });
    Ok(FitResult {
        calibration,
        residuals,
    })
}

/// Returns the calibrated total force along the axes at the pole, N.
#[must_use]
pub fn total_n(calibration: &Calibration, layout: &Layout, values: &[f64]) -> [f64; AXES] {
    let mut total_n = [0.0; AXES];
    for element in 0..calibration.elements_out() {
        let force_n = calibration.force_n(element, values);
        let turned = match calibration.model {
            Model::Matrix => rotation_to_pole(layout, element),
            Model::Resultant | Model::ResultantSquares => IDENTITY,
        };
        for (total_n, row) in total_n.iter_mut().zip(turned) {
            *total_n += row.iter().zip(force_n).map(|(p, n)| p * n).sum::<f64>();
        }
    }
    total_n
}

const IDENTITY: [[f64; AXES]; AXES] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns the rotation of `[f_n, f_t1, f_t2]` from an element's axes to the pole's.
fn rotation_to_pole(layout: &Layout, element: usize) -> [[f64; AXES]; AXES] {
    let axes = |element: usize| {
        [
            layout.normal[element].map(|n| -n),
            layout.tangent1[element],
            layout.tangent2[element],
        ]
    };
    let (pole, own) = (axes(0), axes(element));
    let dot = |a: [f64; AXES], b: [f64; AXES]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    core::array::from_fn(|k| core::array::from_fn(|j| dot(pole[k], own[j])))
}

fn check(
    presses: &[Press],
    silence: &Silence,
    model: Model,
    layout: &Layout,
) -> Result<(), FitError> {
    if presses.len() < FOLDS {
        return Err(FitError::TooFewPresses(presses.len()));
    }
    let found = silence.zero.len();
    let needed = match model {
        Model::Matrix => AXES * layout.count,
        Model::Resultant | Model::ResultantSquares => (found / AXES * AXES).max(AXES),
    };
    let widths = presses
        .iter()
        .flat_map(|press| &press.points)
        .map(|p| p.values.len());
    if let Some(found) = widths.chain([found]).find(|&width| width != needed) {
        return Err(FitError::Width { found, needed });
    }
    let is_finite = |point: &Point| {
        let mut numbers = point.values.iter().chain(&point.force_n);
        numbers.all(|number| number.is_finite())
    };
    match presses
        .iter()
        .position(|press| !press.points.iter().all(is_finite))
    {
        Some(press) => Err(FitError::NotFinite(press)),
        None => Ok(()),
    }
}

type Newtons = Vec<[Vec<f64>; AXES]>;

/// Frame minus zero, and its known force, N.
type Known = (Vec<f64>, [f64; AXES]);

fn frames(presses: &[Press], of: &[usize], silence: &Silence) -> Vec<Known> {
    let points = of.iter().flat_map(|&press| &presses[press].points);
    let known = |point: &Point| {
        let pairs = point.values.iter().zip(&silence.zero);
        (pairs.map(|(v, zero)| v - zero).collect(), point.force_n)
    };
    points.map(known).collect()
}

/// Splits presses into the left-out fold and the others.
fn split_fold(of: &[usize], fold: usize) -> (Vec<usize>, Vec<usize>) {
    let places = of.iter().enumerate();
    let (left_out, others): (Vec<_>, Vec<_>) = places.partition(|(place, _)| place % FOLDS == fold);
    let presses = |of: Vec<(usize, &usize)>| of.into_iter().map(|(_, press)| *press).collect();
    (presses(left_out), presses(others))
}

/// Selects the ridge with the smallest error on left-out presses; `None` for the matrix model. Too
/// weak a ridge fits differences in press position as sensor terms.
fn select_ridge(
    presses: &[Press],
    of: &[usize],
    silence: &Silence,
    model: Model,
) -> Result<Option<f64>, FitError> {
    if model == Model::Matrix {
        return Ok(None);
    }
    let mut errors = [0.0; RIDGES.len()];
    for fold in 0..FOLDS {
        let (left_out, others) = split_fold(of, fold);
        let (left_out, others) = (
            frames(presses, &left_out, silence),
            frames(presses, &others, silence),
        );
        let normals = normals(&others, model);
        for (error, ridge) in errors.iter_mut().zip(RIDGES) {
            let rows = solve(&normals, ridge)?;
            for (values, force_n) in &left_out {
                let terms = expand(values, model);
                for (row, force_n) in rows.iter().zip(force_n) {
                    let fitted_n: f64 = row.iter().zip(&terms).map(|(n, term)| n * term).sum();
                    *error += (fitted_n - force_n).powi(2);
                }
            }
        }
    }
    let best = errors.iter().zip(RIDGES).min_by(|a, b| a.0.total_cmp(b.0));
    Ok(best.map(|(_, ridge)| ridge))
}

fn fit_subset(
    presses: &[Press],
    of: &[usize],
    silence: &Silence,
    model: Model,
    layout: &Layout,
    ridge: Option<f64>,
) -> Result<Newtons, FitError> {
    let points = frames(presses, of, silence);
    match ridge {
        None => matrices(&points, layout),
        Some(ridge) => Ok(vec![solve(&normals(&points, model), ridge)?]),
    }
}

/// Fits a shared matrix, then each element's deviation from it.
fn matrices(points: &[Known], layout: &Layout) -> Result<Newtons, FitError> {
    let turns: Vec<_> = (0..layout.count)
        .map(|e| rotation_to_pole(layout, e))
        .collect();
    let shared_row = |values: &[f64], k: usize| {
        let mut row = [0.0; ENTRIES];
        for (turn, value) in turns.iter().zip(values.chunks_exact(AXES)) {
            for (entry, sum) in row.iter_mut().enumerate() {
                *sum += turn[k][entry / AXES] * value[entry % AXES];
            }
        }
        row
    };
    let mut normal = NormalEquations::new(ENTRIES);
    for (values, force_n) in points {
        (0..AXES).for_each(|k| normal.add(&shared_row(values, k), force_n[k]));
    }
    let shared = normal
        .solve(&[0.0; ENTRIES])
        .ok_or(FitError::Undetermined)?;
    let departures = if layout.count == 1 {
        vec![0.0; ENTRIES]
    } else {
        // The deviations are fitted to the shared matrix's residual.
        let left = |values: &[f64], force_n: &[f64; AXES], k: usize| {
            let row = shared_row(values, k);
            force_n[k] - row.iter().zip(&shared).map(|(a, x)| a * x).sum::<f64>()
        };
        let squares: f64 = points
            .iter()
            .flat_map(|(values, force_n)| (0..AXES).map(move |k| left(values, force_n, k).powi(2)))
            .sum();
        let variance = squares / (AXES * points.len()) as f64;
        let size = shared.iter().map(|x| x * x).sum::<f64>() / AXES as f64;
        let mut normal = NormalEquations::new(ENTRIES * layout.count);
        let mut row = vec![0.0; ENTRIES * layout.count];
        for (values, force_n) in points {
            #[expect(
                clippy::needless_range_loop,
                reason = "the axis is one index of several"
            )]
            for k in 0..AXES {
                for (element, value) in values.chunks_exact(AXES).enumerate() {
                    for entry in 0..ENTRIES {
                        row[ENTRIES * element + entry] =
                            turns[element][k][entry / AXES] * value[entry % AXES];
                    }
                }
                normal.add(&row, left(values, force_n, k));
            }
        }
        let ridge = variance / (ELEMENT_DEVIATION * ELEMENT_DEVIATION * size);
        normal
            .solve(&vec![ridge.max(f64::MIN_POSITIVE); ENTRIES * layout.count])
            .unwrap_or_else(|| vec![0.0; ENTRIES * layout.count])
    };
    let matrix = |own: &[f64]| {
        core::array::from_fn(|j| {
            (0..AXES)
                .map(|i| shared[AXES * j + i] + own[AXES * j + i])
                .collect()
        })
    };
    Ok(departures.chunks_exact(ENTRIES).map(matrix).collect())
}

fn expand(values: &[f64], model: Model) -> Vec<f64> {
    let elements = values.chunks_exact(AXES);
    elements
        .flat_map(|v| {
            model
                .expand([v[0], v[1], v[2]])
                .into_iter()
                .take(model.terms())
        })
        .collect()
}

fn normals(points: &[Known], model: Model) -> [NormalEquations; AXES] {
    let elements = points.first().map_or(0, |(values, _)| values.len() / AXES);
    let mut normals = [(); AXES].map(|()| NormalEquations::new(elements * model.terms()));
    for (values, force_n) in points {
        let row = expand(values, model);
        for (normal, force_n) in normals.iter_mut().zip(force_n) {
            normal.add(&row, *force_n);
        }
    }
    normals
}

fn solve(normals: &[NormalEquations; AXES], ridge: f64) -> Result<[Vec<f64>; AXES], FitError> {
    let mut rows = [const { Vec::new() }; AXES];
    for (row, normal) in rows.iter_mut().zip(normals) {
        *row = normal
            .solve(&normal.scaled(ridge))
            .ok_or(FitError::Undetermined)?;
    }
    Ok(rows)
}
