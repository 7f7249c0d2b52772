//! Progress: a bar on a terminal, gone at the end, and nothing elsewhere.

use eigentrail::report::grouped;
use eigentrail::telemetry::Telemetry;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How often the bar is drawn while nothing comes to an end.
const TICK: Duration = Duration::from_millis(250);

/// Progress of a known number of things, which may be reported from many threads.
pub struct Progress {
    bar: Option<ProgressBar>,
    begun: Instant,
    steps: AtomicU64,
}

impl Progress {
    /// Progress of `total` `what`; silent unless `shown`.
    pub fn new(telemetry: &Telemetry, shown: bool, what: &'static str, total: u64) -> Self {
        let bar = (shown && stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
            let bar = telemetry.bars.add(bar); // they know where to draw
            let template = format!("{{wide_bar}} {{pos}}/{{len}} {what}{{msg}}, {{eta}} left");
            if let Ok(style) = ProgressStyle::with_template(&template) {
                bar.set_style(style);
            }
            bar.enable_steady_tick(TICK);
            bar
        });
        Self {
            bar,
            begun: Instant::now(),
            steps: AtomicU64::new(0),
        }
    }

    /// So many more are done.
    pub fn add(&self, done: u64) {
        if let Some(bar) = &self.bar {
            bar.inc(done);
        }
    }

    /// So many are done by now. A search may turn out longer than was known.
    pub fn reach(&self, done: u64) {
        if let Some(bar) = &self.bar {
            bar.set_length(bar.length().unwrap_or(0).max(done));
            bar.set_position(done);
        }
    }

    /// So many more environment steps were taken.
    pub fn add_steps(&self, steps: u64) {
        let Some(bar) = &self.bar else { return };
        let all = self.steps.fetch_add(steps, Ordering::Relaxed) + steps;
        let a_second = all as f64 / self.begun.elapsed().as_secs_f64().max(1e-3);
        bar.set_message(format!(
            ", {} steps, {} steps/s",
            grouped(all),
            grouped(a_second as u64)
        ));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
