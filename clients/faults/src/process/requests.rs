//! Goals and control requests of the runner.

use std::time::Instant;

use anyhow::Context;
use shm_bus::BusError;
use shm_schemas::{ControlOp, ControlOutcome, ControlReply, ControlRequest, Status, Text};

use super::pace::TIMEOUT;
use super::rig::PAUSE;
use super::{Pace, Rig};

impl Rig<'_> {
    /// Returns the newest status of the daemon.
    pub(crate) fn status(&mut self) -> Result<&Status, BusError> {
        self.ports.statuses.newest(&mut self.ports.status)?;
        Ok(&self.ports.status)
    }

    /// Sends the goal of the course and runs its first tick.
    pub(crate) fn begin_goal(&mut self) -> anyhow::Result<()> {
        let goals = self.observer.goal_client()?;
        self.pending = Some(until_served(|| goals.send(&self.course.goal))?);
        self.goals = Some(goals);
        self.begin_pursuit()
    }

    /// Runs the first tick of a goal that any client has sent.
    pub(crate) fn begin_pursuit(&mut self) -> anyhow::Result<()> {
        self.advance(1)?;
        if self.setup.pace == Pace::LockStep {
            // From now on the daemon answers every joint state, also without a goal.
            self.control(ControlOp::ADVANCE, "", 2_f64.powi(53))?;
        }
        Ok(())
    }

    /// Sends a control request that the daemon answers without a tick.
    pub(crate) fn call(&mut self, request: &ControlRequest) -> anyhow::Result<ControlReply> {
        if self.control.is_none() {
            self.control = Some(self.observer.control_client()?);
        }
        let client = self.control.as_ref().context("a client was opened")?;
        until_served(|| client.call(request, TIMEOUT))
    }

    /// Sends a control request that the daemon executes without a tick.
    pub(crate) fn control(&mut self, op: ControlOp, name: &str, value: f64) -> anyhow::Result<()> {
        let request = ControlRequest {
            op,
            name: Text::new(name),
            value,
            ..ControlRequest::default()
        };
        let reply = self.call(&request)?;
        anyhow::ensure!(
            reply.outcome == ControlOutcome::DONE,
            "the daemon refuses {op:?}: {}",
            reply.text
        );
        Ok(())
    }

    pub(super) fn poll_goal(&mut self) {
        let Some(pending) = &mut self.pending else {
            return;
        };
        // A daemon that has gone ends the goal without an update; the judge reports the rest.
        while let Ok(Some(update)) = pending.next() {
            self.step = update.step.to_string();
            self.end = Some(update).filter(|update| update.state.is_final());
        }
    }
}

/// Repeats a request until a daemon serves it.
fn until_served<T>(mut request: impl FnMut() -> Result<T, BusError>) -> anyhow::Result<T> {
    let begin = Instant::now();
    loop {
        match request() {
            Err(BusError::NoServer { .. }) if begin.elapsed() < TIMEOUT => {
                std::thread::sleep(PAUSE);
            }
            answer => return Ok(answer?),
        }
    }
}
