//! Runs, or a comparison, as one HTML file: data, style and script embedded, nothing fetched, ever.
//!
//! The script draws everything from one object through one function, `update`, so that a live view can send the
//! object again.

mod comparison;
mod data;
mod packed;
mod run;
mod sights;

use super::recorded::RecordedRun;
use super::recorded_comparison::RecordedComparison;
use data::PageData;

const PROGRAM: &str = concat!("eigentrail ", env!("CARGO_PKG_VERSION"));

/// Points of a curve, about.
const MAX_POINTS: usize = 300;

/// Pages stay below this many bytes of data, by leaving out frames.
const MAX_BYTES: usize = 4_500_000;

const HTML: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// In the order in which the browser reads them.
const SCRIPTS: [&str; 6] = [
    include_str!("base.js"),
    include_str!("chart.js"),
    include_str!("interval.js"),
    include_str!("map.js"),
    include_str!("page.js"),
    include_str!("selftest.js"),
];

/// The page about `runs`, the first of which gives it its title.
///
/// # Panics
/// If there are no runs.
pub fn html_report(runs: &[RecordedRun]) -> String {
    page(run::of_runs(runs))
}

/// The page about a comparison.
pub fn html_comparison(recorded: &RecordedComparison) -> String {
    page(comparison::of_comparison(recorded))
}

/// The object that the page about `runs` is drawn from, as JSON, below five million bytes.
///
/// # Panics
/// If there are no runs.
pub fn report_data(runs: &[RecordedRun]) -> String {
    fitted(&mut run::of_runs(runs))
}

fn page(mut data: PageData) -> String {
    // Inside <script>, `</` and `<!--` would be markup.
    let json = fitted(&mut data).replace('<', "\\u003c");
    HTML.replace("{{title}}", &escaped(&data.title))
        .replace("{{style}}", STYLE)
        .replace("{{script}}", &SCRIPTS.concat())
        .replace("{{data}}", &json)
}

/// As JSON, thinned until it is short enough.
fn fitted(data: &mut PageData) -> String {
    loop {
        let json = serde_json::to_string(data).expect("numbers and texts can be written as JSON");
        if json.len() <= MAX_BYTES || !data.thin() {
            return json;
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
