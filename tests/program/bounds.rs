//! The program from outside: numbers, names and files that it was not made for. Each is refused in words, with the exit
//! code that is documented, and never by a panic.

use crate::program::Program;
use std::fs;
use std::path::PathBuf;

const SCENARIO: &str = "[env]\nrows = 3\ncols = 3\n[run]\nepisodes = 3\n";
const GRAPH: &str = "%%MatrixMarket matrix coordinate pattern symmetric\n3 3 2\n2 1\n3 2\n";

/// The program, beside a small scenario and a small graph.
fn program() -> Program {
    let program = Program::new();
    program.file("small.toml", SCENARIO);
    program.file("path.mtx", GRAPH);
    program
}

#[test]
fn sizes_have_limits_that_are_told() {
    let program = program();
    let huge = ["2147483648", "4294967296", "9223372036854775807"];
    let sizes: [(&str, &[&str], &str); 20] = [
        ("env.max_steps", &[], "at most 1000000000"),
        ("env.rounds", &["env.kind=\"caves\""], "at most 1000 rounds"),
        ("env.rows", &[], "too large"),
        ("spectral.num_eigenpairs", &[], "1 to 65536"),
        ("spectral.max_restarts", &[], "1 to 100000"),
        ("spectral.threads", &[], "1 to 1024"),
        ("deepwalk.dimensions", &[], "1 to 4096"),
        ("deepwalk.walks_per_node", &[], "1 to 10000"),
        ("deepwalk.walk_length", &[], "2 to 10000"),
        ("deepwalk.window", &[], "1 to 1000"),
        ("deepwalk.negatives", &[], "1 to 1000"),
        ("gcn.hidden_dim", &[], "1 to 65536"),
        ("gcn.epochs", &[], "at most 1000000"),
        ("shaping.num_labels", &[], "1 to 1000000"),
        ("shaping.cold_epochs", &[], "at most 1000000"),
        ("shaping.warm_epochs", &[], "at most 1000000"),
        (
            "agent.planning_steps",
            &["agent.kind=\"dyna-q\""],
            "1 to 1000000",
        ),
        (
            "agent.max_backups",
            &["agent.kind=\"planner\""],
            "1 to 1000000",
        ),
        (
            "agent.evaluation_sweeps",
            &["agent.kind=\"policy-iteration\""],
            "1 to 1000000",
        ),
        ("run.episodes", &[], "1 to 1000000000"),
    ];
    for (key, more, rule) in sizes {
        for value in huge {
            for command in ["check", "run"] {
                let set = format!("{key}={value}");
                let mut arguments = vec![command, "small.toml", "--set", &set];
                arguments.extend(more.iter().flat_map(|set| ["--set", set]));
                let leaf = key.rsplit('.').next().unwrap();
                let named = if key == "env.rows" { "cells" } else { leaf };
                program.refuses(&arguments, 3, &[named, rule]);
            }
        }
    }
    // Nothing was begun.
    assert!(!program.path("runs").exists());
}

#[test]
fn more_pairs_than_states_are_as_many_as_states() {
    let program = program();
    program.prints(&[
        "check",
        "small.toml",
        "--set",
        "spectral.num_eigenpairs=65536",
    ]);
    let all = ["--set", "spectral.num_eigenpairs=65536", "--out", "o", "-q"];
    program.prints(&[&["run", "small.toml"], &all[..]].concat());
}

#[test]
fn what_cannot_fit_into_memory_is_refused_before_the_work() {
    let program = program();
    // 4 · 10⁶ cells × 65 536 hidden units × 24 bytes are 6 terabytes.
    let large = [
        "--set",
        "env.rows=2000",
        "--set",
        "env.cols=2000",
        "--set",
        "gcn.hidden_dim=65536",
    ];
    for command in ["check", "run", "compare"] {
        let arguments = [&[command, "small.toml"], &large[..]].concat();
        program.refuses(
            &arguments,
            3,
            &["of memory, and this machine has", "gcn.hidden_dim"],
        );
    }
    program.file(
        "isolated.mtx",
        "%%MatrixMarket matrix coordinate pattern symmetric\n2000000 2000000 0\n",
    );
    // 24 bytes × 4 · 10¹² are 96 terabytes.
    let dense = ["track", "isolated.mtx", "-k", "1", "--method", "full"];
    program.refuses(&dense, 3, &["this machine has", "full method"]);
    program.file(
        "empty.mtx",
        "%%MatrixMarket matrix coordinate pattern symmetric\n4294967294 4294967294 0\n",
    );
    program.refuses(&["track", "empty.mtx", "-k", "1"], 3, &["empty.mtx"]);
}

