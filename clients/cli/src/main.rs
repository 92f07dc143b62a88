//! `atas`: see the library.

fn main() -> std::process::ExitCode {
    atas_cli::main()
}
