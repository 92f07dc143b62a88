//! Comparison of every instruction set with scalars, bit for bit.

use super::*;
use crate::random::Random;

const SPECIAL: [f64; 8] = [
    0.0,
    -0.0,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
    f64::MIN_POSITIVE,
    -1.5,
    1e300,
];

fn rows(random: &mut Random) -> [Row; 2] {
    let mut number = || {
        let pick = random.between(0.0, 16.0) as usize;
        let ordinary = random.between(-2.0, 2.0);
        SPECIAL.get(pick).copied().unwrap_or(ordinary)
    };
    [0, 1].map(|_| core::array::from_fn(|_| number()))
}

fn same(got: Row, expected: [f64; LANES], what: &str, of: [Row; 2]) {
    for (got, expected) in got.into_iter().zip(expected) {
        let same = got.to_bits() == expected.to_bits() || got.is_nan() && expected.is_nan();
        assert!(same, "{what} of {of:?}: {got}, expected {expected}");
    }
}

fn as_scalars<L: Lanes>(cpu: L::Cpu) {
    let mut random = Random::new(11, 0);
    for _ in 0..2_000 {
        let of = rows(&mut random);
        let [a, b] = of;
        let each = |of: &dyn Fn(f64, f64) -> f64| core::array::from_fn(|lane| of(a[lane], b[lane]));
        let (x, y) = (L::load(cpu, &a), L::load(cpu, &b));
        same((x + y).store(), each(&|a, b| a + b), "sum", of);
        same((x - y).store(), each(&|a, b| a - b), "difference", of);
        same((x * y).store(), each(&|a, b| a * b), "product", of);
        same((x / y).store(), each(&|a, b| a / b), "quotient", of);
        same(
            x.abs().sqrt().store(),
            each(&|a, _| a.abs().sqrt()),
            "root",
            of,
        );
        same(L::splat(cpu, a[1]).store(), [a[1]; LANES], "splat", of);
        let (above, at_most) = (x.above(y), x.at_most(y));
        let larger = each(&|a, b| if a > b { a } else { b });
        same(L::select(above, x, y).store(), larger, "larger", of);
        let lanes = |is: &dyn Fn(f64, f64) -> bool| {
            (0..LANES)
                .filter(|lane| is(a[*lane], b[*lane]))
                .collect::<Vec<_>>()
        };
        assert_eq!(
            L::set(above).collect::<Vec<_>>(),
            lanes(&|a, b| a > b),
            "{of:?}"
        );
        assert_eq!(
            L::set(at_most).collect::<Vec<_>>(),
            lanes(&|a, b| a <= b),
            "{of:?}"
        );
        assert!(L::set(above & at_most).is_empty(), "{of:?}");
    }
}

#[test]
fn lanes_equal_scalars() {
    as_scalars::<portable::Numbers>(());
    #[cfg(target_arch = "x86_64")]
    if let Some(cpu) = avx2::Cpu::detect() {
        as_scalars::<avx2::Numbers>(cpu);
    }
}

#[test]
fn lane_vectors_equal_vectors() {
    let mut random = Random::new(12, 0);
    let mut vector_of = || Vector3::from_fn(|_, _| random.between(-2.0, 2.0));
    for _ in 0..500 {
        let (a, b) = (vector_of(), vector_of());
        let by = Matrix3::from_columns(&[vector_of(), vector_of(), vector_of()]);
        let (x, y) = (
            Vectors::<portable::Numbers>::splat((), &a),
            Vectors::splat((), &b),
        );
        assert_eq!(vector(&(x + y).store(), 0), a + b);
        assert_eq!(vector(&(x - y).store(), 1), a - b);
        assert_eq!(vector(&x.cross(y).store(), 2), a.cross(&b));
        assert_eq!(vector(&x.rotated((), &by).store(), 3), by * a);
        assert_eq!(x.dot(y).store(), [a.dot(&b); LANES]);
    }
}
