//! Kinds of potentials from outside: each of them runs, and a φ that one run exports is what another one is given.

use crate::program::Program;
use std::collections::HashMap;
use std::fs;

const QUICK: &str =
    "[env]\nrows = 4\ncols = 4\n[spectral]\nnum_eigenpairs = 4\n[run]\nepisodes = 25\n";

const EDGES: &str = "from,action,to\nhome,go,mill\nmill,go,pond\npond,go,far\nmill,back,home\npond,back,mill\nhome,back,home\n";
const LISTED: &str = "[env]\nkind = \"edge-list\"\nfile = \"edges.csv\"\ngoals = [{ at = \"far\" }]\n[run]\nepisodes = 9\n";

/// φ by what a run calls its states.
fn exported(program: &Program, run: &str) -> HashMap<String, f64> {
    let out = format!("{run}-tables");
    program.prints(&["export", run, "--to", "csv", "-o", &out]);
    let mut reader = csv::Reader::from_path(program.path(&out).join("states.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|h| h == name);
    let place = column("name").map_or(["row", "col"].map(column).to_vec(), |name| vec![Some(name)]);
    let phi = column("potential").unwrap();
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| {
        let place: Vec<&str> = place.iter().map(|&at| &row[at.unwrap()]).collect();
        (place.join(","), row[phi].parse().unwrap())
    })
    .collect()
}

#[test]
fn every_kind_runs_and_is_on_the_scale_of_the_return() {
    let program = Program::new();
    program.file("x.toml", QUICK);
    let mut by_kind = HashMap::new();
    for (kind, sign) in [
        ("dr", -1.0),
        ("sr", -1.0),
        ("random", -1.0),
        ("oracle", -1.0),
        ("negated-oracle", 1.0),
    ] {
        let set = format!("shaping.potential={kind}");
        program.prints(&["run", "x.toml", "-q", "--out", kind, "--set", &set]);
        let phi = exported(&program, kind);
        assert_eq!(phi["3,3"], 0.0, "{kind}");
        // The scale of the return: six steps at least, and at most one to each other state.
        let range = phi
            .values()
            .fold(0.0, |most: f64, phi| most.max(sign * phi));
        assert!(phi.values().all(|phi| phi * sign >= 0.0), "{kind}: {phi:?}");
        match kind {
            "random" => assert!((1.0..=15.0).contains(&range), "{range}"),
            "dr" | "sr" => assert!(
                (5.9..=15.0).contains(&range) && (range - range.round()).abs() < 1e-9,
                "{kind}: {range}"
            ),
            _ => assert_eq!((range, phi["0,0"]), (6.0, 6.0 * sign), "{kind}"),
        }
        by_kind.insert(kind, phi);
    }
    let (oracle, negated) = (&by_kind["oracle"], &by_kind["negated-oracle"]);
    let known_to_both = oracle
        .iter()
        .filter(|(state, _)| negated.contains_key(*state));
    let mut compared = 0;
    for (state, phi) in known_to_both {
        assert_eq!(negated[state], 0.0 - phi, "{state}");
        compared += 1;
    }
    assert!(compared >= 10, "{compared}");
}

#[test]
fn arms_of_potentials_are_compared() {
    let program = Program::new();
    let compared = program.prints_json(&[
        "compare",
        "four_rooms",
        "--seeds",
        "0..2",
        "--arms",
        "dr,sr,random-potential,negated-oracle",
        "--set",
        "run.episodes=4",
        "--json",
        "-q",
    ]);
    let arms = compared["arms"].as_array().unwrap();
    let names: Vec<&str> = arms
        .iter()
        .map(|arm| arm["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["dr", "sr", "random-potential", "negated-oracle"]);
    assert_eq!(arms[0]["spurious_maxima"], 0);
    for hostile in &arms[2..] {
        assert!(
            hostile["spurious_maxima"].as_f64().unwrap() > 0.0,
            "{hostile}"
        );
    }
}

#[test]
fn an_exported_potential_is_read_back() {
    let program = Program::new();
    fs::create_dir(program.path("scenarios")).unwrap();
    program.file("scenarios/edges.csv", EDGES);
    for (world, scenario) in [("map", QUICK), ("list", LISTED)] {
        let file = format!("scenarios/{world}.toml");
        fs::write(program.path(&file), scenario).unwrap();
        let heat = "shaping.potential=heat";
        program.prints(&["run", &file, "-q", "--out", world, "--set", heat]);
        let given = exported(&program, world);
        assert!(given.values().any(|&phi| phi < -1.0));
        // A relative path begins at the folder of the scenario.
        let text = format!(
            "{scenario}[shaping]\npotential = \"file\"\nfile = \"../{world}-tables/states.csv\"\n"
        );
        fs::write(program.path(&file), text).unwrap();
        let back = format!("{world}-back");
        let run = program
            .call(&["run", &file, "--out", &back])
            .assert()
            .success();
        assert!(!String::from_utf8_lossy(&run.get_output().stderr).contains("names"));
        assert_eq!(exported(&program, &back), given, "{world}");
    }
}

#[test]
fn states_that_the_file_leaves_out_are_counted_once() {
    let program = Program::new();
    program.file("phi.csv", "row,col,potential\n0,1,-3\n2,2,-1.5\n");
    let text = format!(
        "{QUICK}[shaping]\npotential = \"file\"\nfile = \"phi.csv\"\n[arms.mine]\nagent.gamma = 1\n"
    );
    program.file("x.toml", &text);
    let caution = "phi.csv: names 2 of the 16 states of the world; φ is 0 in the other 14";
    for arguments in [
        &["check", "x.toml"][..],
        &["run", "x.toml", "--out", "o"],
        // Arms with another potential have no use for the file; the scenario's own has.
        &[
            "compare",
            "x.toml",
            "--seeds",
            "0..2",
            "--arms",
            "heat,mine",
            "--out",
            "c",
        ],
    ] {
        let done = program.call(arguments).assert().success();
        let said = String::from_utf8(done.get_output().stderr.clone()).unwrap();
        assert_eq!(said.matches(caution).count(), 1, "{arguments:?}: {said}");
    }
    let phi = exported(&program, "o");
    assert_eq!((phi["0,1"], phi["2,2"], phi["1,1"]), (-3.0, -1.5, 0.0));
}

#[test]
fn a_file_and_its_kind_need_each_other() {
    let program = Program::new();
    program.file("phi.csv", "row,col,potential\n0,1,-3\n");
    let refused = |shaping: &str, words: &[&str]| {
        program.file("x.toml", &format!("{QUICK}[shaping]\n{shaping}"));
        program.refuses(&["run", "x.toml"], 3, words);
    };
    refused(
        "potential = \"file\"\n",
        &["x.toml:9:13", "shaping.potential", "shaping.file"],
    );
    refused(
        "potential = \"dr\"\nfile = \"phi.csv\"\n",
        &[
            "x.toml:10:8",
            "shaping.file",
            "shaping.potential be \"file\"",
        ],
    );
    refused(
        "potential = \"file\"\nfile = \"nowhere.csv\"\n",
        &["x.toml:10:8", "shaping.file", "nowhere.csv: cannot read"],
    );
    program.file(
        "x.toml",
        &format!("{QUICK}[arms.given]\nshaping.potential = \"file\"\nshaping.file = \"no.csv\"\n"),
    );
    program.refuses(
        &["run", "x.toml"],
        3,
        &["x.toml:10:16", "no.csv: cannot read"],
    );
}
