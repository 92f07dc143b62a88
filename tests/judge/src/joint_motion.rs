//! Motion of one joint: finite differences of consecutive commanded positions.

use crate::bounds::JointBounds;
use crate::findings::{Findings, ViolationKind};

/// Largest rounding error of a commanded position, relative to the largest position of the joint.
/// Derivation: four operations of half a unit in the last place each (conversion from the unit,
/// product, sum, conversion to the unit). Smaller values reject correct controllers.
const POSITION_ROUNDING: f64 = 2.0 * f64::EPSILON;
/// Tolerance of a limit, relative to it. Design choice: far above the rounding of a controller that
/// computes with its limits (1e-15), far below any fault.
const LIMIT_ROUNDING: f64 = 1e-9;

/// Tolerances of the checks, in the units of the joint.
///
/// The n-th difference of positions with the error e has an error of up to 2ⁿ·e / dtⁿ. For 3 rad
/// and 1 ms, e is 1.3e-15 rad, and the error of the jerk is 1.1e-5 rad/s³.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) position: f64,
    pub(crate) speed: f64,
    acceleration: f64,
    jerk: f64,
}

impl Tolerance {
    fn new(bounds: &JointBounds, step_s: f64) -> Self {
        let position = POSITION_ROUNDING * bounds.lower.abs().max(bounds.upper.abs());
        let speed = 2.0 * position / step_s;
        let acceleration = 2.0 * speed / step_s;
        let jerk = 2.0 * acceleration / step_s;
        Self {
            position,
            speed: speed + LIMIT_ROUNDING * bounds.speed_max,
            acceleration: acceleration + LIMIT_ROUNDING * bounds.acceleration_max,
            jerk: jerk + LIMIT_ROUNDING * bounds.jerk_max,
        }
    }
}

/// Differences up to the new position, as far as the earlier positions are known.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Differences {
    pub(crate) speed: Option<f64>,
    pub(crate) acceleration: Option<f64>,
    jerk: Option<f64>,
}

/// A difference beyond its limit.
#[derive(Clone, Copy, Debug)]
struct Excess {
    kind: ViolationKind,
    value: f64,
    limit: f64,
    per: &'static str,
}

/// Last position of a joint and the differences up to it.
#[derive(Clone, Debug)]
pub(crate) struct JointMotion {
    pub(crate) bounds: JointBounds,
    pub(crate) tolerance: Tolerance,
    step_s: f64,
    position: Option<f64>,
    last: Differences,
}

impl JointMotion {
    pub(crate) fn new(bounds: JointBounds, step_s: f64) -> Self {
        Self {
            tolerance: Tolerance::new(&bounds, step_s),
            bounds,
            step_s,
            position: None,
            last: Differences::default(),
        }
    }

    /// Returns the last position.
    pub(crate) fn position(&self) -> Option<f64> {
        self.position
    }

    /// Returns the differences up to the last position.
    pub(crate) fn last(&self) -> Differences {
        self.last
    }

    /// Returns the tick period, s.
    pub(crate) fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Returns the last step of the position; 0 if it is unknown.
    pub(crate) fn last_step(&self) -> f64 {
        self.last.speed.unwrap_or(0.0) * self.step_s
    }

    /// Forgets all positions; the next three commands are compared as far as possible.
    pub(crate) fn forget(&mut self) {
        self.position = None;
        self.last = Differences::default();
    }

    /// Takes a position at rest.
    pub(crate) fn rest_at(&mut self, position: f64) {
        self.follow(
            position,
            Differences {
                speed: Some(0.0),
                acceleration: Some(0.0),
                jerk: None,
            },
        );
    }

    /// Takes a position with the differences up to it.
    pub(crate) fn follow(&mut self, position: f64, differences: Differences) {
        self.position = Some(position);
        self.last = differences;
    }

    /// Returns the differences up to a new position.
    pub(crate) fn differences(&self, position: f64) -> Differences {
        let per_step = |now: Option<f64>, last: Option<f64>| Some((now? - last?) / self.step_s);
        let speed = per_step(Some(position), self.position);
        let acceleration = per_step(speed, self.last.speed);
        Differences {
            speed,
            acceleration,
            jerk: per_step(acceleration, self.last.acceleration),
        }
    }

    /// Returns whether all differences are within their limits.
    pub(crate) fn is_within(&self, differences: &Differences) -> bool {
        self.excesses(differences).next().is_none()
    }

    /// Reports every difference beyond its limit.
    pub(crate) fn check_differences(&self, differences: &Differences, findings: &mut Findings) {
        let (name, symbol) = (&self.bounds.name, self.bounds.unit.symbol());
        for Excess {
            kind,
            value,
            limit,
            per,
        } in self.excesses(differences)
        {
            findings.report(
                kind,
                format_args!("joint {name}: {value} {symbol}{per}, limit {limit} {symbol}{per}"),
            );
        }
    }

    /// Reports a position beyond its limits. Controllers clamp exactly, so there is no tolerance.
    pub(crate) fn check_position(&self, position: f64, findings: &mut Findings) {
        let JointBounds {
            name, lower, upper, ..
        } = &self.bounds;
        if !(*lower..=*upper).contains(&position) {
            findings.report(
                ViolationKind::Position,
                format_args!(
                    "joint {name}: {position} {}, limits {lower} to {upper}",
                    self.bounds.unit.symbol()
                ),
            );
        }
    }

    /// Reports a feed-forward that differs from the position difference.
    pub(crate) fn check_feed_forward(
        &self,
        feed_forward: f64,
        differences: &Differences,
        findings: &mut Findings,
    ) {
        let Some(speed) = differences.speed else {
            return;
        };
        if !is_within(feed_forward - speed, self.tolerance.speed) {
            findings.report(
                ViolationKind::FeedForward,
                format_args!(
                    "joint {}: feed-forward {feed_forward}, position difference {speed} {}/s",
                    self.bounds.name,
                    self.bounds.unit.symbol()
                ),
            );
        }
    }

    fn excesses(&self, differences: &Differences) -> impl Iterator<Item = Excess> {
        let (bounds, tolerance) = (&self.bounds, &self.tolerance);
        let excess = |kind, value: Option<f64>, limit: f64, tolerance: f64, per| {
            let value = value.filter(|value| !is_within(*value, limit + tolerance))?;
            Some(Excess {
                kind,
                value,
                limit,
                per,
            })
        };
        [
            excess(
                ViolationKind::Speed,
                differences.speed,
                bounds.speed_max,
                tolerance.speed,
                "/s",
            ),
            excess(
                ViolationKind::Acceleration,
                differences.acceleration,
                bounds.acceleration_max,
                tolerance.acceleration,
                "/s²",
            ),
            excess(
                ViolationKind::Jerk,
                differences.jerk,
                bounds.jerk_max,
                tolerance.jerk,
                "/s³",
            ),
        ]
        .into_iter()
        .flatten()
    }
}

/// Returns whether a magnitude is within a limit; false for NaN.
pub(crate) fn is_within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}
