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
        .arg(format!("--window-size={width},{}", 4 * width.max(900)))
        .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(more)
        .arg(address)
        .output()
        .unwrap()
}

/// Pictures of a page on a desktop and on a phone, for people to look at.
fn take_screenshots(browser: &str, profile: &Path, page: &Path, name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    for (width, dark) in [(1280, false), (1280, true), (390, false)] {
        let ground = if dark { "dark" } else { "light" };
        let picture = folder.join(format!("{name}-{width}-{ground}.png"));
        let _ = std::fs::remove_file(&picture);
        let option = format!("--screenshot={}", picture.display());
        let address = format!("file://{}", page.display());
        open(browser, profile, width, dark, &option, &address);
        // A blank picture of this size compresses to a few kilobytes.
        let bytes = std::fs::metadata(&picture).unwrap().len();
        assert!(bytes > 40_000, "{}: {bytes} bytes", picture.display());
    }
}

/// Lets a page operate itself, and returns what it saw.
fn self_test(browser: &str, profile: &Path, page: &Path, width: u32) -> serde_json::Value {
    let address = format!("file://{}#selftest", page.display());
    let output = open(browser, profile, width, false, "--dump-dom", &address);
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(!messages.contains("CONSOLE"), "{messages}");
    let dom = String::from_utf8_lossy(&output.stdout);
    let result = dom.split("<pre id=\"selftest\">").nth(1);
    let result = result.and_then(|rest| rest.split("</pre>").next());
    serde_json::from_str(result.unwrap_or("null")).unwrap()
}

fn assert_works(browser: &str, folder: &Path, page: &Path, name: &str) {
    let profile = folder.join("profile");
    for width in [1280, 390] {
        let result = self_test(browser, &profile, page, width);
        for fact in [
            "sliderStartsAtTheEnd",
            "sliderMoves",
            "updateKeepsTheMoment",
            "sliderComesBack",
            "armSwitchesOff",
            "updateKeepsArmsOff",
            "armComesBack",
            "axisSwitches",
            "figuresHaveText",
            "numbersAreFinite",
            "fitsWidth",
            "noRequests",
        ] {
            assert_eq!(result[fact], true, "{name}, {width}: {fact}: {result}");
        }
        assert_eq!(result["errors"], serde_json::json!([]), "{result}");
    }
    take_screenshots(browser, &profile, page, name);
}

pub fn the_page_of_runs_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    assert_works(browser, folder.path(), &run_page(folder.path()), "run");
}

pub fn the_page_of_a_comparison_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    let page = comparison_page(folder.path());
    assert_works(browser, folder.path(), &page, "compare");
}

pub fn the_page_of_a_graph_works_in_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    assert_works(browser, folder.path(), &graph_page(folder.path()), "graph");
}

pub fn the_figures_fit_into_a_browser(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("profile");
    take_screenshots(browser, &profile, &figures(folder.path()), "figures");
}
