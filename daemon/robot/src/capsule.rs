//! Collision capsules of one hand and the clearance between two sets of them.

use core::ops::Deref;

use nalgebra::Vector3;

use crate::transform::Transform;

/// Most capsules of one hand: the two-hand arm has 15 (shoulder, upper arm, forearm, wrist, palm;
/// per finger root, proximal, distal, dome and the stem behind it).
pub const CAPSULES_MAX: usize = 24;

/// All points within `radius_m` of the segment from `a_m` to `b_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Capsule {
    /// One end of the segment, metres.
    pub a_m: Vector3<f64>,
    /// Other end of the segment, metres; equal to `a_m` for a sphere.
    pub b_m: Vector3<f64>,
    /// Radius, metres.
    pub radius_m: f64,
    /// The hand's joint that moves this body.
    pub joint: usize,
}

impl Capsule {
    const EMPTY: Capsule = Capsule {
        a_m: Vector3::new(0.0, 0.0, 0.0),
        b_m: Vector3::new(0.0, 0.0, 0.0),
        radius_m: 0.0,
        joint: 0,
    };
}

impl Capsule {
    /// Returns the smallest capsule around two bodies of one joint whose axis joins two of their
    /// four ends.
    pub(crate) fn enclosing(&self, other: &Self) -> Self {
        let balls = [self, other].map(|of| [(of.a_m, of.radius_m), (of.b_m, of.radius_m)]);
        let balls = balls.as_flattened();
        let mut least = self.between(self.a_m, self.b_m, balls);
        for (index, (a_m, _)) in balls.iter().enumerate() {
            for (b_m, _) in &balls[index + 1..] {
                let about = self.between(*a_m, *b_m, balls);
                if about.volume_m3() < least.volume_m3() {
                    least = about;
                }
            }
        }
        least
    }

    /// Returns the capsule between two points that contains these balls.
    fn between(&self, a_m: Vector3<f64>, b_m: Vector3<f64>, balls: &[(Vector3<f64>, f64)]) -> Self {
        let mut body = Self {
            a_m,
            b_m,
            radius_m: 0.0,
            joint: self.joint,
        };
        for (centre_m, radius_m) in balls {
            let ball = Self {
                a_m: *centre_m,
                b_m: *centre_m,
                radius_m: *radius_m,
                joint: self.joint,
            };
            let reach_m = segment_distance_m(&body, &ball) + radius_m;
            body.radius_m = body.radius_m.max(reach_m);
        }
        body
    }

    /// Returns the volume, m³.
    pub(crate) fn volume_m3(&self) -> f64 {
        let across_m2 = core::f64::consts::PI * self.radius_m * self.radius_m;
        across_m2 * (self.radius_m * 4.0 / 3.0 + (self.b_m - self.a_m).norm())
    }
}

/// Up to [`CAPSULES_MAX`] capsules; reads as a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Capsules {
    shapes: [Capsule; CAPSULES_MAX],
    /// Moving frame of each capsule. Mimicked joints move several.
    frames: [usize; CAPSULES_MAX],
    count: usize,
}

impl Capsules {
    /// Creates an empty set.
    #[must_use]
    pub const fn new() -> Capsules {
        Capsules {
            shapes: [Capsule::EMPTY; CAPSULES_MAX],
            frames: [0; CAPSULES_MAX],
            count: 0,
        }
    }

    /// Adds a capsule of this frame. Returns false if there is no room.
    #[must_use]
    pub fn push(&mut self, capsule: Capsule, frame: usize) -> bool {
        let Some(slot) = self.shapes.get_mut(self.count) else {
            return false;
        };
        *slot = capsule;
        self.frames[self.count] = frame;
        self.count += 1;
        true
    }
}

impl Capsules {
    /// Returns the capsules of a frame.
    pub(crate) fn moved_by(&self, frame: Option<usize>) -> impl Iterator<Item = &Capsule> {
        let bodies = self.iter().zip(self.frames);
        bodies.filter_map(move |(body, of)| (Some(of) == frame).then_some(body))
    }

