//! Comparisons with the same bits on every engine.

/// Squared distance of coincident centres, px²; prevents `0 / 0`. Design choice.
pub(crate) const COINCIDENT_SQ: f32 = 1e-12;

/// Maximum as in SIMD instructions; [`lesser`] is the minimum.
#[inline]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
pub(crate) fn clamp(value: f32, limit: f32) -> f32 {
    lesser(greater(value, -limit), limit)
}
