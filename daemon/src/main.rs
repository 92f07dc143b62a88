//! `atasd`, see the crate `atasd` and `atasd --help`.
#![expect(
    clippy::print_stdout,
    reason = "the effective configuration and the tasks are what --check-config and --print-tasks are for"
)]

use std::io::IsTerminal;
use std::process::ExitCode;

use atasd::args::{Args, LogFormat};
use atasd::config::Tasks;
use atasd::daemon::{self, Failure};
use clap::Parser;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

fn main() -> ExitCode {
    let args = Args::parse();
    log_to_stderr(args.log_format);
    let ended = if args.print_tasks {
        print!("{}", Tasks::built_in_text().trim_start());
        Ok(())
    } else if args.check_config {
        check_config(&args)
    } else {
        daemon::run(&args)
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tracing::error!("{failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn check_config(args: &Args) -> Result<(), Failure> {
    print!("{}", args.source().load()?.text());
    Ok(())
}

fn log_to_stderr(format: LogFormat) {
    let filter = EnvFilter::builder()
        .with_default_directive(LevelFilter::INFO.into())
        .from_env_lossy();
    let log = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr);
    match format {
        LogFormat::Human => log
            .with_ansi(std::io::stderr().is_terminal())
            .with_target(false)
            .init(),
        LogFormat::Json => log.json().init(),
    }
}