#[test]
fn counts_on_the_command_line_have_limits() {
    let program = program();
    for seeds in ["0..4294967296", "0..100000,100000..200000"] {
        program.refuses(
            &["compare", "small.toml", "--seeds", seeds],
            2,
            &["more than 100000 seeds"],
        );
    }
    program.refuses(
        &["check", "small.toml", "--threads", "1000000"],
        2,
        &["1 to 1024"],
    );
    program.refuses(
        &["figures", "small.toml", "--seeds", "4294967296"],
        2,
        &["10000"],
    );
    for k in ["4", "4294967296", "18446744073709551615"] {
        program.refuses(&["track", "path.mtx", "-k", k], 3, &["at most 3"]);
    }
}

/// What a terminal would obey: ESC, BEL, CSI as one character, DEL, a turned direction of writing, carriage return.
const ORDERS: [char; 6] = ['\u{1b}', '\u{7}', '\u{9b}', '\u{7f}', '\u{202e}', '\r'];

#[test]
fn files_cannot_give_orders_to_the_terminal() {
    let program = program();
    let evil: String = ORDERS.iter().map(|order| format!("x{order}[31m")).collect();
    program.file("head.mtx", &format!("{}\n1 1 0\n", evil.replace('\r', "")));
    program.file(
        "entry.mtx",
        &GRAPH.replace("3 2\n", &format!("3 {}\n", evil.replace('\r', ""))),
    );
    // In TOML such characters stand as escapes.
    let quoted: String = evil
        .chars()
        .map(|c| format!("\\u{:04x}", c as u32))
        .collect();
    program.file("name.toml", &format!("name = \"{quoted}\"\n"));
    program.file("key.toml", &format!("[env]\n\"{quoted}\" = 3\n"));
    program.file("word.toml", &format!("[agent]\nkind = \"{quoted}\"\n"));
    program.file(
        "arm.toml",
        &format!("{SCENARIO}[arms.\"{quoted}\"]\nabout = \"{quoted}\"\n"),
    );
    program.file(
        "about.toml",
        &format!("{SCENARIO}[arms.a]\nabout = \"{quoted}\"\n"),
    );
    let name = evil.replace('\r', ""); // no line breaks in names
    program.file(
        "states.csv",
        &format!("from,action,to\na,go,\"{name}\"\n\"{name}\",go,end\n"),
    );
    let listed = "[env]\nkind = \"edge-list\"\nfile = \"states.csv\"\nstart = \"a\"\n";
    program.file(
        "listed.toml",
        &format!("{listed}goals = [{{ at = \"end\" }}]\n"),
    );
    program.file(
        "lost.toml",
        &format!("{listed}goals = [{{ at = \"{quoted}?\" }}]\n"),
    );
    let odd_file = format!("a{evil}.toml");
    program.file(&odd_file, "nonsense");
    for (arguments, code) in [
        (vec!["track", "head.mtx", "-k", "1"], 3),
        (vec!["track", "entry.mtx", "-k", "1"], 3),
        (vec!["check", "name.toml"], 3),
        (vec!["check", "key.toml"], 3),
        (vec!["check", "word.toml"], 3),
        (vec!["check", "about.toml"], 0),
        (vec!["check", "arm.toml", "--resolved"], 0),
        (vec!["check", "listed.toml"], 0),
        (vec!["check", "lost.toml"], 3),
        (vec!["show", "listed.toml"], 0),
        (vec!["check", &odd_file], 3),
        (vec!["track", &evil], 3),
        (vec!["report", &evil], 3),
    ] {
        let output = program.call(&arguments).output().unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(!text.contains(ORDERS), "{arguments:?}: {text:?}");
        if arguments[1] != "arm.toml" && arguments[1] != "listed.toml" || arguments[0] == "show" {
            assert!(
                text.contains("\\u001b[31m") || text.contains("\\u{1b}[31m"),
                "{arguments:?}: {text:?}"
            );
        }
        if arguments[1] != "arm.toml" {
            assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text:?}");
        }
    }
}

