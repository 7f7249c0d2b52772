//! stdout: the results, and nothing else.
//!
//! What cannot be printed is no reason to leave work undone, so nothing here fails: the first error is kept, nothing is
//! printed after it, and the program ends with it when everything else is done.

use eigentrail::printable::printable;
use eigentrail::telemetry::say;
use std::io::{self, BufWriter, Write};
use std::sync::OnceLock;

static ERROR: OnceLock<io::Error> = OnceLock::new();

/// Prints a result, with a final newline. What it quotes from files cannot give orders to the terminal.
pub fn print(text: &str) {
    print_drawn(&printable(text));
}

/// Prints what was drawn here, with its colours and a final newline.
pub fn print_drawn(text: &str) {
    let end = if text.ends_with('\n') { "" } else { "\n" };
    print_with(|out| write!(out, "{text}{end}"));
}

/// Prints a result as one line of JSON.
pub fn print_json(value: &impl serde::Serialize) {
    print_with(|out| {
        let line = serde_json::to_string(value)?;
        writeln!(out, "{}", printable(&line))
    });
}

/// Prints what `fill` writes.
pub fn print_with(fill: impl FnOnce(&mut BufWriter<io::StdoutLock<'_>>) -> io::Result<()>) {
    if ERROR.get().is_some() {
        return;
    }
    let mut out = BufWriter::new(io::stdout().lock());
    let printed = fill(&mut out).and_then(|()| out.flush());
    // What is still in the buffer would be tried again, and out of place.
    let _ = out.into_parts();
    keep(printed);
}

/// Prints what there is to say about the command line: help and version to stdout, errors to stderr. Returns the exit
/// code.
pub fn usage(error: &clap::Error) -> u8 {
    let printed = error.print();
    if !error.use_stderr() {
        keep(printed.and_then(|()| io::stdout().flush()));
    }
    u8::try_from(error.exit_code()).unwrap_or(2)
}

/// Whether results were lost, which is then told. Who reads stdout and closes it has read enough
/// (`eigentrail list | head -1`): that loses nothing.
pub fn lost() -> bool {
    let error = ERROR.get();
    let error = error.filter(|error| error.kind() != io::ErrorKind::BrokenPipe);
    if let Some(error) = error {
        say(format!("error: cannot write to stdout: {error}"));
    }
    error.is_some()
}

fn keep(printed: io::Result<()>) {
    if let Err(error) = printed {
        let _ = ERROR.set(error); // the first one counts
    }
}
