//! Real-time set-up: locked memory, pinned core, `SCHED_FIFO`, pre-faulted stack, limited idle
//! states of the cores.
//!
//! A refusal of the kernel stops the daemon under `realtime.mode = "require"`, and is shown as
//! `DEGRADED` under `"try"`.

use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};

use atas_process::scheduling;
use rustix::mm::MlockAllFlags;
use rustix::process::{Resource, Rlimit};
use rustix::thread::CpuSet;

use crate::config::{Cpu, Realtime, RealtimeMode};

/// Maximum computing time of the tick thread without a sleep, µs; the kernel then ends the process
/// (fault catalogue F28: at most 25 ms), and the robot driver holds.
const COMPUTE_MAX_US: u64 = 20_000;
/// Stack pre-faulted before the first tick, bytes: several times a tick's use.
const STACK_BYTES: usize = 128 << 10;
/// Timer slack of the tick thread, ns: the minimum. It matters only without `SCHED_FIFO`.
const TIMER_SLACK_NS: u64 = 1;

/// Device that limits the wake-up latency of idle cores. The limit holds while the file is open and
/// so ends with the process; per-core settings would outlive a killed daemon.
const IDLE_LATENCY_DEVICE: &str = "/dev/cpu_dma_latency";

/// Real-time request refused by the kernel.
#[derive(Debug, thiserror::Error)]
#[error("could not {what}: {source}; {cure}")]
pub struct Refused {
    what: String,
    source: io::Error,
    cure: &'static str,
}

/// Real-time properties granted by the kernel.
#[derive(Debug, Default)]
pub struct Granted {
    /// The tick thread runs under `SCHED_FIFO`.
    pub fifo: bool,
    /// Memory is locked.
    pub locked: bool,
    /// Open idle-latency device.
    pub idle_latency: Option<File>,
    /// Refused requests.
    pub refused: Vec<Refused>,
}

impl Granted {
    fn record(&mut self, mode: RealtimeMode, result: Result<(), Refused>) -> Result<bool, Refused> {
        match result {
            Ok(()) => Ok(true),
            Err(refused) if mode == RealtimeMode::Require => Err(refused),
            Err(refused) => {
                self.refused.push(refused);
                Ok(false)
            }
        }
    }
}

/// Locks present and future memory of the process. Call before the tick thread starts.
///
/// # Errors
/// [`Refused`] under `require`.
pub fn lock_memory(realtime: &Realtime) -> Result<Granted, Refused> {
    let mut granted = Granted::default();
    if realtime.mode != RealtimeMode::Off {
        let all = MlockAllFlags::CURRENT | MlockAllFlags::FUTURE;
        granted.locked = granted.record(realtime.mode, mlockall(all))?;
    }
    Ok(granted)
}

/// Locks memory that is mapped from now on page by page, at the first use. Call after the set-up of
/// the tick thread. Peers that join later map pools of up to 3.4 MB, of which a reader touches few
/// pages; to make all of them resident would also delay the tick that maps them.
///
/// # Errors
/// [`Refused`] under `require`.
pub fn lock_later_memory_on_use(realtime: &Realtime, granted: &mut Granted) -> Result<(), Refused> {
    if granted.locked {
        let later = MlockAllFlags::FUTURE | MlockAllFlags::ONFAULT;
        granted.locked = granted.record(realtime.mode, mlockall(later))?;
    }
    Ok(())
}

/// Keeps the cores out of slow idle states while the device is open, at the cost of power. A
/// refusal adds at most about 50 µs of wake-up latency; it is logged and never degrades the daemon.
///
/// # Errors
/// [`Refused`], for the log.
pub fn limit_idle_latency(realtime: &Realtime, granted: &mut Granted) -> Result<(), Refused> {
    if realtime.mode == RealtimeMode::Off || !realtime.keep_awake {
        return Ok(());
    }
    let wish = |mut file: File| file.write_all(&0_i32.to_ne_bytes()).map(|()| file);
    let opened = OpenOptions::new()
        .write(true)
        .open(IDLE_LATENCY_DEVICE)
        .and_then(wish);
    granted.idle_latency = Some(opened.map_err(|source| Refused {
        what: format!("limit the idle latency of the cores through {IDLE_LATENCY_DEVICE}"),
        source,
        cure: "install daemon/systemd/60-atas.rules, which gives the group atas access, or set \
            realtime.keep_awake to false",
    })?);
    Ok(())
}

