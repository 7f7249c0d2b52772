//! Several seeds of a run at once: what they write, what is printed, and what an interruption leaves.

use assert_cmd::Command;
use predicates::prelude::*;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A fraction of a second.
const TINY: &str = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 40\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.toml"), TINY).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
    command.current_dir(folder).args(["run", "tiny.toml", "-q"]);
    command.args(arguments);
    command
}

fn json(command: &mut Command) -> Value {
    let output = command.assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).expect("one document")
}

/// What a clock said is the only difference between two runs.
fn without_clock(mut line: Value) -> Value {
    let fields = line.as_object_mut().unwrap();
    fields.remove("wall_seconds").unwrap();
    fields.remove("steps_per_second").unwrap();
    line
}

#[test]
fn several_seeds_print_what_each_prints_alone() {
    let folder = folder();
    let all = json(&mut run(folder.path(), &["--seeds", "2..4,9", "--json"]));
    let fields: Vec<&String> = all.as_object().unwrap().keys().collect();
    assert_eq!(fields, ["scenario", "seeds"]);
    assert_eq!(all["scenario"], "tiny");
    let seeds = all["seeds"].as_array().unwrap();
    assert_eq!(seeds.len(), 3);
    for (line, seed) in seeds.iter().zip(["2", "3", "9"]) {
        let out = format!("alone-{seed}");
        let alone = json(&mut run(
            folder.path(),
            &["--seed", seed, "--json", "--out", &out],
        ));
        assert_eq!(without_clock(line.clone()), without_clock(alone));
    }
    let one = json(&mut run(
        folder.path(),
        &["--seeds", "5..6", "--json", "--out", "one"],
    ));
    assert_eq!(one["seeds"][0]["seed"], 5, "a range of one is a range");
}

#[test]
fn they_write_what_each_writes_alone_at_any_number_of_threads() {
    let folder = folder();
    for (threads, out) in [("1", "one"), ("4", "four")] {
        let arguments = ["--seeds", "0..5", "--threads", threads, "--out", out];
        run(folder.path(), &arguments).assert().success();
    }
    run(folder.path(), &["--seed", "3", "--out", "alone"])
        .assert()
        .success();
    let read = |out: &str, seed: usize, file: &str| {
        let path = folder.path().join(out).join(format!("seed-{seed:04}"));
        fs::read(path.join(file)).unwrap()
    };
    for file in [
        "episodes.csv",
        "refreshes.csv",
        "graph.csv",
        "policy.csv",
        "potential.npy",
    ] {
        for seed in 0..5 {
            assert_eq!(
                read("one", seed, file),
                read("four", seed, file),
                "{file}, {seed}"
            );
        }
        assert_eq!(read("alone", 3, file), read("four", 3, file), "{file}");
    }
    let seeds = |out: &str| -> Value {
        let text = fs::read_to_string(folder.path().join(out).join("summary.json")).unwrap();
        serde_json::from_str::<Value>(&text).unwrap()["seeds"].clone()
    };
    assert_eq!(seeds("one"), seeds("four"));
    assert_eq!(seeds("one").as_array().unwrap().len(), 5);
}

#[test]
fn resuming_runs_only_the_seeds_that_are_missing() {
    let folder = folder();
    run(folder.path(), &["--seeds", "1..3", "--out", "o"])
        .assert()
        .success();
    let episodes = folder.path().join("o/seed-0001/episodes.csv");
    fs::write(&episodes, "kept").unwrap();
    let all = json(&mut run(
        folder.path(),
        &["--seeds", "0..4", "--out", "o", "--resume", "--json"],
    ));
    let seeds = all["seeds"].as_array().unwrap().iter();
    let seeds: Vec<u64> = seeds.map(|line| line["seed"].as_u64().unwrap()).collect();
    assert_eq!(seeds, [0, 1, 2, 3]);
    assert_eq!(
        fs::read_to_string(&episodes).unwrap(),
        "kept",
        "not run again"
    );
    let info = fs::read_to_string(folder.path().join("o/run.json")).unwrap();
    let info: Value = serde_json::from_str(&info).unwrap();
    assert_eq!(info["seeds"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(info["status"], "finished");
}

#[test]
fn people_get_a_row_for_each_seed_and_the_medians() {
    let folder = folder();
    let output = run(folder.path(), &["--seeds", "0..3"]).assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(
        text.starts_with("tiny: 3 seeds\n") && text.contains("; optimal: 6.0 steps\n"),
        "{text}"
    );
    assert!(
        text.lines().any(|line| line.starts_with("│ median")),
        "{text}"
    );
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
}

#[test]
fn one_seed_and_several_exclude_each_other() {
    let folder = folder();
    for arguments in [
        &["--seeds", "0..3", "--seed", "1"][..],
        &["--seeds", "0..3", "--serve"],
        &["--seeds", "3..3"],
    ] {
        let refused = run(folder.path(), arguments).assert().code(2);
        refused.stderr(predicate::str::contains("--seeds"));
    }
}
