//! Faults that take processor time from the daemon.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use atas_process::scheduling::enter_fifo;
use rustix::process::Signal;

use super::{Drill, Effect, Pace, Rig};

/// Ticks of a stop. Design choice: longer than the age limits of a run by the clock.
const STOP_TICKS: u64 = 1_500;
/// Pauses of a slow tick, their length and their distance, ticks.
const PAUSES: u64 = 50;
const PAUSE_TICKS: u64 = 2;
const BETWEEN_TICKS: u64 = 8;
/// Length of an overload, ticks, and busy threads per core. Design choice.
const OVERLOAD_TICKS: u64 = 2_000;
const THREADS_PER_CORE: usize = 2;
/// Bursts of a thread of highest priority, and the length of each. Design choice: below the share
/// that the kernel leaves to real-time threads.
const BURSTS: u64 = 10;
const BURST: Duration = Duration::from_millis(20);
const HIGHEST_PRIORITY: i32 = 99;

/// SIGSTOP for 1.5 s, then SIGCONT.
pub(super) const STOPPED: Drill = Drill::new(Pace::Clock, stopped).ending_the_goal();

/// The daemon does not run for 2 ms in 50 of its ticks, as with a slow module.
pub(super) const SLOW_TICKS: Drill = Drill::new(Pace::Clock, slow_ticks);

/// Two busy threads per core for 2 s.
pub(super) const OVERLOAD: Drill = Drill::new(Pace::Clock, overload);

/// A thread of the highest real-time priority takes a core.
pub(super) const REAL_TIME_HOG: Drill = Drill::new(Pace::Clock, real_time_hog).unless(no_real_time);

fn stopped(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.daemon.signal(Signal::STOP)?;
    wait_until_stopped(rig)?;
    rig.receive()?;
    rig.promise();
    rig.advance(STOP_TICKS)?;
    rig.daemon.signal(Signal::CONT)?;
    Ok(Effect::Done)
}

/// Waits until the kernel has stopped the process.
fn wait_until_stopped(rig: &mut Rig<'_>) -> anyhow::Result<()> {
    let (begin, path) = (Instant::now(), format!("/proc/{}/stat", rig.daemon.pid()));
    loop {
        let text = std::fs::read_to_string(&path)?;
        let state = text.rsplit_once(") ").map_or("", |(_, rest)| rest);
        if state.starts_with('T') {
            return Ok(());
        }
        anyhow::ensure!(
            begin.elapsed() < Duration::from_secs(30),
            "the daemon does not stop after SIGSTOP"
        );
        std::thread::sleep(Duration::from_micros(200));
    }
}

fn slow_ticks(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    for _ in 0..PAUSES {
        rig.daemon.signal(Signal::STOP)?;
        let paused = rig.advance(PAUSE_TICKS);
        // The daemon must run again, also after an error.
        rig.daemon.signal(Signal::CONT)?;
        paused?;
        rig.advance(BETWEEN_TICKS)?;
    }
    Ok(Effect::Done)
}

fn overload(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for _ in 0..cores * THREADS_PER_CORE {
            scope.spawn(|| {
                while !stop.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let ran = rig.advance(OVERLOAD_TICKS);
        stop.store(true, Ordering::Relaxed);
        ran
    })?;
    Ok(Effect::Done)
}

fn no_real_time() -> Option<String> {
    let tried = std::thread::spawn(|| enter_fifo(HIGHEST_PRIORITY)).join();
    match tried {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(format!(
            "real-time priority {HIGHEST_PRIORITY} is refused: {error}"
        )),
        Err(_) => Some("the thread of highest priority panicked".to_owned()),
    }
}

fn real_time_hog(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    for _ in 0..BURSTS {
        let burst = std::thread::spawn(|| {
            let refused = enter_fifo(HIGHEST_PRIORITY).err();
            let until = Instant::now() + BURST;
            while refused.is_none() && Instant::now() < until {
                std::hint::spin_loop();
            }
            refused
        });
        rig.advance(2 * BURST.as_millis() as u64)?;
        if let Ok(Some(error)) = burst.join() {
            return Ok(Effect::Skipped(format!(
                "real-time priority {HIGHEST_PRIORITY} is refused: {error}"
            )));
        }
    }
    Ok(Effect::Done)
}
