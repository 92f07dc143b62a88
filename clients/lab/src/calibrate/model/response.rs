//! Fit of gain, latency, hysteresis and creep to a recording with a known force.
//!
//! `calibration(readings) = creep(hysteresis(force(t − latency)))`. The left side is linear in its
//! coefficients: for every choice of the three effects, least squares give them. The effects are
//! found by a coarse search on a grid, then by smaller and smaller steps. Only rows of the first
//! half take part; the second half measures the residual.

use atas_sensors::calibration::NormalEquations;
use sim_backend::{Creep, Hysteresis};

use super::series::Series;

/// Candidate ridges of the calibration, relative to the sum of squares of each term, as of
/// `atas calibrate fit`.
const RIDGES: [f64; 5] = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3];
/// Ridge of the first search (design choice: the middle one).
const FIRST_RIDGE: f64 = 1e-5;
/// Share of the first half that trains the choice of the ridge; the rest of it compares them.
const TRAINING_SHARE: f64 = 2.0 / 3.0;
/// Grid of each effect: lowest value, highest value, number of steps.
const LATENCY_S: ([f64; 2], usize) = ([-0.5, 0.5], 10);
const HYSTERESIS: ([f64; 2], usize) = ([0.0, 0.2], 5);
const CREEP: ([f64; 2], usize) = ([-0.1, 0.2], 6);
/// Halvings of the step after the grid. Design choice: to 1/64 of a step.
const HALVINGS: usize = 6;

/// Effects of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Effects {
    /// Time from the force to the reading, s; negative if the reference is the later one.
    pub(super) latency_s: f64,
    pub(super) hysteresis: f64,
    pub(super) creep_per_decade: f64,
}

/// Result of a fit.
#[derive(Clone, Debug)]
pub(super) struct Response {
    pub(super) effects: Effects,
    /// Largest force of the first half, N: full scale of the hysteresis.
    pub(super) full_scale_n: f64,
    /// Calibrated reading of every row, N.
    pub(super) reading_n: Vec<f64>,
    /// Calibrated reading minus model, per row, N.
    pub(super) residual_n: Vec<f64>,
    /// Change of the calibrated reading at rest per unit of each column, N.
    pub(super) newtons_per_unit: Vec<f64>,
    /// Root mean square of the residual in both halves, N.
    pub(super) rms_n: [f64; 2],
}

/// Highest powers of the calibration of several columns. Design choice: squares, as in `atas
/// calibrate fit`, and cubes; single columns are linear.
const DEGREES: [i32; 2] = [2, 3];

/// Search over the effects of a recording.
pub(super) struct Search<'a> {
    series: &'a Series,
    /// Terms of the calibration per row.
    terms: Vec<Vec<f64>>,
    half: usize,
    full_scale_n: f64,
    /// Largest magnitude of each column in the first half.
    scale: Vec<f64>,
    ridge: f64,
    /// Sums over the first half; the values are added for each choice of effects.
    sums: NormalEquations,
}

