//! A run followed through in Chromium.

use crate::program::HANGS;
use crate::served::{Process, lines, serve};
use std::process::{Command, Stdio};

pub fn a_browser_follows_a_run_through(browser: &str) {
    let folder = tempfile::tempdir().unwrap();
    let (mut run, address) = serve(folder.path(), &["--set", "run.episodes=200000"]);
    let mut chromium = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu"])
        .args(["--no-first-run", "--disable-background-networking"])
        .arg("--enable-logging=stderr")
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("profile").display()
        ))
        .arg(format!("{address}#selftest"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let told = lines(chromium.stderr.take().unwrap());
    let _chromium = Process(chromium);

    let mut seen: Vec<serde_json::Value> = Vec::new();
    while seen.last().is_none_or(|last| last["what"] != "end") {
        let line = told.recv_timeout(HANGS).expect("the page goes on");
        if let Some((_, rest)) = line.split_once("selftest {") {
            let json = rest.rsplit_once('}').unwrap().0.replace("\\\"", "\"");
            seen.push(serde_json::from_str(&format!("{{{json}}}")).unwrap());
        }
    }
    assert!(run.0.wait().unwrap().success());
    let steps: Vec<u64> = seen.iter().map(|s| s["step"].as_u64().unwrap()).collect();
    assert!(steps.len() >= 3, "{seen:?}");
    assert!(steps.windows(2).all(|pair| pair[0] <= pair[1]), "{steps:?}");
    assert!(steps[0] < steps[steps.len() - 1], "{steps:?}");
    let told = |what: &str| seen.iter().find(|told| told["what"] == what).unwrap();
    let (paused, still) = (told("paused"), told("still"));
    for told in [paused, still] {
        let state = told["state"].as_str().unwrap();
        assert!(state.starts_with("Paused at step "), "{state}");
        assert_eq!(told["button"], "Go on");
    }
    assert_eq!(
        paused["drawn"], still["drawn"],
        "nothing is drawn meanwhile"
    );
    assert_eq!(paused["step"], still["step"]);
    let begun = seen[0]["state"].as_str().unwrap();
    assert!(
        begun.starts_with("Live: step ") && begun.contains("ended, at"),
        "{begun}"
    );
    let last = seen.last().unwrap();
    assert_eq!(last["errors"], serde_json::json!([]));
    assert_eq!(last["state"], "The run has ended; this is its last state.");
    let summary = std::fs::read(folder.path().join("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(last["step"], summary["seeds"][0]["steps"], "to the end");
}
