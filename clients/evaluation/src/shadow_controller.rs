//! Production controller that runs beside a recorder. The recorder saves its state at the start of
//! each file, so that the file can be replayed alone.

use atas_controller_state::encode;
use atas_core::record::Replay;
use atas_recording::Follower;
use shm_schemas::{HandFrame, RunHeader, TickInputs};

use crate::replay::{frame_buffers, initial_controller};

/// Production controller that replays a run while it is recorded.
#[derive(Debug, Default)]
pub struct ShadowController {
    replay: Option<Replay<Vec<HandFrame>>>,
}

impl Follower for ShadowController {
    fn begin(&mut self, run: &RunHeader) -> anyhow::Result<()> {
        self.replay = None;
        self.replay = Some(Replay::new(initial_controller(run, None)?, frame_buffers()));
        Ok(())
    }

    fn update(&mut self, part: &TickInputs) -> anyhow::Result<()> {
        let Some(replay) = &mut self.replay else {
            return Ok(());
        };
        if let Some(replayed) = replay.feed(part)? {
            anyhow::ensure!(
                replayed.is_equal,
                "the daemon's commands differ from this version's in tick {}",
                part.tick
            );
        }
        Ok(())
    }

    fn is_within_tick(&self) -> bool {
        self.replay
            .as_ref()
            .is_some_and(|replay| replay.state().is_none())
    }

    fn state(&self) -> anyhow::Result<Option<Vec<u8>>> {
        let state = self.replay.as_ref().and_then(Replay::state);
        let begun = state.filter(|(_, next_sequence)| *next_sequence > 0);
        begun
            .map(|(controller, next_sequence)| encode(controller, next_sequence))
            .transpose()
    }
}
