//! Graphs that people bring along, from outside: edge lists, Matrix Market files, and the examples of both.

use crate::program::{Program, path_graph};
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;

const MUSEUM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data/museum.toml");
const RING: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/examples/data/ring_of_rooms.mtx"
);

/// Lowest eigenvalues by a dense solver that shares no code with ours, of the symmetric matrix with these entries of W.
fn dense(n: usize, edges: &[(usize, usize, f64)], laplacian: &str) -> Vec<f64> {
    let mut w = nalgebra::DMatrix::<f64>::zeros(n, n);
    for &(i, j, weight) in edges {
        w[(i, j)] = weight;
        w[(j, i)] = weight;
    }
    let degree: Vec<f64> = (0..n).map(|i| w.row(i).sum()).collect();
    let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| match laplacian {
        "sym" if degree[i] == 0.0 || degree[j] == 0.0 => 0.0,
        "sym" => f64::from(u8::from(i == j)) - w[(i, j)] / (degree[i] * degree[j]).sqrt(),
        _ if i == j => degree[i] - w[(i, i)],
        _ => -w[(i, j)],
    });
    let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Entries of a Matrix Market file of the plainest kind.
fn edges(text: &str) -> (usize, Vec<(usize, usize, f64)>) {
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let n = lines.next().unwrap().split(' ').next().unwrap();
    let edge = |line: &str| {
        let fields: Vec<&str> = line.split(' ').collect();
        let node = |at: usize| fields[at].parse::<usize>().unwrap() - 1;
        let weight = fields.get(2).map_or(1.0, |weight| weight.parse().unwrap());
        (node(0), node(1), weight)
    };
    (n.parse().unwrap(), lines.map(edge).collect())
}

fn eigenvalues(line: &Value) -> Vec<f64> {
    let values = line["eigenvalues"].as_array().unwrap();
    values.iter().map(|value| value.as_f64().unwrap()).collect()
}

#[track_caller]
fn assert_close(found: &[f64], exact: &[f64], tolerance: f64) {
    let largest = exact[found.len() - 1];
    for (i, (found, exact)) in found.iter().zip(exact).enumerate() {
        let error = (found - exact).abs();
        assert!(
            error <= tolerance * largest,
            "λ_{} is {exact}, not {found}",
            i + 1
        );
    }
}

#[test]
fn a_graph_goes_out_of_a_run_and_into_track() {
    let program = Program::new();
    program.prints(&[
        "run",
        "four_rooms",
        "-q",
        "--no-report",
        "--set",
        "run.episodes=30",
        "--out",
        "o",
    ]);
    program.prints(&["export", "o", "--to", "mtx"]);
    let text = program.text("graph.mtx");
    assert_eq!(
        text,
        program.prints(&["export", "o", "--to", "mtx", "-o", "-"])
    );
    // What the run says it has seen, as edges from the later to the earlier state.
    let seen = program.text("o/seed-0000/graph.csv");
    let mut expected: Vec<(usize, usize, f64)> = seen
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let (from, to) = (fields[0].parse().unwrap(), fields[2].parse().unwrap());
            (std::cmp::max(from, to), std::cmp::min(from, to), 1.0)
        })
        .filter(|(far, near, _)| far != near)
        .collect();
    expected.sort_by_key(|&(far, near, _)| (far, near));
    expected.dedup();
    let (n, found) = edges(&text);
    assert_eq!(found, expected);
    assert_eq!(
        n,
        program.text("o/seed-0000/states.csv").lines().count() - 1
    );
    let line = program.prints_json(&["track", "graph.mtx", "--k", "6", "--tol", "1e-5", "--json"]);
    assert_close(&eigenvalues(&line), &dense(n, &expected, "sym"), 1e-8);
    let fit = program.prints_json(&[
        "potential",
        "graph.mtx",
        "--goal",
        "0",
        "--kind",
        "heat",
        "--json",
    ]);
    assert_eq!(fit["n"], n);
}

