//! Ridge regression by normal equations and Cholesky decomposition.

/// Sums over rows `a·x = b`: `aᵀa` (lower triangle, row by row) and `aᵀb`.
#[derive(Clone, Debug)]
pub struct NormalEquations {
    unknowns: usize,
    squares: Vec<f64>,
    products: Vec<f64>,
}

impl NormalEquations {
    /// Returns empty sums.
    #[must_use]
    pub fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            squares: vec![0.0; unknowns * unknowns],
            products: vec![0.0; unknowns],
        }
    }

    /// Adds a row.
    pub fn add(&mut self, row: &[f64], value: f64) {
        for (i, &a) in row.iter().enumerate() {
            // Elements outside a press contribute nothing.
            if a == 0.0 {
                continue;
            }
            self.products[i] += a * value;
            let line = &mut self.squares[i * self.unknowns..][..=i];
            for (sum, &b) in line.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }

    /// Returns the sums over the same rows with other values, in less time.
    #[must_use]
    pub fn with_values<'a>(&self, rows: impl Iterator<Item = (&'a [f64], f64)>) -> Self {
        let mut products = vec![0.0; self.unknowns];
        for (row, value) in rows {
            for (sum, a) in products.iter_mut().zip(row) {
                *sum += a * value;
            }
        }
        Self {
            products,
            ..self.clone()
        }
    }

    /// Returns `ridge` times each unknown's sum of squares.
    #[must_use]
    pub fn scaled(&self, ridge: f64) -> Vec<f64> {
        let seen = |i: usize| self.squares[i * self.unknowns + i];
        (0..self.unknowns).map(|i| ridge * seen(i)).collect()
    }

    /// Solves the system with a ridge per unknown; returns `None` if it is singular.
    #[must_use]
    pub fn solve(&self, ridge: &[f64]) -> Option<Vec<f64>> {
        let n = self.unknowns;
        let mut lower = self.squares.clone();
        for i in 0..n {
            lower[i * n + i] += ridge[i];
        }
        // L·Lᵀ in place.
        for j in 0..n {
            for i in j..n {
                let dot: f64 = (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum();
                let rest = lower[i * n + j] - dot;
                if i == j {
                    let relative = self.squares[i * n + i] + ridge[i];
                    if !rest.is_finite() || rest <= 1e-12 * relative {
                        return None;
                    }
                    lower[i * n + j] = rest.sqrt();
                } else {
                    lower[i * n + j] = rest / lower[j * n + j];
                }
            }
        }
        let mut x = self.products.clone();
        for i in 0..n {
            let dot: f64 = (0..i).map(|k| lower[i * n + k] * x[k]).sum();
            x[i] = (x[i] - dot) / lower[i * n + i];
        }
        for i in (0..n).rev() {
            let dot: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
            x[i] = (x[i] - dot) / lower[i * n + i];
        }
        x.iter().all(|value| value.is_finite()).then_some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_is_solved_and_singular_system_rejected() {
        let mut normal = NormalEquations::new(3);
        for i in 0..20 {
            let row = [1.0, f64::from(i), f64::from(i * i % 7)];
            normal.add(&row, 2.0 - 0.5 * row[1] + 3.0 * row[2]);
        }
        let found = normal.solve(&[0.0; 3]).expect("a solution");
        for (found, expected) in found.iter().zip([2.0, -0.5, 3.0]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let mut twice = NormalEquations::new(2);
        (1..9).for_each(|i| twice.add(&[f64::from(i), f64::from(2 * i)], 1.0));
        assert_eq!(twice.solve(&[0.0; 2]), None);
        assert!(twice.solve(&[1.0; 2]).is_some());
    }
}
