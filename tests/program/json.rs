//! docs/json.md against what is printed: each field is there, and nothing else is.

use crate::program::{Program, path_graph};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

const PAGE: &str = include_str!("../../docs/json.md");
const STILL: &str =
    "[env]\nrows = 4\ncols = 4\n[spectral]\nnum_eigenpairs = 4\n[run]\nepisodes = 25\n";
const MOVING: &str = "[env]\nrows = 4\ncols = 4\nmoved_goals = [{ at = \"top-right\" }]\n\
     [spectral]\nnum_eigenpairs = 4\n[run]\nepisodes = 50\n";
const QUIET: [&str; 2] = ["--no-report", "--json"];

/// The rows of a command's table, by field.
fn documented(command: &str) -> BTreeMap<&'static str, &'static str> {
    let heading = format!("## `{command} --json`\n");
    let (_, after) = PAGE
        .split_once(&heading)
        .unwrap_or_else(|| panic!("no {heading}"));
    let section = after.split("\n## ").next().unwrap();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `"));
    rows.map(|row| row.split_once('`').unwrap()).collect()
}

/// Every field of a document that is a number, a text or nothing, and which of them are nothing.
fn printed(value: &Value, path: String, fields: &mut BTreeMap<String, bool>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let dot = if path.is_empty() { "" } else { "." };
                printed(value, format!("{path}{dot}{key}"), fields);
            }
        }
        Value::Array(list) => {
            for value in list {
                printed(value, format!("{path}[]"), fields);
            }
        }
        value => *fields.entry(path).or_default() |= value.is_null(),
    }
}

#[track_caller]
fn holds(command: &str, documents: &[Value]) {
    let documented = documented(command);
    let mut fields = BTreeMap::new();
    for document in documents {
        printed(document, String::new(), &mut fields);
    }
    for (field, is_null) in &fields {
        let row = documented.get(field.as_str());
        let row = row.unwrap_or_else(|| panic!("{command}: {field} is not on the page"));
        assert!(
            !is_null || row.contains("null"),
            "{command}: {field} was null"
        );
    }
    // These take a signal, or a pair that a solve has missed.
    let seldom = ["interrupted", "updates[].repaired"];
    for field in documented.keys().filter(|field| !seldom.contains(field)) {
        assert!(
            fields.contains_key(*field),
            "{command}: {field} is on the page and was never printed"
        );
    }
}

/// stdout as one document on one line, whatever the exit code.
fn document(program: &Program, arguments: &[&str]) -> Value {
    let output = program.call(arguments).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.matches('\n').count(), 1, "{arguments:?}: {text}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn run() {
    let program = Program::new();
    let documents = [("s", STILL), ("m", MOVING)].map(|(name, text)| {
        program.file("x.toml", text);
        let out = ["run", "x.toml", "--no-tensorboard", "--out", name];
        document(&program, &[&out[..], &QUIET].concat())
    });
    holds("run", &documents);
    let several = [
        "run",
        "x.toml",
        "--no-tensorboard",
        "--out",
        "several",
        "--seeds",
        "0..2",
    ];
    let several = document(&program, &[&several[..], &QUIET].concat());
    let keys: Vec<&String> = several.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["scenario", "seeds"]);
    let seeds = several["seeds"].as_array().unwrap();
    assert_eq!([&seeds[0]["seed"], &seeds[1]["seed"]], [0, 1]);
    holds("run", &[&documents[..1], seeds].concat());
}

#[test]
fn compare() {
    let program = Program::new();
    program.file("s.toml", STILL);
    program.file("m.toml", MOVING);
    let with = |more: &[&str]| {
        let few = ["--seeds", "0..2", "--arms", "gcn,sparse,planner"];
        document(&program, &[&["compare"], more, &few, &QUIET].concat())
    };
    let one = with(&["m.toml", "--tuned", "--out", "one"]);
    holds("compare", &[one]);
    let several = with(&["s.toml", "m.toml", "--out", "both"]);
    let keys: Vec<&String> = several.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["scenarios"]);
    let each = several["scenarios"].as_array().unwrap();
    assert_eq!([&each[0]["scenario"], &each[1]["scenario"]], ["s", "m"]);
    for comparison in each {
        let mut fields = BTreeMap::new();
        printed(comparison, String::new(), &mut fields);
        let documented = documented("compare");
        assert!(
            fields
                .keys()
                .all(|field| documented.contains_key(field.as_str()))
        );
    }
}

