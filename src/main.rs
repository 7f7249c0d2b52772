//! The program: parse, do, print, exit. The only place with `anyhow` and exit codes.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cli;
mod commands;
mod completions;
mod output;
mod signals;

use clap::Parser;
use cli::Cli;
use commands::Ending;
use eigentrail::error::{Error, ErrorKind};
use eigentrail::telemetry::say;
use std::process::ExitCode;

/// Exit codes beside 0; 2 (usage) is clap's, and those of signals are theirs.
const FAILED: u8 = 1;
const BAD_INPUT: u8 = 3;
const NOT_CONVERGED: u8 = 4;

fn main() -> ExitCode {
    completions::answer();
    let ended = signals::listen().and_then(|()| match Cli::try_parse() {
        Ok(cli) => commands::execute(cli),
        Err(error) => Ok(Ending::Usage(output::usage(&error))),
    });
    let code = match ended {
        Ok(Ending::Done) => 0,
        Ok(Ending::Usage(code)) => code,
        Ok(Ending::NotConverged) => NOT_CONVERGED,
        Ok(Ending::Interrupted) => signals::exit_code(),
        Err(error) => {
            say(format!(
                "error: {}",
                told(&error).replace('\n', "\nerror: ")
            ));
            exit_code(&error)
        }
    };
    ExitCode::from(match (code, output::lost()) {
        (0, true) => FAILED,
        (code, _) => code,
    })
}

/// The error and its causes in one line; a cause that has been told already is not told again.
fn told(error: &anyhow::Error) -> String {
    error
        .chain()
        .map(ToString::to_string)
        .fold(String::new(), |told, cause| {
            match (told.is_empty(), told.contains(&cause)) {
                (true, _) => cause,
                (_, true) => told,
                (_, false) => format!("{told}: {cause}"),
            }
        })
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
