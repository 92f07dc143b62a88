//! Jump of the wall clock of one process.
//!
//! No process may set the clock of the machine for a test. Therefore a small C library between the
//! daemon and its C library adds ten years to the wall clock. The C compiler of the machine builds
//! it for the run.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::Context;
use shm_schemas::GoalState;

use super::goals::{answer, other_goal};
use super::{Drill, Effect, Pace, Rig};

/// Source of the library: after the file exists, the wall clock is ten years ahead.
const SOURCE: &str = r#"
#define _GNU_SOURCE
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long ahead(void) {
    const char *jump = getenv("ATAS_CLOCK_JUMP");
    return jump && access(jump, F_OK) == 0 ? 315569520L : 0;
}
int clock_gettime(clockid_t clock, struct timespec *now) {
    int result = syscall(SYS_clock_gettime, clock, now);
    if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += ahead();
    return result;
}
int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    struct timespec precise;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &precise);
    now->tv_sec = precise.tv_sec;
    now->tv_usec = precise.tv_nsec / 1000;
    return 0;
}
time_t time(time_t *out) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out) *out = now.tv_sec;
    return now.tv_sec;
}
"#;
/// Least difference of the years in the log before and after the jump.
const YEARS: i64 = 9;

/// The wall clock of the daemon jumps by ten years during a goal.
pub(super) const WALL_CLOCK: Drill = Drill::new(Pace::LockStep, wall_clock)
    .unless(no_compiler)
    .with_setup(|setup| setup.has_jumping_clock = true);

fn no_compiler() -> Option<String> {
    let tried = Command::new("cc")
        .arg("--version")
        .stdin(Stdio::null())
        .output();
    match tried {
        Ok(output) if output.status.success() => None,
        _ => Some("a C compiler `cc` is needed to change the clock of one process".to_owned()),
    }
}

/// Builds the library. Returns its path and that of the file that lets the clock jump.
pub(crate) fn library(folder: &Path) -> anyhow::Result<[PathBuf; 2]> {
    let [source, library, jump] = ["clock.c", "clock.so", "jump"].map(|name| folder.join(name));
    if !library.exists() {
        std::fs::write(&source, SOURCE)?;
        let output = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([&library, &source])
            .output()
            .context("could not start cc")?;
        let text = String::from_utf8_lossy(&output.stderr);
        anyhow::ensure!(output.status.success(), "cc fails: {text}");
    }
    Ok([library, jump])
}

fn wall_clock(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    std::fs::write(rig.logs.folder.join("jump"), "")?;
    // The daemon logs a rejected goal, with the time of the wall clock.
    let client = rig.observer.goal_client()?;
    let update = answer(rig, &client, &other_goal(rig), 1)?;
    if update.state != GoalState::REJECTED {
        let text = format!("a second goal is {} during the first", update.state);
        return Ok(Effect::Failed(text));
    }
    let log = rig.daemon.log();
    let years: Vec<i64> = log.lines().filter_map(year).collect();
    let has_jumped = match (years.first(), years.last()) {
        (Some(first), Some(last)) => last - first >= YEARS,
        _ => false,
    };
    if has_jumped {
        return Ok(Effect::Done);
    }
    let reason = "the clock of the daemon could not be changed: its log shows no later year";
    Ok(Effect::Skipped(reason.to_owned()))
}

/// Returns the year at the beginning of a log line.
fn year(line: &str) -> Option<i64> {
    line.get(..4)?.parse().ok()
}
