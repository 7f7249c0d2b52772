//! A run that is watched; tests/outside watches one in a browser.

use crate::program::HANGS;
use crate::served::{serve, start};
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

/// What the server at `address` answers to a request for `path`, however many packets it takes.
#[cfg(unix)]
fn get(address: &str, path: &str) -> String {
    use std::io::Write;
    let host = address.trim_start_matches("http://").trim_end_matches('/');
    let mut stream = std::net::TcpStream::connect(host).unwrap();
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[cfg(unix)]
fn interrupt(process: &std::process::Child) {
    let id = process.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
}

/// Who comes after a short run sees how it ended.
#[cfg(unix)]
#[test]
fn the_page_stays_until_it_is_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--set", "run.episodes=3", "--serve=127.0.0.1:0"];
    let (mut run, address, lines) = start(folder.path(), &arguments);
    while !lines.recv_timeout(HANGS).unwrap().contains("until Ctrl-C") {}
    for _ in 0..2 {
        assert!(get(&address, "/").contains("<html"), "a page");
        let events = get(&address, "/events");
        assert!(events.contains("data: {") && events.ends_with("event: end\ndata: \n\n"));
    }
    assert!(run.0.try_wait().unwrap().is_none(), "it waits");
    interrupt(&run.0);
    assert_eq!(run.0.wait().unwrap().code(), Some(0));
}

/// The page of a run that did not come to its end does not stay.
#[cfg(unix)]
#[test]
fn an_interrupted_run_takes_its_page_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["--set", "run.episodes=10000000", "--serve=127.0.0.1:0"];
    let (mut run, _, lines) = start(folder.path(), &arguments);
    std::thread::spawn(move || lines.iter().for_each(drop));
    interrupt(&run.0);
    assert_eq!(run.0.wait().unwrap().code(), Some(130));
}
