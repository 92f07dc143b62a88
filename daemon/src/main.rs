//! `atasd`, see the crate `atasd` and `atasd --help`.

use std::io::{self, Write as _};
use std::process::ExitCode;

use atas_process::log;
use atasd::args::Args;
use atasd::config::Tasks;
use atasd::daemon::{self, Failure};
use clap::Parser;

fn main() -> ExitCode {
    let args = Args::parse();
    let log = match log::start(args.log_format.into()) {
        Ok(log) => log,
        // Without threads there is no daemon, and nobody to tell.
        Err(_) => return ExitCode::FAILURE,
    };
    let code = match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tracing::error!("{failure}");
            ExitCode::from(failure.exit_code())
        }
    };
    drop(log);
    code
}

fn run(args: &Args) -> Result<(), Failure> {
    if args.print_tasks {
        print(Tasks::built_in_text().trim_start())
    } else if args.check_config {
        print(&args.source().load()?.text())
    } else {
        daemon::run(args)
    }
}

/// A reader that has seen enough is no failure.
fn print(text: &str) -> Result<(), Failure> {
    match io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}
