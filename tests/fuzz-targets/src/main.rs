//! `atas-fuzz`: runs fuzz targets for a number of executions or a time, on all cores.
#![allow(clippy::print_stdout, reason = "this program prints its results")]

use std::num::NonZero;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use atas_fuzz::run::{Extent, SLOW_NS, collect_panics, input_of, run};
use atas_fuzz::{Target, find, targets};
use clap::Parser;

/// Run fuzz targets on mutations of their seeds
#[derive(Debug, Parser)]
#[command(name = "atas-fuzz")]
struct Arguments {
    /// Targets, or `all`; without targets, their names are printed
    targets: Vec<String>,
    /// Executions per target
    #[arg(long, default_value_t = 1_000_000)]
    executions: u64,
    /// Most time per target, s
    #[arg(long)]
    seconds: Option<f64>,
    /// Seed of the mutations
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads [default: all cores]
    #[arg(long)]
    threads: Option<usize>,
    /// Run only the execution with this number, without catching its panic
    #[arg(long)]
    execution: Option<u64>,
    /// Folder for failing inputs
    #[arg(long)]
    out: Option<std::path::PathBuf>,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    let chosen: Vec<Target> = match &arguments.targets[..] {
        [] => {
            targets().for_each(|target| println!("{}", target.name));
            return Ok(ExitCode::SUCCESS);
        }
        [all] if all == "all" => targets().collect(),
        names => {
            let find = |name: &String| find(name).with_context(|| format!("no target {name}"));
            names.iter().map(find).collect::<anyhow::Result<_>>()?
        }
    };
    if let Some(execution) = arguments.execution {
        for target in &chosen {
            let input = input_of(target, &(target.seeds)(), arguments.seed, execution);
            println!("{}: {:?}", target.name, String::from_utf8_lossy(&input));
            (target.run)(&input);
        }
        return Ok(ExitCode::SUCCESS);
    }
    collect_panics();
    println!(
        "{:20} {:>12} {:>10} {:>12} {:>10} {:>8}",
        "target", "executions", "per s", "slowest, ms", "most, kB", "failed"
    );
    let mut failed = 0;
    for target in &chosen {
        failed += run_target(target, &arguments)?;
    }
    Ok(if failed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Runs one target and prints its row; returns the number of failures.
fn run_target(target: &Target, arguments: &Arguments) -> anyhow::Result<u64> {
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    let report = run(
        target,
        Extent {
            executions: arguments.executions,
            time: arguments.seconds.map(Duration::from_secs_f64),
            seed: arguments.seed,
            threads: arguments.threads.unwrap_or(cores),
        },
    );
    println!(
        "{:20} {:12} {:10.0} {:12.2} {:10} {:8}",
        target.name,
        report.executions,
        report.executions as f64 / report.elapsed.as_secs_f64(),
        report.slowest.0 as f64 * 1e-6,
        report.memory_bytes / 1_000,
        report.failed
    );
    for failure in &report.failures {
        println!("    execution {}: {}", failure.execution, failure.cause);
    }
    let is_slow = report.slowest.0 > SLOW_NS;
    if is_slow {
        println!(
            "    too slow: one input may take {} ms",
            SLOW_NS / 1_000_000
        );
    }
    if let Some(out) = &arguments.out {
        std::fs::create_dir_all(out)?;
        for failure in &report.failures {
            let name = format!("{}-{}", target.name, failure.execution);
            std::fs::write(out.join(name), &failure.input)?;
        }
        std::fs::write(
            out.join(format!("{}-slowest", target.name)),
            &report.slowest.1,
        )?;
    }
    Ok(report.failed + u64::from(is_slow))
}
