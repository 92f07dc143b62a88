//! Headings in 64 steps per turn, with literal cosine and sine, independent of mathematics
//! libraries.

/// Steps of one turn. Design choice; the paper prints no turning rate.
pub const HEADINGS: usize = 64;

/// `sin(2πk/64)` for k = 0..=16, rounded to f32; the axes are exact.
const QUARTER_SINE: [f32; 17] = [
    0.0,
    0.098_017_14,
    0.195_090_32,
    0.290_284_66,
    0.382_683_43,
    0.471_396_74,
    0.555_570_24,
    0.634_393_3,
    0.707_106_77,
    0.773_010_43,
    0.831_469_6,
    0.881_921_3,
    0.923_879_5,
    0.956_940_35,
    0.980_785_25,
    0.995_184_7,
    1.0,
];

/// `cos(2πk/64)`. SIMD look-ups rely on the second half being the negated first.
pub(crate) static COSINE: [f32; HEADINGS] = cosines();

const fn cosines() -> [f32; HEADINGS] {
    let mut table = [0.0; HEADINGS];
    let mut k = 0;
    while k <= 16 {
        table[k] = QUARTER_SINE[16 - k];
        k += 1;
    }
    while k < 32 {
        table[k] = -QUARTER_SINE[k - 16];
        k += 1;
    }
    while k < HEADINGS {
        table[k] = -table[k - 32];
        k += 1;
    }
    table
}

/// Returns cosine and sine of a heading, modulo 64.
#[must_use]
#[inline]
pub fn cos_sin(heading: u8) -> (f32, f32) {
    let k = usize::from(heading) % HEADINGS;
    (COSINE[k], COSINE[(k + 48) % HEADINGS])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_unit_vectors_and_axes_exact() {
        for k in 0..64u8 {
            let angle = f64::from(k) * std::f64::consts::TAU / 64.0;
            let (cos, sin) = cos_sin(k);
            assert!(
                (f64::from(cos) - angle.cos()).abs() < 1e-7,
                "cos of step {k}"
            );
            assert!(
                (f64::from(sin) - angle.sin()).abs() < 1e-7,
                "sin of step {k}"
            );
        }
        assert_eq!([cos_sin(0), cos_sin(16)], [(1.0, 0.0), (0.0, 1.0)]);
        assert_eq!([cos_sin(32), cos_sin(48)], [(-1.0, 0.0), (0.0, -1.0)]);
    }
}
