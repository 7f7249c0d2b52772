//! Results as people and programs read them.

mod ansi;
pub mod band;
mod blocks;
mod bounded;
mod color;
mod comparison;
mod comparison_table;
mod figure;
mod map;
mod map_png;
mod page;
mod recorded;
mod recorded_comparison;
mod sparkline;
mod summary;
mod terminal;
mod validity;

pub use ansi::Ink;
pub use blocks::blocks;
pub(crate) use bounded::BoundedEpisodes;
pub use comparison::{
    ArmSummary, ArmTiming, Arrival, Comparison, Course, IqmInterval, MedianInterval, Moments,
    ProbabilityInterval, TrialResult, TrialTiming, Tuning, TuningEntry,
};
pub use comparison_table::{TableStyle, render_comparison, render_overview};
pub use figure::{Figure, ReportRuns, counterparts, figures_page, overview};
pub use map::{Charset, Look, draw_map, draw_policy, draw_values, fitting_note};
pub use map_png::png_of_values;
pub use page::{html_comparison, html_report, live_page, report_data};
pub use recorded::{
    EpisodeRow, PhaseSeconds, RecordedRun, RecordedSeed, RefreshRow, SINGLE_ROWS, read_runs,
};
pub use recorded_comparison::{RecordedArm, RecordedComparison};
pub use sparkline::sparkline;
pub use summary::{
    RunLine, SeedResult, SeedTiming, Summary, Timing, final_mean_return, final_mean_steps,
};
pub use terminal::{grouped, render_run};
