//! Limits of the kernel: descriptors and real-time rights.

use rustix::process::{Pid, Resource, Rlimit, geteuid, getrlimit, prlimit};
use shm_schemas::{ControlOp, StatusFlags};

use super::disk::wrapper_obstacle;
use super::{Drill, Effect, Pace, Rig};

/// Ticks without a free descriptor.
const TICKS: u64 = 500;

/// The daemon has no free file descriptor.
pub(super) const NO_DESCRIPTORS: Drill = Drill::new(Pace::LockStep, no_descriptors);

/// The kernel refuses real-time scheduling to the daemon.
pub(super) const NO_REAL_TIME: Drill = Drill::new(Pace::Clock, no_real_time)
    .unless(|| wrapper_obstacle(refusing()))
    .with_setup(|setup| setup.wrapper = refusing().to_vec());

const REFUSED_TO_USER: &[&str] = &["sh", "-c", "ulimit -r 0 && exec \"$@\"", "sh"];
const REFUSED_TO_ROOT: &[&str] = &[
    "setpriv",
    "--bounding-set=-sys_nice",
    "--inh-caps=-sys_nice",
    "sh",
    "-c",
    "ulimit -r 0 && exec \"$@\"",
    "sh",
];

/// Returns the words before a program that may not use real-time scheduling.
fn refusing() -> &'static [&'static str] {
    if geteuid().is_root() {
        REFUSED_TO_ROOT
    } else {
        REFUSED_TO_USER
    }
}

fn no_descriptors(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    let name = atas_core::settings::PARAMETERS[0].name;
    rig.control(ControlOp::PARAM_GET, name, 0.0)?;
    let pid = i32::try_from(rig.daemon.pid()).ok().and_then(Pid::from_raw);
    let used = std::fs::read_dir(format!("/proc/{}/fd", rig.daemon.pid()))?.count() as u64;
    let limit = Rlimit {
        current: Some(used),
        maximum: getrlimit(Resource::Nofile).maximum,
    };
    if let Err(error) = prlimit(pid, Resource::Nofile, limit) {
        let reason = format!("could not limit the descriptors of the daemon: {error}");
        return Ok(Effect::Skipped(reason));
    }
    rig.promise();
    rig.advance(TICKS)?;
    // A client that is already connected is still served.
    let served = rig.control(ControlOp::PARAM_GET, name, 0.0);
    Ok(served.map_or_else(
        |error| Effect::Failed(format!("{error:#}")),
        |()| Effect::Done,
    ))
}

fn no_real_time(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let flags = rig.status()?.flags;
    if flags & StatusFlags::REALTIME != 0 {
        let reason = "could not take the right to real-time scheduling from the daemon";
        return Ok(Effect::Skipped(reason.to_owned()));
    }
    let requests_it = rig.environment.config.is_none();
    let is_reported = flags & StatusFlags::DEGRADED != 0;
    Ok(Effect::require(is_reported || !requests_it, || {
        "the status does not report DEGRADED".to_owned()
    }))
}