#[test]
fn an_output_of_the_wrong_kind_is_refused_before_the_work() {
    let program = program();
    program.prints(&["run", "small.toml", "--out", "run", "-q"]);
    fs::create_dir(program.path("folder")).unwrap();
    program.file("file", "");
    for arguments in [
        "track path.mtx -k 1 --vectors folder",
        "potential path.mtx --goal 0 --out folder",
        "report run -o folder",
        "figures small.toml -o folder",
        "export run --to npz --force -o folder",
        "export run --to graphml --force -o folder",
        "check small.toml --trace folder",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        program.refuses(&arguments, 3, &["folder"]);
    }
    for arguments in [
        "run small.toml --out file",
        "run small.toml --out file --force",
        "run small.toml --out file --resume",
        "compare small.toml --out file --force",
        "figures --all -o file",
        "export run --to csv --force -o file",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        program.refuses(&arguments, 3, &["file"]);
    }
    for arguments in [
        "track path.mtx -k 1 --vectors no/where",
        "potential path.mtx --goal 0 --out no/where",
        "report run -o no/where",
        "figures small.toml -o no/where",
        "export run --to npz -o no/where",
        "check small.toml --trace no/where",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        program.refuses(&arguments, 3, &["no/where"]);
    }
    assert_eq!(fs::read_dir(program.path("folder")).unwrap().count(), 0);
    assert_eq!(fs::read(program.path("file")).unwrap(), b"");
}

