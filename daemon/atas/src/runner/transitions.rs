//! Step transitions: end of a step, its successor, and recovery.

use super::*;
use crate::tasks::Waypoint;

impl Runner {
    /// Evaluates this tick: verdict, end of the step, end of the task.
    pub fn conclude(
        &mut self,
        verdict: Verdict,
        arrived: bool,
        percept: &Percept,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) -> Outcome {
        if self.grasps_anew(verdict, percept, now, settings, modules) {
            return Outcome::NextStep;
        }
        match verdict {
            Verdict::Refuse(reason) if self.retreat.is_none() && !self.found => {
                let retreat = if reason.cause == Cause::OBSTRUCTED {
                    Retreat::Withdraw
                } else {
                    Retreat::PutBack
                };
                let reason = self.in_hold(reason);
                return self.give_up(retreat, reason, now, settings, modules);
            }
            Verdict::Stiffness(fit) => {
                self.stiffness = Some(fit);
                self.holds = true;
                self.thresholds = Thresholds::for_stiffness(fit.object_n_m, &settings.grasp)
                    .told(self.wishes.max_force_n, &settings.grasp);
            }
            Verdict::None | Verdict::Done | Verdict::Refuse(_) => {}
        }
        let is_refused = self.out_of_force(percept).or_else(|| self.turns_standing());
        if let Some(reason) = is_refused {
            return self.give_up(Retreat::PutBack, reason, now, settings, modules);
        }
        if self.wants_opening() || self.found_nothing(now) {
            self.begin_again(now, settings, modules);
            return Outcome::NextStep;
        }
        if let Some(reason) = self.failure(percept, now, settings) {
            self.holds &= reason.cause != Cause::LOST_OBJECT;
            return Outcome::Failed(reason);
        }
        let done = verdict == Verdict::Done;
        if arrived && !done && self.step().motion == Motion::Lower {
            let reason = Reason::limit(
                Cause::NO_SUPPORT,
                now.centre_m.z,
                self.waypoints.expected_m(),
            );
            let reason = reason.by(ModuleId::TRANSFER);
            return self.give_up(Retreat::Raise, reason, now, settings, modules);
        }
        if self.is_done(arrived, done, percept, now) {
            self.advance(now, settings, modules)
        } else {
            Outcome::Running
        }
    }

    fn is_done(&self, arrived: bool, concluded: bool, percept: &Percept, now: &GraspFrame) -> bool {
        match self.step().transition {
            Transition::Arrived => arrived,
            Transition::AllTouched => self.all_touched,
            Transition::StiffnessKnown => self.stiffness.is_some(),
            Transition::Gripped => {
                let (weakest_n, strongest_n) = force_range_n(percept);
                weakest_n > self.thresholds.f1_n || strongest_n > self.thresholds.f2_n
            }
            Transition::Held => self.step_s >= self.wishes.hold_s,
            Transition::Concluded => concluded,
            Transition::Met(point) => self.peer_reached >= point,
            Transition::GripWanted => self.wants_grip(percept, now),
            // Restarts at the first step instead of entering the next one.
            Transition::OpeningWanted => false,
        }
    }

    fn advance(&mut self, now: &GraspFrame, settings: &Settings, modules: &mut Modules) -> Outcome {
        if self.regrasps(now, settings, modules) {
            return Outcome::NextStep;
        }
        if self.index + 1 == self.steps().len() {
            return match self.retreat {
                Some((Retreat::PutBack | Retreat::Withdraw, reason)) => Outcome::Refused(reason),
                Some((Retreat::Raise, reason)) => Outcome::Failed(reason),
                None => self.end(),
            };
        }
        self.enter(self.index + 1, now, settings, modules);
        Outcome::NextStep
    }

    /// Ends the task once; later findings do not change its outcome.
    fn end(&mut self) -> Outcome {
        let objection = self.in_hand.objection().filter(|_| !self.ended);
        self.ended = true;
        objection.map_or(Outcome::Succeeded, Outcome::Failed)
    }

