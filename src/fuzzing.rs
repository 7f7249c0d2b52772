//! Entries for fuzzers: bytes from outside, taken as the program takes them.
//!
//! None may panic, take longer than a second, or more memory than a gigabyte. `fuzz/` runs them under libFuzzer; a test here runs all
//! of its corpus, and some thousands of changes to it, without. `EIGENTRAIL_FUZZ=1000000` makes as many changes for each target.

use crate::archive::{self, Checkpoint, Existing, RecordedComparison, read_runs};
use crate::env::EdgeList;
use crate::env::layouts::Layout;
use crate::graph::matrix_market;
use crate::report::{html_comparison, html_report};
use crate::runner::{self, CompareRequest, CompareWatch, RunRequest, Watch};
use crate::scenario::Scenario;
use crate::serve;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, OnceLock, PoisonError};
use tempfile::TempDir;

/// Name and entry.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const TARGETS: [Target; 8] = [
    ("scenario", scenario),
    ("setting", setting),
    ("map", map),
    ("edge_list", edge_list),
    ("matrix_market", matrix_market),
    ("checkpoint", checkpoint),
    ("run_folder", run_folder),
    ("request", request),
];

/// A scenario file. Worlds that ask to be large are left out: they take what they need.
pub fn scenario(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    if is_modest(&text) {
        let _ = Scenario::parse(Path::new("x.toml"), text, &[]);
    }
}

/// What follows `--set`.
pub fn setting(bytes: &[u8]) {
    let setting = String::from_utf8_lossy(bytes).into_owned();
    if is_modest(&setting) {
        let text = "[env]\nrows = 3\ncols = 3\n".to_owned();
        let _ = Scenario::parse(Path::new("x.toml"), text, &[setting]);
    }
}

/// Whether no number in a text has more than two digits in a row, and no file is named.
fn is_modest(text: &str) -> bool {
    let is_digit = |byte: &u8| byte.is_ascii_hexdigit() || *byte == b'_';
    let longest = text
        .as_bytes()
        .split(|byte| !is_digit(byte))
        .filter(|run| run.iter().filter(|byte| byte.is_ascii_digit()).count() > 2);
    longest.count() == 0 && !text.contains("path") && !text.contains("file")
}

/// An ASCII map.
pub fn map(bytes: &[u8]) {
    let rewards = BTreeMap::from([('1', 1.0), ('2', -1.0)]);
    let _ = Layout::from_ascii(&String::from_utf8_lossy(bytes), &rewards);
}

/// An edge list.
pub fn edge_list(bytes: &[u8]) {
    let _ = EdgeList::from_reader("x.csv", bytes);
}

/// A graph of Matrix Market.
pub fn matrix_market(bytes: &[u8]) {
    let _ = matrix_market::parse(&String::from_utf8_lossy(bytes));
}

/// A checkpoint: as it is, and as the payload of one whose checksum is right.
pub fn checkpoint(bytes: &[u8]) {
    let _ = Checkpoint::of_bytes(bytes);
    let _ = Checkpoint::of_payload(bytes);
}

/// A file of a run or of a comparison; which one, the first byte says.
pub fn run_folder(bytes: &[u8]) {
    static FOLDER: OnceLock<Mutex<Folder>> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| Mutex::new(Folder::new()));
    let folder = folder.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((&which, bytes)) = bytes.split_first() {
        folder.with(usize::from(which), bytes);
    }
}

/// A request to the live page, in pieces.
pub fn request(bytes: &[u8]) {
    for local in [false, true] {
        serve::read_any_request(bytes, local);
    }
}

