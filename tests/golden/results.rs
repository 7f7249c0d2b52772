//! What is hashed: the result files of a run, the facts and vectors of an eigensolve.

use eigentrail_testing::graphs::Csr;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name of a result → hash.
pub type Hashes = BTreeMap<String, String>;

/// Files of a run that carry clocks, and pages made of them.
const NOT_RESULTS: [&str; 3] = ["timings.csv", "events.jsonl", "report.html"];

/// What is run.
pub enum Subject {
    /// A scenario, with seed 0.
    Scenario(PathBuf),
    /// A graph in order of discovery, by `track` with these flags.
    Graph {
        name: &'static str,
        graph: Box<Csr>,
        flags: Vec<String>,
    },
}

impl Subject {
    pub fn name(&self) -> String {
        match self {
            Subject::Scenario(path) => {
                let stem = path.file_stem().unwrap_or_default();
                format!("run/{}", stem.to_string_lossy())
            }
            Subject::Graph { name, .. } => format!("track/{name}"),
        }
    }

    /// The hash of each result, under the name of the subject.
    pub fn hashes(&self, threads: usize) -> Result<Hashes, String> {
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        let hashes = match self {
            Subject::Scenario(path) => run(path, folder.path(), threads)?,
            Subject::Graph { graph, flags, .. } => track(graph, flags, folder.path(), threads)?,
        };
        let named = |(file, hash)| (format!("{}/{file}", self.name()), hash);
        Ok(hashes.into_iter().map(named).collect())
    }
}

fn run(scenario: &Path, folder: &Path, threads: usize) -> Result<Hashes, String> {
    let out = folder.join("out");
    let mut command = eigentrail(threads);
    command
        .arg("run")
        .arg(scenario)
        .args(["--seed", "0", "-q", "--json", "--out"]);
    output(command.arg(&out))?;
    let mut hashes = Hashes::new();
    let seed = out.join("seed-0000");
    for entry in fs::read_dir(&seed).map_err(|e| format!("{}: {e}", seed.display()))? {
        let path = entry.map_err(|e| e.to_string())?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if !NOT_RESULTS.contains(&name.as_str()) && !name.starts_with("events.out") {
            hashes.insert(name, hash(&read_bytes(&path)?));
        }
    }
    let mut summary: Value = parse(&read_bytes(&out.join("summary.json"))?)?;
    remove(&mut summary, "timing");
    hashes.insert(
        "summary.json".to_owned(),
        hash(summary.to_string().as_bytes()),
    );
    Ok(hashes)
}

fn track(graph: &Csr, flags: &[String], folder: &Path, threads: usize) -> Result<Hashes, String> {
    let (file, vectors) = (folder.join("graph.mtx"), folder.join("vectors.npy"));
    fs::write(&file, matrix_market(graph)).map_err(|e| e.to_string())?;
    let mut command = eigentrail(threads);
    command
        .arg("track")
        .arg(&file)
        .args(flags)
        .args(["-q", "--json", "--vectors"]);
    let mut facts: Value = parse(&output(command.arg(&vectors))?)?;
    // Clocks, and what was asked for rather than found.
    for key in ["seconds", "total_seconds", "threads", "laplacian"] {
        remove(&mut facts, key);
    }
    Ok(Hashes::from([
        ("facts".to_owned(), hash(facts.to_string().as_bytes())),
        ("vectors.npy".to_owned(), hash(&read_bytes(&vectors)?)),
    ]))
}

/// The program, behind the words of `EIGENTRAIL_GOLDEN_RUNNER` if there are any: an emulator of another processor.
fn eigentrail(threads: usize) -> Command {
    let runner = std::env::var("EIGENTRAIL_GOLDEN_RUNNER").unwrap_or_default();
    let mut words = runner
        .split_whitespace()
        .chain([env!("CARGO_BIN_EXE_eigentrail")]);
    let mut command = Command::new(words.next().expect("the program at least"));
    command.args(words);
    command.arg("--threads").arg(threads.to_string());
    command
}

/// Its stdout, if it ends well.
fn output(command: &mut Command) -> Result<Vec<u8>, String> {
    let output = command.output().map_err(|e| e.to_string())?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("{command:?} ended with {}: {said}", output.status))
}

fn matrix_market(graph: &Csr) -> String {
    let mut text = String::from("%%MatrixMarket matrix coordinate real general\n");
    let _ = writeln!(text, "{} {} {}", graph.rows(), graph.cols(), graph.nnz());
    for (weight, (row, column)) in graph {
        let _ = writeln!(text, "{} {} {weight}", row + 1, column + 1);
    }
    text
}

/// Removes a key wherever it stands.
fn remove(value: &mut Value, key: &str) {
    match value {
        Value::Object(fields) => {
            fields.shift_remove(key);
            fields.values_mut().for_each(|v| remove(v, key));
        }
        Value::Array(items) => items.iter_mut().for_each(|v| remove(v, key)),
        _ => {}
    }
}

fn parse(bytes: &[u8]) -> Result<Value, String> {
    serde_json::from_slice(bytes).map_err(|e| e.to_string())
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn hash(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

/// The hashes of a file of lines `HASH  NAME`; none where there is no file.
pub fn read(file: &Path) -> Hashes {
    let text = fs::read_to_string(file).unwrap_or_default();
    let line = |line: &str| {
        line.split_once("  ")
            .map(|(hash, name)| (name.to_owned(), hash.to_owned()))
    };
    text.lines().filter_map(line).collect()
}

/// Writes what [`read`] reads.
pub fn write(file: &Path, hashes: &Hashes) {
    let lines = hashes
        .iter()
        .map(|(name, hash)| format!("{hash}  {name}\n"));
    fs::write(file, lines.collect::<String>()).expect("the file of hashes can be written");
}
