//! Motion limiter of one coordinate: tracks a jumping target with bounded speed, acceleration and
//! jerk.
//!
//! Stage 1, the **lead**, moves to the target at the bounds of speed and acceleration and stops
//! exactly on it. It solves the time-optimal problem of the sampled double integrator, without
//! overshoot or chatter. Stage 2, the **position**, is the low-passed lead. As a weighted mean of
//! past leads it keeps their bounds of speed, acceleration and range. Its jerk is bounded by the
//! acceleration:
//!
//! ```text
//!   p' = p + β·(l' − p),  β = dt/(T + dt)      jerk = β·(a_lead − a)/dt ≤ 2·A/(T + dt)
//! ```

/// Motion bounds, in the coordinate's unit per s and s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Highest speed.
    pub speed: f64,
    /// Highest acceleration, > 0.
    pub acceleration: f64,
    /// Time constant of the low-pass T, s.
    pub smooth_s: f64,
}

impl Bounds {
    /// Returns the highest jerk at this tick period, in the coordinate's unit per s³.
    #[must_use]
    pub fn jerk(&self, step_s: f64) -> f64 {
        2.0 * self.acceleration / (self.smooth_s + step_s)
    }
}

/// Largest lead minus position that counts as zero. Design choice: a picometre; ends the
/// exponential decay.
const ARRIVAL_DISTANCE: f64 = 1e-12;
/// Share of the highest jerk that this end of the decay may use (design choice: the jump appears in
/// four differences).
const ARRIVAL_JERK_SHARE: f64 = 0.1;

/// Motion limiter of one coordinate.
///
/// ```
/// use atas_core::teleop::{Axis, Bounds};
///
/// let bounds = Bounds { speed: 0.1, acceleration: 1.0, smooth_s: 0.02 };
/// let mut axis = Axis::new(0.0);
/// let mut previous = 0.0;
/// for _ in 0..2_000 {
///     let position = axis.step_towards(Some(0.05), &bounds, 1e-3);
///     assert!((position - previous).abs() <= bounds.speed * 1e-3 + 1e-15);
///     previous = position;
/// }
/// assert!((axis.position() - 0.05).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Axis {
    lead: f64,
    lead_speed: f64,
    position: f64,
}

impl Axis {
    /// Creates a coordinate at rest.
    #[must_use]
    pub const fn new(position: f64) -> Self {
        Self {
            lead: position,
            lead_speed: 0.0,
            position,
        }
    }

    /// Returns the position.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.position
    }

    /// Moves one tick towards a finite target, else to rest; returns the position.
    pub fn step_towards(&mut self, target: Option<f64>, bounds: &Bounds, step_s: f64) -> f64 {
        let wanted = target
            .filter(|target| target.is_finite())
            .map_or(0.0, |target| {
                arriving_speed(target - self.lead, bounds.acceleration, step_s)
            });
        let wanted = within(wanted, bounds.speed);
        let change = within(wanted - self.lead_speed, bounds.acceleration * step_s);
        self.lead_speed += change;
        self.lead += self.lead_speed * step_s;
        let off = self.lead - self.position;
        let jump = ARRIVAL_JERK_SHARE * bounds.jerk(step_s) * step_s * step_s * step_s;
        self.position = if off.abs() < ARRIVAL_DISTANCE.min(jump) {
            self.lead
        } else {
            self.position + off * step_s / (bounds.smooth_s + step_s)
        };
        self.position
    }
}

/// Returns the highest speed of the next tick from which braking by `acceleration` ends exactly at
/// the target.
fn arriving_speed(way: f64, acceleration: f64, step_s: f64) -> f64 {
    // Longest last tick of braking.
    let last = acceleration * step_s * step_s;
    let ticks = libm::ceil((libm::sqrt(1.0 + 8.0 * way.abs() / last) - 1.0) / 2.0).max(1.0);
    let speed = way.abs() / (ticks * step_s) + acceleration * step_s * (ticks - 1.0) / 2.0;
    libm::copysign(speed, way)
}

fn within(value: f64, limit: f64) -> f64 {
    if value.abs() <= limit {
        value
    } else {
        libm::copysign(limit, value)
    }
}
