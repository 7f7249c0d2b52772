//! Subcommands: from the command line to the library, and its results to stdout.

mod check;
mod compare;
mod export;
mod figures;
mod gallery;
mod info;
mod inspect;
mod observers;
mod potential;
mod progress;
mod report;
mod run;
mod runs_for_figures;
mod show;
mod show_json;
mod sweep;
mod threads;
mod track;

use crate::cli::{Cli, ColorChoice, Command, Global, LogFormat};
use anyhow::{Context, Result};
use eigentrail::archive::files;
use eigentrail::report::{Ink, TableStyle, is_ours};
use eigentrail::telemetry::{self, Telemetry, say};
use indexmap::IndexSet;
use std::fs::File;
use std::io::{self, IsTerminal, Read};
use std::path::Path;
use tracing::level_filters::LevelFilter;

/// Bytes that tell whose file it is.
const HEAD: u64 = 4096;

/// Ending of a command that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As asked.
    Done,
    /// Under `--strict`, with something that did not converge.
    NotConverged,
    /// By a signal, with what was done until then on disk.
    Interrupted,
    /// With help, or an error in the command line, and this exit code.
    Usage(u8),
}

/// A file that the caller named, and that the program cannot use.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct BadInput(pub String);

/// A signal came before there was anything to show.
#[derive(Debug, thiserror::Error)]
#[error("interrupted: nothing is written")]
struct Interrupted;

/// Does what the command line asks.
pub fn execute(cli: Cli) -> Result<Ending> {
    let telemetry = install(&cli.global)?;
    threads::start(cli.global.threads)?;
    let ended = match &cli.command {
        Command::Run(args) => run::run(args, &telemetry, bars(&cli.global)),
        Command::Compare(args) => compare::compare(args, &telemetry, bars(&cli.global)),
        Command::Sweep(args) => sweep::sweep(args, &telemetry, bars(&cli.global)),
        Command::Check(args) => check::check(args),
        Command::Inspect(args) => inspect::inspect(args),
        Command::Show(args) => show::show(args, &cli.global),
        Command::Track(args) => {
            track::track(args, cli.global.threads, &telemetry, bars(&cli.global))
        }
        Command::Potential(args) => potential::potential(args),
        Command::Export(args) => export::export(args),
        Command::Report(args) => report::report(args),
        Command::Figures(args) => figures::figures(args, &telemetry),
        Command::Schema => info::schema(),
        Command::List(args) => info::list(args),
        Command::New(args) => info::new(args),
        Command::Completions { shell } => info::completions(*shell),
        Command::Man => info::man(),
    };
    match ended {
        Err(error) if error.is::<Interrupted>() => {
            say(error);
            Ok(Ending::Interrupted)
        }
        ended => ended,
    }
}

fn install(global: &Global) -> Result<Telemetry> {
    if global.trace.is_some() {
        threads::require_one().context("cannot start the thread that writes the trace")?;
    }
    let level = match i16::from(global.verbose) - i16::from(global.quiet) {
        ..=-2 => LevelFilter::OFF,
        -1 => LevelFilter::ERROR,
        0 => LevelFilter::WARN,
        1 => LevelFilter::INFO,
        2 => LevelFilter::DEBUG,
        3.. => LevelFilter::TRACE,
    };
    let options = telemetry::Options {
        level,
        format: match global.log_format {
            LogFormat::Text => telemetry::LogFormat::Text,
            LogFormat::Json => telemetry::LogFormat::Json,
        },
        color: match global.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => io::stderr().is_terminal() && !no_color(),
        },
        chrome_trace: global.trace.clone(),
    };
    telemetry::install(&options).map_err(|error| match &global.trace {
        Some(path) => BadInput(format!(
            "{}: cannot write the trace: {error}",
            path.display()
        ))
        .into(),
        None => error.into(),
    })
}

/// <https://no-color.org>: set and not empty.
fn no_color() -> bool {
    std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
}

/// The colours that stdout takes.
fn stdout_ink(global: &Global) -> Ink {
    let colored = match global.color {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => io::stdout().is_terminal() && !no_color(),
    };
    let terminal = std::env::var("COLORTERM").unwrap_or_default();
    match (colored, terminal.as_str()) {
        (false, _) => Ink::None,
        (true, "truecolor" | "24bit") => Ink::True,
        (true, _) => Ink::Cube,
    }
}

/// Characters in a line of the terminal; none if stdout is not one.
fn terminal_width() -> Option<usize> {
    let (terminal_size::Width(width), _) = terminal_size::terminal_size_of(io::stdout())?;
    Some(usize::from(width))
}

/// How a table is printed.
fn table_style(markdown: bool, wide: bool) -> TableStyle {
    match markdown {
        true => TableStyle::Markdown,
        false => TableStyle::Terminal {
            width: match wide {
                true => usize::MAX,
                false => terminal_width().unwrap_or(80),
            },
        },
    }
}

/// Names as they were typed, each once; an empty one, as behind a last comma, is none.
fn without_duplicates(names: &[String]) -> Vec<String> {
    let names = names.iter().map(|name| name.trim());
    let unique: IndexSet<&str> = names.filter(|name| !name.is_empty()).collect();
    unique.into_iter().map(str::to_owned).collect()
}

/// Whether progress may be drawn.
fn bars(global: &Global) -> bool {
    global.quiet == 0
}

/// Replaces the text of a file that the caller named; behind a link, that of its target.
fn write_text(path: &Path, text: &str) -> Result<()> {
    let target = path.canonicalize();
    files::write_text(target.as_deref().unwrap_or(path), text)
        .with_context(|| format!("{}: cannot write", path.display()))
}

/// Finds out before hours of work whether a file can be written at the end.
fn require_writable(path: Option<&Path>) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    if path.is_dir() {
        let message = format!("{}: is a folder; name a file", path.display());
        return Err(BadInput(message).into());
    }
    match files::try_out(path) {
        Ok(_) => Ok(()),
        Err(error) => Err(BadInput(format!("{}: cannot write: {error}", path.display())).into()),
    }
}

/// The same for a page or a figure, which replaces no file but another one of ours; an empty file holds nothing to lose.
fn require_replaceable(path: &Path) -> Result<()> {
    require_writable(Some(path))?;
    if !path.is_file() {
        return Ok(());
    }
    let mut there = Vec::new();
    let read = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut there));
    if let Err(error) = read {
        return Err(BadInput(format!("{}: cannot read: {error}", path.display())).into());
    }
    if there.is_empty() || is_ours(&there) {
        return Ok(());
    }
    let message = format!(
        "{}: is there already, and eigentrail has not made it; name another file, or remove this one",
        path.display()
    );
    Err(BadInput(message).into())
}

/// The same for a folder, which need not be there yet.
fn require_writable_folder(path: &Path) -> Result<()> {
    let mut above = path.ancestors().map(|folder| match folder {
        here if here.as_os_str().is_empty() => Path::new("."),
        folder => folder,
    });
    let there = above.find(|folder| folder.symlink_metadata().is_ok());
    let there = there.unwrap_or(path);
    if there.metadata().is_ok_and(|there| !there.is_dir()) {
        let message = format!("{}: is a file; name a folder", there.display());
        return Err(BadInput(message).into());
    }
    match tempfile::tempfile_in(there) {
        Ok(_) => Ok(()),
        Err(error) => Err(BadInput(format!("{}: cannot write: {error}", path.display())).into()),
    }
}

/// The command line, for the records; what is not Unicode is replaced.
fn arguments() -> Vec<String> {
    let arguments = std::env::args_os();
    arguments
        .map(|argument| argument.to_string_lossy().into_owned())
        .collect()
}
