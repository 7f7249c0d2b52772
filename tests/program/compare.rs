//! Comparisons from outside: the exact fields, the same bytes at any number of threads, and what is refused.

use assert_cmd::Command;
use predicates::prelude::*;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Three arms, three seeds, a fraction of a second.
const TINY: &str = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 60\n";
const ARMS: &str = "sparse,gcn,planner";

/// A folder with `tiny.toml` in it.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.toml"), TINY).unwrap();
    folder
}

fn call(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
    command.current_dir(folder).args(arguments);
    command
}

/// `compare tiny.toml` over three seeds.
fn compare(folder: &Path, arms: &str, more: &[&str]) -> Command {
    let mut command = call(folder, &["compare", "tiny.toml", "--seeds", "0..3"]);
    command.args(["--arms", arms]).args(more);
    command
}

fn json(command: &mut Command) -> Value {
    let output = command.assert().success().get_output().clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn json_has_the_fields_of_the_format() {
    let folder = folder();
    let found = json(&mut compare(folder.path(), ARMS, &["--out", "o", "--json"]));
    assert_eq!(found["scenario"], "tiny");
    assert_eq!(found["seeds"], serde_json::json!([0, 1, 2]));
    let arms = found["arms"].as_array().unwrap();
    let names: Vec<&str> = arms.iter().map(|a| a["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["sparse", "gcn", "planner"]);
    for arm in arms {
        for key in ["iqm", "low", "high"] {
            assert!(arm["regret"][key].is_f64(), "{arm}");
        }
        for key in ["median", "low", "high"] {
            assert!(arm["ratio_to_sparse"][key].is_f64(), "{arm}");
        }
        assert!(arm["steps_to_1_1x"].get("median").is_some());
        assert!(arm["final_ratio"].as_f64().unwrap() >= 1.0);
    }
    // The sparse arm against itself.
    let itself = &arms[0]["ratio_to_sparse"];
    assert_eq!(
        (&itself["median"], &itself["low"]),
        (&1.0.into(), &1.0.into())
    );
    assert_eq!(arms[0]["probability_of_improvement"]["value"], 0.5);
    assert_eq!(arms[0]["spurious_maxima"], Value::Null);
    assert_eq!(arms[1]["spurious_maxima"], 0);
    assert!(arms[1]["ratio_to_sparse"]["high"].as_f64().unwrap() < 0.5);
    let written = fs::read_to_string(folder.path().join("o/compare.json")).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&written).unwrap(), found);
}

#[test]
fn threads_change_no_byte() {
    let folder = folder();
    let csv = |threads: &str| {
        let out = format!("o{threads}");
        compare(folder.path(), ARMS, &["--out", &out, "--threads", threads])
            .assert()
            .success();
        fs::read(folder.path().join(out).join("compare.csv")).unwrap()
    };
    let one = csv("1");
    assert_eq!(one.iter().filter(|&&byte| byte == b'\n').count(), 1 + 3 * 3);
    assert_eq!(one, csv("4"));
}

#[test]
fn resuming_runs_only_what_is_missing() {
    let folder = folder();
    let out = folder.path().join("o");
    let whole = json(&mut compare(folder.path(), ARMS, &["--out", "o", "--json"]));
    let kept = out.join("arms/gcn/seed-0001.json");
    let gone = out.join("arms/planner/seed-0002.json");
    let modified = || fs::metadata(&kept).unwrap().modified().unwrap();
    let before = modified();
    fs::remove_file(&gone).unwrap();
    let again = json(&mut compare(
        folder.path(),
        ARMS,
        &["--out", "o", "--json", "--resume"],
    ));
    assert_eq!(again["arms"], whole["arms"]);
    assert_eq!(modified(), before);
    assert!(gone.exists());
    // Another scenario: nothing that is there counts.
    let other = json(&mut compare(
        folder.path(),
        ARMS,
        &[
            "--out",
            "o",
            "--json",
            "--resume",
            "--set",
            "run.episodes=50",
        ],
    ));
    assert_eq!(other["episodes"], 50);
    assert_ne!(other["arms"][0]["regret"], whole["arms"][0]["regret"]);
    assert!(modified() > before);
}

#[test]
fn an_existing_folder_is_refused_and_force_replaces_it() {
    let folder = folder();
    let run = |more: &[&str]| compare(folder.path(), "planner", more).assert();
    run(&["--out", "o"]).success();
    run(&["--out", "o"])
        .code(3)
        .stdout("")
        .stderr(predicate::str::contains("--resume"));
    run(&["--out", "o", "--force"]).success();
    run(&["--out", ".", "--force"])
        .code(3)
        .stderr(predicate::str::contains("not a run folder"));
    assert!(folder.path().join("tiny.toml").exists());
}

#[test]
fn the_sparse_arm_is_run_but_not_listed_unless_asked_for() {
    let folder = folder();
    compare(folder.path(), "planner", &["--out", "o"])
        .assert()
        .success()
        .stdout(predicate::str::contains(
            "The sparse arm was run for the ratios",
        ));
    assert!(folder.path().join("o/arms/sparse/seed-0000.json").exists());
    let text = fs::read_to_string(folder.path().join("o/compare.json")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(found["arms"].as_array().unwrap().len(), 1);
}

#[test]
fn a_tuned_sparse_arm_says_how_it_was_tuned() {
    let folder = folder();
    let found = json(&mut compare(
        folder.path(),
        "gcn",
        &["--out", "o", "--tuned", "--json"],
    ));
    let tuning = &found["tuning"];
    let tried = tuning["tried"].as_array().unwrap();
    let best = tried
        .iter()
        .map(|entry| entry["regret_iqm"].as_f64().unwrap())
        .fold(f64::INFINITY, f64::min);
    assert_eq!(tuning["chosen"]["regret_iqm"].as_f64(), Some(best));
    assert!(
        tuning["seeds"]
            .as_array()
            .unwrap()
            .iter()
            .all(|s| s.as_u64() > Some(2))
    );
    let against = |key: &str| found["arms"][0][key]["median"].as_f64().unwrap();
    assert!(against("ratio_to_tuned_sparse") > against("ratio_to_sparse"));
}

#[test]
fn several_scenarios_end_in_one_table() {
    let folder = folder();
    fs::write(folder.path().join("other.toml"), TINY).unwrap();
    let arguments = [
        "compare",
        "tiny.toml",
        "other.toml",
        "--seeds",
        "5",
        "--arms",
        "planner",
    ];
    call(folder.path(), &arguments)
        .args(["--out", "o", "--markdown"])
        .assert()
        .success()
        .stdout(predicate::str::contains("| regret ÷ sparse |"));
    assert!(folder.path().join("o/tiny/compare.csv").exists());
    assert!(folder.path().join("o/other/compare.csv").exists());
}

#[test]
fn slips_of_the_command_line_are_told() {
    let folder = folder();
    compare(folder.path(), "gcn,planer", &["--out", "o"])
        .assert()
        .code(3)
        .stdout("")
        .stderr(predicate::str::contains("did you mean `planner`?"));
    for seeds in ["3..3", "x", "1..", ""] {
        call(folder.path(), &["compare", "tiny.toml", "--seeds", seeds])
            .assert()
            .code(2);
    }
    call(folder.path(), &["compare"]).assert().code(2);
    assert!(!folder.path().join("o").exists(), "nothing is left behind");
}

#[test]
fn a_scenario_brings_arms_of_its_own() {
    let folder = folder();
    let arms = "[arms.slow]\nbase = \"sparse\"\n\"agent.critic_learning_rate\" = 0.2\n\
                [arms.same]\nbase = \"sparse\"\nabout = \"nothing else\"\n";
    fs::write(folder.path().join("tiny.toml"), TINY.to_owned() + arms).unwrap();
    let out = ["--out", "o", "--json"];
    let found = json(&mut compare(folder.path(), "sparse,slow,same", &out));
    let arms = found["arms"].as_array().unwrap();
    assert_eq!(arms[1]["name"], "slow");
    assert_eq!(arms[2]["regret"], arms[0]["regret"], "the same settings");
    assert_ne!(arms[1]["regret"], arms[0]["regret"]);
    let settings = fs::read_to_string(folder.path().join("o/arms.json")).unwrap();
    assert!(
        settings.contains("agent.critic_learning_rate=0.2"),
        "{settings}"
    );
    let resolved = fs::read_to_string(folder.path().join("o/arms/slow/resolved.toml")).unwrap();
    assert!(resolved.contains("critic_learning_rate = 0.2") && !resolved.contains("[arms"));
    compare(folder.path(), "slwo", &["--out", "p"])
        .assert()
        .code(3)
        .stderr(predicate::str::contains("did you mean `slow`?"));
    call(folder.path(), &["check", "tiny.toml"])
        .assert()
        .success()
        .stdout(predicate::str::contains(
            "sparse, agent.critic_learning_rate = 0.2",
        ))
        .stdout(predicate::str::contains("nothing else"));
}

#[test]
fn goals_that_move_are_told_in_the_numbers() {
    let folder = folder();
    let moving =
        "[env]\nrows = 4\ncols = 4\nmoved_goals = [{ at = \"top-right\" }]\n[run]\nepisodes = 60\n";
    fs::write(folder.path().join("tiny.toml"), moving).unwrap();
    let out = ["--out", "o", "--json"];
    let found = json(&mut compare(folder.path(), "gcn", &out));
    assert_eq!(found["goals_moved_after"], 30);
    assert_eq!(found["optimal_steps"], 3.0);
    assert!(found["arms"][0]["final_ratio"].as_f64().unwrap() < 1.5);
    for (bad, why) in [
        ("goals_move_after=60", "the goals would never move"),
        ("goals_move_after=haf", "\"half\" or a whole number from 1"),
        (
            "moved_goals=[{at=\"bottom-right\"}]",
            "the goals would not move",
        ),
        ("moved_goals=[{at=\"top-left\"}]", "env.moved_goals"),
        (
            "moved_goals=[{at=\"top-rigth\"}]",
            "did you mean \"top-right\"?",
        ),
        ("moved_goals=[]", "env.moved_goals"),
    ] {
        let set = format!("env.{bad}");
        call(folder.path(), &["check", "tiny.toml", "--set", &set])
            .assert()
            .code(3)
            .stderr(predicate::str::contains(why));
    }
}