impl<'a> Search<'a> {
    /// Returns the search whose degree and ridge predict the last third of the first half best;
    /// `None` if the readings do not determine the gain.
    pub(super) fn new(series: &'a Series) -> Option<Self> {
        let degrees = DEGREES
            .iter()
            .take(if series.readings[0].len() > 1 { 2 } else { 1 });
        let searches = degrees.filter_map(|degree| Self::with_degree(series, *degree).validated());
        let best = searches.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, search)| search)
    }

    /// Chooses the ridge; returns the error on the last third of the first half, N.
    fn validated(mut self) -> Option<(f64, Self)> {
        let effects = self.best([true; 3])?.effects;
        let model_n = model_n(self.series, &effects, self.full_scale_n);
        let trained = (TRAINING_SHARE * self.half as f64) as usize;
        let sums = sums(&self.terms[..trained]);
        let error_n = |ridge: &f64| {
            let coefficients = self.coefficients(&sums, &model_n[..trained], *ridge)?;
            let rows = trained..self.half;
            let errors = rows.map(|row| dot(&self.terms[row], &coefficients) - model_n[row]);
            Some(rms(&errors.collect::<Vec<_>>()))
        };
        let errors = RIDGES
            .iter()
            .map(|ridge| (error_n(ridge).unwrap_or(f64::INFINITY), *ridge));
        let (error_n, ridge) = errors.min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.ridge = ridge;
        Some((error_n, self))
    }

    fn with_degree(series: &'a Series, degree: i32) -> Self {
        let half = series.readings.len() / 2;
        let columns = series.readings[0].len();
        let scale: Vec<f64> = (0..columns)
            .map(|column| {
                let values = series.readings[..half].iter().map(|row| row[column].abs());
                values.fold(1e-12, f64::max)
            })
            .collect();
        let zero = zero(series, half);
        let rows = series.readings.iter();
        let terms: Vec<_> = rows.map(|row| terms(row, &zero, &scale, degree)).collect();
        let largest_n = series.force_n[..half]
            .iter()
            .fold(0.0_f64, |most, n| most.max(n.abs()));
        Self {
            series,
            sums: sums(&terms[..half]),
            terms,
            half,
            full_scale_n: largest_n.max(1e-6),
            scale,
            ridge: FIRST_RIDGE,
        }
    }

    /// Returns the best effects; `free` selects those that may differ from zero.
    pub(super) fn best(&self, free: [bool; 3]) -> Option<Response> {
        let mut best = (f64::INFINITY, Effects::default());
        let values = |free: bool, ([low, high], steps): ([f64; 2], usize)| -> Vec<f64> {
            let at = |step: usize| low + (high - low) * step as f64 / steps as f64;
            if free {
                (0..=steps).map(at).collect()
            } else {
                vec![0.0]
            }
        };
        for latency_s in values(free[0], LATENCY_S) {
            for hysteresis in values(free[1], HYSTERESIS) {
                for creep_per_decade in values(free[2], CREEP) {
                    let effects = Effects {
                        latency_s,
                        hysteresis,
                        creep_per_decade,
                    };
                    self.compare(effects, &mut best);
                }
            }
        }
        self.refine(free, &mut best);
        self.fit(best.1)
    }

    fn refine(&self, free: [bool; 3], best: &mut (f64, Effects)) {
        let step = |([low, high], steps): ([f64; 2], usize)| (high - low) / steps as f64;
        let mut steps = [step(LATENCY_S), step(HYSTERESIS), step(CREEP)];
        for _ in 0..HALVINGS {
            steps.iter_mut().for_each(|step| *step /= 2.0);
            // Twice, because the effects depend on each other.
            for effect in [0, 1, 2, 0, 1, 2] {
                if !free[effect] {
                    continue;
                }
                for sign in [-1.0, 1.0] {
                    let mut effects = best.1;
                    let moved = match effect {
                        0 => &mut effects.latency_s,
                        1 => &mut effects.hysteresis,
                        _ => &mut effects.creep_per_decade,
                    };
                    *moved += sign * steps[effect];
                    effects.hysteresis = effects.hysteresis.clamp(HYSTERESIS.0[0], HYSTERESIS.0[1]);
                    effects.creep_per_decade =
                        effects.creep_per_decade.clamp(CREEP.0[0], CREEP.0[1]);
                    self.compare(effects, best);
                }
            }
        }
    }

    fn compare(&self, effects: Effects, best: &mut (f64, Effects)) {
        if let Some(rms_n) = self.fit(effects).map(|fit| fit.rms_n[0])
            && rms_n < best.0
        {
            *best = (rms_n, effects);
        }
    }

    /// Returns the calibration that maps the first rows to these forces.
    fn coefficients(
        &self,
        sums: &NormalEquations,
        model_n: &[f64],
        ridge: f64,
    ) -> Option<Vec<f64>> {
        let rows = self.terms.iter().zip(model_n);
        let equations = sums.with_values(rows.map(|(terms, n)| (&terms[..], *n)));
        equations.solve(&equations.scaled(ridge))
    }

    /// Fits the calibration for these effects; `None` if the readings do not determine it.
    fn fit(&self, effects: Effects) -> Option<Response> {
        let model_n = model_n(self.series, &effects, self.full_scale_n);
        let coefficients = self.coefficients(&self.sums, &model_n[..self.half], self.ridge)?;
        let reading_n: Vec<f64> = self.terms.iter().map(|of| dot(of, &coefficients)).collect();
        let residual_n: Vec<f64> = reading_n.iter().zip(&model_n).map(|(a, b)| a - b).collect();
        let (fitted, held_out) = residual_n.split_at(self.half);
        let slopes = coefficients[1..].iter().zip(&self.scale);
        let newtons_per_unit = slopes.map(|(slope, scale)| slope / scale);
        Some(Response {
            effects,
            full_scale_n: self.full_scale_n,
            newtons_per_unit: newtons_per_unit.collect(),
            rms_n: [rms(fitted), rms(held_out)],
            reading_n,
            residual_n,
        })
    }
}

