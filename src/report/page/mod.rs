//! Runs, or a comparison, as one HTML file: data, style and script embedded, nothing fetched, ever.
//!
//! The script draws everything from one object through one function, `update`, so that a live view can send the
//! object again.

mod comparison;
mod data;
mod ground;
mod names;
mod packed;
mod run;
mod sights;

use crate::archive::RecordedComparison;
use crate::archive::RecordedRun;
use crate::report::marker::MARKER;
use data::PageData;

const PROGRAM: &str = concat!("eigentrail ", env!("CARGO_PKG_VERSION"));

/// Points of a curve, about.
const MAX_POINTS: usize = 300;

/// Pages stay below this many bytes of data, by leaving out frames.
const MAX_BYTES: usize = 4_500_000;

const HTML: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// In the order in which the browser reads them.
const SCRIPTS: [&str; 8] = [
    include_str!("base.js"),
    include_str!("probe.js"),
    include_str!("labels.js"),
    include_str!("chart.js"),
    include_str!("interval.js"),
    include_str!("map.js"),
    include_str!("page.js"),
    include_str!("selftest.js"),
];
/// Only of the served page, after the others: draws again what the server sends.
const LIVE: &str = include_str!("live.js");

/// The page about `runs`, with a part for each of their worlds.
///
/// # Panics
/// If there are no runs.
pub fn html_report(runs: &[RecordedRun]) -> String {
    page_about(run::of_runs(runs))
}

/// The page about a comparison.
pub fn html_comparison(recorded: &RecordedComparison) -> String {
    page_about(comparison::of_comparison(recorded))
}

/// The object that the page about `runs` is drawn from, as JSON, below five million bytes.
///
/// # Panics
/// If there are no runs.
pub fn report_data(runs: &[RecordedRun]) -> String {
    fitted(&mut run::of_runs(runs))
}

/// The page drawn from `data`, and drawn again whenever the server it comes from sends newer data.
pub fn live_page(title: &str, data: &str) -> String {
    const NO_REQUESTS: &str = "default-src 'none'";
    let page = page(title, data, &[&SCRIPTS[..], &[LIVE]].concat());
    page.replacen(NO_REQUESTS, "default-src 'none'; connect-src 'self'", 1)
}

fn page_about(mut data: PageData) -> String {
    let json = fitted(&mut data);
    let others = data.others.iter().map(|other| other.title.as_str());
    let titles: Vec<&str> = [data.title.as_str()].into_iter().chain(others).collect();
    page(&titles.join(", "), &json, &SCRIPTS)
}

fn page(title: &str, data: &str, scripts: &[&str]) -> String {
    // Inside <script>, `</` and `<!--` would be markup.
    let data = data.replace('<', "\\u003c");
    HTML.replace("{{marker}}", MARKER)
        .replace("{{title}}", &escaped(title))
        .replace("{{style}}", STYLE)
        .replace("{{script}}", &scripts.concat())
        .replace("{{data}}", &data)
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