    pub(super) fn enter(
        &mut self,
        index: usize,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        self.index = index;
        self.step_s = 0.0;
        if self.step().motion.waypoint() == Some(Waypoint::OverTarget) {
            self.learn_held(now);
        }
        self.path = self.plan(now, settings);
        self.arrive();
        modules.restart_step();
        match self.step().motion {
            Motion::Carry(_) if self.retreat.is_none() => self.lifted_from_m = Some(now.centre_m),
            Motion::Open | Motion::LetGo | Motion::Square => self.holds = false,
            Motion::Follow if self.holds => self.lifted_from_m = Some(now.centre_m),
            Motion::Brake if self.step().transition == Transition::AllTouched => {
                self.touched_opening_m = now.half_opening_m.iter().sum();
            }
            _ => {}
        }
    }

    /// Initialises the state that a step needs at entry.
    pub(super) fn arrive(&mut self) {
        match self.step().transition {
            Transition::Met(point) => self.reached = point,
            Transition::AllTouched => {
                self.all_touched = false;
                (self.hangs, self.tries) = (false, false);
                self.proof = Proof::default();
                self.in_hand = InHand::default();
                self.lifted_from_m = None;
            }
            _ => {}
        }
    }

    pub(super) fn plan(&self, now: &GraspFrame, settings: &Settings) -> Path {
        path_of(
            self.step().motion,
            now,
            &self.waypoints,
            &self.path,
            settings,
        )
    }

    /// Converts a threshold rejection of a held object to `OUT_OF_FORCE`, because its load has
    /// grown.
    fn in_hold(&self, reason: Reason) -> Reason {
        let held =
            self.step().transition == Transition::Held || self.step().motion == Motion::Square;
        if held && reason.cause == self.thresholds.exceeded() {
            Reason {
                cause: Cause::OUT_OF_FORCE,
                ..reason
            }
        } else {
            reason
        }
    }

    fn give_up(
        &mut self,
        retreat: Retreat,
        reason: Reason,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) -> Outcome {
        if self.is_led() {
            return Outcome::Failed(reason);
        }
        self.retreat = Some((retreat, reason));
        self.regrasp = Regrasp::default();
        self.track = match retreat {
            Retreat::PutBack => BACK_OUT,
            Retreat::Raise => RAISE,
            Retreat::Withdraw => WITHDRAW,
        };
        self.holds &= retreat == Retreat::Raise;
        self.enter(0, now, settings, modules);
        Outcome::NextStep
    }

    /// Returns the reason to put back an object that rotates before lift verification succeeded.
    fn turns_standing(&self) -> Option<Reason> {
        let is_tested = self.step().modules.contains(ModuleId::LOAD_TEST);
        self.turns().filter(|_| is_tested && !self.hangs)
    }

    /// Returns the reason to stop carrying a rotating object. It stays in the hand, because it
    /// would land on its edge.
    pub(super) fn turns(&self) -> Option<Reason> {
        let carries = matches!(self.step().motion, Motion::Carry(_) | Motion::Convey(_));
        let goes_on = carries && self.retreat.is_none() && !self.found;
        self.in_hand.turned().filter(|_| goes_on)
    }

    /// Returns the reason if the task fails in this tick.
    fn failure(&self, percept: &Percept, now: &GraspFrame, settings: &Settings) -> Option<Reason> {
        let step = self.step();
        if self.holds && self.lifted_from_m.is_some() && self.out_of_touch_s > LOST_AFTER_S {
            let (weakest_n, _) = force_range_n(percept);
            return Some(Reason::limit(
                Cause::LOST_OBJECT,
                weakest_n,
                settings.perception.touch_off_n,
            ));
        }
        if let Some(reason) = self.in_hand.lost().filter(|_| self.holds) {
            return Some(reason);
        }
        if let Some(reason) = self.turns() {
            return Some(reason);
        }
        if step.transition == Transition::AllTouched {
            let deepest_m = (self.wishes.width_m / 2.0 - settings.motion.search_m).max(MEET_M);
            let closed_m = now
                .half_opening_m
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
            if closed_m < deepest_m {
                let reason = Reason::limit(Cause::NOTHING_TOUCHED, 2.0 * closed_m, 2.0 * deepest_m);
                return Some(reason.by(ModuleId::FIRST_TOUCH));
            }
        }
        (self.step_s > step.timeout_s)
            .then(|| Reason::limit(Cause::TIMED_OUT, self.step_s, step.timeout_s))
    }
}
