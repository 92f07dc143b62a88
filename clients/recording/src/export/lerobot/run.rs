//! Episodes of a recorded run: one per goal, with frames at a fixed rate.

use atas_client::goal_summary::begins;
use shm_schemas::{EventKind, GoalKind, GoalRequest, Hand};

use super::DatasetChoices;
use super::episode::Episode;
use super::features::{Features, Newest};
use super::writer::Writer;
use crate::rows::Row;

/// Goals of a run, read tick by tick.
pub(super) struct Run {
    features: Features,
    hand: Hand,
    stride: u64,
    newest: Newest,
    episode: Option<Episode>,
}

impl Run {
    pub(super) fn new(features: Features, hand: Hand, stride: u32) -> Self {
        Self {
            features,
            hand,
            stride: stride.into(),
            newest: Newest::default(),
            episode: None,
        }
    }

    /// Adds one tick of the recording.
    pub(super) fn tick(
        &mut self,
        row: &Row,
        goal: Option<GoalRequest>,
        choices: &DatasetChoices,
        writer: &mut Writer,
    ) -> anyhow::Result<()> {
        if let Some(goal) = goal {
            // A goal without a recorded end has ended before the next one begins.
            self.end(None, choices, writer)?;
            self.newest.begin_goal();
            if goal.kind != GoalKind::RELEASE {
                let is_own = goal.hand == self.hand || goal.kind == GoalKind::TELEOP_BOTH;
                writer.dataset.skipped += usize::from(!is_own);
                self.episode = is_own.then(|| Episode {
                    goal,
                    next_tick: row.tick,
                    states: Vec::new(),
                    taxels: Vec::new(),
                    actions: Vec::new(),
                    frames: 0,
                });
            }
        }
        self.features.update(&mut self.newest, row)?;
        if let Some(episode) = &mut self.episode
            && row.tick >= episode.next_tick
        {
            let state = self.features.state(&self.newest);
            let action = self.features.action(&self.newest);
            if let (Some(state), Some(action)) = (state, action) {
                // Frames of lost ticks repeat the next known values, so that time stays uniform.
                let due = (row.tick - episode.next_tick) / self.stride + 1;
                for _ in 0..due {
                    episode.add_action(action);
                    episode.states.extend(&state);
                    episode.taxels.extend(self.features.taxels(&self.newest));
                    episode.frames += 1;
                }
                episode.next_tick += self.stride * due;
            }
        }
        let is_end = |event: &&shm_schemas::ModuleEvent| {
            event.kind == EventKind::GOAL && !begins(event) && self.episode.is_some()
        };
        if let Some(end) = row.events.iter().find(is_end) {
            self.end(Some(end.text.as_str()), choices, writer)?;
        }
        Ok(())
    }

    /// Writes the episode, if one is being read.
    pub(super) fn end(
        &mut self,
        end: Option<&str>,
        choices: &DatasetChoices,
        writer: &mut Writer,
    ) -> anyhow::Result<()> {
        let Some(mut episode) = self.episode.take() else {
            return Ok(());
        };
        match self.features.action(&self.newest) {
            Some(action) if episode.frames > 0 => episode.add_action(action),
            _ => {
                writer.dataset.skipped += 1;
                return Ok(());
            }
        }
        let task = choices.task.clone().unwrap_or_else(|| text(&episode.goal));
        writer.write(
            &self.features,
            &episode,
            &task,
            end.unwrap_or("not recorded"),
        )
    }
}

/// Returns the default task text.
fn text(goal: &GoalRequest) -> String {
    match goal.kind {
        GoalKind::GRASP => "Grasp the object and lift it.".to_owned(),
        GoalKind::PICK_PLACE => "Pick the object up and place it.".to_owned(),
        GoalKind::SCREW => "Screw the cap.".to_owned(),
        GoalKind::ASSEMBLE => "Screw the cap onto the bottle.".to_owned(),
        GoalKind::CUSTOM => goal.task.to_string(),
        kind => kind.name().to_owned(),
    }
}