    /// Returns the bodies in the base frame.
    pub(crate) fn placed(&self, base_from_frame: &[Transform]) -> Self {
        let mut placed = *self;
        for (capsule, frame) in placed.shapes[..placed.count].iter_mut().zip(self.frames) {
            let frame = &base_from_frame[frame];
            capsule.a_m = frame.point(&capsule.a_m);
            capsule.b_m = frame.point(&capsule.b_m);
        }
        placed
    }
}

impl Default for Capsules {
    fn default() -> Capsules {
        Capsules::new()
    }
}

impl Deref for Capsules {
    type Target = [Capsule];

    fn deref(&self) -> &[Capsule] {
        &self.shapes[..self.count]
    }
}

/// Nearest bodies of two sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Gap between them, metres: negative when they overlap, minus infinity (never safe) if a
    /// coordinate is not finite.
    pub gap_m: f64,
    /// Joint of each hand that moves its body.
    pub joints: [usize; 2],
}

/// Returns the nearest pair of bodies of two sets; an infinite gap if a set is empty.
#[must_use]
pub fn nearest(ours: &[Capsule], theirs: &[Capsule]) -> Nearest {
    let mut nearest = Nearest {
        gap_m: f64::INFINITY,
        joints: [0; 2],
    };
    for a in ours {
        for b in theirs {
            let gap_m = gap_m(a, b, nearest.gap_m);
            let joints = [a.joint, b.joint];
            if !gap_m.is_finite() {
                let gap_m = f64::NEG_INFINITY;
                return Nearest { gap_m, joints };
            }
            if gap_m < nearest.gap_m {
                nearest = Nearest { gap_m, joints };
            }
        }
    }
    nearest
}

/// Returns the smallest gap between two sets, see [`nearest`].
///
/// ```
/// use nalgebra::Vector3;
/// use robot_model::{Capsule, clearance_m};
///
/// let ball = |x_m| {
///     let centre_m = Vector3::new(x_m, 0.0, 0.0);
///     Capsule { a_m: centre_m, b_m: centre_m, radius_m: 0.01, joint: 0 }
/// };
/// assert!((clearance_m(&[ball(0.0)], &[ball(0.1)]) - 0.08).abs() < 1e-12);
/// ```
#[must_use]
pub fn clearance_m(ours: &[Capsule], theirs: &[Capsule]) -> f64 {
    nearest(ours, theirs).gap_m
}

/// Returns the largest motion of an end of a body between two poses of a hand, metres.
#[must_use]
pub fn farthest_move_m(before: &[Capsule], after: &[Capsule]) -> f64 {
    let moves = before
        .iter()
        .zip(after)
        .flat_map(|(b, a)| [(a.a_m - b.a_m).norm(), (a.b_m - b.b_m).norm()]);
    moves.fold(0.0, f64::max)
}

/// Returns the gap between two capsules, or a lower bound of it that is at least `enough_m`.
fn gap_m(a: &Capsule, b: &Capsule, enough_m: f64) -> f64 {
    let (along_a, along_b) = (a.b_m - a.a_m, b.b_m - b.a_m);
    let between_middles = (a.a_m + along_a * 0.5) - (b.a_m + along_b * 0.5);
    let radii = a.radius_m + b.radius_m;
    let bound = between_middles.norm() - 0.5 * (along_a.norm() + along_b.norm()) - radii;
    if bound >= enough_m {
        bound
    } else {
        segment_distance_m(a, b) - radii
    }
}

/// Distance between the segments of two capsules, metres. Source: closest points of two segments
/// (Ericson, Real-Time Collision Detection, 5.1.9).
fn segment_distance_m(one: &Capsule, two: &Capsule) -> f64 {
    let (d1, d2, between) = (one.b_m - one.a_m, two.b_m - two.a_m, one.a_m - two.a_m);
    let (a, e, b) = (d1.norm_squared(), d2.norm_squared(), d1.dot(&d2));
    let (c, f) = (d1.dot(&between), d2.dot(&between));
    // Fractions along each segment. A segment without length or a parallel pair may take any
    // fraction: 0.
    let fraction = |numerator: f64, denominator: f64| {
        if denominator > 0.0 {
            (numerator / denominator).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let s_free = fraction(b * f - c * e, a * e - b * b);
    let t = fraction(b * s_free + f, e);
    let s = fraction(b * t - c, a);
    let t = fraction(b * s + f, e);
    (between + d1 * s - d2 * t).norm()
}
