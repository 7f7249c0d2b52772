//! Results as people and programs read them.

mod map;
mod sparkline;
mod summary;
mod terminal;

pub use map::{Charset, draw_map, draw_values};
pub use sparkline::sparkline;
pub use summary::{RunLine, SeedResult, SeedTiming, Summary, Timing, final_mean_steps};
pub use terminal::{grouped, render_run};