fn dot(terms: &[f64], coefficients: &[f64]) -> f64 {
    terms.iter().zip(coefficients).map(|(a, b)| a * b).sum()
}

/// Returns the mean of the rows of the first half whose force is nearest to zero.
fn zero(series: &Series, half: usize) -> Vec<f64> {
    let least_n = series.force_n[..half]
        .iter()
        .fold(f64::INFINITY, |least, n| least.min(n.abs()));
    let at_rest = |row: &usize| series.force_n[*row].abs() <= least_n + 1e-9;
    let rows: Vec<usize> = (0..half).filter(at_rest).collect();
    let mean = |column: usize| {
        let sum: f64 = rows.iter().map(|row| series.readings[*row][column]).sum();
        sum / rows.len().max(1) as f64
    };
    (0..series.readings[0].len()).map(mean).collect()
}

/// Returns 1 and the scaled values; of several columns also their powers.
fn terms(row: &[f64], zero: &[f64], scale: &[f64], degree: i32) -> Vec<f64> {
    let values = row.iter().zip(zero).zip(scale);
    let values: Vec<f64> = values
        .map(|((value, zero), scale)| (value - zero) / scale)
        .collect();
    let degree = if values.len() > 1 { degree } else { 1 };
    let powers = (1..=degree).flat_map(|power| values.iter().map(move |v| v.powi(power)));
    core::iter::once(1.0).chain(powers).collect()
}

fn sums(terms: &[Vec<f64>]) -> NormalEquations {
    let mut sums = NormalEquations::new(terms.first().map_or(0, Vec::len));
    terms.iter().for_each(|terms| sums.add(terms, 0.0));
    sums
}

/// Returns the force as a sensor with these effects measures it, per row, N.
pub(super) fn model_n(series: &Series, effects: &Effects, full_scale_n: f64) -> Vec<f64> {
    let hysteresis = Hysteresis::new(effects.hysteresis, full_scale_n, true);
    let mut model_n = Vec::with_capacity(series.time_s.len());
    for group in series.ranges() {
        let (time_s, force_n) = (&series.time_s[group.clone()], &series.force_n[group]);
        let mut play_n = hysteresis.initial();
        let mut creep = Creep::new(effects.creep_per_decade, 0.0);
        let mut delayed_n = creep.initial();
        let (mut before_s, mut period_s) = (time_s.first().copied().unwrap_or(0.0), 0.0);
        for now_s in time_s {
            let elapsed_s = now_s - before_s;
            before_s = *now_s;
            if (elapsed_s - period_s).abs() > 1e-9 {
                period_s = elapsed_s;
                creep = Creep::new(effects.creep_per_decade, period_s);
            }
            let force_n = force_at(time_s, force_n, now_s - effects.latency_s);
            let worked_n = hysteresis.advance(&mut play_n, force_n);
            model_n.push(creep.advance(&mut delayed_n, worked_n));
        }
    }
    model_n
}

/// Returns the force at a time by linear interpolation; constant outside the recording.
fn force_at(time_s: &[f64], force_n: &[f64], at_s: f64) -> f64 {
    let after = time_s.partition_point(|time_s| *time_s < at_s);
    let last = time_s.len() - 1;
    if after == 0 || after > last {
        return force_n[after.min(last)];
    }
    let (early_s, late_s) = (time_s[after - 1], time_s[after]);
    let share = if late_s > early_s {
        (at_s - early_s) / (late_s - early_s)
    } else {
        1.0
    };
    force_n[after - 1] + (force_n[after] - force_n[after - 1]) * share
}

pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
