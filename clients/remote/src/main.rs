//! Program `atas-remote`: see the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    atas_console::run_any(atas_remote::execute)
}