#[test]
fn sweep() {
    let program = Program::new();
    program.file("m.toml", MOVING);
    let grid = |more: &[&str]| {
        let few = [
            "sweep",
            "m.toml",
            "--seeds",
            "0..2",
            "--grid",
            "run.episodes=40,50",
            "--json",
        ];
        document(&program, &[&few[..], more].concat())
    };
    let plain = grid(&["--out", "plain"]);
    assert!(plain["points"][0].get("arm").is_none());
    holds(
        "sweep",
        &[plain, grid(&["--arms", "gcn,sparse", "--out", "arms"])],
    );
}

#[test]
fn check() {
    let program = Program::new();
    program.file("s.toml", STILL);
    program.file("m.toml", MOVING);
    program.file(
        "wrong.toml",
        "name = \"mine\"\n[agent]\ngama = 1\n[run]\nepisodes = 0\n",
    );
    let wrong = [
        "check",
        "wrong.toml",
        "--set",
        "agent.kind=sarssa",
        "--json",
    ];
    let refused = document(&program, &wrong);
    program
        .call(&wrong)
        .assert()
        .code(3)
        .stderr("error: 3 mistakes in wrong.toml\n");
    assert_eq!(
        refused,
        json!({ "scenario": "mine", "mistakes": [
            { "file": "wrong.toml", "line": 3, "column": 1, "set": null, "key": "agent.gama",
              "message": "unknown key `agent.gama`; did you mean `gamma`?" },
            { "file": "wrong.toml", "line": 5, "column": 12, "set": null, "key": "run.episodes",
              "message": "run.episodes = 0: must be 1 to 1000000000" },
            { "file": "wrong.toml", "line": null, "column": null, "set": "agent.kind=sarssa", "key": "agent.kind",
              "message": "`agent.kind` cannot be \"sarssa\"; did you mean `sarsa`?" },
        ]})
    );
    let missing = document(&program, &["check", "none.toml", "--json"]);
    assert_eq!(missing["scenario"], json!(null));
    assert_eq!(missing["mistakes"].as_array().unwrap().len(), 1);
    holds(
        "check",
        &[
            document(
                &program,
                &[
                    "check",
                    "s.toml",
                    "--json",
                    "--set",
                    "env.hazards=[{ at = [2, 2], reward = -5 }]",
                ],
            ),
            document(&program, &["check", "m.toml", "--json"]),
            document(
                &program,
                &[
                    "check",
                    "river_swim_6_continuing",
                    "--json",
                    "--set",
                    "agent.gamma=1",
                ],
            ),
            refused,
            missing,
        ],
    );
}

