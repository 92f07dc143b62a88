//! Reporting of one hand: figures, reports, counts, events.

use super::*;
use robot_model::PerSide;

impl HandControl {
    /// Returns the grasp figures for the goal's client.
    #[must_use]
    pub(crate) fn figures(&self) -> GraspFigures {
        let percept = self.perception.percept();
        let mut figures = GraspFigures::default();
        for (i, finger) in percept.fingertips.iter().enumerate() {
            figures.normal_n[i] = finger.normal_n as f32;
            figures.tangential_n[i] = finger.tangential_n as f32;
        }
        let friction = percept
            .sides
            .iter()
            .map(|f| f.friction)
            .fold(f64::INFINITY, f64::min);
        figures.friction = friction as f32;
        if let Some(runner) = &self.executor {
            figures.f1_n = runner.object().thresholds().f1_n as f32;
            figures.f2_n = runner.object().thresholds().f2_n as f32;
            figures.lifted_m = runner.object().object().carried_m as f32;
            if let Some(fit) = runner.object().stiffness() {
                figures.stiffness_n_m = fit.object_n_m as f32;
                figures.stiffness_confidence = fit.confidence as f32;
            }
        }
        figures
    }

    /// Returns the report of this tick.
    #[must_use]
    pub(crate) fn report(&self, tick: Tick) -> HandReport {
        let percept = self.perception.percept();
        let closing = self.intent_closing();
        let mut report = HandReport {
            frame_sequence: self.intake.sequence(),
            frame_age_ns: self.intake.age_ns(tick),
            frames: self.frames,
            modules_active: self.active_modules,
            centre_m: self
                .servo
                .as_ref()
                .map_or([0.0; 3], |c| c.pose().centre_m.into()),
            ..HandReport::default()
        };
        if let Some(runner) = &self.executor {
            report.step = runner.index() as u32;
            report.f1_n = runner.object().thresholds().f1_n as f32;
            report.f2_n = runner.object().thresholds().f2_n as f32;
            report.stiffness_n_m = runner
                .object()
                .stiffness()
                .map_or(0.0, |h| h.object_n_m as f32);
        }
        for (i, finger) in percept.fingertips.iter().enumerate() {
            report.fingers[i] = FingerReport {
                normal_n: finger.normal_n as f32,
                tangential_n: finger.tangential_n as f32,
                tangential_increment_n: finger.increment_n as f32,
                utilisation: finger.utilisation as f32,
                utilisation_now: finger.utilisation_now as f32,
                friction: finger.friction as f32,
                closing_m_s: if i < self.model.fingertip_count() {
                    closing[self.model.grasp_side(i)] as f32
                } else {
                    0.0
                },
                in_contact: u32::from(finger.in_contact),
            };
        }
        report
    }

    /// Returns counts and readings for [`shm_schemas::Status`].
    #[must_use]
    pub(crate) fn status(&self, tick: Tick) -> HandStatus {
        let counts = self.intake.counts();
        let fingers = &self.perception.percept().fingertips;
        HandStatus {
            frames: counts.frames,
            lost: counts.lost,
            duplicates: counts.duplicates,
            reordered: counts.reordered,
            corrupt: counts.corrupt,
            mistimed: counts.mistimed,
            foreign: counts.foreign,
            masked_elements: counts.masked_elements,
            restarts: counts.restarts,
            touches: fingers.map(|f| f.touches),
            writer_epoch: self.intake.writer_epoch(),
            age_ns: self.intake.age_ns(tick),
            layout_hash: self.layout_hash,
            normal_n: fingers.map(|f| f.normal_n as f32),
            tangential_n: fingers.map(|f| f.tangential_n as f32),
            required: u32::from(self.required),
            modules_active: self.active_modules,
        }
    }

    fn intent_closing(&self) -> PerSide<f64> {
        self.intent.map_or(PerSide::repeat(0.0), |i| i.closing_m_s)
    }

    pub(super) fn event(&self, kind: EventKind) -> ModuleEvent {
        ModuleEvent {
            kind,
            hand: self.hand,
            ..ModuleEvent::default()
        }
    }

    pub(super) fn publish_contacts(
        &self,
        before: &Percept,
        settings: &Settings,
        events: &mut Events,
    ) {
        for (i, (was, is)) in before
            .fingertips
            .iter()
            .zip(&self.perception.percept().fingertips)
            .enumerate()
        {
            if was.in_contact == is.in_contact {
                continue;
            }
            let (kind, threshold) = if is.in_contact {
                (EventKind::TOUCH_ON, settings.perception.touch_on_n)
            } else {
                (EventKind::TOUCH_OFF, settings.perception.touch_off_n)
            };
            events.push(ModuleEvent {
                finger: i as u32,
                value: is.normal_n,
                threshold,
                ..self.event(kind)
            });
        }
    }

    pub(super) fn publish_modules(
        &mut self,
        selection: Selection,
        proposals: &[Proposal],
        events: &mut Events,
    ) {
        let before = self.active_modules;
        self.active_modules = 0;
        for (id, proposal) in modules::IDS.iter().zip(proposals) {
            let bit = 1 << id.0;
            let is = proposal.active && selection.contains(*id);
            self.active_modules |= if is { bit } else { 0 };
            if is != (before & bit != 0) {
                let kind = if is {
                    EventKind::MODULE_ON
                } else {
                    EventKind::MODULE_OFF
                };
                events.push(ModuleEvent {
                    module: *id,
                    ..self.event(kind)
                });
            }
        }
    }

    /// Publishes a warning at once, because a goal may have no client that waits for its end.
    pub(super) fn warn(&self, reason: Option<Reason>, events: &mut Events) {
        if let Some(reason) = reason {
            events.push(ModuleEvent {
                reason: reason.into(),
                ..self.event(EventKind::WARNING)
            });
        }
    }

    pub(super) fn publish_outcome(&self, outcome: Outcome, events: &mut Events) {
        let Some(runner) = self
            .executor
            .as_ref()
            .filter(|_| outcome == Outcome::NextStep)
        else {
            return;
        };
        events.push(self.step_event(runner.step()));
        if let Some(fit) = runner.stiffness_before() {
            let mut event = self.event(EventKind::STIFFNESS);
            event.value = fit.object_n_m;
            event.threshold = runner.object().thresholds().f2_n;
            events.push(event);
        }
    }

    /// Returns the event that announces a step.
    #[must_use]
    pub(crate) fn step_event(&self, step: &Step) -> ModuleEvent {
        ModuleEvent {
            text: shm_schemas::Text::new(&step.name),
            ..self.event(EventKind::STEP)
        }
    }
}
