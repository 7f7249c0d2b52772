//! The program: parse, do, print, exit. The only place with `anyhow` and exit codes.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cli;
mod commands;

use clap::Parser;
use cli::Cli;
use eigentrail::error::{Error, ErrorKind};
use eigentrail::report::printable;
use std::io;
use std::process::ExitCode;

/// Exit codes beside 0; 2 (usage) is clap's.
const FAILED: u8 = 1;
const BAD_INPUT: u8 = 3;
const NOT_CONVERGED: u8 = 4;
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match commands::execute(cli) {
        Ok(commands::Ending::Done) => ExitCode::SUCCESS,
        Ok(commands::Ending::NotConverged) => ExitCode::from(NOT_CONVERGED),
        Ok(commands::Ending::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", told(&error));
            ExitCode::from(exit_code(&error))
        }
    }
}

/// The error and its causes in one line; a cause that has been told already is not told again. What they quote from files
/// cannot give orders to the terminal.
fn told(error: &anyhow::Error) -> String {
    let told = error
        .chain()
        .map(ToString::to_string)
        .fold(String::new(), |told, cause| {
            match (told.is_empty(), told.contains(&cause)) {
                (true, _) => cause,
                (_, true) => told,
                (_, false) => format!("{told}: {cause}"),
            }
        });
    printable(&told).into_owned()
}

fn exit_code(error: &anyhow::Error) -> u8 {
    let ours = error
        .chain()
        .find_map(|cause| cause.downcast_ref::<Error>());
    match ours.map(Error::kind) {
        Some(ErrorKind::BadInput) => BAD_INPUT,
        _ if error.is::<commands::BadInput>() => BAD_INPUT,
        _ => FAILED,
    }
}

/// Whoever read our stdout has read enough (`eigentrail list | head -1`): no error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.is::<commands::Stdout>()
        && error.chain().any(|cause| {
            let cause = cause.downcast_ref::<io::Error>();
            cause.is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
        })
}
