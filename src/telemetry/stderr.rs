//! stderr, shared by messages, log lines and progress bars.
//!
//! Nobody may be there to read: a full disk, a pipe without a reader, a terminal that was closed. What cannot be said is
//! no reason to lose a run, so nothing here fails.

use crate::printable::printable;
use indicatif::{MultiProgress, ProgressDrawTarget, TermLike};
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use tracing_subscriber::fmt::MakeWriter;

/// Bars are drawn so often a second at most.
const DRAWINGS_A_SECOND: u8 = 20;

/// A line on stderr, if it takes it. What the line quotes from files cannot give orders to the terminal.
pub fn say(message: impl Display) {
    write(format!("{}\n", printable(&message.to_string())).as_bytes());
}

/// In one piece, so that the lines of several threads do not mix.
fn write(bytes: &[u8]) {
    let mut stderr = io::stderr().lock();
    let _ = stderr.write_all(bytes).and_then(|()| stderr.flush());
}

/// Bars on stderr if it is a terminal, else none.
pub(super) fn bars() -> MultiProgress {
    let target = match io::stderr().is_terminal() {
        true => ProgressDrawTarget::term_like_with_hz(Box::new(Terminal), DRAWINGS_A_SECOND),
        false => ProgressDrawTarget::hidden(),
    };
    MultiProgress::with_draw_target(target)
}

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
        self.0.suspend(|| write(line));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The terminal behind stderr as the bars see it. With one that reports errors they would panic.
#[derive(Debug)]
struct Terminal;

impl Terminal {
    /// An escape sequence that takes a count; with a count of 0 it would still move by 1.
    fn control(count: usize, letter: char) -> io::Result<()> {
        if count > 0 {
            write(format!("\x1b[{count}{letter}").as_bytes());
        }
        Ok(())
    }
}

impl TermLike for Terminal {
    fn width(&self) -> u16 {
        terminal_size::terminal_size_of(io::stderr()).map_or(80, |(width, _)| width.0)
    }

    fn height(&self) -> u16 {
        terminal_size::terminal_size_of(io::stderr()).map_or(24, |(_, height)| height.0)
    }

    fn move_cursor_up(&self, n: usize) -> io::Result<()> {
        Self::control(n, 'A')
    }

    fn move_cursor_down(&self, n: usize) -> io::Result<()> {
        Self::control(n, 'B')
    }

    fn move_cursor_right(&self, n: usize) -> io::Result<()> {
        Self::control(n, 'C')
    }

    fn move_cursor_left(&self, n: usize) -> io::Result<()> {
        Self::control(n, 'D')
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        write(format!("{text}\n").as_bytes());
        Ok(())
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        write(text.as_bytes());
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        write(b"\r\x1b[2K");
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        Ok(())
    }
}
