//! One row per trial: what was drawn, what became of it, how hard and how long.

use serde::Serialize;

use crate::condition::Condition;
use crate::judge::Load;
use crate::plan::Plan;
use crate::policy::GripPolicy;
use crate::trial::Record;

/// One trial. Numbers have six significant digits; what does not apply, or is infinite, is absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialRow {
    /// The robot, as it was named.
    pub robot: String,
    /// Its fingertips' layout, if it is another than the robot file's.
    pub skin: Option<String>,
    /// The task.
    pub task: &'static str,
    /// What governed the grip.
    pub policy: &'static str,
    /// Its forces, in words.
    pub setting: String,
    /// Errors, by name.
    pub errors: String,
    /// Frames per second of the sensors.
    pub rate_hz: u32,
    /// The object in the middle of its family.
    pub object: String,
    /// The seed.
    pub seed: u64,
    /// Scale of the sensors' noise.
    pub noise: Option<f64>,
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Static friction coefficient.
    pub friction: Option<f64>,
    /// Stiffness, N/m; absent if rigid.
    pub stiffness_n_m: Option<f64>,
    /// Width, mm.
    pub width_mm: Option<f64>,
    /// Width that the controller was told, mm.
    pub told_width_mm: Option<f64>,
    /// Height, mm.
    pub height_mm: Option<f64>,
    /// Centre of mass beside the closing axis, mm.
    pub off_centre_mm: Option<f64>,
    /// Where it stood against what the controller was told, x, mm.
    pub off_x_mm: Option<f64>,
    /// The same, y, mm.
    pub off_y_mm: Option<f64>,
    /// The same, degrees.
    pub off_yaw_deg: Option<f64>,
    /// Friction of a cap's thread, mN·m.
    pub thread_mn_m: Option<f64>,
    /// Angle at which a cap is closed, degrees.
    pub closes_at_deg: Option<f64>,
    /// Force per finger that carries it, N.
    pub needed_n: Option<f64>,
    /// Force per finger that carries it without letting it turn, N.
    pub steady_n: Option<f64>,
    /// Force that crushes it, N.
    pub crush_n: Option<f64>,
    /// F_2 at its true stiffness, N.
    pub f2_n: Option<f64>,
    /// Whether the paper's rule allows it.
    pub feasible: bool,
    /// Whether physics allows it.
    pub feasible_by_physics: bool,
    /// What became of it.
    pub outcome: String,
    /// Whether that is what should.
    pub success: bool,
    /// Whether that is what should by physics alone.
    pub success_by_physics: bool,
    /// Greatest slip in the hand, mm.
    pub slip_mm: Option<f64>,
    /// Greatest turn in the hand, degrees.
    pub turn_deg: Option<f64>,
    /// Largest force that it felt, N.
    pub max_force_n: Option<f64>,
    /// Mean normal force at the end over the force needed.
    pub over_grip: Option<f64>,
    /// F_2 that the controller found over F_2 at the true stiffness.
    pub f2_ratio: Option<f64>,
    /// How far it was put from its place, mm.
    pub off_mm: Option<f64>,
    /// From its support carrying it to the hand opening, ms.
    pub latency_ms: Option<f64>,
    /// Height at which it was let go, mm.
    pub released_above_mm: Option<f64>,
    /// Torque that turns a cap further over the friction of its thread.
    pub tightness: Option<f64>,
    /// How far a bottle tilts, degrees.
    pub tilt_deg: Option<f64>,
    /// How far a bottle was turned, degrees.
    pub bottle_turn_deg: Option<f64>,
    /// Simulated time, s.
    pub simulated_s: Option<f64>,
}

impl TrialRow {
    /// Of a record of a plan's series.
    pub(crate) fn of(
        plan: &Plan,
        (policy, condition): &(GripPolicy, Condition),
        record: &Record,
    ) -> Self {
        let Record {
            drawn,
            load,
            finding,
            ..
        } = record;
        let measure = |name| finding.measure(name).and_then(rounded);
        let force = |of: fn(&Load) -> f64| load.as_ref().map(of).and_then(rounded);
        Self {
            robot: plan.robot.name.to_string(),
            skin: plan.skin.map(|layout| layout.to_string()),
            task: plan.task.name(),
            policy: policy.name(),
            setting: policy.setting(),
            errors: condition.errors.name.clone(),
            rate_hz: condition.rate_hz,
            object: plan.objects[record.object].name.clone(),
            seed: record.number,
            noise: rounded(drawn.noise),
            mass_kg: rounded(drawn.mass_kg),
            friction: rounded(drawn.friction),
            stiffness_n_m: rounded(drawn.stiffness_n_m),
            width_mm: rounded(drawn.width_mm),
            told_width_mm: rounded(drawn.told_width_mm),
            height_mm: rounded(drawn.height_mm),
            off_centre_mm: rounded(drawn.off_centre_mm),
            off_x_mm: rounded(drawn.off_x_mm),
            off_y_mm: rounded(drawn.off_y_mm),
            off_yaw_deg: rounded(drawn.off_yaw_deg),
            thread_mn_m: drawn.thread_mn_m.and_then(rounded),
            closes_at_deg: drawn.closes_at_deg.and_then(rounded),
            needed_n: force(|load| load.needed_n),
            steady_n: force(|load| load.steady_n),
            crush_n: force(|load| load.crush_n),
            f2_n: force(|load| load.f2_n),
            feasible: record.feasible(),
            feasible_by_physics: record.feasible_by_physics(),
            outcome: finding.outcome.clone(),
            success: record.failure().is_none(),
            success_by_physics: record.failure_by_physics().is_none(),
            slip_mm: measure("slip_mm"),
            turn_deg: measure("turn_deg"),
            max_force_n: rounded(record.max_force_n),
            over_grip: measure("over_grip"),
            f2_ratio: finding.f2_ratio.and_then(rounded),
            off_mm: measure("off_mm"),
            latency_ms: measure("latency_ms"),
            released_above_mm: measure("released_above_mm"),
            tightness: measure("tightness"),
            tilt_deg: measure("tilt_deg"),
            bottle_turn_deg: measure("bottle_turn_deg"),
            simulated_s: rounded(record.simulated_s),
        }
    }
}

/// To six significant digits; `None` unless finite.
fn rounded(value: f64) -> Option<f64> {
    let text = format!("{value:.5e}");
    text.parse().ok().filter(|value: &f64| value.is_finite())
}
