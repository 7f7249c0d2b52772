//! The program from outside: what it accepts, what it refuses and how it says so, what it writes.

use crate::program::{Program, path_graph, until};
use assert_cmd::Command;
use predicates::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// A run of a fraction of a second.
const QUICK: &str =
    "[env]\nrows = 4\ncols = 4\n[spectral]\nnum_eigenpairs = 4\n[run]\nepisodes = 25\n";

mod scenarios_refused {
    use super::*;

    #[track_caller]
    fn refused(text: &str, words: &[&str]) {
        let program = Program::new();
        let file = program.file("x.toml", text);
        program.refuses(&["check", file], 3, words);
        program.refuses(&["run", file], 3, words);
        assert!(
            !program.path("runs").exists(),
            "a refused scenario leaves no folder"
        );
    }

    #[test]
    fn misspelt_key() {
        refused(
            "[agent]\ngama = 0.9\n",
            &[
                "x.toml:2:1",
                "unknown key `agent.gama`",
                "did you mean `gamma`?",
            ],
        );
    }

    #[test]
    fn misspelt_section() {
        refused(
            "[agnet]\n",
            &["x.toml:1:2", "unknown key `agnet`", "did you mean `agent`?"],
        );
    }

    #[test]
    fn misspelt_choice() {
        refused(
            "[shaping]\npotential = \"het\"\n",
            &[
                "x.toml:2:13",
                "`shaping.potential` cannot be \"het\"",
                "did you mean `heat`?",
            ],
        );
    }

    #[test]
    fn wrong_type() {
        refused(
            "[run]\nepisodes = \"many\"\n",
            &[
                "x.toml:2:12",
                "`run.episodes`",
                "\"many\"",
                "expected a whole number",
            ],
        );
    }

    #[test]
    fn value_out_of_range() {
        refused(
            "[agent]\ngamma = 1.5\n",
            &["x.toml:2:9", "agent.gamma", "1.5"],
        );
        refused("[env]\nslip = nan\n", &["x.toml:2:8", "env.slip", "NaN"]);
        refused(
            "[spectral]\nnum_eigenpairs = 0\n",
            &["x.toml:2:18", "spectral.num_eigenpairs"],
        );
        refused(
            "[schedule]\ngrowth = 0.0\n",
            &["x.toml:2:10", "schedule.growth"],
        );
        refused(
            "[exploration]\nbonus = -1.0\n",
            &["x.toml:2:9", "exploration.bonus"],
        );
        refused(
            "[gcn]\nhidden_dim = 0\n",
            &["x.toml:2:14", "gcn.hidden_dim"],
        );
        refused("[run]\nepisodes = 0\n", &["x.toml:2:12", "run.episodes"]);
        refused(
            "[env]\nmax_steps = 0\n",
            &["x.toml:2:13", "\"auto\" or a whole number from 1"],
        );
    }

    #[test]
    fn not_toml() {
        refused("[env\n", &["x.toml:1:5", "not valid TOML"]);
    }

    #[test]
    fn key_of_another_kind() {
        refused(
            "[env]\nkind = \"open\"\nloops = 0.1\n",
            &[
                "x.toml:3:9",
                "env.loops means nothing for kind = \"open\"",
                "\"maze\"",
            ],
        );
        refused(
            "[env]\nkind = \"ascii\"\n",
            &["x.toml:1:1", "env.map is missing"],
        );
    }

    #[test]
    fn empty_map() {
        refused(
            "[env]\nkind = \"ascii\"\nmap = \"\"\n",
            &["x.toml:3:7", "the map is empty"],
        );
        refused("[env]\nrows = 0\n", &["x.toml:2:8", "the map is empty"]);
        refused(
            "[env]\nkind = \"ascii\"\nmap = \"###\"\n",
            &["x.toml:3:7", "no free cell"],
        );
    }

    #[test]
    fn goal_in_a_wall() {
        refused(
            "[env]\nkind = \"ascii\"\nmap = \"S.#\"\ngoals = [{ at = [0, 2] }]\n",
            &["x.toml:4:9", "the goal [0, 2] is in a wall"],
        );
    }

    #[test]
    fn goal_outside_the_map() {
        refused(
            "[env]\ngoals = [{ at = [0, 99] }]\n",
            &["x.toml:2:17", "[0, 99] is outside the map"],
        );
    }

