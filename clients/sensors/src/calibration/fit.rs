//! Fits a calibration to presses whose total force is known, and judges it on presses that were left out.

use shm_schemas::Layout;

use super::least_squares::Normal;
use super::{AXES, Calibration, FORMAT, Model, Quality, Silence};

/// A force of the reference, N, and how far what is told is from it, N.
type Pair = ([f64; AXES], [f64; AXES]);

/// Parts that the presses are dealt into for judging: each is left out once.
const FOLDS: usize = 5;
/// How far the matrices of elements may be expected to lie apart, over their size (ours: gains spread by 3 %, crosstalk is a few
/// per cent).
const DEPARTURE: f64 = 0.05;
/// Ridges of a resultant that are tried, over what is seen of each term, the weakest first. Ours: from what only settles what presses
/// do not tell, to what no longer follows them.
const RIDGES: [f64; 7] = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
/// Entries of one element's matrix.
const ENTRIES: usize = AXES * AXES;

/// One frame of a press.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Values of the fingertip in the device's unit, element by element.
    pub values: Vec<f64>,
    /// The known force `[f_n, f_t1, f_t2]` along the axes that an element at the pole of the fingertip has, N.
    pub force_n: [f64; AXES],
}

/// One press, from touch to letting go: never split between fitting and judging.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Press {
    /// Its frames.
    pub points: Vec<Point>,
}

/// A calibration, and how it did on presses that it was not fitted to.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The calibration.
    pub calibration: Calibration,
    /// Known force and error of every frame, N.
    pub residuals: Vec<([f64; AXES], [f64; AXES])>,
}

/// Why presses make no calibration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Too few presses.
    #[error(
        "could not calibrate with {0} presses, needs {FOLDS} or more, in different directions and places"
    )]
    Few(usize),
    /// Widths that do not belong together.
    #[error(
        "could not calibrate {found} values per frame, needs {needed}: {AXES} for each element of the layout"
    )]
    Width {
        /// Found.
        found: usize,
        /// Needed.
        needed: usize,
    },
    /// A number that is none.
    #[error(
        "could not calibrate because press {0} holds a number that is not finite; leave that press out"
    )]
    NotFinite(usize),
    /// Directions that were not pressed.
    #[error(
        "could not tell all axes apart; press along the normal and push along both tangential axes as well"
    )]
    Undetermined,
}

