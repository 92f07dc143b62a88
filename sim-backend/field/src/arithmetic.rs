//! Comparisons whose bits do not depend on the engine, and what they compare with.

/// Below this squared distance two centres coincide; keeps `0 / 0` out of the contact direction (ours).
pub(crate) const COINCIDENT_SQ: f32 = 1e-12;

/// `max` and `min` as the SIMD instructions define them, so that the bits agree.
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