    #[test]
    fn unknown_place() {
        refused(
            "[env]\nstart = \"top-lift\"\n",
            &[
                "x.toml:2:9",
                "\"top-lift\" is no place",
                "did you mean \"top-left\"?",
            ],
        );
    }

    #[test]
    fn unreachable_goal() {
        refused(
            "[env]\nkind = \"ascii\"\nmap = \"\"\"\nS#.\n.#G\n\"\"\"\n",
            &[
                "x.toml:3:7",
                "the goal [1, 2] cannot be reached from the start [0, 0]",
            ],
        );
    }

    #[test]
    fn strange_character_in_a_map() {
        refused(
            "[env]\nkind = \"ascii\"\nmap = \"S?G\"\n",
            &["x.toml:3:7", "line 1, column 2", "'?'"],
        );
    }

    #[test]
    fn edge_list_with_a_mistake() {
        let program = Program::new();
        program.file("world.csv", "from,action,to\na,go,b\nb,go\n");
        let scenario =
            "[env]\nkind = \"edge-list\"\nfile = \"world.csv\"\ngoals = [{ at = \"b\" }]\n";
        let file = program.file("x.toml", scenario);
        program.refuses(&["run", file], 3, &["x.toml:3:8", "world.csv", "line 3"]);
        program.file("world.csv", "from,action,to\na,go,b\n");
        let file = program.file("x.toml", &scenario.replace("\"b\"", "\"c\""));
        program.refuses(&["run", file], 3, &["x.toml", "no state is named \"c\""]);
        let file = program.file("x.toml", &scenario.replace("world", "word"));
        program.refuses(&["run", file], 3, &["x.toml:3:8", "word.csv"]);
    }

    #[test]
    fn missing_file() {
        let program = Program::new();
        program.refuses(
            &["run", "nowhere.toml"],
            3,
            &["nowhere.toml: there is no such file"],
        );
        program.refuses(&["run", "four_room.toml"], 3, &["`four_rooms` alone names"]);
        program.refuses(
            &["run", "four_room"],
            3,
            &["no such file, nor", "did you mean `four_rooms`?"],
        );
        program.refuses(
            &["compare", "four_rooms", "--arms", "gcn", "heat"],
            3,
            &["gcn,heat"],
        );
    }

    #[test]
    fn flags_are_blamed_for_their_own_slips() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        program.refuses(
            &["run", file, "--set", "agent.gama=0.9"],
            3,
            &["--set agent.gama=0.9", "did you mean `gamma`?"],
        );
        program.refuses(
            &["run", file, "--set", "run.episodes=few"],
            3,
            &["--set run.episodes=few", "expected a whole number"],
        );
        program.refuses(
            &["run", file, "--set", "episodes"],
            2,
            &["section.key=value"],
        );
    }
}

mod folders_refused {
    use super::*;

    #[test]
    fn existing_output_folder() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        program.prints(&["run", file, "--out", "o"]);
        let before = fs::read(program.path("o/seed-0000/episodes.csv")).unwrap();
        let words = ["o: the output folder exists", "--resume", "--force"];
        program.refuses(&["run", file, "--out", "o"], 3, &words);
        assert_eq!(
            fs::read(program.path("o/seed-0000/episodes.csv")).unwrap(),
            before
        );
        program.prints(&["run", file, "--out", "o", "--force", "--seed", "1"]);
        assert!(!program.path("o/seed-0000").exists());
        program.refuses(
            &["run", file, "--out", "o", "--force", "--resume"],
            2,
            &["--resume"],
        );
    }

    #[test]
    fn folder_that_is_no_run() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        fs::create_dir(program.path("o")).unwrap();
        program.file("o/thesis.tex", "years of work");
        program.refuses(
            &["run", file, "--out", "o"],
            3,
            &["the output folder exists"],
        );
        for flag in ["--force", "--resume"] {
            program.refuses(&["run", file, "--out", "o", flag], 3, &["not a run folder"]);
        }
        assert!(program.path("o/thesis.tex").exists());
    }

    #[test]
    fn unwritable_output_folder() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        // Below a file nothing can be created, whoever asks; permissions do not stop a superuser.
        program.refuses(
            &["run", file, "--out", "x.toml/o"],
            3,
            &["x.toml/o: cannot write"],
        );
    }

    #[cfg(unix)]
    #[test]
    fn read_only_output_folder() {
        use std::os::unix::fs::PermissionsExt;
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        let locked = program.path("locked");
        fs::create_dir(&locked).unwrap();
        fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
        if fs::write(locked.join("probe"), "").is_ok() {
            return; // a superuser writes anyway; `unwritable_output_folder` covers the message
        }
        program.refuses(
            &["run", file, "--out", "locked/o"],
            3,
            &["locked/o: cannot write"],
        );
    }

    #[test]
    fn resuming_another_scenario() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        program.prints(&["run", file, "--out", "o"]);
        program.refuses(
            &[
                "run",
                file,
                "--out",
                "o",
                "--resume",
                "--set",
                "agent.gamma=0.5",
            ],
            3,
            &["resolved.toml", "the scenario differs", "gamma = 0.5"],
        );
    }
}