#[test]
fn either_laplacian_of_a_path_has_its_closed_form() {
    let program = Program::new();
    let n = 700;
    let file = program.file("g.mtx", &path_graph(n));
    for (flags, name, exact) in [
        (&[][..], "sym", |k: usize, n: f64| {
            1.0 - (PI * k as f64 / (n - 1.0)).cos()
        }),
        (&["--laplacian", "sym"], "sym", |k: usize, n: f64| {
            1.0 - (PI * k as f64 / (n - 1.0)).cos()
        }),
        (
            &["--laplacian", "unnormalised"],
            "unnormalised",
            |k: usize, n: f64| 2.0 - 2.0 * (PI * k as f64 / n).cos(),
        ),
    ] as [(&[&str], &str, fn(usize, f64) -> f64); 3]
    {
        let exact: Vec<f64> = (0..12).map(|k| exact(k, n as f64)).collect();
        let call = ["track", file, "--k", "12", "--tol", "1e-4", "--certify"];
        let call = [&call[..], flags].concat();
        let line = program.prints_json(&[&call[..], &["--strict", "--json"]].concat());
        assert_eq!(line["laplacian"], name);
        let updates = line["updates"].as_array().unwrap();
        assert!(updates.iter().all(|update| update["certified"] == true));
        assert_close(&eigenvalues(&line), &exact, 1e-6);
        let text = program.prints(&call);
        assert!(text.contains(&format!("laplacian {name}\n")), "{text}");
    }
    program.refuses(
        &["track", file, "--laplacian", "random-walk"],
        2,
        &["sym, unnormalised"],
    );
}

#[test]
fn either_laplacian_takes_weights_loops_and_isolated_nodes() {
    let program = Program::new();
    // A ring of 380 nodes with chords, weights from 0.25 to 4, one loop, and 20 nodes by themselves.
    let (n, ring) = (400, 380);
    let weight = |i: usize| [0.25, 4.0, 1.0, 0.5, 2.0][i % 5];
    let around = (1..ring).map(|i| (i, i - 1, weight(i)));
    let chords = (60..ring)
        .step_by(60)
        .map(|i| (i, (7 * i) % 53, weight(i + 2)));
    let mut edges: Vec<(usize, usize, f64)> = around.chain(chords).collect();
    edges.push((ring - 1, 0, 3.0));
    edges.push((5, 5, 1.5));
    let lines: String = edges
        .iter()
        .map(|(i, j, weight)| format!("{} {} {weight}\n", i + 1, j + 1))
        .collect();
    let header = "%%MatrixMarket matrix coordinate real symmetric";
    let text = format!("{header}\n{n} {n} {}\n{lines}", edges.len());
    let file = program.file("g.mtx", &text);
    for laplacian in ["sym", "unnormalised"] {
        let exact = dense(n, &edges, laplacian);
        for method in ["warm", "full"] {
            let line = program.prints_json(&[
                "track",
                file,
                "--k",
                "30",
                "--tol",
                "1e-5",
                "--laplacian",
                laplacian,
                "--method",
                method,
                "--certify",
                "--strict",
                "--json",
            ]);
            let found = eigenvalues(&line);
            assert_eq!(found.iter().filter(|&&value| value == 0.0).count(), 21);
            assert_close(&found, &exact, 1e-8);
        }
    }
}

#[test]
fn the_example_of_a_graph_has_its_spectrum_and_potential() {
    let program = Program::new();
    let (n, edges) = edges(&fs::read_to_string(RING).unwrap());
    let line = program.prints_json(&[
        "track", RING, "--k", "8", "--tol", "1e-5", "--strict", "--json",
    ]);
    assert_eq!(line["n"], n);
    assert_close(&eigenvalues(&line), &dense(n, &edges, "sym"), 1e-8);
    let call = ["potential", RING, "--goal", "0", "--kind", "hops"];
    let line = program.prints_json(&[&call[..], &["--out", "phi.csv", "--json"]].concat());
    assert_eq!(line["spurious_maxima"], 0);
    assert_eq!(program.text("phi.csv").lines().count(), n + 1);
}

