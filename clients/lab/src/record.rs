//! `atas record`: runs the recorder. For recordings of several files, a shadow controller runs as
//! well, so that each file can be replayed alone.

use std::path::PathBuf;
use std::time::SystemTime;

use atas_client::Session;
use atas_console::{Exit, ExitError, Interrupt, Output, arguments};
use atas_evaluation::shadow_controller::ShadowController;
use atas_recording::{Bounds, Follower, Tally};
use serde_json::json;

pub(crate) fn record(
    arguments: &arguments::Record,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::join(&arguments.bus.bus)?;
    let out = arguments.out.clone().unwrap_or_else(default_out);
    let bounds = Bounds {
        file_bytes: arguments.max_size,
        files: arguments.max_files.map(usize::from),
        total_bytes: arguments.disk_budget,
    };
    let notes = arguments.notes.iter().cloned().collect();
    // The shadow controller costs about as much CPU time as the daemon's ticks.
    let follower = arguments
        .max_size
        .map(|_| Box::<ShadowController>::default() as Box<dyn Follower>);
    let stop = interrupt.flag();
    let tally = atas_recording::record(
        session.bus(),
        &out,
        bounds,
        notes,
        follower,
        notify_service_manager,
        stop,
    )?;
    print(&tally, output)
}

/// Notifies the service manager, if there is one, that recording has begun: the daemon starts after
/// the recorder and no tick is lost.
fn notify_service_manager() {
    if let Err(error) = sd_notify::notify(&[sd_notify::NotifyState::Ready]) {
        tracing::warn!(%error, "could not notify the service manager");
    }
}

fn default_out() -> PathBuf {
    let unix = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    format!("atas-{}.mcap", unix.map_or(0, |time| time.as_secs())).into()
}

fn print(tally: &Tally, output: &mut Output) -> anyhow::Result<()> {
    let files: Vec<String> = tally
        .files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    if output.is_json() {
        output.json(&json!({
            "parts": tally.parts,
            "lost": tally.lost,
            "has_beginning": tally.has_beginning,
            "disk_budget_reached": tally.is_full,
            "bytes": tally.bytes,
            "files": files,
        }))?;
    } else {
        output.line(format_args!(
            "recorded {} parts of ticks, lost {}, {:.1} MiB in {}",
            tally.parts,
            tally.lost,
            tally.bytes as f64 / f64::from(1 << 20),
            files.join(", ")
        ))?;
    }
    if tally.is_full {
        return Err(ExitError::with_code(
            Exit::Failed,
            "the recording ended early: the disk budget is exhausted; raise --disk-budget",
        ));
    }
    if tally.lost > 0 {
        let sentence = format!(
            "the recording cannot be replayed completely: {} parts of ticks are lost",
            tally.lost
        );
        return Err(ExitError::with_code(Exit::Failed, sentence));
    }
    if !tally.has_beginning {
        tracing::warn!(
            "a run was not recorded from its first tick and cannot be replayed; start the recorder \
             first"
        );
    }
    Ok(())
}