mod graphs_refused {
    use super::*;

    const HEADER: &str = "%%MatrixMarket matrix coordinate";

    #[track_caller]
    fn refused(text: &str, words: &[&str]) {
        let program = Program::new();
        let file = program.file("g.mtx", text);
        program.refuses(&["track", file, "--k", "1"], 3, words);
        program.refuses(&["potential", file, "--goal", "0"], 3, words);
    }

    #[test]
    fn asymmetric() {
        refused(
            &format!("{HEADER} real general\n2 2 1\n1 2 1.0\n"),
            &["g.mtx:3"],
        );
    }

    #[test]
    fn malformed() {
        refused("hello\n", &["g.mtx:1"]);
        refused(
            &format!("{HEADER} real symmetric\n2 2 1\n2 one 1.0\n"),
            &["g.mtx:3"],
        );
        refused(
            &format!("{HEADER} real symmetric\n2 2 2\n2 1 1.0\n"),
            &["g.mtx"],
        );
        refused(
            &format!("{HEADER} real symmetric\n2 2 1\n3 1 1.0\n"),
            &["g.mtx:3"],
        );
    }

    #[test]
    fn weights_that_are_no_weights() {
        for weight in ["nan", "inf", "-1.0"] {
            let text = format!("{HEADER} real symmetric\n2 2 1\n2 1 {weight}\n");
            refused(&text, &["g.mtx:3"]);
        }
    }

    #[test]
    fn missing_file() {
        Program::new().refuses(&["track", "nowhere.mtx"], 3, &["nowhere.mtx"]);
    }

    #[test]
    fn more_pairs_than_nodes() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(10));
        let words = ["g.mtx: --k 11", "10 nodes", "--k 10 or less"];
        program.refuses(&["track", file, "--k", "11"], 3, &words);
        for k in ["0", "-3", "many"] {
            program.refuses(
                &["track", file, "--k", k],
                2,
                &["--k", "a whole number from 1"],
            );
        }
        program.refuses(&["track", file, "--growth", "-1"], 2, &["--growth"]);
    }

    #[test]
    fn unwritable_results() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(10));
        let words = ["g.mtx/v: cannot write"];
        program.refuses(
            &["track", file, "--k", "2", "--vectors", "g.mtx/v"],
            3,
            &words,
        );
        program.refuses(
            &["potential", file, "--goal", "1", "--out", "g.mtx/v"],
            3,
            &words,
        );
    }

    #[test]
    fn goal_that_is_no_node() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(10));
        program.refuses(
            &["potential", file, "--goal", "10"],
            3,
            &["--goal 10", "from 0 to 9"],
        );
        program.refuses(
            &["potential", file, "--goal", "-1"],
            2,
            &["--goal", "the number of a node, from 0"],
        );
        program.refuses(&["potential", file], 2, &["--goal"]);
        program.refuses(
            &["potential", file, "--goal", "0", "--out", "nowhere/phi.csv"],
            3,
            &["error: nowhere/phi.csv: cannot write: No such file or directory (os error 2)\n"],
        );
    }
}

mod runs {
    use super::*;

    const FIELDS: [&str; 14] = [
        "scenario",
        "seed",
        "episodes",
        "steps",
        "regret",
        "optimal_steps",
        "final_mean_steps",
        "first_goal_step",
        "nodes",
        "edges",
        "spectrum_refreshes",
        "gcn_fits",
        "wall_seconds",
        "steps_per_second",
    ];

