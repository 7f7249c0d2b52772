//! Results as people and programs read them.

pub mod band;
mod color;
mod comparison;
mod comparison_table;
mod figure;
mod map;
mod map_png;
mod page;
mod recorded;
mod sparkline;
mod summary;
mod terminal;
mod validity;

pub use comparison::{
    ArmSummary, ArmTiming, Arrival, Comparison, IqmInterval, MedianInterval, Moments,
    ProbabilityInterval, TrialResult, TrialTiming, Tuning, TuningEntry,
};
pub use comparison_table::{TableStyle, render_comparison, render_overview};
pub use figure::overview;
pub use map::{Charset, draw_map, draw_values};
pub use map_png::png_of_values;
pub use page::{html_report, live_page, report_data};
pub use recorded::{EpisodeRow, RecordedRun, RecordedSeed, RefreshRow, read_runs};
pub use sparkline::sparkline;
pub use summary::{RunLine, SeedResult, SeedTiming, Summary, Timing, final_mean_steps};
pub use terminal::{grouped, render_run};
