//! Results as people and programs read them.

pub mod band;
mod color;
mod figure;
mod map;
mod recorded;
mod sparkline;
mod summary;
mod terminal;

pub use figure::overview;
pub use map::{Charset, draw_map, draw_values};
pub use recorded::{EpisodeRow, RecordedRun, RecordedSeed, RefreshRow, read_runs};
pub use sparkline::sparkline;
pub use summary::{RunLine, SeedResult, SeedTiming, Summary, Timing, final_mean_steps};
pub use terminal::{grouped, render_run};
