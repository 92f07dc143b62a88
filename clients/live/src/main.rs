//! Program `atas-live`: see the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    atas_console::run(atas_live::execute)
}
