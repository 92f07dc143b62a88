//! Monitoring of the held object: warnings and reasons to put it back.

use super::*;

/// Slip duration on one side before a warning, s (design choice: several times the response time of
/// Module 2).
const SLIP_WARNING_S: f64 = 0.1;
/// Duration of slip, and slide under a sudden load, before a warning, s, m (design choice: an
/// object that the grip catches within this time slides by about three millimetres. A slowly
/// growing load that the grip follows gives a smaller slide).
const OVERLOAD_WARNING_S: f64 = 0.05;
const OVERLOAD_SLIDE_M: f64 = 0.001;
/// Slip duration on both sides, or drop duration, at F_2 before the object is put back, s (design
/// choice).
const OUT_OF_FORCE_S: f64 = 0.03;
/// Friction utilisation below which slip is ignored (design choice): a light load on a firm grip is
/// noise.
const SLIP_UTILISATION: f64 = 0.9;

impl TaskExecutor {
    /// Returns true if a slip or a rotation of the object would be a failure of the task. A
    /// teleoperated hand may place its object at any time.
    pub(super) fn is_monitored(&self) -> bool {
        self.step().motion != Motion::Lower && !self.is_teleoperated()
    }

    /// Returns the warning reason if a held object slips.
    pub(super) fn check_slip(&self, percept: &Percept) -> Option<Reason> {
        let (slip_s, limit_s) = if self.object.overload_m() > OVERLOAD_SLIDE_M {
            (slip_s(percept), OVERLOAD_WARNING_S)
        } else {
            (self.unheld_slip_s(percept), SLIP_WARNING_S)
        };
        (self.holds_object() && slip_s > limit_s).then_some(Reason::Sliding { slip_s, limit_s })
    }

    /// Returns the duration of a slip beyond the load that the grip holds, s.
    fn unheld_slip_s(&self, percept: &Percept) -> f64 {
        slip_s(percept).min(self.object.unheld_s())
    }

    fn holds_object(&self) -> bool {
        self.step().transition == Transition::Held && self.grips()
    }

    /// Returns the reason to put back an object that slips despite F_2.
    pub(super) fn out_of_force(&self, percept: &Percept) -> Option<Reason> {
        let (_, strongest_n) = percept.normal_range_n();
        let f2_n = self.object.thresholds().f2_n;
        let everywhere = percept
            .sides
            .iter()
            .all(|side| side.gross_slip_s > OUT_OF_FORCE_S);
        let slips = self.holds_object() && self.unheld_slip_s(percept) > SLIP_WARNING_S;
        let slides = (slips && everywhere) || self.object.drop_s() > OUT_OF_FORCE_S;
        let spent = slides && strongest_n > RELEASE_SHARE * f2_n;
        let goes_on = self.recovery_reason().is_none() && !self.object.is_found();
        (spent && goes_on).then_some(Reason::OutOfForce {
            force_n: strongest_n,
            limit_n: f2_n,
            module: ModuleId::FORCE_LIMIT,
        })
    }

    /// Returns the reason to put back an object that rotates before lift verification succeeded.
    pub(super) fn turning_before_verification(&self) -> Option<Reason> {
        let is_tested = self.step().modules.contains(ModuleId::LIFT_VERIFICATION);
        self.turning()
            .filter(|_| is_tested && !self.object.is_verified())
    }

    /// Returns the reason to stop carrying a rotating object. It stays in the hand, because it
    /// would land on its edge.
    pub(super) fn turning(&self) -> Option<Reason> {
        let carries = matches!(self.step().motion, Motion::Carry(_) | Motion::Convey(_));
        let goes_on = carries && self.recovery_reason().is_none() && !self.object.is_found();
        self.object.turning().filter(|_| goes_on)
    }
}

/// Returns the longest slip of a side whose friction is nearly used up, s.
fn slip_s(percept: &Percept) -> f64 {
    percept
        .sides
        .iter()
        .filter(|side| side.utilisation > SLIP_UTILISATION)
        .map(|side| side.gross_slip_s)
        .fold(0.0, |most, s| if s > most { s } else { most })
}
