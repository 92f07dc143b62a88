//! `ebts`: evolves behaviour tables, repeats the paper's experiment, shows what came out.
//!
//! Exit codes, stable: 0 done; 2 wrong usage; 3 something given was refused; 4 the output folder is in use; 5 the system
//! refused (disk full, no permission); 6 the bus could not be used; 130 interrupted, with everything finished saved.

mod cli;

use std::process::ExitCode;

use clap::Parser;

use cli::Arguments;

fn main() -> ExitCode {
    let args = Arguments::parse();
    match cli::run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::complain(&error);
            ExitCode::from(error.exit_code())
        }
    }
}
