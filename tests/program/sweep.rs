//! Sweeps from outside: the same bytes at any number of threads and after any interruption, and what is refused.

use crate::program::{Program, until};
use serde_json::json;
use std::fs;

const TINY: &str = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 40\n[arms.mine]\nbase = \"gcn\"\n";
const GRID: [&str; 4] = [
    "--grid",
    "shaping.potential=gcn,heat",
    "--grid",
    "env.slip=0.0,0.1",
];

fn tiny() -> Program {
    let program = Program::new();
    program.file("tiny.toml", TINY);
    program
}

fn sweep<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let begin = ["sweep", "tiny.toml", "--seeds", "0..3", "--out", out];
    [&begin[..], &GRID, more].concat()
}

/// The files of a sweep that equal ones share to the byte.
fn results(program: &Program, out: &str) -> [Vec<u8>; 2] {
    ["summary.json", "sweep.csv"].map(|name| fs::read(program.path(out).join(name)).unwrap())
}

#[test]
fn a_table_a_document_and_a_row_for_each_trial() {
    let program = tiny();
    let text = program.prints(&sweep("o", &[]));
    assert!(
        text.contains("tiny: 4 points, 3 seeds each (0–2)"),
        "{text}"
    );
    assert!(
        text.contains("potential") && text.contains("slip"),
        "{text}"
    );
    assert!(text.ends_with("written to o\n"), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
    let wide = program.prints(&sweep("o", &["--wide"]));
    assert!(wide.contains("false maxima") && !wide.contains("more columns"));
    // stdout has what summary.json has.
    let document = program.prints_json(&sweep("o", &["--json"]));
    assert_eq!(document, program.json("o/summary.json"));
    let settings = &document["points"][1]["settings"];
    assert_eq!(
        settings[0],
        json!({ "key": "shaping.potential", "value": "gcn" })
    );
    assert_eq!(settings[1], json!({ "key": "env.slip", "value": 0.1 }));
    let rows = program.text("o/sweep.csv");
    let rows: Vec<&str> = rows.lines().collect();
    assert_eq!(rows.len(), 1 + 4 * 3);
    assert!(rows[0].starts_with("shaping.potential,env.slip,seed,episodes,steps,regret,"));
    assert!(rows[12].starts_with("heat,0.1,2,40,"), "{}", rows[12]);
    // Each point by itself is what `compare` makes of the same settings and seeds.
    let compared = program.prints_json(&[
        "compare",
        "tiny.toml",
        "--seeds",
        "0..3",
        "--arms",
        "heat",
        "--set",
        "env.slip=0.1",
        "--out",
        "c",
        "--json",
        "--no-report",
    ]);
    let (point, arm) = (&document["points"][3], &compared["arms"][0]);
    for field in [
        "first_goal_step",
        "regret",
        "final_return",
        "greedy_return",
        "failures",
        "worst_seed",
    ] {
        assert_eq!(point[field], arm[field], "{field}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let program = tiny();
    program.prints(&sweep("one", &["--threads", "1"]));
    program.prints(&sweep("four", &["--threads", "4"]));
    assert_eq!(results(&program, "one"), results(&program, "four"));
}

#[test]
fn arms_are_laid_over_every_point() {
    let program = tiny();
    let document = program.prints_json(&[
        "sweep",
        "tiny.toml",
        "--seeds",
        "0,7",
        "--arms",
        "mine, sparse",
        "--grid",
        "env.cols=4,5",
        "--out",
        "o",
        "--json",
    ]);
    let points = document["points"].as_array().unwrap();
    let arms: Vec<&str> = points.iter().map(|p| p["arm"].as_str().unwrap()).collect();
    assert_eq!(arms, ["mine", "mine", "sparse", "sparse"]);
    assert_eq!(points[1]["optimal_steps"], json!(7.0), "cols = 5");
    assert!(
        program
            .text("o/sweep.csv")
            .starts_with("arm,env.cols,seed,")
    );
}

#[test]
fn what_is_finished_is_not_run_again() {
    let program = tiny();
    // Without --out the same command finds the same folder.
    let call = [&["sweep", "tiny.toml", "--seeds", "0..2"][..], &GRID].concat();
    let first = program.prints(&call);
    let folder = first
        .lines()
        .last()
        .unwrap()
        .strip_prefix("written to ")
        .unwrap();
    let shards = || {
        let points = fs::read_dir(program.path(folder).join("points")).unwrap();
        let files = points.flat_map(|point| fs::read_dir(point.unwrap().path()).unwrap());
        let files = files.map(|file| file.unwrap());
        let times = files.filter(|file| file.file_name().to_str().unwrap().starts_with("seed-"));
        let mut times: Vec<_> = times
            .map(|file| (file.path(), file.metadata().unwrap().modified().unwrap()))
            .collect();
        times.sort();
        times
    };
    let before = shards();
    assert_eq!(before.len(), 8);
    assert_eq!(program.prints(&call), first);
    assert_eq!(shards(), before);
    // A seed more is a seed more; --force begins anew.
    let more = [&["sweep", "tiny.toml", "--seeds", "0..3"][..], &GRID].concat();
    assert!(
        program
            .prints(&more)
            .ends_with(&format!("written to {folder}\n"))
    );
    assert_eq!(shards().len(), 12);
    assert!(before.iter().all(|shard| shards().contains(shard)));
    program.prints(&[&call[..], &["--force"]].concat());
    assert_eq!(shards().len(), 8);
    assert!(shards().iter().all(|shard| !before.contains(shard)));
}

/// What a world is read from has a part in what is run.
#[test]
fn an_edge_list_that_changed_is_run_anew() {
    let program = Program::new();
    let list = |reward: &str| format!("from,action,to,reward\na,go,b,{reward}\nb,go,end,-1\n");
    program.file("w.csv", &list("-1"));
    program.file(
        "w.toml",
        "[env]\nkind = \"edge-list\"\nfile = \"w.csv\"\ngoals = [{ at = \"end\" }]\n[run]\nepisodes = 5\n",
    );
    let call = ["sweep", "w.toml", "--seeds", "0", "--out", "o", "--json"];
    let before = program.prints_json(&call);
    assert_eq!(before["points"][0]["optimal_return"], json!(-2.0));
    program.file("w.csv", &list("-3"));
    let after = program.prints_json(&call);
    assert_eq!(after["points"][0]["optimal_return"], json!(-4.0));
    assert_ne!(before["points"][0]["hash"], after["points"][0]["hash"]);
}

#[test]
fn mistakes_are_told_before_anything_is_run() {
    let program = tiny();
    let refuses = |more: &[&str], code, words: &[&str]| {
        let call = ["sweep", "tiny.toml", "--seeds", "0..2", "--out", "o"];
        program.refuses(&[&call[..], more].concat(), code, words);
        assert!(!program.path("o").exists(), "{more:?}");
    };
    refuses(
        &["--grid", "agent.gama=0.9,1"],
        3,
        &["--grid agent.gama=0.9: unknown key `agent.gama`; did you mean `gamma`?"],
    );
    refuses(
        &["--grid", "agent.gamma=0.9,2"],
        3,
        &["--grid agent.gamma=2: agent.gamma = 2: must be"],
    );
    refuses(
        &["--grid", "shaping.potential=heat,gnc"],
        3,
        &["--grid shaping.potential=gnc: ", "did you mean `gcn`?"],
    );
    refuses(&["--arms", "plannner"], 3, &["did you mean `planner`?"]);
    refuses(
        &["--grid", "agent.gamma=1", "--grid", "agent.gamma=0.9"],
        3,
        &["`agent.gamma` is given twice"],
    );
    refuses(&["--grid", "env.room=[3,3"], 2, &["is not closed"]);
    refuses(&["--grid", "agent.gamma"], 2, &["section.key=value,value"]);
    program.file("o", "mine");
    let call = ["sweep", "tiny.toml", "--seeds", "0", "--out", "o"];
    program.refuses(&call, 3, &["o: "]);
    assert_eq!(program.text("o"), "mine");
}

/// A value may be an array or a table with commas of its own.
#[test]
fn values_may_be_arrays_and_tables() {
    let program = tiny();
    let document = program.prints_json(&[
        "sweep",
        "tiny.toml",
        "--seeds",
        "0",
        "--out",
        "o",
        "--json",
        "--grid",
        r#"env.goals=[{ at = "top-right" }],[{ at = [3, 3] }, { at = "bottom-left" }]"#,
    ]);
    let points = document["points"].as_array().unwrap();
    assert_eq!(points.len(), 2);
    assert_eq!(
        points[0]["settings"][0]["value"],
        json!([{ "at": "top-right" }])
    );
    let texts = program.text("o/sweep.csv");
    assert!(texts.contains(r#""[{""at"":""top-right""}]""#), "{texts}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_sweep_comes_to_the_same_bytes() {
    use std::process::{Command, Stdio};
    let program = tiny();
    program.prints(&sweep("whole", &[]));
    let spawn = || {
        Command::new(env!("CARGO_BIN_EXE_eigentrail"))
            .args(sweep("o", &["--threads", "2"]))
            .current_dir(program.folder())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let finished = || {
        let points = fs::read_dir(program.path("o/points")).into_iter().flatten();
        let files = points.flat_map(|point| fs::read_dir(point.unwrap().path()).unwrap());
        let is_shard = |name: &str| name.starts_with("seed-");
        files
            .filter(|file| is_shard(file.as_ref().unwrap().file_name().to_str().unwrap()))
            .count()
    };
    let mut stopped = 0;
    for signal in ["INT", "KILL", "TERM"] {
        for at_least in [1, 4, 8] {
            let child = spawn();
            until("shards", || finished() >= at_least);
            let pid = child.id().to_string();
            let _ = Command::new("kill").args(["-s", signal, &pid]).status();
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            match output.status.code() {
                // Nothing is said by a program that had not begun.
                Some(130 | 143) => assert!(
                    said.is_empty() || said.contains("the same command goes on"),
                    "{said}"
                ),
                code => assert!(matches!(code, None | Some(0)), "{said}"),
            }
            if output.status.code() != Some(0) {
                stopped += 1;
                assert!(finished() >= at_least);
                assert!(!program.path("o/summary.json").exists());
            }
        }
        program.prints(&sweep("o", &[]));
        assert_eq!(results(&program, "o"), results(&program, "whole"));
        assert!(!program.path("o/.eigentrail.lock").exists());
        fs::remove_dir_all(program.path("o")).unwrap();
    }
    assert!(stopped > 0, "no signal came in time");
}
