//! `atas status`: status of the daemon, once or continuously.

use std::time::{Duration, Instant};

use atas_client::{POLL, Run, Session, Stopped, json, standstill, text};
use atas_console::{Exit, ExitError, Interrupt, Output, arguments, modules, number, table};
use robot_model::{RobotFiles, RobotModel};
use shm_bus::{BusName, End, Owner, now_ns};
use shm_schemas::capacity::HANDS;
use shm_schemas::{Hand, JointLabel, Mode, Percentiles, Reason, ReasonRecord, Status, StatusFlags};

use atas_client::rejections::{self, rejection_texts};

/// Pause between two updates of a watched status.
const UPDATE_PERIOD: Duration = Duration::from_millis(200);
/// Time without a status after which a watched daemon counts as gone. Design choice: 50 missing
/// statuses.
const STATUS_TIMEOUT: Duration = Duration::from_secs(1);

pub(crate) fn status(
    arguments: &arguments::Status,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let session = Session::existing(&arguments.bus.bus)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let mut before = status;
    let mut run = Run::read(session.bus(), &status)?;
    let former = End::before(&arguments.bus.bus, status.pid);
    let former = former.as_ref();
    if !arguments.watch {
        rejections::await_rejections(&mut statuses, &mut status)?;
        let frozen = print([&before, &status], &session, &run, former, output)?;
        return frozen.map_or(Ok(()), |frozen| {
            Err(ExitError::with_code(Exit::Failed, standstill_text(frozen)))
        });
    }
    let mut received = Instant::now();
    let mut drawn = None::<Instant>;
    while !interrupt.is_set() {
        if statuses.newest(&mut status)? {
            received = Instant::now();
        } else if received.elapsed() > STATUS_TIMEOUT {
            return Err(ExitError::with_code(
                Exit::NoDaemon,
                missing_status_text(&arguments.bus.bus),
            ));
        }
        if drawn.is_none_or(|drawn| drawn.elapsed() >= UPDATE_PERIOD) {
            output.clear()?;
            run.poll(session.bus(), &status)?;
            print([&before, &status], &session, &run, former, output)?;
            drawn = Some(Instant::now());
            before = status;
        }
        std::thread::sleep(POLL);
    }
    Ok(())
}

/// Prints the newer of two statuses. Returns the time since the last tick if the ticks have
/// stopped.
fn print(
    [before, status]: [&Status; 2],
    session: &Session,
    run: &Run,
    former: Option<&End>,
    output: &mut Output,
) -> anyhow::Result<Option<Duration>> {
    let refusals = rejection_texts(session, status)?;
    let frozen = standstill(status, now_ns());
    let fingers = run.fingertips(status);
    if output.is_json() {
        let mut value = json::status(status, fingers);
        value["refusals"] = refusals.into();
        value["standstill_s"] = frozen.map(|frozen| frozen.as_secs_f64()).into();
        value["former_end"] = former.map(|end| end.to_string()).into();
        output.json(&value)?;
        return Ok(frozen);
    }
    output.line(heading([before, status], run))?;
    if let Some(frozen) = frozen {
        output.line(standstill_text(frozen))?;
    }
    if let Some(end) = former {
        output.line(format!("before this daemon: {end}"))?;
    }
    for refusal in refusals {
        output.line(refusal)?;
    }
    output.table(hands(status, fingers))?;
    output.table(timing(status))?;
    Ok(frozen)
}

/// Explains why a watched daemon no longer reports.
fn missing_status_text(bus: &BusName) -> String {
    let why = match (Stopped::owner(bus), Owner::find(bus)) {
        (Some(stopped), _) => stopped.to_string(),
        (None, Some(owner)) => format!("{owner}, which owns the bus, hangs"),
        (None, None) => End::last(bus).map_or("it ended".to_owned(), |end| end.to_string()),
    };
    format!("no status from the daemon for one second: {why}")
}

