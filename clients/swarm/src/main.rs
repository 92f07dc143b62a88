//! `ebts`: evolves behaviour tables, repeats the paper's experiment, shows what came out.
//!
//! Exit codes, stable: 0 done; 2 wrong usage; 3 something given was refused; 4 the output folder is in use; 5 the system
//! refused (disk full, no permission); 6 the bus could not be used; 130 interrupted, with everything finished saved.

mod cli;

use std::process::ExitCode;

use clap::Parser;

use cli::Command;

/// Evolutionary behaviour tables for teams of mobile robots.
#[derive(Debug, Parser)]
#[command(name = "ebts", version, max_term_width = 110, after_help = AFTER_HELP)]
struct Args {
    /// How results are printed to standard output; progress and errors go to standard error.
    #[arg(long, global = true, value_enum, default_value_t = cli::Format::Human)]
    format: cli::Format,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "Exit codes: 0 done, 2 wrong usage, 3 something given was refused, 4 the output folder is in use, \
                          5 the system refused (disk full, no permission), 6 the bus could not be used, 130 interrupted with everything finished saved.";

fn main() -> ExitCode {
    let args = Args::parse();
    match cli::run(args.command, args.format) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::complain(&error);
            ExitCode::from(error.exit_code())
        }
    }
}