    #[test]
    fn json_has_exactly_the_documented_fields() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        let line = program.prints_json(&["run", file, "--seed", "7", "--json"]);
        let fields: Vec<&str> = line
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        assert_eq!(fields, FIELDS);
        assert_eq!(line["scenario"], "quick");
        assert_eq!(line["seed"], 7);
        assert_eq!(line["episodes"], 25);
        assert_eq!(line["optimal_steps"], 6.0);
        assert!(line["regret"].as_f64().unwrap() >= 0.0);
        assert!(line["first_goal_step"].as_u64().unwrap() >= 6);
        assert!(line["nodes"].as_u64().unwrap() <= 16);
    }

    #[test]
    fn numbers_agree_with_the_rows() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        let line = program.prints_json(&["run", file, "--out", "o", "--json"]);
        let mut reader = csv::Reader::from_path(program.path("o/seed-0000/episodes.csv")).unwrap();
        let header = reader.headers().unwrap().clone();
        let column = |name: &str| header.iter().position(|h| h == name).unwrap();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let number =
            |row: &csv::StringRecord, name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!(rows.len(), 25);
        let steps: f64 = rows.iter().map(|row| number(row, "length")).sum();
        assert_eq!(line["steps"].as_f64().unwrap(), steps);
        // Reward −1 a step: the regret is the sum of steps beyond the six of the shortest path.
        assert_eq!(line["regret"].as_f64().unwrap(), steps - 6.0 * 25.0);
        let last = rows.last().unwrap();
        assert_eq!(line["regret"].as_f64().unwrap(), number(last, "regret"));
        assert_eq!(line["nodes"].as_f64().unwrap(), number(last, "nodes"));
        let tail: f64 = rows[5..].iter().map(|row| number(row, "length")).sum();
        assert_eq!(line["final_mean_steps"].as_f64().unwrap(), tail / 20.0);
    }

    #[test]
    fn a_run_folder_has_every_file() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        program.prints(&["run", file]);
        let runs: Vec<_> = fs::read_dir(program.path("runs/quick")).unwrap().collect();
        assert_eq!(runs.len(), 1);
        let run = runs[0].as_ref().unwrap().path();
        for name in ["run.json", "scenario.toml", "resolved.toml", "summary.json"] {
            assert!(run.join(name).is_file(), "{name}");
        }
        let seed = run.join("seed-0000");
        for name in [
            "episodes.csv",
            "refreshes.csv",
            "timings.csv",
            "events.jsonl",
            "events.out.tfevents.0.eigentrail",
            "states.csv",
            "potential.npy",
            "eigenvectors.npy",
        ] {
            assert!(seed.join(name).is_file(), "{name}");
        }
        assert_eq!(
            fs::read_to_string(run.join("scenario.toml")).unwrap(),
            QUICK
        );
        let info: Value = serde_json::from_slice(&fs::read(run.join("run.json")).unwrap()).unwrap();
        assert_eq!(info["status"], "finished");
    }

    #[test]
    fn resolved_scenarios_run_the_same() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        program.prints(&["run", file, "--out", "a", "--set", "env.slip=0.1"]);
        program.prints(&["run", "a/resolved.toml", "--out", "b"]);
        assert_same_results(&program.path("a"), &program.path("b"));
    }

    #[test]
    fn equal_seeds_write_equal_bytes_and_others_do_not() {
        let program = Program::new();
        let file = program.file(
            "quick.toml",
            &QUICK.replace("[spectral]", "slip = 0.2\n[spectral]"),
        );
        for (out, seed, threads) in [("a", "3", "1"), ("b", "3", "4"), ("c", "4", "1")] {
            program.prints(&[
                "run",
                file,
                "--seed",
                seed,
                "--threads",
                threads,
                "--out",
                out,
            ]);
        }
        assert_same_results(&program.path("a"), &program.path("b"));
        let episodes = |out: &str, seed: &str| {
            fs::read(program.path(out).join(seed).join("episodes.csv")).unwrap()
        };
        assert_ne!(episodes("a", "seed-0003"), episodes("c", "seed-0004"));
    }

    /// Byte for byte, but for what is documented to know a clock.
    #[track_caller]
    fn assert_same_results(a: &Path, b: &Path) {
        let mut compared = 0;
        for entry in fs::read_dir(a).unwrap() {
            let seed = entry.unwrap().path();
            if !seed.is_dir() {
                continue;
            }
            for entry in fs::read_dir(&seed).unwrap() {
                let file = entry.unwrap().path();
                let name = file.file_name().unwrap().to_str().unwrap();
                if name == "timings.csv" || name.starts_with("events.") {
                    continue;
                }
                let other = b.join(seed.file_name().unwrap()).join(name);
                assert_eq!(fs::read(&file).unwrap(), fs::read(other).unwrap(), "{name}");
                compared += 1;
            }
        }
        assert_eq!(
            compared, 9,
            "episodes, refreshes, states, potential, eigenvectors, graph, actions, policy, snapshots"
        );
        let results = |run: &Path| {
            let summary = fs::read(run.join("summary.json")).unwrap();
            let mut summary: Value = serde_json::from_slice(&summary).unwrap();
            summary
                .as_object_mut()
                .unwrap()
                .shift_remove("timing")
                .unwrap();
            summary
        };
        assert_eq!(results(a), results(b));
    }

    #[test]
    fn events_are_json_lines_with_the_documented_names() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        program.prints(&["run", file, "--out", "o"]);
        let text = fs::read_to_string(program.path("o/seed-0000/events.jsonl")).unwrap();
        let lines: Vec<Value> = text
            .lines()
            .map(|l| serde_json::from_str(l).unwrap())
            .collect();
        let with_fields = |name: &str, fields: &[&str]| {
            let found: Vec<&Value> = lines.iter().filter(|l| l["name"] == name).collect();
            assert!(!found.is_empty(), "no event {name}");
            for field in fields {
                assert!(
                    !found[0][field].is_null(),
                    "{name} without {field}: {}",
                    found[0]
                );
            }
            found.len()
        };
        with_fields("graph_growth", &["step", "nodes", "edges"]);
        with_fields(
            "spectrum_refresh",
            &[
                "step",
                "nodes",
                "edges",
                "converged",
                "applications",
                "max_relative_residual",
                "elapsed_ms",
            ],
        );
        with_fields("gcn_fit", &["step", "nodes", "loss", "elapsed_ms"]);
        assert_eq!(
            with_fields("first_goal", &["step", "nodes", "time", "level"]),
            1
        );
        assert_eq!(with_fields("run", &["scenario", "seed", "elapsed_ms"]), 1);
    }

    #[test]
    fn a_finished_seed_is_not_run_again_and_another_is_added() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        let first = program.prints_json(&["run", file, "--out", "o", "--json"]);
        let again = program.prints_json(&["run", file, "--out", "o", "--resume", "--json"]);
        assert_eq!(first, again, "wall_seconds included: nothing was run");
        program.prints(&["run", file, "--out", "o", "--resume", "--seed", "5"]);
        let summary = fs::read(program.path("o/summary.json")).unwrap();
        let summary: Value = serde_json::from_slice(&summary).unwrap();
        let seeds: Vec<u64> = summary["seeds"]
            .as_array()
            .unwrap()
            .iter()
            .map(|seed| seed["seed"].as_u64().unwrap())
            .collect();
        assert_eq!(seeds, [0, 5]);
    }

    #[test]
    fn an_edge_list_is_a_world() {
        let program = Program::new();
        program.file(
            "world.csv",
            "from,action,to\nhome,east,shop\nshop,west,home\nshop,east,\"sea, the\"\nhome,west,home\n",
        );
        let file = program.file(
            "x.toml",
            "[env]\nkind = \"edge-list\"\nfile = \"world.csv\"\ngoals = [{ at = \"sea, the\" }]\n[run]\nepisodes = 30\n",
        );
        let line = program.prints_json(&["run", file, "--out", "o", "--json"]);
        assert_eq!(line["optimal_steps"], 2.0);
        assert_eq!(line["nodes"], 3);
        let shown = program.prints(&["show", file, "--potential", "o"]);
        assert!(
            shown.contains("sea, the") && shown.contains("home"),
            "{shown}"
        );
        let shown = program.prints(&["show", file, "--policy", "o"]);
        assert!(shown.contains("shop: east → sea, the\n"), "{shown}");
    }

    #[test]
    fn verbose_talks_on_stderr_only() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        let output = program
            .call(&["run", file, "--json", "-vv"])
            .assert()
            .success()
            .stderr(
                predicate::str::contains("first_goal")
                    .and(predicate::str::contains("\u{1b}").not()),
            )
            .get_output()
            .clone();
        assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
        let quiet = program
            .call(&["run", file, "--out", "q"])
            .assert()
            .success();
        quiet.stderr("");
    }

    #[test]
    fn a_trace_opens_in_a_profiler() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        program.prints(&["run", file, "--trace", "trace.json"]);
        let text = fs::read(program.path("trace.json")).unwrap();
        let trace: Value = serde_json::from_slice(&text).unwrap();
        let names: Vec<&Value> = trace
            .as_array()
            .unwrap()
            .iter()
            .map(|e| &e["name"])
            .collect();
        for name in ["run", "episode", "spectrum_refresh"] {
            assert!(names.iter().any(|n| *n == name), "no {name}");
        }
        program.refuses(
            &["run", file, "--trace", "quick.toml/x"],
            3,
            &["quick.toml/x"],
        );
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_cannot_grow_is_named_and_stays_whole() {
        let program = Program::new();
        let text = QUICK.replace("episodes = 25", "episodes = 2000");
        let file = program.file("x.toml", &text);
        // Files may have 16 KiB; without the trap the signal would end the program before it can say why.
        let script = format!(
            "trap '' XFSZ; ulimit -f 16; exec '{}' run {file} --out o",
            env!("CARGO_BIN_EXE_eigentrail")
        );
        Command::new("bash")
            .current_dir(program.folder())
            .args(["-c", &script])
            .assert()
            .code(1)
            .stdout("")
            .stderr(predicate::str::contains(
                "o/seed-0000/episodes.csv: cannot write: ",
            ));
        let rows = fs::read_to_string(program.path("o/seed-0000/episodes.csv")).unwrap();
        assert!(rows.is_empty() || rows.ends_with('\n'));
        let info: Value =
            serde_json::from_slice(&fs::read(program.path("o/run.json")).unwrap()).unwrap();
        assert_eq!(info["status"], "failed");
    }

    #[cfg(unix)]
    #[test]
    fn ctrl_c_ends_a_run_with_its_files() {
        use std::process::{Command, Stdio};
        let program = Program::new();
        let file = program.file(
            "long.toml",
            &QUICK.replace("episodes = 25", "episodes = 10000000"),
        );
        let mut child = Command::new(env!("CARGO_BIN_EXE_eigentrail"))
            .current_dir(program.folder())
            .args(["run", file, "--out", "o", "--json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let episodes = program.path("o/seed-0000/episodes.csv");
        until("rows come", || {
            fs::metadata(&episodes).is_ok_and(|file| file.len() > 0)
        });
        let interrupted = Command::new("kill")
            .args(["-INT", &child.id().to_string()])
            .status();
        assert!(interrupted.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        let summary: Value =
            serde_json::from_slice(&fs::read(program.path("o/summary.json")).unwrap()).unwrap();
        assert_eq!(summary["seeds"][0]["finished"], false);
        let rows = fs::read_to_string(episodes).unwrap();
        assert!(rows.ends_with('\n'));
        assert_eq!(
            rows.lines().count() as u64,
            1 + summary["seeds"][0]["episodes"].as_u64().unwrap()
        );
        let info: Value =
            serde_json::from_slice(&fs::read(program.path("o/run.json")).unwrap()).unwrap();
        assert_eq!(info["status"], "interrupted");
    }
}

mod tracks {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn json_has_exactly_the_documented_fields() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(100));
        let line = program.prints_json(&[
            "track",
            file,
            "--k",
            "5",
            "--tol",
            "1e-4",
            "--threads",
            "2",
            "--vectors",
            "v.npy",
            "--json",
        ]);
        let fields: Vec<&str> = line
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let expected = [
            "n",
            "nnz",
            "k",
            "method",
            "threads",
            "updates",
            "total_seconds",
            "eigenvalues",
            "laplacian",
        ];
        assert_eq!(fields, expected);
        assert_eq!(
            (&line["n"], &line["nnz"], &line["threads"]),
            (&100.into(), &198.into(), &2.into())
        );
        let updates = line["updates"].as_array().unwrap();
        let fields: Vec<&str> = updates[0]
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let expected = [
            "nodes",
            "edges",
            "seconds",
            "applications",
            "solves",
            "max_relative_residual",
            "converged",
            "cold_start",
            "eigenvalues",
            "cluster_cut",
            "route",
            "certified",
        ];
        assert_eq!(fields, expected);
        assert_eq!(
            (&updates[0]["nodes"], &updates[0]["edges"]),
            (&64.into(), &63.into())
        );
        assert_eq!(updates.last().unwrap()["nodes"], 100);
        for (j, value) in line["eigenvalues"].as_array().unwrap().iter().enumerate() {
            let exact = 1.0 - (PI * j as f64 / 99.0).cos(); // Chung 1997
            assert!(
                (value.as_f64().unwrap() - exact).abs() < 1e-6,
                "λ_{j} = {value}, not {exact}"
            );
        }
        let (shape, vectors) =
            eigentrail::archive::files::read_npy(&program.path("v.npy")).unwrap();
        assert_eq!(shape, [100, 5]);
        for (a, b) in (0..5).flat_map(|a| (0..5).map(move |b| (a, b))) {
            let dot: f64 = vectors.chunks(5).map(|row| row[a] * row[b]).sum();
            let exact = if a == b { 1.0 } else { 0.0 };
            assert!((dot - exact).abs() < 1e-10, "columns {a}, {b}: {dot}");
        }
    }

    #[test]
    fn every_method_gives_the_same_eigenvalues() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(150));
        let values = |method: &str| -> Vec<f64> {
            let line = program.prints_json(&[
                "track", file, "--k", "6", "--tol", "1e-4", "--method", method, "--strict",
                "--json",
            ]);
            let values = line["eigenvalues"].as_array().unwrap();
            values.iter().map(|v| v.as_f64().unwrap()).collect()
        };
        let full = values("full");
        for method in ["warm", "cold"] {
            for (value, exact) in values(method).iter().zip(&full) {
                assert!(
                    (value - exact).abs() <= 1e-6 * full[5],
                    "{method}: {value} {exact}"
                );
            }
        }
    }

    #[test]
    fn small_graphs_keep_as_many_pairs_as_there_are_nodes() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(3));
        let line = program.prints_json(&["track", file, "--k", "3", "--json"]);
        assert_eq!(line["updates"].as_array().unwrap().len(), 1);
        assert_eq!(line["eigenvalues"].as_array().unwrap().len(), 3);
        // Unasked, the same with a word about it.
        let said = predicate::str::contains("g.mtx: the graph has 3 nodes");
        let output = program.call(&["track", file, "--json"]).assert().success();
        let output = output.stderr(said).get_output().clone();
        let unasked: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(unasked["k"], 3);
        assert_eq!(unasked["eigenvalues"], line["eigenvalues"]);
        let large = program.file("large.mtx", &path_graph(16));
        program
            .call(&["track", large])
            .assert()
            .success()
            .stderr("");
    }

    #[test]
    fn people_get_a_table() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(80));
        let text = program.prints(&["track", file, "--k", "2"]);
        assert!(
            text.contains("nodes") && text.contains("eigenvalues"),
            "{text}"
        );
    }
}

