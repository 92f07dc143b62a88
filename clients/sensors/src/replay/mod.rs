//! Replay of recorded frames onto the bus, as a sensor process would publish them.
//!
//! ```text
//! recording ─┐
//! table ─────┴▶ Source (recorded frames) ─▶ Timeline (spacing) ─▶ player (new stamps) ─▶ bus
//!               read-ahead thread
//! ```
//!
//! * **Input:** the files of one run, or a table from `--dry-run`. **Output:** frames with the
//!   recorded layout, masks and forces, bit for bit; epoch, sequence and time of this process.
//! * **Invariants:** frames are played forward, with the recorded gaps. Frames that were damaged
//!   when recorded, or are not newer than all before, are skipped and counted. A damaged recording
//!   is played up to the damage, which is then the error.
//! * **Not included:** joints and commands. A replayed robot would not be at the position that the
//!   daemon commands.

mod player;
mod recording;
mod table;
mod timeline;

use std::path::{Path, PathBuf};

use shm_schemas::{Hand, HandFrame};

use crate::failure::Failure;
pub use player::{ReplaySummary, play};
use recording::Recording;
use table::Table;
pub use timeline::{Pace, Timeline};

/// Source of a replay.
#[derive(Clone, Debug)]
pub struct Source {
    /// The files of one run in order, or one table.
    pub files: Vec<PathBuf>,
    /// Hand of the frames.
    pub hand: Hand,
    /// Fingertip layout of a table; default: a layout for the number of its columns.
    pub layout: Option<String>,
    /// Number of fingertips of a table; default: one.
    pub fingers: Option<usize>,
}

/// Frames in recorded order, or the error that ends them.
pub type Frames = Box<dyn Iterator<Item = Result<HandFrame, String>>>;

impl Source {
    /// Checks the source.
    ///
    /// # Errors
    /// [`Failure::Recording`] if there is nothing to play; [`Failure::Usage`] if options do not fit
    /// the source.
    pub fn check(&self) -> Result<(), Failure> {
        let reported = self.layout.is_some() || self.fingers.is_some();
        match (self.is_recording()?, &*self.files) {
            (true, _) if reported => {
                return Err(Failure::Usage(
                    "could not use --layout or --fingers: they are for tables; a recording \
                     contains its layout"
                        .to_owned(),
                ));
            }
            (false, [_, _, ..]) => {
                return Err(Failure::Usage(
                    "could not play several tables as one; name one, or the files of one recorded run".to_owned(),
                ));
            }
            (true, files) if files.len() > 1 => one_run(files)?,
            _ => {}
        }
        match self.frames()?.next() {
            Some(Ok(_)) => Ok(()),
            Some(Err(reason)) => Err(Failure::Recording(reason)),
            None => Err(Failure::Recording(self.no_frames_error())),
        }
    }

    /// Opens the frames from the first.
    ///
    /// # Errors
    /// [`Failure::Recording`] if a file cannot be opened.
    pub fn frames(&self) -> Result<Frames, Failure> {
        if self.is_recording()? {
            return Ok(Box::new(Recording::new(&self.files, self.hand)));
        }
        let table = Table::open(
            &self.files[0],
            self.hand,
            self.fingers,
            self.layout.as_deref(),
        );
        Ok(Box::new(table.map_err(Failure::Recording)?))
    }

    /// Returns the name of the source for reports.
    #[must_use]
    pub fn name(&self) -> String {
        self.files[0].display().to_string()
    }

    fn is_recording(&self) -> Result<bool, Failure> {
        atas_recording::is_recording(&self.files[0])
            .map_err(|error| Failure::Recording(format!("{error:#}")))
    }

    fn no_frames_error(&self) -> String {
        format!("could not play {}: it has no frames", self.name())
    }
}

fn one_run(files: &[PathBuf]) -> Result<(), Failure> {
    let runs = atas_recording::runs(files).map_err(|error| Failure::Recording(one_line(&error)))?;
    match &*runs {
        [_] => Ok(()),
        several => Err(Failure::Recording(format!(
            "could not play {} runs of the daemon as one; the first is {}",
            several.len(),
            listed(&several[0])
        ))),
    }
}

fn listed(files: &[PathBuf]) -> String {
    let names = files.iter().map(|file| Path::display(file).to_string());
    names.collect::<Vec<_>>().join(", ")
}

/// Returns the first line of an error. The record parser adds drawings on further lines.
fn one_line(error: &impl std::fmt::Display) -> String {
    let text = format!("{error:#}");
    let line = text.lines().next().unwrap_or_default();
    line.trim_end_matches([' ', ':']).to_owned()
}
