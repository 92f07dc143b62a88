//! Reduction of a mesh by vertex clustering: corners in one cell of a grid become one.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

/// Cells along the longest side of the first grid, and the factor between grids. Design choice.
const CELLS: f64 = 32.0;
const COARSER: f64 = 0.8;

/// Returns corners and triangles of the finest grid with at most `most` triangles. A mesh that is
/// small enough stays unchanged.
pub(crate) fn reduce(
    points: &[Point3<f64>],
    triangles: Vec<[usize; 3]>,
    most: usize,
) -> (Vec<Point3<f64>>, Vec<[usize; 3]>) {
    if triangles.len() <= most {
        return (points.to_vec(), triangles);
    }
    let (low, size) = bounds(points);
    let mut cells = CELLS;
    loop {
        let cell = (size.max() / cells).max(f64::MIN_POSITIVE);
        let (merged, fewer) = cluster(points, &triangles, &low, cell);
        if fewer.len() <= most || cells < 1.0 {
            return (merged, fewer);
        }
        cells *= COARSER;
    }
}

fn bounds(points: &[Point3<f64>]) -> (Point3<f64>, Vector3<f64>) {
    let first = points.first().copied().unwrap_or_else(Point3::origin);
    let (low, high) = points.iter().fold((first, first), |(low, high), point| {
        (low.inf(point), high.sup(point))
    });
    (low, high - low)
}

/// Merges the corners of each cell into their mean; triangles without area vanish.
fn cluster(
    points: &[Point3<f64>],
    triangles: &[[usize; 3]],
    low: &Point3<f64>,
    cell: f64,
) -> (Vec<Point3<f64>>, Vec<[usize; 3]>) {
    let mut index_of = HashMap::new();
    let mut sums: Vec<(Vector3<f64>, f64)> = Vec::new();
    let merged: Vec<usize> = points
        .iter()
        .map(|point| {
            let key = (point - low).map(|along| (along / cell) as u32);
            let index = *index_of.entry([key.x, key.y, key.z]).or_insert_with(|| {
                sums.push((Vector3::zeros(), 0.0));
                sums.len() - 1
            });
            sums[index].0 += point.coords;
            sums[index].1 += 1.0;
            index
        })
        .collect();
    let fewer = triangles.iter().map(|corners| corners.map(|at| merged[at]));
    let mut fewer: Vec<_> = fewer
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    // Equal triangles are drawn once: the smallest corner comes first, which keeps the direction.
    for corners in &mut fewer {
        let least = (0..3).min_by_key(|at| corners[*at]).unwrap_or(0);
        corners.rotate_left(least);
    }
    fewer.sort_unstable();
    fewer.dedup();
    let points = sums.iter().map(|(sum, count)| Point3::from(sum / *count));
    (points.collect(), fewer)
}