/// A run and a comparison that have ended.
struct Folder {
    folder: TempDir,
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Folder {
    fn new() -> Self {
        static GO_ON: AtomicBool = AtomicBool::new(false);
        let folder = tempfile::tempdir().expect("a folder");
        let text = "[env]\nrows = 3\ncols = 3\n[run]\nepisodes = 3\n".to_owned();
        let loaded = Scenario::parse(Path::new("x.toml"), text, &[]).expect("a scenario");
        let request = RunRequest {
            seeds: vec![0],
            out: Some(folder.path().join("run")),
            existing: Existing::Refuse,
            arguments: Vec::new(),
        };
        let watch = Watch {
            stop: &GO_ON,
            observers: &|_| Ok(Vec::new()),
        };
        runner::run(&loaded, &request, watch).expect("a run");
        let request = CompareRequest {
            path: Path::new("x.toml").to_owned(),
            sets: Vec::new(),
            seeds: vec![0],
            arms: vec!["sparse".to_owned()],
            tuned: false,
            out: Some(folder.path().join("compare")),
            existing: Existing::Refuse,
            arguments: Vec::new(),
        };
        let watch = CompareWatch {
            stop: &GO_ON,
            on_trial: &|_, _| {},
        };
        runner::compare(&loaded, &request, watch).expect("a comparison");
        let files = files(folder.path());
        Self { folder, files }
    }

    /// Reads both with `bytes` in the place of one file, and puts that back.
    fn with(&self, which: usize, bytes: &[u8]) {
        let (path, before) = &self.files[which % self.files.len()];
        std::fs::write(path, bytes).expect("it can be written");
        if let Ok(runs) = read_runs(&self.folder.path().join("run")) {
            html_report(&runs);
        }
        if let Ok(comparison) = RecordedComparison::read(&self.folder.path().join("compare")) {
            html_comparison(&comparison);
        }
        let _ = archive::read_potential(&self.folder.path().join("run/seed-0000"));
        std::fs::write(path, before).expect("it can be written");
    }
}

/// The files below a folder, sorted, with what is in them.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    let below = paths.into_iter().flat_map(|path| match path.is_dir() {
        true => files(&path),
        false => {
            let bytes = std::fs::read(&path).expect("it can be read");
            vec![(path, bytes)]
        }
    });
    below.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::time::{Duration, Instant};

    fn corpus(target: &str) -> Vec<Vec<u8>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("fuzz/corpus")
            .join(target);
        files(&folder).into_iter().map(|(_, bytes)| bytes).collect()
    }

    /// One of `all`, cut, repeated, joined with another one, or with bytes that are others.
    fn changed(all: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
        let mut bytes = all[random.random_range(0..all.len())].clone();
        for _ in 0..random.random_range(1..5) {
            let at = random.random_range(0..=bytes.len());
            let end = (at + random.random_range(0..40)).min(bytes.len());
            match random.random_range(0..5) {
                0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
                1 if at < bytes.len() => {
                    bytes[at] = b"\0\n\"\xFF0-9.,=[]{}\x7F"[random.random_range(0..15)]
                }
                2 => drop(bytes.drain(at..end)),
                3 => bytes.extend_from_within(at..end),
                _ => {
                    let other = &all[random.random_range(0..all.len())];
                    let from = random.random_range(0..=other.len());
                    let part = &other[from..(from + 40).min(other.len())];
                    drop(bytes.splice(at..end, part.iter().copied()));
                }
            }
        }
        bytes
    }

    #[test]
    fn bytes_from_outside_never_panic_nor_hang() {
        let changes = std::env::var("EIGENTRAIL_FUZZ").map_or(1000, |n| n.parse().unwrap());
        for (number, (name, target)) in TARGETS.into_iter().enumerate() {
            let all = corpus(name);
            assert!(all.len() > 1, "{name} has a corpus");
            let mut random = ChaCha8Rng::seed_from_u64(number as u64);
            let kept = all.iter().cloned();
            let changed = (0..changes).map(|_| changed(&all, &mut random));
            let mut longest = Duration::ZERO;
            for bytes in kept.chain(changed) {
                let begun = Instant::now();
                let outcome = std::panic::catch_unwind(|| target(&bytes));
                longest = longest.max(begun.elapsed());
                assert!(
                    outcome.is_ok(),
                    "{name}: {:?}",
                    String::from_utf8_lossy(&bytes)
                );
            }
            println!(
                "{name}: {} inputs, the slowest {longest:?}",
                all.len() + changes
            );
        }
    }
}
