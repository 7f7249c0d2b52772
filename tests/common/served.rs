//! A run that shows itself while it goes on.

use crate::program::HANGS;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};

/// A process that does not outlive its test.
pub struct Process(pub Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A run of some seconds that shows itself while it goes on, and where.
pub fn serve(folder: &Path, arguments: &[&str]) -> (Process, String) {
    let once = ["--serve-once=127.0.0.1:0"];
    let (run, address, lines) = start(folder, &[arguments, &once].concat());
    // The pipe must stay open for what the run has to say.
    std::thread::spawn(move || lines.iter().for_each(drop));
    (run, address)
}

/// A run that shows itself, where, and what it says after that.
pub fn start(folder: &Path, arguments: &[&str]) -> (Process, String, Receiver<String>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_eigentrail"))
        .args(["run", "rooms_25x25", "--no-report"])
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
    loop {
        let line = lines.recv_timeout(HANGS);
        let line = line.expect("the run says where it is live");
        if let Some(rest) = line.strip_prefix("live at ") {
            return (run, rest.trim_end().to_owned(), lines);
        }
    }
}

/// Lines as they come.
pub fn lines(source: impl Read + Send + 'static) -> Receiver<String> {
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
