//! `replay`: publishes a recording instead of a device.

use std::io::{self, Write};

use super::stop_on_signal;
use crate::cli::ReplayArgs;
use crate::failure::Failure;
use crate::replay::{Pace, Source, play};

/// Plays the recording and prints a summary.
pub(super) fn run(arguments: ReplayArgs) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let speed = Pace::Speed(arguments.speed);
    let pace = arguments.rate_hz.map_or(speed, Pace::Rate);
    let source = Source {
        files: arguments.files,
        hand: arguments.hand,
        layout: arguments.layout,
        fingers: arguments.fingers,
    };
    let (played, outcome) = play(&source, pace, arguments.repeat, &arguments.bus, &stop);
    if outcome.is_ok() || played.frames > 0 {
        let name = source.name();
        let _ = writeln!(io::stderr(), "{name}, {} hand: {played}", source.hand);
    }
    outcome
}
