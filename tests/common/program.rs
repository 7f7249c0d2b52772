//! The program in an empty folder of its own.

use assert_cmd::Command;
use predicates::prelude::*;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The folder, and how the program is called in it.
pub struct Program {
    folder: TempDir,
}

impl Program {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file and returns its name.
    pub fn file<'n>(&self, name: &'n str, text: &str) -> &'n str {
        fs::write(self.path(name), text).unwrap();
        name
    }

    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).unwrap()
    }

    pub fn call(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
        command
            .current_dir(self.folder.path())
            .env_remove("NO_COLOR")
            .args(arguments);
        command
    }

    /// Calls it and expects this exit code and these words on stderr, and nothing on stdout.
    #[track_caller]
    pub fn refuses(&self, arguments: &[&str], code: i32, words: &[&str]) {
        let mut assert = self.call(arguments).assert().code(code).stdout("");
        for word in words {
            assert = assert.stderr(predicate::str::contains(*word));
        }
    }

    /// Calls it, expects success, returns stdout.
    #[track_caller]
    pub fn prints(&self, arguments: &[&str]) -> String {
        let output = self.call(arguments).assert().success().get_output().clone();
        String::from_utf8(output.stdout).unwrap()
    }

    #[track_caller]
    pub fn prints_json(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.prints(arguments)).unwrap()
    }
}

/// A path of `n` nodes as a Matrix Market file.
pub fn path_graph(n: usize) -> String {
    let edges: String = (1..n).map(|i| format!("{} {i}\n", i + 1)).collect();
    let count = n - 1;
    format!("%%MatrixMarket matrix coordinate pattern symmetric\n{n} {n} {count}\n{edges}")
}

/// After so long something hangs.
pub const HANGS: Duration = Duration::from_secs(600);

/// Waits until it is so.
#[track_caller]
pub fn until(what: &str, so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !so() {
        assert!(begun.elapsed() < HANGS, "never: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}
