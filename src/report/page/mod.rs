//! A run, or several as arms, as one HTML file: data, style and script embedded, nothing fetched, ever.

mod data;

use super::recorded::RecordedRun;
use data::PageData;

/// Pages stay below this many bytes of data, by leaving out frames.
const MAX_BYTES: usize = 4_500_000;

const HTML: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Only of the served page: draws again what the server sends.
const LIVE: &str = include_str!("live.js");

/// The page about `runs`, the first of which gives it its title.
///
/// # Panics
/// If there are no runs.
pub fn html_report(runs: &[RecordedRun]) -> String {
    page(&runs[0].scenario.name, &report_data(runs), "")
}

/// The object that the page about `runs` is drawn from, as JSON, below five million bytes.
///
/// # Panics
/// If there are no runs.
pub fn report_data(runs: &[RecordedRun]) -> String {
    let mut data = PageData::new(runs);
    loop {
        let json = serde_json::to_string(&data).expect("numbers and texts can be written as JSON");
        if json.len() <= MAX_BYTES || !data.thin() {
            return json;
        }
    }
}

/// The page drawn from `data`, and drawn again whenever the server it comes from sends newer data.
pub fn live_page(title: &str, data: &str) -> String {
    const NO_REQUESTS: &str = "default-src 'none'";
    let page = page(title, data, LIVE);
    page.replacen(NO_REQUESTS, "default-src 'none'; connect-src 'self'", 1)
}

fn page(title: &str, data: &str, more: &str) -> String {
    // Inside <script>, `</` and `<!--` would be markup.
    let data = data.replace('<', "\\u003c");
    HTML.replace("{{title}}", &escaped(title))
        .replace("{{style}}", STYLE)
        .replace("{{script}}", &[SCRIPT, more].concat())
        .replace("{{data}}", &data)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
