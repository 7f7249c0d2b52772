//! Pages that operate themselves in Chromium.
//!
//! Screenshots go to `target/screenshots/`.

use crate::runs::{comparison_page, figures, graph_page, run_page};
use std::path::Path;
use std::process::{Command, Output};

/// Opens `address` in a window of this width.
fn open(
    browser: &str,
    profile: &Path,
    width: u32,
    dark: bool,
    more: &str,
    address: &str,
) -> Output {
    let scheme = if dark { 0 } else { 1 };
    Command::new("timeout")
        .args(["90", browser])
        .args(["--headless=new", "--no-sandbox", "--disable-gpu"])
        .args(["--no-first-run", "--disable-background-networking"])
        .args(["--enable-logging=stderr", "--hide-scrollbars"])
        .arg("--virtual-time-budget=3000")
        .arg(format!("--window-size={width},{}", 4 * width.max(900)))
        .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(more)
        .arg(address)
        .output()
        .unwrap()
}

/// The narrowest window that Chromium has.
const NARROWEST: u32 = 500;

/// The address of a page as it is in a window of this width: below the narrowest one in a frame, whose page hands on what the page in it
/// has seen.
fn address(folder: &Path, page: &Path, hash: &str, width: u32) -> String {
    let page = format!("file://{}{hash}", page.display());
    if width >= NARROWEST {
        return page;
    }
    let frame = folder.join("frame.html");
    let html = format!(
        "<!doctype html><meta charset=utf-8><meta name=color-scheme content='light dark'><body style='margin:0'>\
         <iframe src='{page}' style='width:{width}px;height:6000px;border:0'></iframe><pre id=\"selftest\"></pre>\
         <script>onmessage = event => {{ document.getElementById('selftest').textContent = event.data }}</script>"
    );
    std::fs::write(&frame, html).unwrap();
    format!("file://{}", frame.display())
}

/// Pictures of a page on a desktop and on a phone, for people to look at.
fn take_screenshots(browser: &str, work: &Path, page: &Path, name: &str) {
    let profile = work.join("profile");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    for (width, dark) in [(1280, false), (1280, true), (390, false)] {
        let ground = if dark { "dark" } else { "light" };
        let picture = folder.join(format!("{name}-{width}-{ground}.png"));
        let _ = std::fs::remove_file(&picture);
        let option = format!("--screenshot={}", picture.display());
        let address = address(work, page, "", width);
        open(browser, &profile, width, dark, &option, &address);
        // A blank picture of this size compresses to a few kilobytes.
        let bytes = std::fs::metadata(&picture).unwrap().len();
        assert!(bytes > 40_000, "{}: {bytes} bytes", picture.display());
    }
}

/// Lets a page operate itself, and returns what it saw.
fn self_test(browser: &str, work: &Path, page: &Path, width: u32) -> serde_json::Value {
    let address = address(work, page, "#selftest", width);
    let profile = work.join("profile");
    let output = open(browser, &profile, width, false, "--dump-dom", &address);
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(!messages.contains("CONSOLE"), "{messages}");
    let dom = String::from_utf8_lossy(&output.stdout);
    let result = dom.split("<pre id=\"selftest\">").nth(1);
    let result = result.and_then(|rest| rest.split("</pre>").next());
    serde_json::from_str(result.unwrap_or("null")).unwrap()
}

/// What the page saw on a desktop, if all is well there and on a phone.
fn assert_works(browser: &str, folder: &Path, page: &Path, name: &str) -> serde_json::Value {
    let results = [390, 1280].map(|width| {
        let result = self_test(browser, folder, page, width);
        for fact in [
            "sliderStartsAtTheEnd",
            "sliderMoves",
            "updateKeepsTheMoment",
            "sliderComesBack",
            "armSwitchesOff",
            "updateKeepsArmsOff",
            "armComesBack",
            "axisSwitches",
            "curvesHaveLabels",
            "labelsAreFree",
            "pointerTells",
            "keysTell",
            "figuresHaveText",
            "numbersAreFinite",
            "fitsWidth",
            "noRequests",
        ] {
            assert_eq!(result[fact], true, "{name}, {width}: {fact}: {result}");
        }
        assert_eq!(result["errors"], serde_json::json!([]), "{result}");
        result
    });
    take_screenshots(browser, folder, page, name);
    let [_, desktop] = results;
    desktop
}

pub fn the_page_of_runs_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    assert_works(browser, folder.path(), &run_page(folder.path()), "run");
}

pub fn the_page_of_a_comparison_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    let page = comparison_page(folder.path());
    let seen = assert_works(browser, folder.path(), &page, "compare");
    // Without advice to leave out the two arms are one, and neither may hide the other.
    assert_eq!(seen["twins"], serde_json::json!(["= no-advice"]));
}

pub fn the_page_of_a_graph_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    let seen = assert_works(browser, folder.path(), &graph_page(folder.path()), "graph");
    let policy = seen["policy"].as_str().unwrap();
    let states = seen["states"].to_string();
    assert!(
        policy.starts_with("s0") && policy.contains("leads to"),
        "{policy}"
    );
    assert!(
        states.contains("s4") && states.contains("offgoal"),
        "{states}"
    );
}

pub fn the_figures_fit_into_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    take_screenshots(browser, folder.path(), &figures(folder.path()), "figures");
}
