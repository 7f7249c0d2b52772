//! Runs and comparisons as people look at them: tables, maps, pages, figures.

mod ansi;
pub mod band;
mod color;
mod comparison_table;
mod figure;
mod fitted_table;
mod map;
mod marker;
mod page;
mod seeds_table;
mod sparkline;
mod sweep_table;
mod terminal;
mod validity;

pub use ansi::Ink;
pub(crate) use color::viridis_rgb;
pub use comparison_table::{render_comparison, render_overview};
pub use figure::{Figure, PaperRuns, counterparts, figures_page, overview};
pub use fitted_table::TableStyle;
pub use map::{Charset, Look, draw_map, draw_policy, draw_values, fitting_note};
pub use marker::is_ours;
pub use page::{html_comparison, html_report, live_page, report_data};
pub use seeds_table::render_seeds;
pub use sparkline::sparkline;
pub use sweep_table::render_sweep;
pub use terminal::{grouped, render_run};
