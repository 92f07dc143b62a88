//! One robot in process: its pilot, and the world and controller of its hands.

use anyhow::Context;
use atas_core::{Order, Settings};
use robot_model::RobotModel;
use shm_schemas::{BaseCommand, Mode, WorldTruth};
use sim_backend::course::{Host, Player, Responses, SETTLE_TICKS};

use super::pilot::{Pilot, Reflexes};
use crate::offline::OfflineRun;

pub(super) struct Robot {
    index: usize,
    /// On the heap, because controller and world are large.
    run: Box<OfflineRun>,
    pub(super) pilot: Pilot,
    order: Option<Order>,
}

impl Robot {
    pub(super) fn new(
        model: &RobotModel,
        (index, player): (usize, &Player),
        reflexes: Reflexes,
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let at_rest = OfflineRun::at_rest(model, &player.scene, player.seed, *settings)?;
        let mut run = Box::new(at_rest);
        run.teach(reflexes.lesson());
        for _ in 0..SETTLE_TICKS {
            run.step(None);
        }
        let (mode, reason) = run.controller().mode();
        anyhow::ensure!(
            mode == Mode::READY,
            "could not begin the course because the controller was {mode} ({reason}) after {SETTLE_TICKS} ticks, needs ready"
        );
        Ok(Self {
            index,
            run,
            pilot: Pilot::new(player, reflexes),
            order: None,
        })
    }

    pub(super) fn frame(&mut self, host: &mut Host, table: Responses) -> Option<&'static str> {
        let truth = self.truth();
        let state = host.look(self.index, &truth);
        if self.pilot.ended().is_some() {
            return None;
        }
        let decision = self.pilot.frame(&state, &truth);
        if let Some(goal) = decision.goal {
            match self.run.order(&goal) {
                Ok(order) => self.order = Some(order),
                Err(reason) => self.pilot.hear_rejection(reason),
            }
        }
        self.obey(host, &decision.command, table, &truth);
        decision.began
    }

    fn obey(&self, host: &mut Host, command: &BaseCommand, table: Responses, truth: &WorldTruth) {
        let row = host.row(self.index, command);
        let wheels = row.map(|row| table.get(row));
        host.obey(self.index, command, wheels, truth);
    }

    pub(super) fn tick(&mut self, host: &mut Host) -> anyhow::Result<()> {
        self.run.ride(&host.ride(self.index))?;
        let outputs = *self.run.step(self.order.take().as_ref());
        self.pilot.hear_report(&outputs.report);
        if let Some(update) = &outputs.goal_update {
            self.pilot.hear_goal(update);
        }
        host.watch(self.index, || self.truth());
        let fault = self.run.world().fault();
        fault.map_or(Ok(()), |fault| {
            Err(fault).context("the world of a robot's hands cannot go on")
        })
    }

    pub(super) fn truth(&self) -> WorldTruth {
        self.run.world().truth()
    }
}