/// Fits and judges.
///
/// # Errors
/// [`FitError`] that says which presses are missing.
pub fn fit(
    presses: &[Press],
    silence: &Silence,
    model: Model,
    layout: &Layout,
    source: &str,
) -> Result<Fitted, FitError> {
    check(presses, silence, model, layout)?;
    let all: Vec<usize> = (0..presses.len()).collect();
    let ridge = ridge(presses, &all, silence, model)?;
    let newtons = fit_some(presses, &all, silence, model, layout, ridge)?;
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
        let (left_out, others) = deal(&all, fold);
        // Neither the fit nor its ridge has seen what it is judged by.
        let ridge = self::ridge(presses, &others, silence, model)?;
        let judged = Calibration {
            newtons: fit_some(presses, &others, silence, model, layout, ridge)?,
            ..calibration.clone()
        };
        for point in left_out.iter().flat_map(|&press| &presses[press].points) {
            let told_n = total_n(&judged, layout, &point.values);
            let error_n = core::array::from_fn(|axis| told_n[axis] - point.force_n[axis]);
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
    Ok(Fitted {
        calibration,
        residuals,
    })
}

/// The total force that a calibration tells, along the axes at the pole, N.
#[must_use]
pub fn total_n(calibration: &Calibration, layout: &Layout, values: &[f64]) -> [f64; AXES] {
    let mut total_n = [0.0; AXES];
    for element in 0..calibration.elements_out() {
        let force_n = calibration.force_n(element, values);
        let turned = match calibration.model {
            Model::Matrix => turn(layout, element),
            Model::Resultant | Model::ResultantSquares => IDENTITY,
        };
        for (total_n, row) in total_n.iter_mut().zip(turned) {
            *total_n += row.iter().zip(force_n).map(|(p, n)| p * n).sum::<f64>();
        }
    }
    total_n
}

const IDENTITY: [[f64; AXES]; AXES] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// From an element's axes to those at the pole: how the force `[f_n, f_t1, f_t2]` of one looks from the other.
fn turn(layout: &Layout, element: usize) -> [[f64; AXES]; AXES] {
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
        return Err(FitError::Few(presses.len()));
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

/// A frame without the silence in it, and its known force, N.
type Known = (Vec<f64>, [f64; AXES]);

/// The frames of some presses.
fn frames(presses: &[Press], of: &[usize], silence: &Silence) -> Vec<Known> {
    let points = of.iter().flat_map(|&press| &presses[press].points);
    let known = |point: &Point| {
        let pairs = point.values.iter().zip(&silence.zero);
        (pairs.map(|(v, zero)| v - zero).collect(), point.force_n)
    };
    points.map(known).collect()
}

/// Some presses as one part that is left out and the others.
fn deal(of: &[usize], fold: usize) -> (Vec<usize>, Vec<usize>) {
    let places = of.iter().enumerate();
    let (left_out, others): (Vec<_>, Vec<_>) = places.partition(|(place, _)| place % FOLDS == fold);
    let presses = |of: Vec<(usize, &usize)>| of.into_iter().map(|(_, press)| *press).collect();
    (presses(left_out), presses(others))
}

/// The ridge that tells presses best which were left out, the weakest of equal ones; `None` for a model that has none. Presses at
/// places that differ a little look like terms that are not there: a ridge that is too weak follows them.
fn ridge(
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
        let (left_out, others) = deal(of, fold);
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
                    let told_n: f64 = row.iter().zip(&terms).map(|(n, term)| n * term).sum();
                    *error += (told_n - force_n).powi(2);
                }
            }
        }
    }
    let best = errors.iter().zip(RIDGES).min_by(|a, b| a.0.total_cmp(b.0));
    Ok(best.map(|(_, ridge)| ridge))
}

fn fit_some(
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

/// One matrix for all elements, then how each departs from it.
fn matrices(points: &[Known], layout: &Layout) -> Result<Newtons, FitError> {
    let turns: Vec<_> = (0..layout.count).map(|e| turn(layout, e)).collect();
    let shared_row = |values: &[f64], k: usize| {
        let mut row = [0.0; ENTRIES];
        for (turn, value) in turns.iter().zip(values.chunks_exact(AXES)) {
            for (entry, sum) in row.iter_mut().enumerate() {
                *sum += turn[k][entry / AXES] * value[entry % AXES];
            }
        }
        row
    };
    let mut normal = Normal::new(ENTRIES);
    for (values, force_n) in points {
        (0..AXES).for_each(|k| normal.add(&shared_row(values, k), force_n[k]));
    }
    let shared = normal
        .solve(&[0.0; ENTRIES])
        .ok_or(FitError::Undetermined)?;
    let departures = if layout.count == 1 {
        vec![0.0; ENTRIES]
    } else {
        // What the shared matrix leaves over is what the elements' own can be asked to explain.
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
        let mut normal = Normal::new(ENTRIES * layout.count);
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
        let ridge = variance / (DEPARTURE * DEPARTURE * size);
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

/// The terms of all values of a fingertip.
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

/// Sums for each axis of one force from all terms.
fn normals(points: &[Known], model: Model) -> [Normal; AXES] {
    let elements = points.first().map_or(0, |(values, _)| values.len() / AXES);
    let mut normals = [(); AXES].map(|()| Normal::new(elements * model.terms()));
    for (values, force_n) in points {
        let row = expand(values, model);
        for (normal, force_n) in normals.iter_mut().zip(force_n) {
            normal.add(&row, *force_n);
        }
    }
    normals
}

/// Each axis of one force, with a ridge over what is seen of each term.
fn solve(normals: &[Normal; AXES], ridge: f64) -> Result<[Vec<f64>; AXES], FitError> {
    let mut rows = [const { Vec::new() }; AXES];
    for (row, normal) in rows.iter_mut().zip(normals) {
        *row = normal
            .solve(&normal.scaled(ridge))
            .ok_or(FitError::Undetermined)?;
    }
    Ok(rows)
}