/// Returns the text of a reason that concerns a joint. It names the joint if the daemon's robot
/// files can be read.
fn joint_reason(reason: &ReasonRecord, run: &Run) -> String {
    let robot = || {
        let header = run.header()?;
        let files = RobotFiles::find(header.robot.as_str()).ok()?;
        (files.hash() == header.robot_hash).then(|| files.load().ok())?
    };
    let robot: Option<RobotModel> = robot();
    let joint = robot.as_ref().zip(Reason::from(*reason).joint());
    let joint = joint.and_then(|(robot, index)| robot.joint(index));
    let label = joint.map(|joint| JointLabel {
        name: joint.name.as_str(),
        unit: joint.unit(),
    });
    reason.text(label).to_string()
}

fn standstill_text(frozen: Duration) -> String {
    format!(
        "the ticks have stood still for {:.1} s: this status is outdated and the robot is not \
         controlled; if `atas estop` has no effect, restart the daemon",
        frozen.as_secs_f64()
    )
}

fn heading([before, status]: [&Status; 2], run: &Run) -> String {
    let mut lines = vec![format!(
        "atasd {}, process {}, {} Hz{}{}",
        status.version,
        status.pid,
        status.rate_hz,
        flags(status.flags),
        uptime(status),
    )];
    lines.push(if status.reason.is_some() {
        let why = match Reason::from(status.reason).joint() {
            Some(_) => joint_reason(&status.reason, run),
            None => rejections::mode_reason([before, status]),
        };
        format!("mode {}: {why}", status.mode)
    } else {
        format!("mode {}{}", status.mode, hint(status.mode))
    });
    lines.push(text::goal(status));
    lines.push(format!(
        "{} ticks, {} missed, {} late, {} records dropped",
        status.ticks, status.missed_ticks, status.late_ticks, status.dropped_records
    ));
    lines.join("\n")
}

/// Formats the run time of the daemon. Lock-step has no time before its first tick.
fn uptime(status: &Status) -> String {
    let is_virtual = status.flags & StatusFlags::LOCKSTEP != 0;
    if is_virtual && status.ticks == 0 {
        return String::new();
    }
    let up_ns = status.stamp.captured_ns.saturating_sub(status.started_ns);
    let clock = if is_virtual { " of virtual time" } else { "" };
    format!(", up {:.0} s{clock}", up_ns as f64 * 1e-9)
}

fn hint(mode: Mode) -> &'static str {
    match mode {
        Mode::INIT => {
            ": waiting for the first frames and joint states; is a sensor process \
            running?"
        }
        _ => "",
    }
}

fn flags(flags: u32) -> String {
    let known = [
        (StatusFlags::LOCKSTEP, "lock-step"),
        (StatusFlags::REALTIME, "real-time scheduling"),
        (StatusFlags::MEMORY_LOCKED, "memory locked"),
        (StatusFlags::PHASE_LOCKED, "phase-locked"),
        (StatusFlags::KEPT_AWAKE, "cores kept awake"),
        (
            StatusFlags::DEGRADED,
            "DEGRADED: real-time scheduling or memory locking was refused",
        ),
        (
            StatusFlags::SENSE_ONLY,
            "perception only, no motion (robot.joints_required is false)",
        ),
    ];
    let set = known.iter().filter(|(flag, _)| flags & flag != 0);
    set.map(|(_, text)| format!(", {text}")).collect()
}

/// Table of the inputs. Absent hands have no row.
fn hands(status: &Status, fingers: [usize; HANDS]) -> comfy_table::Table {
    let mut rows = table(&[
        "hand", "frames", "lost", "bad", "age ms", "F_n N", "F_t N", "touches", "modules",
    ]);
    let sensors = Hand::BOTH.iter().zip(&status.hands).zip(fingers);
    for ((hand, sensor), fingers) in sensors.filter(|(_, fingers)| *fingers > 0) {
        let touches = sensor.touches[..fingers].iter().map(u64::to_string);
        rows.add_row([
            hand.to_string(),
            sensor.frames.to_string(),
            sensor.lost.to_string(),
            rejections::rejected_frames(sensor).to_string(),
            age_ms(sensor.age_ns),
            forces(&sensor.normal_n[..fingers]),
            forces(&sensor.tangential_n[..fingers]),
            touches.collect::<Vec<_>>().join(" "),
            modules(sensor.modules_active),
        ]);
    }
    let joints = &status.joints;
    rows.add_row([
        "joints".into(),
        joints.states.to_string(),
        joints.lost.to_string(),
        joints.rejected.to_string(),
        age_ms(joints.age_ns),
    ]);
    rows
}