#[test]
fn a_comparison_that_was_cut_short_is_told_with_its_file_and_field() {
    let program = program();
    let compare = [
        "compare",
        "small.toml",
        "--seeds",
        "0..2",
        "--arms",
        "sparse",
        "--out",
        "c",
        "-q",
    ];
    program.prints(&compare);
    let trial = program.path("c/arms/sparse/seed-0001.json");
    let numbers = program.path("c/compare.json");
    let cut = |path: &PathBuf, change: &dyn Fn(&mut serde_json::Value), words: &[&str]| {
        let text = fs::read_to_string(path).unwrap();
        let mut value = serde_json::from_str(&text).unwrap();
        change(&mut value);
        fs::write(path, value.to_string()).unwrap();
        program.refuses(&["report", "c", "-o", "page.html"], 3, words);
        fs::write(path, text).unwrap();
    };
    let pop = |list: &mut serde_json::Value| drop(list.as_array_mut().unwrap().pop());
    for field in ["length", "regret", "episodes"] {
        let words = ["seed-0001.json", &format!("course.{field}")];
        let words = if field == "episodes" {
            [words[0], "course."]
        } else {
            words
        };
        cut(&trial, &|value| pop(&mut value["course"][field]), &words);
    }
    let all = |value: &mut serde_json::Value| {
        for field in ["length", "regret", "episodes"] {
            pop(&mut value["course"][field]);
        }
    };
    cut(&trial, &all, &["seed-0001.json", "course.episodes"]);
    let clear = |list: &mut serde_json::Value| *list = serde_json::json!([]);
    cut(
        &numbers,
        &|value| clear(&mut value["seeds"]),
        &["compare.json", "seeds"],
    );
    cut(
        &numbers,
        &|value| clear(&mut value["arms"]),
        &["compare.json", "arms"],
    );
    cut(
        &numbers,
        &|value| clear(&mut value["timing"]),
        &["compare.json", "timing"],
    );
    program.prints(&["report", "c", "-o", "page.html"]);
    // Going on runs the trial again that is not whole.
    let text = fs::read_to_string(&trial).unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    all(&mut value);
    fs::write(&trial, value.to_string()).unwrap();
    program.prints(&[&compare[..], &["--resume"]].concat());
    let course =
        |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["course"].clone();
    assert_eq!(course(&fs::read_to_string(&trial).unwrap()), course(&text));
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::ffi::OsStr;
    use std::io::{BufRead, BufReader};
    use std::os::unix::ffi::OsStrExt;
    use std::process::Stdio;

    #[test]
    fn paths_need_not_be_unicode() {
        let program = program();
        let odd = |name: &[u8]| program.folder().join(OsStr::from_bytes(name));
        let call = |arguments: &[&OsStr]| program.call(&[]).args(arguments).output().unwrap();
        let ends = |arguments: &[&OsStr], codes: &[i32]| {
            let output = call(arguments);
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            let code = output.status.code();
            assert!(
                code.is_some_and(|code| codes.contains(&code)),
                "{arguments:?}: {code:?} {told}"
            );
            assert!(!told.contains("panicked"), "{told}");
            told
        };
        let os = OsStr::new;
        let (scenario, graph) = (odd(b"s\xff.toml"), odd(b"g\xff.mtx"));
        fs::write(&scenario, SCENARIO).unwrap();
        fs::write(&graph, GRAPH).unwrap();
        let out = odd(b"o\xff");
        let (scenario, graph, out) = (scenario.as_os_str(), graph.as_os_str(), out.as_os_str());
        ends(&[os("check"), scenario], &[0]);
        ends(&[os("run"), scenario, os("--out"), out], &[0]);
        ends(&[os("show"), scenario, os("--potential"), out], &[0]);
        ends(
            &[os("report"), out, os("-o"), odd(b"p\xff.html").as_os_str()],
            &[0],
        );
        for format in ["csv", "npz", "graphml", "dot"] {
            let to = odd(&[b"e\xff.", format.as_bytes()].concat());
            ends(
                &[
                    os("export"),
                    out,
                    os("--to"),
                    os(format),
                    os("-o"),
                    to.as_os_str(),
                ],
                &[0],
            );
        }
        let compared = odd(b"c\xff");
        let seeds = [
            os("--seeds"),
            os("0..1"),
            os("--arms"),
            os("sparse"),
            os("--out"),
        ];
        ends(
            &[
                &[os("compare"), scenario],
                &seeds[..],
                &[compared.as_os_str()],
            ]
            .concat(),
            &[0],
        );
        ends(
            &[os("report"), compared.as_os_str(), os("-o"), os("c.html")],
            &[0],
        );
        let vectors = odd(b"v\xff.npy");
        ends(
            &[
                os("track"),
                graph,
                os("-k"),
                os("2"),
                os("--vectors"),
                vectors.as_os_str(),
            ],
            &[0],
        );
        ends(
            &[
                os("potential"),
                graph,
                os("--goal"),
                os("0"),
                os("--kind"),
                os("hops"),
            ],
            &[0],
        );
        // Records are Unicode: they could not name the file of the world.
        let folder = odd(b"f\xff");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("w.csv"), "from,action,to\na,go,b\n").unwrap();
        let listed = "[env]\nkind = \"edge-list\"\nfile = \"w.csv\"\ngoals = [{ at = \"b\" }]\n";
        fs::write(folder.join("w.toml"), listed).unwrap();
        let listed = folder.join("w.toml");
        let told = ends(&[os("check"), listed.as_os_str(), os("--resolved")], &[3]);
        assert!(
            told.contains("env.file") && told.contains("UTF-8"),
            "{told}"
        );
        // What is no path is refused by the command line.
        ends(
            &[
                os("check"),
                scenario,
                os("--set"),
                OsStr::from_bytes(b"a\xff=1"),
            ],
            &[2],
        );
        ends(&[os("new"), OsStr::from_bytes(b"\xff")], &[2]);
    }

    #[test]
    fn quiet_does_not_hide_who_can_read_the_page() {
        let program = program();
        let binary = env!("CARGO_BIN_EXE_eigentrail");
        for quiet in ["-q", "-qq"] {
            let mut run = std::process::Command::new(binary)
                .current_dir(program.folder())
                .args([
                    "run",
                    "small.toml",
                    "--force",
                    "--out",
                    "open",
                    "--serve=0.0.0.0:0",
                    quiet,
                ])
                .stderr(Stdio::piped())
                .stdout(Stdio::null())
                .spawn()
                .unwrap();
            let told = BufReader::new(run.stderr.take().unwrap());
            let first = told.lines().next().unwrap().unwrap();
            assert!(
                first.starts_with("warning:") && first.contains("0.0.0.0"),
                "{quiet}: {first}"
            );
            run.kill().unwrap();
            run.wait().unwrap();
        }
    }
}