#[test]
fn the_example_of_a_world_is_run_by_the_names_of_its_actions() {
    let program = Program::new();
    let facts = program.prints_json(&["check", MUSEUM, "--json"]);
    // By hand: four steps of which the last costs 3; or right, 1.25 lifts, and the same last one.
    let best = 0.75 * -6.0 + 0.25 * (-1.0 - 1.25 - 3.0);
    let found = facts["optimal_return"].as_f64().unwrap();
    assert!((found - best).abs() < 1e-9, "{found}");
    assert_eq!(facts["warnings"], Value::Array(Vec::new()));
    let shown = program.prints(&["show", MUSEUM]);
    assert!(shown.contains("side door"), "{shown}");
    program.prints(&["run", MUSEUM, "-q", "--no-report", "--out", "o"]);
    let policy = program.prints(&["show", MUSEUM, "--policy", "o"]);
    for line in ["side door: right → lift", "tower: up → roof"] {
        assert!(policy.lines().any(|found| found == line), "{policy}");
    }
    let actions = program.text("o/seed-0000/actions.csv");
    assert_eq!(actions, "action,name\n0,left\n1,right\n2,back\n3,up\n");
    let held = program.text("o/seed-0000/policy.csv");
    assert!(held.starts_with("state,visits,greedy,greedy_name\n"));
    assert!(held.lines().any(|line| line.ends_with(",3,up")), "{held}");

    program.prints(&["export", "o", "--to", "csv"]);
    let table = program.text("export/transitions.csv");
    let names = ["left", "right", "back", "up"];
    let mut rows = table.lines();
    let header = "seed,from,action,to,count,reward_sum,terminal,action_name";
    assert_eq!(rows.next(), Some(header));
    for row in rows {
        let fields: Vec<&str> = row.split(',').collect();
        assert_eq!(fields[7], names[fields[2].parse::<usize>().unwrap()]);
    }
    assert!(
        program
            .text("export/states.csv")
            .lines()
            .next()
            .unwrap()
            .ends_with("greedy,greedy_name")
    );
    let graphml = program.prints(&["export", "o", "--to", "graphml", "-o", "-"]);
    assert!(graphml.contains("<data key=\"action_name\">back</data></edge>"));
    let dot = program.prints(&["export", "o", "--to", "dot", "-o", "-"]);
    assert!(dot.contains("label = \"right ×"), "{dot}");

    // A run from before actions had names.
    fs::remove_file(program.path("o/seed-0000/actions.csv")).unwrap();
    let policy = program.prints(&["show", MUSEUM, "--policy", "o"]);
    assert!(policy.contains("tower → roof\n"), "{policy}");
    let graphml = program.prints(&["export", "o", "--to", "graphml", "-o", "-"]);
    assert!(!graphml.contains("<data key=\"action_name\">"));
    program.prints(&["export", "o", "--to", "csv", "-o", "old"]);
    let header = program.text("old/transitions.csv");
    assert!(header.starts_with("seed,from,action,to,count,reward_sum,terminal\n"));
}

#[test]
fn maps_and_boards_have_names_of_actions_too() {
    for (scenario, set, expected) in [
        ("four_rooms", "agent.gamma=1", "up right down left"),
        ("four_rooms", "env.actions=turns", "left right forward"),
        ("frozen_lake_4", "agent.gamma=1", "left down right up"),
    ] {
        let program = Program::new();
        let call = ["run", scenario, "-q", "--no-report", "--out", "o", "--set"];
        program.prints(&[&call[..], &[set, "--set", "run.episodes=2"]].concat());
        let table = program.text("o/seed-0000/actions.csv");
        let names: Vec<&str> = table
            .lines()
            .skip(1)
            .map(|row| row.split_once(',').unwrap().1)
            .collect();
        assert_eq!(names.join(" "), expected);
    }
}

