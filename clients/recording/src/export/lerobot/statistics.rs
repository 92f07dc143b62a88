//! Statistics of a feature, as LeRobot's normalisation expects them.

use super::columns::{Column, Values};

/// Quantiles in the statistics: name and share.
const QUANTILES: [(&str, f64); 5] = [
    ("q01", 0.01),
    ("q10", 0.10),
    ("q50", 0.50),
    ("q90", 0.90),
    ("q99", 0.99),
];

/// Statistics of a feature: name and one value per component; the count has one value.
pub(super) type Statistics = Vec<(&'static str, Vec<f64>)>;

/// Computes the statistics of a column's rows; `None` for texts.
pub(super) fn statistics(column: &Column) -> Option<Statistics> {
    let of = |width: usize, values: Vec<f64>| Some(of_components(width, &values));
    match &column.values {
        Values::Whole(values) => of(1, values.iter().map(|value| *value as f64).collect()),
        Values::Short(values) => of(1, values.iter().copied().map(f64::from).collect()),
        Values::Flag(values) => of(1, values.iter().copied().map(f64::from).collect()),
        Values::Shorts(width, values) => {
            of(*width, values.iter().copied().map(f64::from).collect())
        }
        Values::Numbers(width, values) => of(*width, values.clone()),
        Values::Text(_) | Values::Texts(..) => None,
    }
}

fn of_components(width: usize, values: &[f64]) -> Statistics {
    let rows = values.len() / width.max(1);
    let sorted: Vec<Vec<f64>> = (0..width)
        .map(|component| {
            let mut values: Vec<f64> = values
                .iter()
                .skip(component)
                .step_by(width)
                .copied()
                .collect();
            values.sort_by(f64::total_cmp);
            values
        })
        .collect();
    let each = |of: &dyn Fn(&[f64]) -> f64| sorted.iter().map(|values| of(values)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let deviation = |values: &[f64]| {
        let middle = mean(values);
        let squares = values.iter().map(|value| (value - middle).powi(2));
        (squares.sum::<f64>() / values.len() as f64).sqrt()
    };
    let mut all: Statistics = vec![
        ("min", each(&|values| values[0])),
        ("max", each(&|values| values[values.len() - 1])),
        ("mean", each(&mean)),
        ("std", each(&deviation)),
        ("count", vec![rows as f64]),
    ];
    all.extend(QUANTILES.map(|(name, share)| (name, each(&|values| quantile(values, share)))));
    all
}

/// Interpolates the quantile of sorted values.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (below, above) = (at.floor() as usize, at.ceil() as usize);
    sorted[below] + (sorted[above] - sorted[below]) * (at - at.floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_are_per_component() {
        let rows = vec![0.0, 10.0, 2.0, 10.0, 4.0, 10.0];
        let found = statistics(&Column::new("x", Values::Shorts(2, rows))).expect("numbers");
        let of = |name: &str| {
            &found
                .iter()
                .find(|(known, _)| *known == name)
                .expect(name)
                .1
        };
        assert_eq!(*of("min"), [0.0, 10.0]);
        assert_eq!(*of("max"), [4.0, 10.0]);
        assert_eq!(*of("mean"), [2.0, 10.0]);
        assert_eq!(*of("count"), [3.0]);
        assert!((of("std")[0] - (8.0_f64 / 3.0).sqrt()).abs() < 1e-12 && of("std")[1] == 0.0);
        assert!((of("q90")[0] - 3.6).abs() < 1e-12);
        assert_eq!(
            statistics(&Column::new("x", Values::Text(vec![String::new()]))),
            None
        );
    }
}
