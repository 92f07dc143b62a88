//! One coordinate that follows a target which may jump at any time, with bounded speed, acceleration and jerk.
//!
//! Two stages. The **lead** goes to the target as fast as speed and acceleration allow and stops on it exactly: it solves the
//! time-optimal problem of the sampled double integrator, so that it neither overshoots nor chatters. The **position** is the
//! lead, low-passed: a weighted mean of places where the lead has been. A mean exceeds no bound that all of its parts keep,
//! so speed, acceleration and range are the lead's; and its jerk is bounded because the lead's acceleration is:
//!
//! ```text
//!   p' = p + β·(l' − p),  β = dt/(T + dt)      jerk = β·(a_lead − a)/dt ≤ 2·A/(T + dt)
//! ```

/// What a coordinate may do, in its unit per s and s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Highest speed.
    pub speed: f64,
    /// Highest acceleration; more than 0.
    pub acceleration: f64,
    /// Time constant of the low-pass T, s.
    pub smooth_s: f64,
}

impl Bounds {
    /// Highest jerk that follows from them at this tick period, in the coordinate's unit per s³.
    #[must_use]
    pub fn jerk(&self, step_s: f64) -> f64 {
        2.0 * self.acceleration / (self.smooth_s + step_s)
    }
}

/// Distance between lead and position that is none (ours: a picometre; a decay would never end).
const ARRIVED: f64 = 1e-12;

/// One coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Axis {
    lead: f64,
    lead_speed: f64,
    position: f64,
}

impl Axis {
    /// A coordinate at rest.
    #[must_use]
    pub const fn at(position: f64) -> Self {
        Self {
            lead: position,
            lead_speed: 0.0,
            position,
        }
    }

    /// Where it is.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.position
    }

    /// One tick towards a target, or to rest if there is none; returns where it is then. A target that is not finite is none.
    pub fn towards(&mut self, target: Option<f64>, bounds: &Bounds, step_s: f64) -> f64 {
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
        self.position = if off.abs() < ARRIVED {
            self.lead
        } else {
            self.position + off * step_s / (bounds.smooth_s + step_s)
        };
        self.position
    }
}

/// The highest speed of the coming tick from which braking by `acceleration` in every tick after it ends exactly where the way
/// ends: n ticks, each slower than the one before by the same amount, cover it.
fn arriving_speed(way: f64, acceleration: f64, step_s: f64) -> f64 {
    // What the last tick of braking covers at most.
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
