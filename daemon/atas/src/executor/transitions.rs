//! Step transitions: end of a step, its successor, and recovery.

use super::*;
use crate::tasks::Waypoint;

/// Half opening at which any search ends, m (design choice): the fingertips meet below it.
pub(super) const FINGERTIPS_MEET_M: f64 = 0.001;

impl TaskExecutor {
    /// Evaluates this tick: verdict, end of the step, end of the task.
    pub fn finish_tick(
        &mut self,
        verdict: Verdict,
        arrived: bool,
        percept: &Percept,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) -> Outcome {
        if self.start_regrasp(verdict, percept, now, settings, modules) {
            return Outcome::NextStep;
        }
        if self.start_evasion(verdict, percept, now, settings, modules) {
            return Outcome::NextStep;
        }
        match verdict {
            Verdict::Refuse(reason)
                if self.recovery_reason().is_none() && !self.object.is_found() =>
            {
                let retreat = match reason {
                    Reason::Obstructed { .. } => Recovery::Withdraw,
                    _ => Recovery::PutBack,
                };
                let reason = self.reason_while_held(reason);
                return self.start_recovery(retreat, reason, now, settings, modules);
            }
            Verdict::Stiffness(fit) => {
                let thresholds = Thresholds::for_stiffness(fit.object_n_m, &settings.grasp)
                    .with_force_limit(self.parameters.max_force_n, &settings.grasp);
                self.object.set_stiffness(fit, thresholds);
            }
            Verdict::None | Verdict::Done | Verdict::Refuse(_) => {}
        }
        let is_refused = self
            .out_of_force(percept)
            .or_else(|| self.turning_before_verification());
        if let Some(reason) = is_refused {
            return self.start_recovery(Recovery::PutBack, reason, now, settings, modules);
        }
        if self.opening_requested() || self.fingertips_met(now) {
            self.restart_teleop(now, settings, modules);
            return Outcome::NextStep;
        }
        if let Some(reason) = self.failure(percept, now, settings) {
            if matches!(reason, Reason::LostObject { .. }) {
                self.object.keep_if_touched();
            }
            return Outcome::Failed(reason);
        }
        let done = verdict == Verdict::Done;
        if arrived && !done && self.step().motion == Motion::Lower {
            let reason = Reason::NoSupport {
                height_m: now.centre_m.z,
                expected_m: self.waypoints.expected_height_m(),
                module: ModuleId::TRANSFER,
            };
            return self.start_recovery(Recovery::Raise, reason, now, settings, modules);
        }
        if self.is_done(arrived, done, percept, now) {
            self.advance(now, settings, modules)
        } else {
            Outcome::Running
        }
    }

    fn is_done(&self, arrived: bool, concluded: bool, percept: &Percept, now: &GraspPose) -> bool {
        match self.step().transition {
            Transition::Arrived => arrived,
            Transition::AllTouched => self.object.object().all_touched,
            Transition::StiffnessKnown => self.object.stiffness().is_some(),
            Transition::Gripped => {
                let (weakest_n, strongest_n) = percept.normal_range_n();
                let Thresholds { f1_n, f2_n, .. } = self.object.thresholds();
                weakest_n > f1_n || strongest_n > f2_n
            }
            Transition::Held => self.step_s >= self.parameters.hold_s,
            Transition::Concluded => concluded,
            Transition::Met(point) => self.peer_meeting_point >= point,
            Transition::GripRequested => self.grip_requested(percept, now),
            // Restarts at the first step instead of entering the next one.
            Transition::OpeningRequested => false,
        }
    }

    fn advance(&mut self, now: &GraspPose, settings: &Settings, modules: &mut Modules) -> Outcome {
        if self.advance_regrasp(now, settings, modules) {
            return Outcome::NextStep;
        }
        if self.index + 1 == self.steps().len() {
            return match self.course {
                Course::Recovery(Recovery::Raise, reason) => Outcome::Failed(reason),
                Course::Recovery(_, reason) => Outcome::Refused(reason),
                Course::Regrasp { resume_step } | Course::Evasion { resume_step } => {
                    self.course = Course::Task;
                    self.enter(resume_step, now, settings, modules);
                    Outcome::NextStep
                }
                Course::Task => self.finish_task(),
                Course::Ended => Outcome::Succeeded,
            };
        }
        self.enter(self.index + 1, now, settings, modules);
        Outcome::NextStep
    }

