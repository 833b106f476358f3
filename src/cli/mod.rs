//! The command line: one file a command.
//!
//! Exit codes: 0 done, 1 the command itself failed (a file could not be written, `check` found
//! errors, `validate` a wrong value), 2 wrong usage or bad input. An interrupt ends the process by its signal.

mod accuracy;
mod budget;
mod check;
mod failure;
mod interrupt;
mod lamps;
mod options;
mod page;
mod photometry;
mod picture;
mod plan;
mod points;
mod progress;
mod report;
mod scenes;
mod sky;
mod sky_picture;
mod solve;
mod text;
mod tour;
mod validate;
mod weather;
mod window;
mod work_planes;
mod written;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

const EXIT_CODES: &str = "Exit codes: 0 done; 1 the command failed; 2 wrong usage or bad input.";

/// Walk through a building while its light is still being computed.
///
/// Without a command, opens SCENE in a window.
#[derive(Debug, Parser)]
#[command(version, after_help = EXIT_CODES, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    window: window::Arguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    Solve(Box<solve::Arguments>),
    Report(Box<page::Arguments>),
    Accuracy(accuracy::Arguments),
    Scenes(scenes::Arguments),
    Check(check::Arguments),
    Plan(plan::Arguments),
    Sky(sky::Arguments),
    Validate(validate::Arguments),
}

/// Runs the program with the arguments of the process and tells its exit code.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help that nobody reads to the end is no failure.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    interrupt::leave_nothing_half_written();
    // These know how many threads they are to have.
    let set_by_themselves = matches!(
        arguments.command,
        None | Some(Command::Solve(_) | Command::Report(_) | Command::Accuracy(_))
    );
    let threads = if set_by_themselves { Ok(()) } else { options::set_threads(None) };
    let result = threads.and_then(|()| match &arguments.command {
        None => window::run(&arguments.window),
        Some(Command::Solve(arguments)) => solve::run(arguments),
        Some(Command::Report(arguments)) => page::run(arguments),
        Some(Command::Accuracy(arguments)) => accuracy::run(arguments),
        Some(Command::Scenes(arguments)) => scenes::run(arguments),
        Some(Command::Check(arguments)) => check::run(arguments),
        Some(Command::Plan(arguments)) => plan::run(arguments),
        Some(Command::Sky(arguments)) => sky::run(arguments),
        Some(Command::Validate(arguments)) => validate::run(arguments),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_definition_of_the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn a_scene_alone_means_the_window() {
        let arguments = Arguments::try_parse_from(["lumenwalk", "a.obj"]).unwrap();
        assert!(arguments.command.is_none());
        let arguments = Arguments::try_parse_from(["lumenwalk", "check", "a.obj"]).unwrap();
        assert!(matches!(arguments.command, Some(Command::Check(_))));
    }
}
