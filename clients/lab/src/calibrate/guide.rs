//! `atas calibrate guide`: asks the user to load the fingertip step by step, and records the time
//! span of each steady load.

use std::io::{BufRead, Write};
use std::time::Duration;

use anyhow::{Context, ensure};
use atas_console::arguments::Guide;
use atas_console::{Exit, ExitError, Interrupt, Output};
use serde_json::json;

const AXES: [&str; 3] = ["normal", "tangential1", "tangential2"];
pub(crate) const STEPS: &str = "from_ns,to_ns,normal_n,tangential1_n,tangential2_n";
/// Longest duration of one load, s (design choice: a person can hold a load steady for that long).
const SECONDS_MAX: f64 = 600.0;

pub(super) fn guide(
    guide: &Guide,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    ensure!(
        guide.seconds > 0.0 && guide.seconds <= SECONDS_MAX,
        "could not use {} s per step: needs more than 0 and at most {SECONDS_MAX} s; correct \
         --seconds",
        guide.seconds
    );
    let loads = loads(guide);
    let path = guide.out.display();
    let mut file = std::fs::File::create_new(&guide.out).with_context(|| {
        format!(
            "could not create {path}: existing step tables are not overwritten; name a new file"
        )
    })?;
    let mut write =
        |line: String| writeln!(file, "{line}").with_context(|| format!("could not write {path}"));
    write(STEPS.to_owned())?;
    let mut entered = std::io::stdin().lock();
    for (step, load) in loads.iter().enumerate() {
        print_prompt(&format!(
            "{} of {}: {}. Press Enter when the load is steady.",
            step + 1,
            loads.len(),
            load_text(load)
        ))?;
        let mut line = String::new();
        let read = entered
            .read_line(&mut line)
            .context("could not read standard input")?;
        let interrupted = || {
            ExitError::with_code(
                Exit::Interrupted,
                format!("interrupted; {path} contains {step} steps"),
            )
        };
        if read == 0 || interrupt.is_set() {
            return Err(interrupted());
        }
        let from_ns = shm_bus::now_ns();
        std::thread::sleep(Duration::from_secs_f64(guide.seconds));
        if interrupt.is_set() {
            return Err(interrupted());
        }
        let to_ns = shm_bus::now_ns();
        write(row(from_ns, to_ns, *load))?;
    }
    if output.is_json() {
        return output.json(&json!({ "file": path.to_string(), "steps": loads.len() }));
    }
    output.line(format_args!("wrote {path}: {} steps", loads.len()))
}

/// Formats a row of a step table: time span and load, N.
pub(crate) fn row(from_ns: u64, to_ns: u64, [normal_n, t1_n, t2_n]: [f64; 3]) -> String {
    format!("{from_ns},{to_ns},{normal_n},{t1_n},{t2_n}")
}

/// Returns the loads in order, N: no load, the normal loads, each tangential load under the middle
/// normal load.
pub(crate) fn loads(guide: &Guide) -> Vec<[f64; 3]> {
    let under = guide
        .normal
        .get(guide.normal.len() / 2)
        .copied()
        .unwrap_or(0.0);
    let normal = guide.normal.iter().map(|&n| [n, 0.0, 0.0]);
    let along = |axis: usize| {
        guide.tangential.iter().map(move |&t| {
            let mut load = [under, 0.0, 0.0];
            load[axis] = t;
            load
        })
    };
    [[0.0; 3]]
        .into_iter()
        .chain(normal)
        .chain(along(1))
        .chain(along(2))
        .collect()
}

fn load_text(load: &[f64; 3]) -> String {
    let parts: Vec<String> = AXES
        .iter()
        .zip(load)
        .filter(|(_, n)| **n != 0.0)
        .map(|(axis, n)| format!("{n} N along {axis}"))
        .collect();
    if parts.is_empty() {
        "do not touch the fingertip".to_owned()
    } else {
        format!("load the fingertip with {}", parts.join(" and "))
    }
}

fn print_prompt(line: &str) -> anyhow::Result<()> {
    writeln!(std::io::stderr(), "{line}").context("could not write to standard error")
}