/// Makes the calling thread the tick thread.
///
/// # Errors
/// [`Refused`] under `require`; under `try` refusals are added to `granted.refused`.
pub fn enter_tick_thread(realtime: &Realtime, granted: &mut Granted) -> Result<(), Refused> {
    if realtime.mode == RealtimeMode::Off {
        return Ok(());
    }
    let mode = realtime.mode;
    if let Cpu::Core(core) = realtime.cpu {
        granted.record(mode, pin(core))?;
    }
    // Only affects threads without `SCHED_FIFO`; a failure is harmless.
    let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(TIMER_SLACK_NS));
    granted.fifo = granted.record(mode, schedule_fifo(realtime.priority))?;
    if granted.fifo {
        limit_compute_time();
    }
    touch_stack();
    Ok(())
}

/// Makes the calling thread real-time at the next lower priority: it mostly sleeps, but must run at
/// once when needed. A refusal has no effect.
pub fn enter_stop_thread(realtime: &Realtime) {
    if realtime.mode != RealtimeMode::Off && realtime.priority > 1 {
        let _ordinary = schedule_fifo(realtime.priority - 1);
    }
}

/// Makes the tick thread non-real-time again, because closing ports may exceed the computing limit.
pub fn leave_realtime() {
    scheduling::leave_fifo();
}

fn mlockall(flags: MlockAllFlags) -> Result<(), Refused> {
    rustix::mm::mlockall(flags).map_err(|e| Refused {
        what: "lock memory".to_owned(),
        source: e.into(),
        cure: "raise LimitMEMLOCK (ulimit -l) to 512M, or set realtime.mode to \"try\"",
    })
}

fn pin(core: u32) -> Result<(), Refused> {
    let mut cores = CpuSet::new();
    cores.set(core as usize);
    rustix::thread::sched_setaffinity(None, &cores).map_err(|e| Refused {
        what: format!("pin the tick thread to core {core}"),
        source: e.into(),
        cure: "set realtime.cpu to a core that this process may use, or to \"any\"",
    })
}

fn schedule_fifo(priority: u32) -> Result<(), Refused> {
    scheduling::enter_fifo(priority.cast_signed()).map_err(|source| Refused {
        what: format!("run the tick thread under SCHED_FIFO at priority {priority}"),
        source,
        cure: "raise LimitRTPRIO (ulimit -r) to this priority, or set realtime.mode to \"try\"; in \
            a container or with RT_GROUP_SCHED, give the cgroup a real-time budget",
    })
}

fn limit_compute_time() {
    let hard = rustix::process::getrlimit(Resource::Rttime).maximum;
    // At the hard limit the kernel kills the process, and no cause remains.
    let below = |hard: u64| COMPUTE_MAX_US.min(hard - hard / 5);
    let current = Some(hard.map_or(COMPUTE_MAX_US, below));
    // The kernel never refuses to lower a limit.
    let _ = rustix::process::setrlimit(
        Resource::Rttime,
        Rlimit {
            current,
            maximum: hard,
        },
    );
}

#[inline(never)]
fn touch_stack() {
    let mut stack = [0_u8; STACK_BYTES];
    std::hint::black_box(&mut stack);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mode_off_requests_nothing() {
        let realtime = Realtime {
            mode: RealtimeMode::Off,
            ..Realtime::default()
        };
        let mut granted = lock_memory(&realtime).expect("nothing is requested");
        enter_tick_thread(&realtime, &mut granted).expect("nothing is requested");
        assert!(!granted.fifo && !granted.locked && granted.refused.is_empty());
    }

    #[test]
    fn missing_core_is_refused_and_try_continues() {
        let mut granted = Granted::default();
        assert!(
            !granted
                .record(RealtimeMode::Try, pin(1023))
                .expect("try never fails")
        );
        assert!(granted.refused[0].to_string().contains("core 1023"));
        assert!(granted.record(RealtimeMode::Require, pin(1023)).is_err());
    }
}
