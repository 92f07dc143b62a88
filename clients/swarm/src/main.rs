//! `ebts`: evolves behaviour tables, repeats the paper's experiment and reports the results.
//!
//! An interruption keeps every finished run. Exit codes: [`atas_process::exit::Exit`].

mod cli;

use std::process::ExitCode;

use atas_process::command_line;
use clap::FromArgMatches;

use cli::Arguments;

const PROGRAM: &str = "ebts";

fn main() -> ExitCode {
    let parsed = cli::command()
        .try_get_matches()
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    let args = match parsed {
        Ok(args) => args,
        Err(error) => return command_line::exit_without_work(PROGRAM, &error),
    };
    let as_json = args.is_json();
    match cli::run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let exit = error.exit_code();
            command_line::print_error(PROGRAM, &error.to_string(), exit, as_json);
            exit.into()
        }
    }
}