mod potentials {
    use super::*;

    #[test]
    fn every_kind_has_its_facts_and_its_file() {
        let program = Program::new();
        let file = program.file("g.mtx", &path_graph(40));
        for kind in ["gcn", "report", "heat", "dr", "sr", "hops"] {
            let line = program.prints_json(&[
                "potential",
                file,
                "--goal",
                "0",
                "39",
                "--kind",
                kind,
                "--out",
                "phi.csv",
                "--json",
            ]);
            let fields: Vec<&str> = line
                .as_object()
                .unwrap()
                .keys()
                .map(String::as_str)
                .collect();
            assert_eq!(fields, ["n", "kind", "spurious_maxima", "seconds"]);
            assert_eq!((&line["n"], &line["kind"]), (&40.into(), &kind.into()));
            if kind != "report" {
                assert_eq!(line["spurious_maxima"], 0, "{kind}");
            }
            let rows = fs::read_to_string(program.path("phi.csv")).unwrap();
            let rows: Vec<&str> = rows.lines().collect();
            assert_eq!((rows[0], rows.len()), ("node,potential", 41));
            let phi = |node: usize| {
                rows[node + 1]
                    .split_once(',')
                    .unwrap()
                    .1
                    .parse::<f64>()
                    .unwrap()
            };
            assert_eq!(
                phi(0).max(phi(39)),
                0.0,
                "{kind}: the best goal is the zero of φ"
            );
            if kind != "report" {
                assert_eq!(phi(0), phi(39), "{kind}: equal goals are equal");
            }
            assert!(phi(20) < 0.0, "{kind}");
        }
    }
}

