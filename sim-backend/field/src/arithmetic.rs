//! Comparisons whose bits do not depend on the engine.

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
