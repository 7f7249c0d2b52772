//! Results as people and programs read them.

mod sparkline;
mod summary;
mod terminal;

pub use sparkline::sparkline;
pub use summary::{RunLine, SeedResult, SeedTiming, Summary, Timing, final_mean_steps};
pub use terminal::{grouped, render_run};
