//! One robot in process: its pilot, and the world and controller of its hands.

use anyhow::Context;
use atas_core::{OperatorRequest, Settings};
use robot_model::RobotModel;
use shm_schemas::{BaseCommand, Mode, WorldTruth};
use sim_backend::course::{Host, Responses, RobotSetup, SETTLE_TICKS};

use super::pilot::{Pilot, Reflexes};
use crate::offline::OfflineRun;

pub(super) struct Robot {
    index: usize,
    /// On the heap, because controller and world are large.
    run: Box<OfflineRun>,
    pub(super) pilot: Pilot,
    request: Option<OperatorRequest>,
}

impl Robot {
    pub(super) fn new(
        model: &RobotModel,
        (index, player): (usize, &RobotSetup),
        reflexes: Reflexes,
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let at_rest = OfflineRun::without_tick(model, &player.scene, player.seed, *settings)?;
        let mut run = Box::new(at_rest);
        run.set_task(reflexes.custom_task());
        for _ in 0..SETTLE_TICKS {
            run.step(None);
        }
        let (mode, reason) = run.controller().mode();
        anyhow::ensure!(
            mode == Mode::READY,
            "could not begin the course: the controller was {mode} ({reason}) after {SETTLE_TICKS} \
             ticks, but must be ready"
        );
        Ok(Self {
            index,
            run,
            pilot: Pilot::new(player, model, reflexes),
            request: None,
        })
    }

    pub(super) fn frame(&mut self, host: &mut Host, table: Responses) -> Option<&'static str> {
        let truth = self.truth();
        let state = host.base_state(self.index, &truth);
        if self.pilot.ended().is_some() {
            return None;
        }
        let decision = self.pilot.frame(&state, &truth);
        if let Some(goal) = decision.goal {
            match self.run.request(&goal) {
                Ok(order) => self.request = Some(order),
                Err(reason) => self.pilot.process_rejection(reason),
            }
        }
        self.drive(host, &decision.command, table, &truth);
        decision.began
    }

    fn drive(&self, host: &mut Host, command: &BaseCommand, table: Responses, truth: &WorldTruth) {
        let row = host.row(self.index, command);
        let wheels = row.map(|row| table.get(row));
        host.execute(self.index, command, wheels, truth);
    }

    pub(super) fn tick(&mut self, host: &mut Host) -> anyhow::Result<()> {
        self.run.set_base_motion(&host.base_motion(self.index))?;
        let outputs = *self.run.step(self.request.take().as_ref());
        self.pilot.process_report(&outputs.report);
        if let Some(update) = &outputs.goal_update {
            self.pilot.process_goal_update(update);
        }
        host.measure(self.index, || self.truth());
        let fault = self.run.world().fault();
        fault.map_or(Ok(()), |fault| {
            Err(fault).context("a fault stopped the world of a robot's hands")
        })
    }

    pub(super) fn truth(&self) -> WorldTruth {
        self.run.world().truth()
    }
}
