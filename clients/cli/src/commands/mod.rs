//! From arguments to commands: the only place that knows which function a command is.

mod manual;

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use crate::arguments::{Arguments, Command, Param, RecordAction};
use crate::exit::Exit;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::{bench, client, demo, doctor, eval, plot, recording};

/// The whole program: reads the command line, does what it says, tells errors in one line, returns the exit code.
#[must_use]
pub fn main() -> ExitCode {
    log_to_stderr();
    let arguments = Arguments::parse();
    let mut output = Output::new(arguments.format);
    let Err(error) = run(&arguments.command, &mut output) else {
        return Exit::Ok.into();
    };
    if is_broken_pipe(&error) {
        return Exit::Ok.into();
    }
    // Nothing can be done if standard error is closed as well.
    let _ = writeln!(std::io::stderr(), "atas: {error:#}");
    Exit::of(&error).into()
}

fn run(command: &Command, output: &mut Output) -> anyhow::Result<()> {
    let interrupt = Interrupt::listen()?;
    match command {
        Command::Demo { task } => demo::demo(task, &interrupt, output),
        Command::Eval { task } => eval::evaluate(task, &interrupt, output),
        Command::Plot { figure } => plot::plot(figure, output),
        Command::Grasp(arguments) => client::grasp(arguments, &interrupt, output),
        Command::PickPlace(arguments) => client::pick_place(arguments, &interrupt, output),
        Command::Screw(arguments) => client::screw(arguments, &interrupt, output),
        Command::Assemble(arguments) => client::assemble(arguments, &interrupt, output),
        Command::Task(arguments) => client::task(arguments, &interrupt, output),
        Command::Release(arguments) => client::release(arguments, &interrupt, output),
        Command::Estop(bus) => client::estop(&bus.bus, output),
        Command::Recover(bus) => client::recover(&bus.bus, output),
        Command::Status(arguments) => client::status(arguments, &interrupt, output),
        Command::Events(arguments) => client::events(arguments, &interrupt, output),
        Command::Param { action } => parameter(action, output),
        Command::Bench { what } => bench::bench(what, &interrupt, output),
        Command::Latency(arguments) => client::latency(arguments, &interrupt, output),
        Command::Record { action, options } => match action {
            None => recording::record(options, &interrupt, output),
            Some(RecordAction::Check { file }) => recording::check(file, output),
            Some(RecordAction::Repair { file, out }) => {
                recording::repair(file, out.as_deref(), output)
            }
        },
        Command::Replay { files } => recording::replay(files, output),
        Command::Diff { first, second } => recording::diff(first, second, output),
        Command::Doctor(bus) => doctor::doctor(&bus.bus, output),
        Command::Completions { shell } => {
            let mut command = Arguments::command();
            clap_complete::generate(*shell, &mut command, "atas", &mut std::io::stdout());
            Ok(())
        }
        Command::Man { folder } => manual::write(folder),
    }
}

fn parameter(action: &Param, output: &mut Output) -> anyhow::Result<()> {
    match action {
        Param::List(bus) => client::list(&bus.bus, output),
        Param::Get { name, bus } => client::get(&bus.bus, name, output),
        Param::Set { name, value, bus } => client::set(&bus.bus, name, *value, output),
    }
}

/// Whoever reads the output may stop reading: `atas events | head` is no error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let io = error.downcast_ref::<std::io::Error>();
    io.is_some_and(|io| io.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Warnings of the libraries below, or what `RUST_LOG` asks for.
fn log_to_stderr() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false)
        .init();
}
