//! A run, or several as arms, as one HTML file: data, style and script embedded, nothing fetched, ever.

mod data;

use super::recorded::RecordedRun;
use data::PageData;

/// Pages stay below this many bytes of data, by leaving out frames.
const MAX_BYTES: usize = 4_500_000;

const HTML: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page about `runs`, the first of which gives it its title.
///
/// # Panics
/// If there are no runs.
pub fn html_report(runs: &[RecordedRun]) -> String {
    let mut data = PageData::new(runs);
    let json = loop {
        let json = serde_json::to_string(&data).expect("numbers and texts can be written as JSON");
        if json.len() <= MAX_BYTES || !data.thin() {
            break json;
        }
    };
    // Inside <script>, `</` and `<!--` would be markup.
    let json = json.replace('<', "\\u003c");
    HTML.replace("{{title}}", &escaped(&data.title))
        .replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
        .replace("{{data}}", &json)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
