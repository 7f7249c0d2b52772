//! A run that is watched; tests/outside watches one in a browser.

use crate::served::serve;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};

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
