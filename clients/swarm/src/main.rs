//! `ebts`: evolves behaviour tables, repeats the paper's experiment and reports the results.
//!
//! Exit codes, stable: 0 success; 2 wrong usage; 3 input rejected; 4 output folder in use; 5
//! operating system error (disk full, no permission); 6 bus error; 130 interrupted, with every
//! finished run saved.

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
