//! Rows: one value per element of a fingertip, in SIMD vectors of four lanes.
//!
//! Each lane computes the scalar result without fused operations, and [`sum`] adds the lanes in one
//! fixed order. The instruction set of the machine therefore changes no bit.

use core::ops::{AddAssign, Range};
use nalgebra::Vector3;
use shm_schemas::capacity::ELEMENTS;
pub(super) use wide::f64x4 as Lanes;

/// Values per group.
pub(super) const LANES: usize = 4;
/// Validity bits of one group of elements.
pub(super) const LANES_MASK: u64 = (1 << LANES) - 1;

/// Returns the sum of all lanes.
#[inline(always)]
pub(super) fn sum(lanes: Lanes) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + c) + (b + d)
}

/// Keeps the lanes above a limit; the others become 0.
#[inline(always)]
pub(super) fn keep_above(lanes: Lanes, limit: f64) -> Lanes {
    lanes & lanes.simd_gt(Lanes::splat(limit))
}

/// Returns 1/x where x > 0, otherwise 0.
#[inline(always)]
pub(super) fn positive_inverse(lanes: Lanes) -> Lanes {
    (Lanes::splat(1.0) / lanes) & lanes.simd_gt(Lanes::ZERO)
}

/// Replaces the lanes whose bit in `kept` is 0.
pub(super) fn replace(lanes: &mut Lanes, kept: u64, by: Lanes) {
    let pairs = lanes.as_mut_array().iter_mut().zip(by.to_array());
    for (lane, (value, by)) in pairs.enumerate() {
        if kept >> lane & 1 == 0 {
            *value = by;
        }
    }
}

/// One value per element; 0 beyond the last element.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Row([Lanes; ELEMENTS / LANES]);

impl Row {
    pub(super) const GROUPS: usize = ELEMENTS / LANES;

    /// Groups of the first `count` elements.
    #[inline(always)]
    pub(super) fn groups(count: usize) -> Range<usize> {
        0..count.div_ceil(LANES).min(Self::GROUPS)
    }

    #[inline(always)]
    pub(super) fn group(&self, group: usize) -> Lanes {
        self.0[group]
    }

    #[inline(always)]
    pub(super) fn group_mut(&mut self, group: usize) -> &mut Lanes {
        &mut self.0[group]
    }

    #[inline(always)]
    pub(super) fn get(&self, element: usize) -> f64 {
        self.0[element / LANES].as_array()[element % LANES]
    }

    #[inline(always)]
    pub(super) fn set(&mut self, element: usize, value: f64) {
        self.0[element / LANES].as_mut_array()[element % LANES] = value;
    }

    /// Returns the sum over the first `count` elements.
    #[inline(always)]
    pub(super) fn sum(&self, count: usize) -> f64 {
        let mut lanes = Lanes::ZERO;
        for group in Self::groups(count) {
            lanes += self.0[group];
        }
        sum(lanes)
    }
}

impl AddAssign for Row {
    fn add_assign(&mut self, other: Self) {
        for (group, by) in self.0.iter_mut().zip(other.0) {
            *group += by;
        }
    }
}

/// Three values per element, one row for each.
pub(super) type Rows = [Row; 3];

/// Converts from three values per element.
pub(super) fn to_rows(values: &[[f64; 3]]) -> Rows {
    let mut rows = Rows::default();
    for (index, of_element) in values.iter().enumerate() {
        for (row, value) in rows.iter_mut().zip(of_element) {
            row.set(index, *value);
        }
    }
    rows
}

/// Returns the three readings of a group of elements.
#[inline(always)]
pub(super) fn readings(of_elements: &[[f32; 3]; ELEMENTS], group: usize) -> [Lanes; 3] {
    let [a, b, c, d] = of_elements.as_chunks::<LANES>().0[group];
    let axis = |axis: usize| {
        Lanes::new([
            a[axis].into(),
            b[axis].into(),
            c[axis].into(),
            d[axis].into(),
        ])
    };
    [axis(0), axis(1), axis(2)]
}

/// Returns the three values of one element.
#[inline(always)]
pub(super) fn element(rows: &Rows, element: usize) -> [f64; 3] {
    let [x, y, z] = rows;
    [x.get(element), y.get(element), z.get(element)]
}

/// Returns the three values of a group of elements.
#[inline(always)]
pub(super) fn group([x, y, z]: &Rows, group: usize) -> [Lanes; 3] {
    [x.group(group), y.group(group), z.group(group)]
}

/// Sum of one vector per element, in lanes.
#[derive(Clone, Copy, Default)]
pub(super) struct VectorSum([Lanes; 3]);

impl VectorSum {
    #[inline(always)]
    pub(super) fn add(&mut self, vectors: [Lanes; 3]) {
        let ([x, y, z], [by_x, by_y, by_z]) = (self.0, vectors);
        self.0 = [x + by_x, y + by_y, z + by_z];
    }

    #[inline(always)]
    pub(super) fn total(self) -> Vector3<f64> {
        let [x, y, z] = self.0;
        Vector3::new(sum(x), sum(y), sum(z))
    }
}

/// Returns the cross product of two vectors per lane.
#[inline(always)]
pub(super) fn cross([ax, ay, az]: [Lanes; 3], [bx, by, bz]: [Lanes; 3]) -> [Lanes; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

/// Returns the dot product of two vectors per lane.
#[inline(always)]
pub(super) fn dot([ax, ay, az]: &[Lanes; 3], [bx, by, bz]: &[Lanes; 3]) -> Lanes {
    *ax * *bx + *ay * *by + *az * *bz
}

/// Returns the same vector in each lane.
#[inline(always)]
pub(super) fn splat(vector: &Vector3<f64>) -> [Lanes; 3] {
    [
        Lanes::splat(vector.x),
        Lanes::splat(vector.y),
        Lanes::splat(vector.z),
    ]
}
