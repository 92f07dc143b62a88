//! `atasd`; see the crate `atasd` and `atasd --help`.

use std::io::{self, Write as _};
use std::process::ExitCode;

use atas_process::exit::Exit;
use atas_process::{command_line, log};
use atasd::args::{Args, Command};
use atasd::config::Tasks;
use atasd::daemon::{self, Failure};
use clap::Parser;

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return command_line::exit_without_work("atasd", &error),
    };
    let log = match log::start(args.log_format.into(), log::LevelFilter::INFO) {
        Ok(log) => log,
        Err(error) => {
            let sentence = format!("could not start the log: {error}");
            command_line::print_error("atasd", &sentence, Exit::Failed, false);
            return Exit::Failed.into();
        }
    };
    let code = match run(&args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tracing::error!("{failure}");
            failure.exit_code().into()
        }
    };
    drop(log);
    code
}

fn run(args: &Args) -> Result<(), Failure> {
    if let Some(Command::Completions { shell }) = args.command {
        print(&Args::completions(shell))
    } else if args.print_tasks {
        print(Tasks::built_in_text().trim_start().as_bytes())
    } else if args.check_config {
        print(args.source().load()?.text().as_bytes())
    } else {
        daemon::run(args)
    }
}

/// Prints `text`. A closed pipe is not an error.
fn print(text: &[u8]) -> Result<(), Failure> {
    let mut out = io::stdout();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}
