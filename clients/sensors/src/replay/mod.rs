//! Recorded frames, played onto the bus as the process of a sensor would publish them.
//!
//! ```text
//! recording ─┐
//! table ─────┴▶ Source (frames as they were) ─▶ Timeline (which, and when) ─▶ player (fresh stamps) ─▶ bus
//!               a thread that reads ahead
//! ```
//!
//! * **In:** the files of one run, or a table that `--dry-run` printed. **Out:** frames with the recorded layout, masks and
//!   forces, bit for bit; epoch, sequence and time of this process.
//! * **Invariants:** what is played goes forward, with the gaps that it was recorded with. A frame that was damaged when it
//!   was recorded, or is not newer than all before, is left out and counted. A recording that ends in damage is played as
//!   far as it can be read; then the damage is the failure.
//! * **Absent on purpose:** joints and commands: a robot that is played back would not be where the daemon thinks.

mod player;
mod recording;
mod table;
mod timeline;

use std::path::{Path, PathBuf};

use shm_schemas::{Hand, HandFrame};

use crate::failure::Failure;
pub use player::{Played, play};
use recording::Recording;
use table::Table;
pub use timeline::{Pace, Timeline};

/// What to play.
#[derive(Clone, Debug)]
pub struct Source {
    /// The files of one run in order, or one table.
    pub files: Vec<PathBuf>,
    /// Whose frames.
    pub hand: Hand,
    /// What a table does not say of itself: the layout of its fingertips, by default one made for its columns.
    pub layout: Option<String>,
    /// The same: its fingertips, by default one.
    pub fingers: Option<usize>,
}

/// Frames in the order in which they were recorded, or why there are no more.
pub type Frames = Box<dyn Iterator<Item = Result<HandFrame, String>>>;

impl Source {
    /// Looks at what there is to play.
    ///
    /// # Errors
    /// [`Failure::Recording`] when there is nothing to play; [`Failure::Usage`] when what was said does not fit it.
    pub fn check(&self) -> Result<(), Failure> {
        let told = self.layout.is_some() || self.fingers.is_some();
        match (self.is_recording()?, &*self.files) {
            (true, _) if told => {
                return Err(Failure::Usage(
                    "could not use --layout or --fingers: a recording has its own, only a table is told".to_owned(),
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
            None => Err(Failure::Recording(self.nothing())),
        }
    }

    /// The frames, from the first.
    ///
    /// # Errors
    /// [`Failure::Recording`] when a file cannot be opened.
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

    /// What is played, for reports.
    #[must_use]
    pub fn name(&self) -> String {
        self.files[0].display().to_string()
    }

    fn is_recording(&self) -> Result<bool, Failure> {
        atas_recording::is_recording(&self.files[0])
            .map_err(|error| Failure::Recording(format!("{error:#}")))
    }

    fn nothing(&self) -> String {
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

/// The parser of records draws pictures over several lines; the first says what it is about.
fn one_line(error: &impl std::fmt::Display) -> String {
    let text = format!("{error:#}");
    let line = text.lines().next().unwrap_or_default();
    line.trim_end_matches([' ', ':']).to_owned()
}
