//! Row format of single trials: drawn values, outcome, forces, durations.

use serde::Serialize;

use crate::condition::Condition;
use crate::judge::Load;
use crate::plan::Plan;
use crate::policy::GripPolicy;
use crate::trial::Record;

/// One trial. Numbers have six significant digits; inapplicable or infinite values are absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrialRow {
    /// Robot name, as given.
    pub robot: String,
    /// Fingertip layout, if not the robot file's.
    pub skin: Option<String>,
    /// Task name.
    pub task: &'static str,
    /// Grip policy.
    pub policy: &'static str,
    /// Forces of the policy, as text.
    pub setting: String,
    /// Errors, by name.
    pub errors: String,
    /// Sensor model, if not that of the design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_model: Option<String>,
    /// Sensor rate, Hz.
    pub rate_hz: u32,
    /// Nominal object of the family.
    pub object: String,
    /// Seed.
    pub seed: u64,
    /// Noise scale.
    pub noise: Option<f64>,
    /// Mass, kg.
    pub mass_kg: Option<f64>,
    /// Static friction coefficient.
    pub friction: Option<f64>,
    /// Stiffness, N/m; absent if rigid.
    pub stiffness_n_m: Option<f64>,
    /// Width, mm.
    pub width_mm: Option<f64>,
    /// Width given to the controller, mm.
    pub expected_width_mm: Option<f64>,
    /// Height, mm.
    pub height_mm: Option<f64>,
    /// Offset of the centre of mass from the closing axis, mm.
    pub off_centre_mm: Option<f64>,
    /// True minus expected x position, mm.
    pub off_x_mm: Option<f64>,
    /// True minus expected y position, mm.
    pub off_y_mm: Option<f64>,
    /// True minus expected yaw, degrees.
    pub off_yaw_deg: Option<f64>,
    /// Friction torque of a cap's thread, mN·m.
    pub thread_mn_m: Option<f64>,
    /// Angle at which a cap is closed, degrees.
    pub closes_at_deg: Option<f64>,
    /// Force per side against sliding, N.
    pub needed_n: Option<f64>,
    /// Force per side against sliding and rotation, N.
    pub steady_n: Option<f64>,
    /// Force that crushes the object, N.
    pub crush_n: Option<f64>,
    /// F_2 at the true stiffness, N.
    pub f2_n: Option<f64>,
    /// Feasible under the paper's rule.
    pub feasible: bool,
    /// Feasible by physics alone.
    pub feasible_by_physics: bool,
    /// Outcome key.
    pub outcome: String,
    /// Success under the paper's rule.
    pub success: bool,
    /// Success by physics alone.
    pub success_by_physics: bool,
    /// Largest slip in the hand, mm.
    pub slip_mm: Option<f64>,
    /// Largest turn in the hand, degrees.
    pub turn_deg: Option<f64>,
    /// Largest force on the object, N.
    pub max_force_n: Option<f64>,
    /// Mean final over needed normal force.
    pub over_grip: Option<f64>,
    /// Measured F_2 over F_2 at the true stiffness.
    pub f2_ratio: Option<f64>,
    /// Horizontal distance from the destination, mm.
    pub off_mm: Option<f64>,
    /// Time from support to the hand opening, ms.
    pub latency_ms: Option<f64>,
    /// Largest force that pressed the object onto its support, N.
    pub pressed_down_n: Option<f64>,
    /// Height above the support at release, mm.
    pub released_above_mm: Option<f64>,
    /// Holding torque of the cap over its thread's friction.
    pub tightness: Option<f64>,
    /// Tilt of the bottle, degrees.
    pub tilt_deg: Option<f64>,
    /// Rotation of the bottle, degrees.
    pub bottle_turn_deg: Option<f64>,
    /// Simulated time, s.
    pub simulated_s: Option<f64>,
}

impl TrialRow {
    pub(crate) fn from_record(
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
            sensor_model: condition.sensor_model.as_ref().map(|of| of.name.clone()),
            rate_hz: condition.rate_hz,
            object: plan.objects[record.object].name.clone(),
            seed: record.number,
            noise: rounded(drawn.noise),
            mass_kg: rounded(drawn.mass_kg),
            friction: rounded(drawn.friction),
            stiffness_n_m: rounded(drawn.stiffness_n_m),
            width_mm: rounded(drawn.width_mm),
            expected_width_mm: rounded(drawn.expected_width_mm),
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
            pressed_down_n: measure("pressed_down_n"),
            released_above_mm: measure("released_above_mm"),
            tightness: measure("tightness"),
            tilt_deg: measure("tilt_deg"),
            bottle_turn_deg: measure("bottle_turn_deg"),
            simulated_s: rounded(record.simulated_s),
        }
    }
}

/// Rounds to six significant digits; `None` if not finite.
fn rounded(value: f64) -> Option<f64> {
    let text = format!("{value:.5e}");
    text.parse().ok().filter(|value: &f64| value.is_finite())
}
