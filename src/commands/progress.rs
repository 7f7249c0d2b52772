//! Progress: a bar on a terminal, elsewhere a line every ten seconds.

use eigentrail::telemetry::{Telemetry, say};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Progress of a known number of things.
pub struct Progress {
    what: &'static str,
    bar: Option<ProgressBar>,
    lines: bool,
    said: Instant,
    done: u64,
    total: u64,
}

impl Progress {
    /// Progress of `total` `what`; silent unless `shown`.
    pub fn new(telemetry: &Telemetry, shown: bool, what: &'static str, total: u64) -> Self {
        let terminal = stderr().is_terminal();
        let bar = (shown && terminal).then(|| {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
            let bar = telemetry.bars.add(bar); // they know where to draw
            let template = "{wide_bar} {pos}/{len} {msg} {elapsed}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar.set_message(what);
            bar
        });
        Self {
            what,
            bar,
            lines: shown && !terminal,
            said: Instant::now(),
            done: 0,
            total,
        }
    }

    /// So many are done; `detail` says something about the last one.
    pub fn reach(&mut self, done: u64, detail: impl FnOnce() -> String) {
        self.done = done;
        self.total = self.total.max(done); // a search may turn out longer than was known
        if let Some(bar) = &self.bar {
            bar.set_length(self.total);
            bar.set_position(done);
        } else if self.lines && self.said.elapsed() >= LINE_EVERY {
            self.said = Instant::now();
            say(format!(
                "{} of {} {}, {}",
                self.done,
                self.total,
                self.what,
                detail()
            ));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
