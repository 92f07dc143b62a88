//! `ebts`: evolves behaviour tables, repeats the paper's experiment, shows what came out.
//!
//! Exit codes, stable: 0 done; 2 wrong usage; 3 something given was refused; 4 the output folder is in use; 5 the system
//! refused (disk full, no permission); 6 the bus could not be used; 130 interrupted, with everything finished saved.

mod cli;

use std::process::ExitCode;

use atas_process::command_line;
use clap::FromArgMatches;

use cli::Arguments;
use ebts::error::Error;

const PROGRAM: &str = "ebts";

fn main() -> ExitCode {
    let parsed = cli::command()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let args = match parsed {
        Ok(args) => args,
        Err(error) => return command_line::end(PROGRAM, &error, Error::SYSTEM),
    };
    let as_json = args.is_json();
    match cli::run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let exit = error.exit_code();
            command_line::tell(PROGRAM, &error.to_string(), exit, as_json);
            ExitCode::from(exit)
        }
    }
}
