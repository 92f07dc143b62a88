//! Frames of one hand from a recorded run.

use std::path::PathBuf;

use atas_recording::Frames;
use shm_schemas::{Hand, HandFrame};

use super::one_line;

/// Frames in the order in which the daemon received them.
pub(super) struct Recording {
    frames: Frames,
    name: String,
    hand: Hand,
    /// Number of frames of this hand, and of the other.
    found: [u64; 2],
    has_ended: bool,
}

impl Recording {
    pub(super) fn new(files: &[PathBuf], hand: Hand) -> Self {
        Self {
            frames: Frames::open(files),
            name: files[0].display().to_string(),
            hand,
            found: [0; 2],
            has_ended: false,
        }
    }

    /// Returns the next frame; `None` at the end. Fails if there were no frames.
    fn read(&mut self) -> Result<Option<HandFrame>, String> {
        for measured in &mut self.frames {
            let measured = measured.map_err(|error| one_line(&error))?;
            let is_other = measured.hand != self.hand;
            self.found[usize::from(is_other)] += 1;
            if !is_other {
                return Ok(Some(measured.frame));
            }
        }
        let Self { name, hand, .. } = self;
        match self.found {
            [0, 0] => Err(format!(
                "could not play {name}: it was recorded without a sensor"
            )),
            [0, _] => Err(format!(
                "could not play the {hand} hand of {name}: only the other hand has frames in it"
            )),
            _ => Ok(None),
        }
    }
}

impl Iterator for Recording {
    type Item = Result<HandFrame, String>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let next = self.read().transpose();
        self.has_ended = !matches!(next, Some(Ok(_)));
        next
    }
}