#[test]
fn show() {
    let program = Program::new();
    program.file("m.toml", MOVING);
    program.prints(&[
        "run",
        "m.toml",
        "--no-report",
        "--no-tensorboard",
        "--out",
        "o",
    ]);
    let learnt = document(
        &program,
        &[
            "show",
            "m.toml",
            "--potential",
            "o",
            "--policy",
            "o",
            "--json",
        ],
    );
    assert_eq!(learnt["map"], json!(["S...", "....", "....", "...G"]));
    assert_eq!(learnt["moved"], json!({ "after": 25, "goals": [3] }));
    let states = learnt["states"].as_array().unwrap();
    let goal = json!({ "state": 15, "place": "3,3", "row": 3, "col": 3, "start": 0.0, "end": true, "goal": true, "reward": -1.0 });
    assert_eq!((states.len(), &states[15]), (16, &goal));
    assert_eq!(states[0]["start"], json!(1.0));
    for row in learnt["potential"].as_array().unwrap() {
        let state = row["state"].as_u64().unwrap() as usize;
        assert_eq!(states[state]["place"], row["place"]);
    }
    // A learnt action leads to the goal: from beside it, into it.
    let names = ["up", "right", "down", "left"];
    for row in learnt["policy"].as_array().unwrap() {
        let name = row["action"].as_u64().map(|action| names[action as usize]);
        assert_eq!(row["action_name"].as_str(), name, "{row}");
    }

    let turns = document(
        &program,
        &["show", "open_5x5", "--set", "env.actions=turns", "--json"],
    );
    assert_eq!(
        turns["states"][3],
        json!({ "state": 3, "place": "0,0,north", "row": 0, "col": 0, "start": 0.0, "end": false, "goal": false, "reward": null })
    );
    program.file(
        "w.csv",
        "from,action,to,reward\na,go,b,-1\na,stay,a,-2\nb,go,end,-3\nb,stay,trap,-9\n",
    );
    program.file(
        "e.toml",
        "[env]\nkind = \"edge-list\"\nfile = \"w.csv\"\ngoals = [{ at = \"end\" }]\n",
    );
    let listed = document(&program, &["show", "e.toml", "--json"]);
    assert_eq!(
        (&listed["map"], &listed["actions"]),
        (&json!(null), &json!(["go", "stay"]))
    );
    let ends: BTreeSet<(&str, bool, bool, String)> = listed["states"]
        .as_array()
        .unwrap()
        .iter()
        .map(|state| {
            let is = |key: &str| state[key].as_bool().unwrap();
            let place = state["place"].as_str().unwrap();
            (place, is("end"), is("goal"), state["reward"].to_string())
        })
        .collect();
    let told = |place, end, goal, reward: &str| (place, end, goal, reward.to_owned());
    assert_eq!(
        ends,
        BTreeSet::from([
            told("a", false, false, "null"),
            told("b", false, false, "null"),
            told("end", true, true, "-3.0"),
            told("trap", false, false, "null"),
        ])
    );
    let deep_sea = document(&program, &["show", "deep_sea_10", "--json"]);
    holds("show", &[learnt, turns, listed, deep_sea]);
}

#[test]
fn list() {
    holds("list", &[document(&Program::new(), &["list", "--json"])]);
}

#[test]
fn track_and_potential() {
    let program = Program::new();
    let graph = program.file("g.mtx", &path_graph(100));
    let track = ["track", graph, "--k", "3", "--json"];
    let beyond = [&track[..], &["--tol", "1e-17"]].concat();
    holds(
        "track",
        &[document(&program, &track), document(&program, &beyond)],
    );
    let potential = ["potential", graph, "--goal", "3", "--json"];
    holds("potential", &[document(&program, &potential)]);
}

#[test]
fn every_command_with_json_is_on_the_page() {
    let program = Program::new();
    let help = program.prints(&["--help"]);
    let (_, commands) = help.split_once("Commands:\n").unwrap();
    let names = commands.lines().map_while(|line| line.strip_prefix("  "));
    let names = names.filter_map(|line| line.split(' ').next());
    let mut found = BTreeSet::new();
    for name in names.filter(|name| !name.is_empty() && *name != "help") {
        if program.prints(&[name, "--help"]).contains("--json") {
            documented(name);
            found.insert(name.to_owned());
        }
    }
    assert_eq!(found.len(), PAGE.matches(" --json`\n").count(), "{found:?}");
}

#[test]
fn inspect() {
    let program = Program::new();
    let checkpoint = eigentrail::archive::Checkpoint {
        program: "eigentrail 0.1.0".to_owned(),
        scenario: "name = \"x\"\n".to_owned(),
        seed: 7,
        steps: 1000,
        episodes: 3,
        states: 12,
        run: vec![1; 100].into(),
        observers: BTreeMap::new(),
    };
    checkpoint.write(program.folder()).unwrap();
    let printed = document(&program, &["inspect", "checkpoint", "--json"]);
    assert_eq!(
        (&printed["seed"], &printed["scenario"]),
        (&json!(7), &json!("x"))
    );
    holds("inspect", &[printed]);
    let text = program.prints(&["inspect", "checkpoint"]);
    assert!(text.contains("whole") && text.contains("1 000"), "{text}");
    let bytes = std::fs::read(program.path("checkpoint")).unwrap();
    std::fs::write(program.path("torn"), &bytes[..60]).unwrap();
    program.refuses(&["inspect", "torn"], 3, &["torn: cut off or added to"]);
    program.refuses(&["inspect", "none"], 3, &["none: "]);
}
