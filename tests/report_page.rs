//! The page of a run, opened in a real browser where there is one.

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

fn eigentrail() -> Command {
    Command::cargo_bin("eigentrail").unwrap()
}

/// Two short runs and their page.
fn page(folder: &Path) -> PathBuf {
    for (arm, sets) in [
        ("shaped", &[][..]),
        (
            "sparse",
            &[
                "--set",
                "shaping.potential=none",
                "--set",
                "exploration.kind=none",
            ][..],
        ),
    ] {
        eigentrail()
            .args([
                "run",
                "four_rooms",
                "-q",
                "--set",
                "run.episodes=60",
                "--out",
            ])
            .arg(folder.join(arm))
            .args(sets)
            .assert()
            .success();
    }
    let page = folder.join("page.html");
    eigentrail()
        .arg("report")
        .args([folder.join("shaped"), folder.join("sparse")])
        .arg("-o")
        .arg(&page)
        .assert()
        .success();
    page
}

/// Chromium under one of its names.
fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| {
            let version = Process::new(name).arg("--version").output();
            version.is_ok_and(|output| output.status.success())
        })
}

#[test]
fn a_run_leaves_a_page_that_asks_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let html = std::fs::read_to_string(page(folder.path())).unwrap();
    assert!(folder.path().join("shaped/report.html").is_file());
    assert!(html.contains("default-src 'none'"));
    // The only address is the name of the SVG name space.
    let addresses = html.matches("http").count() - html.matches("http-equiv").count();
    assert_eq!(
        addresses,
        html.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(
        !html.contains("{{"),
        "every place of the template is filled"
    );
    assert!(html.len() < 5_000_000);
}

#[test]
fn shaping_of_the_default_run_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    let html = std::fs::read_to_string(page(folder.path())).unwrap();
    assert!(html.contains("optimal actions differ in 0 of"));
    assert!(html.contains("\"holds\":true"));
    assert!(!html.contains("\"holds\":false"));
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium on this machine");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path());
    let output = Process::new("timeout")
        .args(["60", browser])
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--window-size=390,844",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("profile").display()
        ))
        .arg(format!("file://{}#selftest", page.display()))
        .output()
        .unwrap();
    let dom = String::from_utf8_lossy(&output.stdout);
    let result = dom.split("<pre id=\"selftest\">").nth(1);
    let result = result.and_then(|rest| rest.split("</pre>").next());
    let result: serde_json::Value = serde_json::from_str(result.unwrap_or("null")).unwrap();
    for fact in [
        "sliderMoves",
        "armSwitchesOff",
        "armComesBack",
        "figuresHaveText",
        "fitsWidth",
        "noRequests",
    ] {
        assert_eq!(result[fact], true, "{fact}: {result}");
    }
    assert_eq!(result["errors"], serde_json::json!([]), "{result}");
}