    /// Ends the task once; later findings do not change its outcome.
    fn finish_task(&mut self) -> Outcome {
        self.course = Course::Ended;
        self.object
            .failure()
            .map_or(Outcome::Succeeded, Outcome::Failed)
    }

    pub(super) fn enter(
        &mut self,
        index: usize,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        self.index = index;
        self.step_s = 0.0;
        if self.step().motion.waypoint() == Some(Waypoint::OverTarget) {
            self.update_held_offset(now);
        }
        self.path = self.plan(now, settings);
        self.init_step();
        modules.restart_step();
        match self.step().motion {
            Motion::Carry(_) if self.recovery_reason().is_none() => self.object.lift(now.centre_m),
            Motion::Open | Motion::LetGo | Motion::Square => self.object.let_go(),
            Motion::Teleop if self.object.is_gripped() => self.object.lift(now.centre_m),
            Motion::Brake if self.step().transition == Transition::AllTouched => {
                self.teleoperation.touched_opening_m = now.half_opening_m.iter().sum();
            }
            _ => {}
        }
    }

    /// Initialises the state that a step needs at entry.
    pub(super) fn init_step(&mut self) {
        match self.step().transition {
            Transition::Met(point) => self.meeting_point = point,
            Transition::AllTouched => self.object.begin_search(),
            _ => {}
        }
    }

    pub(super) fn plan(&self, now: &GraspPose, settings: &Settings) -> Path {
        path_of(
            self.step().motion,
            now,
            &self.waypoints,
            &self.path,
            settings,
        )
    }

    /// Converts a threshold rejection of a held object to [`Reason::OutOfForce`], because its load
    /// has grown.
    fn reason_while_held(&self, reason: Reason) -> Reason {
        let held =
            self.step().transition == Transition::Held || self.step().motion == Motion::Square;
        match reason {
            Reason::TooHeavy {
                force_n,
                limit_n,
                module,
            }
            | Reason::TooSoft {
                force_n,
                limit_n,
                module,
            }
            | Reason::AboveMaxForce {
                force_n,
                limit_n,
                module,
            } if held => Reason::OutOfForce {
                force_n,
                limit_n,
                module,
            },
            _ => reason,
        }
    }

    fn start_recovery(
        &mut self,
        retreat: Recovery,
        reason: Reason,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) -> Outcome {
        if self.is_teleoperated() {
            return Outcome::Failed(reason);
        }
        (self.course, self.corrections) =
            (Course::Recovery(retreat, reason), Corrections::default());
        self.sequence = match retreat {
            Recovery::PutBack => PUT_BACK,
            Recovery::Raise => RAISE,
            Recovery::Withdraw => WITHDRAW,
        };
        if retreat != Recovery::Raise {
            self.object.let_go();
        }
        self.enter(0, now, settings, modules);
        Outcome::NextStep
    }

    /// Returns the reason if the task fails in this tick.
    fn failure(&self, percept: &Percept, now: &GraspPose, settings: &Settings) -> Option<Reason> {
        let step = self.step();
        if self.object.is_carried() && self.object.has_lost_contact() {
            let (weakest_n, _) = percept.normal_range_n();
            return Some(Reason::LostObject {
                force_n: weakest_n,
                limit_n: settings.perception.touch_off_n,
            });
        }
        if let Some(reason) = self.object.loss() {
            return Some(reason);
        }
        if let Some(reason) = self.turning() {
            return Some(reason);
        }
        if step.transition == Transition::AllTouched || step.motion == Motion::Square {
            let deepest_m =
                (self.parameters.width_m / 2.0 - settings.motion.search_m).max(FINGERTIPS_MEET_M);
            let closed_m = now
                .half_opening_m
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
            if closed_m < deepest_m {
                return Some(Reason::NothingTouched {
                    width_m: 2.0 * closed_m,
                    limit_m: 2.0 * deepest_m,
                    module: ModuleId::FIRST_TOUCH,
                });
            }
        }
        (self.step_s > step.timeout_s).then_some(Reason::TimedOut {
            elapsed_s: self.step_s,
            limit_s: step.timeout_s,
        })
    }
}
