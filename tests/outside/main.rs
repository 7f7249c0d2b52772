//! What only other programs can judge: Chromium, Python's libraries, TensorBoard. Where one of them is missing its tests
//! are ignored, and listed so with what they need.

#[path = "../common/program.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod program;
#[path = "../common/runs.rs"]
mod runs;
#[path = "../common/served.rs"]
mod served;

mod live_page;
mod pages;
mod readers;

use libtest_mimic::{Arguments, Trial};
use std::process::{Command, ExitCode};

/// What a test does with the program that was found.
type Test = fn(&str);

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let chromium = chromium();
    let libraries = "duckdb, networkx, numpy, pandas, pyarrow";
    let (with_libraries, with_tensorboard) = (python(libraries), python("tensorboard"));
    let in_chromium = |name, test| trial(name, "Chromium", &chromium, test);
    let trials = vec![
        in_chromium(
            "a_browser_follows_a_run_through",
            live_page::a_browser_follows_a_run_through,
        ),
        in_chromium(
            "the_page_of_runs_works_in_a_browser",
            pages::the_page_of_runs_works_in_a_browser,
        ),
        in_chromium(
            "the_page_of_a_comparison_works_in_a_browser",
            pages::the_page_of_a_comparison_works_in_a_browser,
        ),
        in_chromium(
            "the_page_of_a_graph_works_in_a_browser",
            pages::the_page_of_a_graph_works_in_a_browser,
        ),
        in_chromium(
            "the_figures_fit_into_a_browser",
            pages::the_figures_fit_into_a_browser,
        ),
        trial(
            "other_programs_read_the_exports",
            libraries,
            &with_libraries,
            readers::other_programs_read_the_exports,
        ),
        trial(
            "tensorboard_reads_every_kind_of_value",
            "tensorboard",
            &with_tensorboard,
            readers::tensorboard_reads_every_kind_of_value,
        ),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test that needs something, and the program that has it if one was found.
fn trial(name: &str, needs: &str, program: &Option<String>, test: Test) -> Trial {
    let found = program.clone();
    let is_missing = found.is_none();
    let trial = Trial::test(name, move || {
        test(&found.ok_or("what it needs is not here")?);
        Ok(())
    });
    trial
        .with_kind(format!("needs {needs}"))
        .with_ignored_flag(is_missing)
}

/// Chromium under one of its names.
fn chromium() -> Option<String> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| works(name, &["--version"]));
    found.map(str::to_owned)
}

/// The Python that EIGENTRAIL_PYTHON names, else `python3`, if it has these modules.
fn python(modules: &str) -> Option<String> {
    let python = std::env::var("EIGENTRAIL_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    works(&python, &["-c", &format!("import {modules}")]).then_some(python)
}

fn works(program: &str, arguments: &[&str]) -> bool {
    let output = Command::new(program).args(arguments).output();
    output.is_ok_and(|output| output.status.success())
}
