//! A run followed through in a real browser, where there is one.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that does not outlive its test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A run of some seconds that shows itself, and where.
fn serve(folder: &Path, arguments: &[&str]) -> (Process, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_eigentrail"))
        .args(["run", "rooms_25x25", "--no-report", "--serve=127.0.0.1:0"])
        .args(arguments)
        .arg("--out")
        .arg(folder.join("run"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let told = BufReader::new(child.stderr.take().unwrap());
    let lines = lines(told);
    let run = Process(child);
    let begun = Instant::now();
    loop {
        let line = lines.recv_timeout(PATIENCE.saturating_sub(begun.elapsed()));
        let line = line.expect("the run says where it is live");
        if let Some(rest) = line.strip_prefix("live at ") {
            let address = rest.split(' ').next().unwrap().to_owned();
            // The pipe must stay open for what the run has to say.
            std::thread::spawn(move || lines.iter().for_each(drop));
            return (run, address);
        }
    }
}

/// Lines as they come.
fn lines(source: impl Read + Send + 'static) -> Receiver<String> {
    let (to, lines) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(source).lines().map_while(Result::ok) {
            if to.send(line).is_err() {
                return;
            }
        }
    });
    lines
}

/// Chromium under one of its names.
fn browser() -> Option<&'static str> {
    ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| {
            let version = Command::new(name).arg("--version").output();
            version.is_ok_and(|output| output.status.success())
        })
}

#[test]
fn a_browser_follows_a_run_through() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium on this machine");
        return;
    };
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
        let line = told.recv_timeout(PATIENCE).expect("the page goes on");
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
    let last = seen.last().unwrap();
    assert_eq!(last["errors"], serde_json::json!([]));
    assert_eq!(last["state"], "The run has ended; this is its last state.");
    let summary = std::fs::read(folder.path().join("run/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    assert_eq!(last["step"], summary["seeds"][0]["steps"], "to the end");
}

#[test]
fn a_run_that_is_served_writes_what_any_run_writes() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    let status = Command::new(env!("CARGO_BIN_EXE_eigentrail"))
        .args(["run", "rooms_25x25", "-q", "--no-report"])
        .args(["--set", "run.episodes=200", "--out"])
        .arg(&plain)
        .stdout(Stdio::null())
        .status();
    assert!(status.unwrap().success());
    let (mut run, address) = serve(folder.path(), &["--set", "run.episodes=200"]);
    let host = address.trim_start_matches("http://").trim_end_matches('/');
    // It may be over already; what it writes must not depend on that.
    if let Ok(mut stream) = std::net::TcpStream::connect(host) {
        use std::io::Write;
        let _ = stream.write_all(b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
        let _ = stream.read_to_end(&mut Vec::new());
    }
    assert!(run.0.wait().unwrap().success());
    for file in [
        "episodes.csv",
        "refreshes.csv",
        "graph.csv",
        "snapshots.json",
    ] {
        let read = |run: &Path| std::fs::read(run.join("seed-0000").join(file)).unwrap();
        assert_eq!(read(&plain), read(&folder.path().join("run")), "{file}");
    }
}