#[test]
fn a_list_of_edges_without_actions_is_a_world() {
    let program = Program::new();
    program.file(
        "g.csv",
        "from,to\nhome,mill\nhome,field\nmill,pond\nfield,mill\nfield,home\n",
    );
    let scenario = |start: &str| {
        format!(
            "[env]\nkind = \"edge-list\"\nfile = \"g.csv\"\nstart = {start}\ngoals = [{{ at = \"pond\" }}]\n[run]\nepisodes = 40\n"
        )
    };
    let file = program.file("x.toml", &scenario("[\"home\", \"field\", \"mill\"]"));
    let facts = program.prints_json(&["check", file, "--json"]);
    assert_eq!(
        (&facts["states"], &facts["actions"]),
        (&4.into(), &2.into())
    );
    let steps = facts["optimal_steps"].as_f64().unwrap();
    assert!((steps - 5.0 / 3.0).abs() < 1e-9, "{steps}");
    program.prints(&["run", file, "-q", "--no-report", "--out", "o"]);
    let policy = program.prints(&["show", file, "--policy", "o"]);
    assert!(policy.contains("home: 0 → mill\n"), "{policy}");
    let resolved = program.prints(&["check", file, "--resolved"]);
    program.file("resolved.toml", &resolved);
    let again = program.prints_json(&["check", "resolved.toml", "--json"]);
    assert_eq!(again["optimal_steps"], facts["optimal_steps"]);

    let file = program.file("x.toml", &scenario("[\"home\", \"feild\"]"));
    let words = [
        "x.toml:4",
        "no state is named \"feild\"; did you mean \"field\"?",
    ];
    program.refuses(&["check", file], 3, &words);
    program.file("g.csv", "home,mill\nmill,pond\n");
    let words = [
        "g.csv, line 1",
        "names the columns: from,action,to",
        "or from,to",
    ];
    program.refuses(&["check", file], 3, &words);
    program.file("g.csv", "from,to,probability\nhome,pond,1\n");
    let words = [
        "g.csv, line 1",
        "\"probability\" needs the column \"action\"",
    ];
    program.refuses(&["check", file], 3, &words);
}

#[test]
fn a_new_scenario_may_be_of_a_kind() {
    let program = Program::new();
    let named = program.prints(&["new", "edge-list"]);
    assert!(named.contains("\nname = \"edge-list\"\n"), "{named}");
    assert!(named.contains("\nfile = \"world.csv\"\n"), "{named}");
    let asked = program.prints(&["new", "my-world", "--kind", "edge-list"]);
    let renamed = named.replacen("edge-list", "my-world", 2); // in the title and as the name
    assert!(asked == renamed, "{asked}");
    let maze = program.prints(&["new", "edge-list", "--kind", "maze"]);
    assert!(
        maze.contains("\nkind = \"maze\"\n") && maze.contains("\nloops = 0.0\n"),
        "{maze}"
    );
    program.file("maze.toml", &maze);
    assert_eq!(
        program.prints_json(&["check", "maze.toml", "--json"])["kind"],
        "maze"
    );
    program.refuses(&["new", "x", "--kind", "moze"], 2, &["maze", "edge-list"]);
}

#[test]
fn more_pairs_than_a_world_has_states_are_as_many_as_it_has() {
    let program = Program::new();
    let call = ["run", MUSEUM, "-q", "--no-report", "--set"];
    for (pairs, out) in [("8", "eight"), ("400", "many")] {
        let set = format!("spectral.num_eigenpairs={pairs}");
        program.prints(&[&call[..], &[&set, "--out", out]].concat());
    }
    let array = |out: &str| {
        let path = program.path(out).join("seed-0000/eigenvectors.npy");
        eigentrail::archive::files::read_npy(&path).unwrap()
    };
    assert_eq!(
        (array("eight").0, array("many").0),
        (vec![9, 8], vec![9, 9])
    );
    let said = |pairs: &str| {
        let set = format!("spectral.num_eigenpairs={pairs}");
        program.prints(&["check", MUSEUM, "--set", &set])
    };
    assert!(said("10").contains("all 9 of 9 reachable states (spectral.num_eigenpairs = 10)"));
    assert!(!said("9").contains("num_eigenpairs"));
}