mod words {
    use super::*;

    #[test]
    fn check_says_what_a_scenario_amounts_to() {
        let program = Program::new();
        let file = program.file("quick.toml", QUICK);
        let text = program.prints(&["check", file]);
        for words in [
            "open, 4 × 4 cells",
            "16, 16 of them reachable",
            "6 steps, return -6",
            "diameter ",
            "25 at gamma = 1",
            "MB",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        // Up and left lead away from the goal from 11 cells each, a gap of 2; into a wall, a gap of 1, lead up and left from 4
        // cells each, down and right from 3: 22 / 2 + 8 + 6.
        let facts = program.prints_json(&["check", file, "--json"]);
        for (key, value) in [
            ("reachable", json!(16)),
            ("optimal_return", json!(-6.0)),
            ("optimal_gain", json!(null)),
            ("diameter", json!(6.0)),
            ("why_no_diameter", json!(null)),
            ("sum_of_inverse_gaps", json!(25.0)),
            ("moved", json!(null)),
            ("warnings", json!([])),
        ] {
            assert_eq!(facts[key], value, "{key}");
        }
        let resolved = program.prints(&["check", file, "--resolved"]);
        program.file("resolved.toml", &resolved);
        assert_eq!(
            program.prints(&["check", "resolved.toml", "--resolved"]),
            resolved
        );
    }

    #[test]
    fn show_draws_the_map_and_the_potential() {
        let program = Program::new();
        let file = program.file(
            "x.toml",
            "[env]\nkind = \"ascii\"\nmap = \"\"\"\nS#.\n..G\n\"\"\"\n[run]\nepisodes = 20\n",
        );
        let text = program.prints(&["show", file, "--ascii"]);
        assert!(
            text.starts_with("S ##.\n. . G\n2 × 3 cells, 5 states, 4 reachable"),
            "{text}"
        );
        program.prints(&["run", file, "--out", "o"]);
        let text = program.prints(&["show", file, "--potential", "o", "--ascii"]);
        assert!(
            text.starts_with("S ##") && text.contains("to 0.00 (9)"),
            "{text}"
        );
        let text = program.prints(&["show", file, "--policy", "o", "--ascii"]);
        assert!(
            text.contains("> > G") && text.contains("greedy policy, learnt in"),
            "{text}"
        );
        let text = program.prints(&["show", file, "--policy", "o", "--color", "always"]);
        assert!(text.contains("\u{1b}[48;") && text.contains('→'), "{text}");
        let text = program.prints(&["show", file, "--ascii", "--width", "2"]);
        assert!(
            text.starts_with("SG\n") && text.contains("each square stands for 2 × 2 cells"),
            "{text}"
        );
        program.refuses(
            &["show", "open_5x5", "--potential", "o"],
            3,
            &["the run is of another world"],
        );
        program.refuses(
            &["show", file, "--potential", "nowhere"],
            3,
            &["nowhere: not a run folder"],
        );
    }

    #[test]
    fn a_new_scenario_can_be_run() {
        let program = Program::new();
        let text = program.prints(&["new", "my-world"]);
        let file = program.file("my-world.toml", &text);
        assert!(program.prints(&["check", file]).contains("my-world"));
        for name in ["my/world", "", ".hidden", "two\nlines"] {
            program.refuses(&["new", name], 3, &["error: name = ", "use letters"]);
        }
    }

    #[test]
    fn list_knows_scenarios_and_kinds() {
        let text = Program::new().prints(&["list"]);
        for word in [
            "four_rooms",
            "maze_101",
            "edge-list",
            "heat",
            "count-bonus",
            "actor-critic",
        ] {
            assert!(text.contains(word), "{word}");
        }
    }

    #[test]
    fn completions_and_manual_are_made() {
        let program = Program::new();
        for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
            assert!(
                program
                    .prints(&["completions", shell])
                    .contains("eigentrail")
            );
        }
        let man = program.prints(&["man"]);
        assert!(man.contains(".TH eigentrail 1") && man.contains("eigentrail\\-track"));
    }

    #[test]
    fn usage_errors_are_two() {
        let program = Program::new();
        program.refuses(&[], 2, &["Usage"]);
        program.refuses(&["rum"], 2, &["run"]);
        for threads in ["0", "-1", "100000"] {
            let told = ["--threads", "from 1 to 1024"];
            program.refuses(&["run", "smoke", "--threads", threads], 2, &told);
        }
        for seed in ["-1", "18446744073709551616", "x"] {
            let told = ["--seed", "a whole number from 0"];
            program.refuses(&["run", "smoke", "--seed", seed], 2, &told);
        }
    }

    #[test]
    fn help_is_stable() {
        let program = Program::new();
        insta::assert_snapshot!("help", program.prints(&["--help"]));
        for command in [
            "run",
            "check",
            "show",
            "track",
            "potential",
            "export",
            "new",
        ] {
            insta::assert_snapshot!(
                format!("help_{command}"),
                program.prints(&[command, "--help"])
            );
        }
    }
}
