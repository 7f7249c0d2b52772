//! What a shell is offered where a name is to be typed.
//!
//! The script of a shell asks the program itself, by calling it with an environment variable, each time the key for it is
//! pressed: so the names are those of the program that is installed.

use crate::cli::Cli;
use clap::CommandFactory;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::{CompleteEnv, Shells};
use eigentrail::scenario::{BUILT_IN_ARMS, Scenario, shipped};
use std::ffi::OsStr;
use std::io;

/// The variable that asks for candidates instead of a run of the program.
const VARIABLE: &str = "EIGENTRAIL_COMPLETE";
const PROGRAM: &str = "eigentrail";

/// Answers a shell that asks for candidates, and ends the program then.
pub fn answer() {
    CompleteEnv::with_factory(Cli::command)
        .var(VARIABLE)
        .complete();
}

/// The script that makes a shell ask; none if it is not known.
pub fn script(shell: &str) -> Option<io::Result<Vec<u8>>> {
    let shells = Shells::builtins();
    let shell = shells.completer(shell)?;
    let mut script = Vec::new();
    let written = shell.write_registration(VARIABLE, PROGRAM, PROGRAM, PROGRAM, &mut script);
    Some(written.map(|()| script))
}

/// Scenarios that come with the program, and files.
pub fn scenarios(typed: &OsStr) -> Vec<CompletionCandidate> {
    let typed_name = typed.to_string_lossy();
    let named = shipped()
        .iter()
        .filter(|scenario| scenario.name.starts_with(&*typed_name))
        .map(|scenario| candidate(scenario.name, scenario.shows()));
    let is_scenario = |path: &std::path::Path| path.extension().is_some_and(|end| end == "toml");
    let files = PathCompleter::file().filter(is_scenario).complete(typed);
    named.chain(files).collect()
}

/// Arms that come with the program.
pub fn arms() -> Vec<CompletionCandidate> {
    let arms = BUILT_IN_ARMS.iter();
    arms.map(|arm| candidate(arm.name, arm.about)).collect()
}

/// Keys of a scenario, to be followed by values.
pub fn axes(typed: &OsStr) -> Vec<CompletionCandidate> {
    let typed = typed.to_string_lossy();
    let keys = Scenario::default().settings().into_keys();
    let keys = keys.filter(|key| key.contains('.') && key.starts_with(&*typed));
    keys.map(|key| CompletionCandidate::new(format!("{key}=")))
        .collect()
}

fn candidate(name: &str, about: &'static str) -> CompletionCandidate {
    CompletionCandidate::new(name).help(Some(about.into()))
}
