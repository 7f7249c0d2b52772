//! stderr shared by log lines and progress bars.

use indicatif::MultiProgress;
use std::io::{self, Write};
use tracing_subscriber::fmt::MakeWriter;

/// Writes whole log lines while the bars step aside.
pub(super) struct Beside(pub MultiProgress);

/// One line under way.
pub(super) struct Line(MultiProgress);

impl<'a> MakeWriter<'a> for Beside {
    type Writer = Line;

    fn make_writer(&'a self) -> Line {
        Line(self.0.clone())
    }
}

impl Write for Line {
    /// The formatter hands over one event as one buffer.
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.0.suspend(|| io::stderr().lock().write_all(line))?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}