fn timing(status: &Status) -> comfy_table::Table {
    let mut rows = table(&["µs", "p50", "p99", "p99.9", "max"]);
    let lines: [(&str, &Percentiles); 4] = [
        ("wake-up", &status.wake),
        ("frame age", &status.frame_age),
        ("tick body", &status.tick),
        ("sensor to command", &status.sensor_to_command),
    ];
    for (name, figures) in lines {
        let Percentiles {
            p50_ns,
            p99_ns,
            p999_ns,
            max_ns,
            ..
        } = *figures;
        let microseconds = |ns: u64| format!("{:.1}", ns as f64 * 1e-3);
        rows.add_row([
            name.to_owned(),
            microseconds(p50_ns),
            microseconds(p99_ns),
            microseconds(p999_ns),
            microseconds(max_ns),
        ]);
    }
    rows
}

fn age_ms(age_ns: u64) -> String {
    match age_ns {
        u64::MAX => "never".into(),
        age_ns => format!("{:.1}", age_ns as f64 * 1e-6),
    }
}

fn forces(force_n: &[f32]) -> String {
    let shown: Vec<String> = force_n
        .iter()
        .map(|force_n| number((*force_n).into(), 2))
        .collect();
    shown.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use shm_schemas::{GoalKind, GoalState, Stamp, Text};

    fn heading_of(status: &Status) -> String {
        heading([status, status], &Run::default())
    }

    #[test]
    fn heading_names_goal_step_and_reason() {
        let status = Status {
            goal_id: 7,
            goal_kind: GoalKind::CUSTOM,
            goal_state: GoalState::FAILED,
            task: Text::new("polish"),
            step: Text::new("press"),
            goal_reason: Reason::TimedOut {
                elapsed_s: 9.0,
                limit_s: 9.0,
            }
            .into(),
            ..Status::default()
        };
        let expected = "goal polish failed, step press: took 9.0 s, allowed 9.0 s";
        assert!(
            heading_of(&status).contains(expected),
            "{}",
            heading_of(&status)
        );
        let none = heading_of(&Status::default());
        assert!(none.contains("no goal yet"), "{none}");
    }

    #[test]
    fn table_lists_fingertips_of_present_hands() {
        let mut status = Status::default();
        status.hands[1].normal_n = [0.25, 1.5, 2.75, 0.0];
        status.hands[1].touches = [1, 2, 3, 0];
        let table = hands(&status, [0, 3]).to_string();
        for part in ["right", "0.25 1.50 2.75 ", " 1 2 3 "] {
            assert!(table.contains(part), "{part}: {table}");
        }
        assert!(!table.contains("left"), "{table}");
    }

    #[test]
    fn uptime_uses_the_daemon_clock() {
        let check = |flags, ticks, [started_s, captured_s]: [u64; 2], expected: &str| {
            let status = Status {
                stamp: Stamp {
                    captured_ns: captured_s * 1_000_000_000,
                    ..Stamp::default()
                },
                started_ns: started_s * 1_000_000_000,
                flags,
                ticks,
                ..Status::default()
            };
            assert_eq!(uptime(&status), expected, "{flags} {ticks}");
        };
        check(0, 0, [500, 500], ", up 0 s");
        check(0, 9, [500, 517], ", up 17 s");
        let lockstep = StatusFlags::LOCKSTEP;
        check(lockstep, 9, [1, 18], ", up 17 s of virtual time");
        check(lockstep, 0, [0, 500], "");
    }

    #[test]
    fn perception_only_is_shown_without_frames() {
        let status = Status {
            flags: StatusFlags::SENSE_ONLY,
            reason: Reason::FramesStopped {
                hand: Hand::LEFT,
                age_ns: None,
                limit_ns: 5e6,
            }
            .into(),
            ..Status::default()
        };
        let reported = heading_of(&status);
        for part in [
            "perception only, no motion (robot.joints_required is false)",
            "no tactile frame of hand left yet",
        ] {
            assert!(reported.contains(part), "{reported}");
        }
    }
}
