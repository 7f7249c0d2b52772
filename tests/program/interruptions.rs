//! What may come from outside while the program works: signals, outputs that are closed or full, a second program in the
//! same folder. Nothing that was done may be lost, and nothing may be left behind.

#![cfg(unix)]

use crate::program::{Program, path_graph, until};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const QUICK: &str = "name = \"quick\"\n[env]\nrows = 4\ncols = 4\n[spectral]\nnum_eigenpairs = 4\n[run]\nepisodes = 200\n";

/// With the exit code of each.
const SIGNALS: [(&str, i32); 3] = [("INT", 130), ("TERM", 143), ("HUP", 129)];

/// The program, beside a short and a long scenario, and a folder for its temporary files.
struct Place {
    program: Program,
    temporary: TempDir,
}

impl std::ops::Deref for Place {
    type Target = Program;

    fn deref(&self) -> &Program {
        &self.program
    }
}

impl Place {
    fn new() -> Self {
        let program = Program::new();
        program.file("quick.toml", QUICK);
        program.file("long.toml", &QUICK.replace("200", "10000000"));
        let temporary = tempfile::tempdir().unwrap();
        Self { program, temporary }
    }

    /// The program as `bash` calls it, with what the shell does to its outputs.
    fn in_shell(&self, line: &str) -> Command {
        let program = env!("CARGO_BIN_EXE_eigentrail");
        let mut command = Command::new("bash");
        command.args(["-c", &line.replace("eigentrail", program)]);
        self.at_home(command)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
        command.args(line.split_whitespace());
        self.at_home(command)
    }

    fn at_home(&self, mut command: Command) -> Command {
        command
            .current_dir(self.folder())
            .env("TMPDIR", self.temporary.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn spawn(&self, line: &str) -> Child {
        self.command(line).spawn().unwrap()
    }

    #[track_caller]
    fn ends_with(&self, line: &str, code: i32) -> Output {
        let output = self.command(line).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{line}: {stderr}");
        output
    }

    /// Nothing in TMPDIR, and no temporary file and no lock where the program writes.
    #[track_caller]
    fn is_tidy(&self) {
        for folder in [self.temporary.path(), self.folder()] {
            for path in files_below(folder) {
                let name = path.file_name().unwrap().to_str().unwrap();
                assert!(!name.starts_with('.'), "{} stayed", path.display());
                assert!(!path.starts_with(self.temporary.path()), "{name} stayed");
            }
        }
        assert_eq!(fs::read_dir(self.temporary.path()).unwrap().count(), 0);
    }
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let below = entries.flat_map(|entry| match entry.file_type().unwrap().is_dir() {
        true => files_below(&entry.path()),
        false => vec![entry.path()],
    });
    below.collect()
}

/// The files of a run or a comparison that equal runs share to the byte.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut results = BTreeMap::new();
    for path in files_below(folder) {
        let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
        let last = path.file_name().unwrap().to_str().unwrap();
        let has_clock = [
            "run.json",
            "arms.json",
            "sweep.json",
            "report.html",
            "timings.csv",
        ]
        .contains(&last)
            || last.starts_with("events.");
        if !has_clock {
            let mut bytes = fs::read(&path).unwrap();
            if last.ends_with(".json") && last != "snapshots.json" {
                let mut value: Value = serde_json::from_slice(&bytes).unwrap();
                remove_timing(&mut value);
                bytes = value.to_string().into_bytes();
            }
            results.insert(name.to_owned(), bytes);
        }
    }
    results
}

/// Clock readings stand in objects of their own.
fn remove_timing(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("timing");
            fields.values_mut().for_each(remove_timing);
        }
        Value::Array(values) => values.iter_mut().for_each(remove_timing),
        _ => {}
    }
}

fn is_filled(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|file| file.len() > 0)
}

fn send(child: &Child, signal: &str) {
    let kill = ["-s", signal, &child.id().to_string()];
    assert!(Command::new("kill").args(kill).status().unwrap().success());
}

mod signals {
    use super::*;

    #[test]
    fn each_ends_a_run_with_its_files() {
        for (signal, code) in SIGNALS {
            let place = Place::new();
            let child = place.spawn("run long.toml --out o --json");
            let rows = place.path("o/seed-0000/episodes.csv");
            until("rows", || is_filled(&rows));
            send(&child, signal);
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(code), "SIG{signal}");
            let summary = place.json("o/summary.json");
            assert_eq!(summary["seeds"][0]["finished"], false);
            let episodes = summary["seeds"][0]["episodes"].as_u64().unwrap();
            let rows = fs::read_to_string(rows).unwrap();
            assert!(rows.ends_with('\n'));
            assert_eq!(rows.lines().count() as u64, 1 + episodes);
            assert_eq!(place.json("o/run.json")["status"], "interrupted");
            let line: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(line["episodes"], episodes);
            let checkpoint = place.prints_json(&["inspect", "o/seed-0000/checkpoint", "--json"]);
            assert_eq!(checkpoint["episodes"], episodes);
            place.is_tidy();
        }
    }

    #[test]
    fn an_episode_without_end_is_given_up() {
        let place = Place::new();
        // A goal behind the step limit of a lifetime: the first episode does not end.
        let sets = "--set shaping.potential=none --set exploration.kind=none --set env.slip=0.9 --set env.rows=60 \
                    --set env.cols=60 --set env.max_steps=1000000000 --set agent.kind=random";
        let child = place.spawn(&format!("run long.toml --out o --json {sets}"));
        until("a seed", || place.path("o/seed-0000").exists());
        send(&child, "TERM");
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(143), "{stderr}");
        assert_eq!(place.json("o/run.json")["status"], "interrupted");
        place.is_tidy();
    }

    #[test]
    fn nohup_is_respected() {
        let place = Place::new();
        let mut child = place
            .in_shell("trap '' HUP; exec eigentrail run long.toml --out o")
            .spawn()
            .unwrap();
        let rows = place.path("o/seed-0000/episodes.csv");
        until("rows", || is_filled(&rows));
        send(&child, "HUP");
        let before = fs::metadata(&rows).unwrap().len();
        until("more rows", || fs::metadata(&rows).unwrap().len() > before);
        assert!(child.try_wait().unwrap().is_none());
        send(&child, "TERM");
        assert_eq!(child.wait().unwrap().code(), Some(143));
    }

    /// Nobody reads the trace, so that the program waits for ever at its end.
    #[test]
    fn the_second_ends_the_program_at_once() {
        let place = Place::new();
        let pipe = place.path("pipe");
        assert!(
            Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let child = place.spawn("run long.toml --out o --no-report --trace pipe");
        let _hold = fs::File::open(&pipe).unwrap();
        let rows = place.path("o/seed-0000/episodes.csv");
        until("rows", || is_filled(&rows));
        send(&child, "INT");
        until("an end", || {
            place.json("o/run.json")["status"] == "interrupted"
        });
        until("a summary", || place.path("o/summary.json").exists());
        // Until it dies of one, as a signal that comes before the first has been dealt with is none.
        let child = RefCell::new(child);
        until("an end by the second", || {
            send(&child.borrow(), "TERM");
            child.borrow_mut().try_wait().unwrap().is_some()
        });
        let mut child = child.into_inner();
        assert_eq!(child.wait().unwrap().code(), Some(143));
        place.is_tidy();
    }

    #[test]
    fn a_run_resumes_to_the_same_bytes_wherever_it_ended() {
        let place = Place::new();
        place.file(
            "quick.toml",
            &format!("{QUICK}checkpoint_every_steps = 40\n"),
        );
        place.ends_with("run quick.toml --out whole", 0);
        let whole = results(&place.path("whole"));
        assert!(whole.len() >= 10, "{:?}", whole.keys());
        let mut ended = 0;
        for (turn, signal) in ["KILL", "TERM", "KILL", "HUP", "KILL", "INT"]
            .into_iter()
            .cycle()
            .take(18)
            .enumerate()
        {
            let again = if turn % 3 == 0 { "--force" } else { "--resume" };
            let child = place.spawn(&format!("run quick.toml --out o {again}"));
            until("a folder", || place.path("o").exists());
            std::thread::sleep(Duration::from_millis(3 * turn as u64));
            send(&child, signal); // it may have ended by itself
            let output = child.wait_with_output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code();
            ended += i32::from(code != Some(0));
            assert!(!matches!(code, Some(1..=128)), "{code:?}: {stderr}");
            if turn % 2 == 1 {
                place.ends_with("run quick.toml --out o --resume", 0);
                assert_eq!(results(&place.path("o")), whole);
                place.is_tidy();
                fs::remove_dir_all(place.path("o")).unwrap();
            }
        }
        assert!(ended > 0, "no signal came in time");
    }

    /// Killed again and again, at moments drawn from as long as the whole takes, and gone on with each time.
    /// `EIGENTRAIL_KILLS=240` kills as often as that, instead of a few times, and prints what was killed how often.
    #[test]
    fn whatever_is_killed_again_and_again_ends_with_the_same_bytes() {
        let wanted = std::env::var("EIGENTRAIL_KILLS").map_or(9, |kills| kills.parse().unwrap());
        let place = Place::new();
        let text = QUICK.replace("200", "1000") + "checkpoint_every_steps = 200\n";
        place.file("quick.toml", &text);
        let lines = [
            "run quick.toml --seeds 0..2 --resume --out",
            "compare quick.toml --seeds 0..3 --arms gcn,heat --no-report --resume --out",
            "sweep quick.toml --grid agent.gamma=0.9,1 --seeds 0..3 --out",
        ];
        for (number, line) in lines.into_iter().enumerate() {
            let begun = Instant::now();
            place.ends_with(&format!("{line} whole-{number}"), 0);
            let takes = begun.elapsed();
            let whole = results(&place.path(&format!("whole-{number}")));
            let wanted = (wanted + number) / lines.len();
            let (mut kills, mut rounds) = (0, 0);
            let mut moments = ChaCha8Rng::seed_from_u64(number as u64);
            while kills < wanted || place.path("o").exists() {
                let child = place.spawn(&format!("{line} o"));
                std::thread::sleep(takes.mul_f64(moments.random_range(0.0..0.7)));
                if kills < wanted {
                    send(&child, "KILL"); // it may have ended by itself
                }
                let ended = child.wait_with_output().unwrap();
                if ended.status.signal() == Some(9) {
                    kills += 1;
                    continue;
                }
                let stderr = String::from_utf8_lossy(&ended.stderr);
                assert_eq!(ended.status.code(), Some(0), "{line}: {stderr}");
                assert_eq!(
                    results(&place.path("o")),
                    whole,
                    "{line} after {kills} kills"
                );
                rounds += 1;
                fs::remove_dir_all(place.path("o")).unwrap();
            }
            println!("{line}: {kills} kills, {rounds} times to its end");
        }
    }

    #[test]
    fn a_comparison_resumes_to_the_same_bytes() {
        let place = Place::new();
        let line = "compare quick.toml --seeds 0..3 --arms gcn,heat --no-report --out";
        place.ends_with(&format!("{line} whole"), 0);
        let whole = results(&place.path("whole"));
        for (signal, code) in SIGNALS {
            let child = place.spawn(&format!("{line} o --resume"));
            let first = place.path("o/arms/sparse/seed-0000.json");
            until("a trial", || first.exists());
            send(&child, signal);
            let ended = child.wait_with_output().unwrap().status.code();
            assert!([Some(code), Some(0)].contains(&ended), "{ended:?}");
            place.is_tidy();
            place.ends_with(&format!("{line} o --resume"), 0);
            assert_eq!(results(&place.path("o")), whole);
            fs::remove_dir_all(place.path("o")).unwrap();
        }
    }

    #[test]
    fn figures_draw_nothing_from_half_the_runs() {
        for (signal, code) in SIGNALS {
            let place = Place::new();
            let before = "<!-- made by eigentrail 0.1.0 --> the picture before";
            place.file("old.svg", before);
            let child = place.spawn("figures quick.toml --seeds 10000 -o old.svg");
            until("runs", || {
                let files = files_below(place.temporary.path());
                files.iter().any(|f| f.ends_with("seed-0000/episodes.csv"))
            });
            send(&child, signal);
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(code), "SIG{signal}");
            assert!(output.stdout.is_empty());
            assert_eq!(place.text("old.svg"), before);
            place.is_tidy();
        }
    }

    #[test]
    fn all_figures_or_none() {
        let place = Place::new();
        let child = place.spawn("figures --all --seeds 30 -o pictures");
        until("runs", || !files_below(place.temporary.path()).is_empty());
        send(&child, "TERM");
        assert_eq!(child.wait_with_output().unwrap().status.code(), Some(143));
        assert!(!place.path("pictures").exists());
        place.is_tidy();
    }

    #[test]
    fn track_shows_the_updates_so_far() {
        let place = Place::new();
        place.file("g.mtx", &path_graph(50_000));
        for (signal, code) in SIGNALS {
            let mut child = place.spawn("track g.mtx --k 3 --tol 1e-9 --growth 1e-9 --json -vv");
            let stderr = BufReader::new(child.stderr.take().unwrap());
            let mut lines = stderr.lines().map(Result::unwrap);
            let update = lines.find(|line| line.contains("spectrum_refresh"));
            assert!(update.is_some());
            send(&child, signal);
            let rest = std::thread::spawn(move || lines.count());
            let output = child.wait_with_output().unwrap();
            rest.join().unwrap();
            assert_eq!(output.status.code(), Some(code), "SIG{signal}");
            let line: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert_eq!(line["interrupted"], true);
            assert_eq!(line["eigenvalues"], Value::Array(Vec::new()));
            let updates = line["updates"].as_array().unwrap();
            for (i, update) in updates.iter().enumerate() {
                // One node an update, and λ_j = 1 − cos(π j ÷ (n − 1)) of a path.
                let n = 64 + i as u64;
                assert_eq!(update["nodes"], n);
                for j in 0..3 {
                    let exact =
                        1.0 - (std::f64::consts::PI * f64::from(j as u32) / (n - 1) as f64).cos();
                    let found = update["eigenvalues"][j].as_f64().unwrap();
                    assert!((found - exact).abs() < 1e-8, "{found} for {exact}");
                }
            }
            assert!(!updates.is_empty());
        }
    }

    #[test]
    fn what_was_not_interrupted_does_not_say_so() {
        let place = Place::new();
        place.file("g.mtx", &path_graph(100));
        let output = place.ends_with("track g.mtx --k 3 --json", 0);
        let line: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(line.get("interrupted").is_none());
    }

    /// A pipe that gives nothing keeps them reading for ever.
    #[test]
    fn other_commands_end_at_once_and_write_nothing() {
        let place = Place::new();
        place.file("old.csv", "old");
        for (signal, code) in SIGNALS {
            for line in [
                "potential pipe --goal 0 --out old.csv",
                "track pipe --vectors new.npy",
                "check pipe",
                "run pipe --out o",
            ] {
                let pipe = place.path("pipe");
                let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
                assert!(made.success());
                let child = place.spawn(line);
                // Opens when the program does.
                let mut hold = fs::OpenOptions::new().write(true).open(&pipe).unwrap();
                let _ = hold.write_all(b"%");
                send(&child, signal);
                let output = child.wait_with_output().unwrap();
                assert_eq!(output.status.code(), Some(code), "{line}: SIG{signal}");
                assert!(output.stdout.is_empty());
                assert_eq!(place.text("old.csv"), "old");
                assert!(!place.path("new.npy").exists() && !place.path("o").exists());
                fs::remove_file(pipe).unwrap();
                place.is_tidy();
            }
        }
    }
}

mod outputs {
    use super::*;

    /// Every seed, whatever becomes of the messages about it.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_stderr_that_takes_nothing_loses_nothing() {
        let place = Place::new();
        place.file("g.mtx", &path_graph(200));
        for to in ["2>&-", "2>/dev/full", "2> >(exec true)"] {
            for format in ["-vvv", "-vvv --log-format json", "--trace /dev/full -vv"] {
                for (line, code, made) in [
                    ("run quick.toml --out o --force", 0, "o/summary.json"),
                    (
                        "run quick.toml --out o --force --serve-once=127.0.0.1:0",
                        0,
                        "o/summary.json",
                    ),
                    (
                        "compare quick.toml --seeds 0..2 --arms gcn --out c --force",
                        0,
                        "c/compare.json",
                    ),
                    ("track g.mtx --k 2 --vectors v.npy", 0, "v.npy"),
                    ("figures quick.toml --seeds 1 -o f.svg", 0, "f.svg"),
                    ("run nowhere.toml", 3, "quick.toml"),
                    ("run --nonsense", 2, "quick.toml"),
                ] {
                    let line = format!("eigentrail {line} {format} {to}");
                    let output = place.in_shell(&line).output().unwrap();
                    assert_eq!(output.status.code(), Some(code), "{line}");
                    assert!(place.path(made).exists(), "{line}");
                    if made != "quick.toml" {
                        fs::remove_file(place.path(made)).unwrap();
                    }
                }
            }
        }
        place.is_tidy();
    }

    #[test]
    fn a_stdout_that_is_closed_ends_nothing() {
        let place = Place::new();
        place.file("other.toml", &QUICK.replace("quick", "other"));
        for format in ["", "--json", "--markdown"] {
            let line = "compare quick.toml other.toml --seeds 0..2 --arms gcn --out c --force";
            let mut child = place.spawn(&format!("{line} {format}"));
            drop(child.stdout.take());
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0));
            for name in ["quick", "other"] {
                for file in ["compare.json", "compare.csv", "report.html"] {
                    let file = place.path("c").join(name).join(file);
                    assert!(is_filled(&file), "{}", file.display());
                    fs::remove_file(file).unwrap();
                }
            }
        }
        for line in ["list", "schema", "--help", "man"] {
            let mut child = place.spawn(line);
            drop(child.stdout.take());
            let output = child.wait_with_output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{line}");
            assert!(output.stderr.is_empty(), "{line}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_stdout_that_is_full_is_told_after_the_work() {
        let place = Place::new();
        place.file("other.toml", &QUICK.replace("quick", "other"));
        let run = "compare quick.toml other.toml --seeds 0..2 --arms gcn --out c";
        for line in [
            run,
            "run quick.toml --out o --json",
            "list",
            "--version",
            "new x",
        ] {
            let to = "eigentrail LINE >/dev/full".replace("LINE", line);
            let output = place.in_shell(&to).output().unwrap();
            assert_eq!(output.status.code(), Some(1), "{line}");
            let stderr = String::from_utf8(output.stderr).unwrap();
            assert!(stderr.contains("cannot write to stdout: "), "{stderr}");
        }
        assert!(is_filled(&place.path("c/other/compare.json")));
        assert!(is_filled(&place.path("o/report.html")));
    }

    #[test]
    fn pictures_go_where_they_are_sent() {
        let place = Place::new();
        place.ends_with("run quick.toml --out o", 0);
        let page = place.ends_with("report o -o /dev/stdout", 0).stdout;
        assert!(page.starts_with(b"<!doctype html>") || page.starts_with(b"<!DOCTYPE html>"));
        place.file("target.html", "<!-- made by eigentrail 0.1.0 -->");
        std::os::unix::fs::symlink("target.html", place.path("link.html")).unwrap();
        place.ends_with("report o -o link.html", 0);
        assert!(
            fs::symlink_metadata(place.path("link.html"))
                .unwrap()
                .is_symlink()
        );
        assert!(place.text("target.html").len() > 1000);
    }
}

mod folders {
    use super::*;

    #[test]
    fn a_folder_has_one_writer() {
        let place = Place::new();
        let mut first = place.spawn("run long.toml --out o");
        until("rows", || {
            is_filled(&place.path("o/seed-0000/episodes.csv"))
        });
        for again in ["--resume", "--force"] {
            for seed in ["0", "1"] {
                let line = format!("run long.toml --out o {again} --seed {seed}");
                let output = place.ends_with(&line, 3);
                let stderr = String::from_utf8(output.stderr).unwrap();
                assert!(stderr.contains("o: another run is writing"), "{stderr}");
            }
        }
        let refused = place.ends_with("run long.toml --out o", 3);
        assert!(String::from_utf8_lossy(&refused.stderr).contains("--resume"));
        assert!(first.try_wait().unwrap().is_none());
        assert_eq!(place.json("o/run.json")["status"], "running");
        assert!(!place.path("o/seed-0001").exists());
        // The lock goes with whoever had it, however that ends.
        send(&first, "KILL");
        first.wait().unwrap();
        place.ends_with("run quick.toml --out o --force", 0);
        place.is_tidy();
    }

    #[test]
    fn a_comparison_has_one_writer() {
        let place = Place::new();
        let line = "compare long.toml --seeds 0..2 --arms gcn --out c";
        let first = place.spawn(line);
        until("a beginning", || {
            is_filled(&place.path("c/arms/gcn/resolved.toml"))
        });
        for again in ["--resume", "--force"] {
            let output = place.ends_with(&format!("{line} {again}"), 3);
            let stderr = String::from_utf8(output.stderr).unwrap();
            assert!(stderr.contains("c: another run is writing"), "{stderr}");
        }
        send(&first, "TERM");
        assert_eq!(first.wait_with_output().unwrap().status.code(), Some(143));
        place.is_tidy();
    }

    #[test]
    fn of_many_that_begin_together_none_is_lost() {
        let place = Place::new();
        place.file("quick.toml", &QUICK.replace("200", "5000")); // so that they meet
        let all: Vec<Child> = (0..6)
            .map(|seed| place.spawn(&format!("run quick.toml --out o --resume --seed {seed}")))
            .collect();
        let codes = all
            .into_iter()
            .map(|child| child.wait_with_output().unwrap().status.code());
        let codes: Vec<Option<i32>> = codes.collect();
        assert!(codes.iter().all(|code| [Some(0), Some(3)].contains(code)));
        assert!(codes.contains(&Some(0)), "{codes:?}");
        let (summary, info) = (place.json("o/summary.json"), place.json("o/run.json"));
        let seeds = summary["seeds"].as_array().unwrap();
        let known: Vec<&Value> = seeds.iter().map(|seed| &seed["seed"]).collect();
        let done = (0..6).filter(|&seed: &usize| codes[seed] == Some(0));
        let done: Vec<Value> = done.map(Value::from).collect();
        assert_eq!(known, done.iter().collect::<Vec<_>>());
        assert_eq!(info["seeds"], Value::from(done));
        place.is_tidy();
    }

    #[test]
    fn runs_that_begin_in_one_second_have_folders_of_their_own() {
        let place = Place::new();
        let lines = [
            "run quick.toml --no-report",
            "compare quick.toml --seeds 0..1 --arms heat",
        ];
        let all: Vec<Child> = (0..6).map(|i| place.spawn(lines[i % 2])).collect();
        for child in all {
            assert!(child.wait_with_output().unwrap().status.success());
        }
        let made = fs::read_dir(place.path("runs/quick")).unwrap();
        let made: Vec<PathBuf> = made.map(|entry| entry.unwrap().path()).collect();
        assert_eq!(made.len(), 6, "{made:?}");
        for (file, count) in [("summary.json", 3), ("compare.json", 3)] {
            let with = made.iter().filter(|folder| folder.join(file).exists());
            assert_eq!(with.count(), count, "{file}");
        }
    }

    #[test]
    fn force_removes_what_a_run_wrote_and_nothing_else() {
        let place = Place::new();
        place.ends_with("run quick.toml --out o --seed 0", 0);
        place.ends_with("run quick.toml --out o --seed 7 --resume", 0);
        let elsewhere = tempfile::tempdir().unwrap();
        fs::write(elsewhere.path().join("episodes.csv"), "precious").unwrap();
        fs::remove_dir_all(place.path("o/seed-0007")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), place.path("o/seed-0007")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), place.path("o/linked")).unwrap();
        fs::create_dir(place.path("o/papers")).unwrap();
        let theirs = ["o/notes.txt", "o/seed-0000/mine.txt", "o/papers/run.json"];
        for name in theirs {
            place.file(name, "mine");
        }
        place.ends_with("run quick.toml --out o --seed 7 --force", 0);
        for name in theirs {
            assert_eq!(place.text(name), "mine");
        }
        assert_eq!(files_below(elsewhere.path()).len(), 1);
        let precious = elsewhere.path().join("episodes.csv");
        assert_eq!(fs::read_to_string(precious).unwrap(), "precious");
        assert!(place.path("o/linked/episodes.csv").exists());
        assert_eq!(fs::read_dir(place.path("o/seed-0000")).unwrap().count(), 1);
        let seeds = &place.json("o/summary.json")["seeds"];
        assert_eq!(seeds.as_array().unwrap().len(), 1);
        assert_eq!(seeds[0]["seed"], 7);
        assert_eq!(place.json("o/run.json")["seeds"], Value::from(vec![7]));
    }

    #[test]
    fn folders_of_others_are_left_alone() {
        let place = Place::new();
        for (name, text) in [
            ("run.json", "{\"program\": \"their run 1.0\"}"),
            ("run.json", "not even JSON"),
            ("arms.json", "{}"),
            ("scenario.toml", "name = \"their own\"\n"),
            ("resolved.toml", "name = \"their own\"\n"),
            ("summary.json", "{}"),
            ("seed-0000/episodes.csv", "1,2,3"),
        ] {
            let folder = place.path("theirs");
            fs::create_dir_all(folder.join("seed-0000")).unwrap();
            if !name.starts_with("seed") {
                fs::remove_dir(folder.join("seed-0000")).unwrap();
            }
            place.file(&format!("theirs/{name}"), text);
            for again in ["--resume", "--force", ""] {
                for command in ["run quick.toml", "compare quick.toml --seeds 0..1"] {
                    place.ends_with(&format!("{command} --out theirs {again}"), 3);
                    place.ends_with(&format!("{command} --out theirs/. {again}"), 3);
                }
            }
            assert_eq!(files_below(&folder), [folder.join(name)]);
            assert_eq!(place.text(&format!("theirs/{name}")), text);
            fs::remove_dir_all(folder).unwrap();
        }
        for again in ["--resume", "--force"] {
            place.ends_with(&format!("run quick.toml --out . {again}"), 3);
            place.ends_with(&format!("run quick.toml --out / {again}"), 3);
        }
    }

    #[test]
    fn a_run_killed_at_its_start_begins_anew() {
        for names in [
            &[".eigentrail-Ab12Cd.tmp", ".eigentrail.lock"][..],
            &["scenario.toml"],
            &["scenario.toml", "resolved.toml"],
        ] {
            for again in ["--resume", "--force"] {
                let place = Place::new();
                fs::create_dir(place.path("o")).unwrap();
                for name in names {
                    place.file(&format!("o/{name}"), QUICK);
                }
                place.ends_with(&format!("run quick.toml --out o {again}"), 0);
                assert_eq!(place.json("o/run.json")["status"], "finished");
                place.is_tidy();
            }
        }
    }

    #[test]
    fn two_scenarios_of_one_name_do_not_share_a_folder() {
        let place = Place::new();
        let line = "compare quick.toml long.toml --seeds 0..1 --arms gcn --out c --force";
        let output = place.ends_with(line, 3);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(stderr.contains("called quick"), "{stderr}");
        assert!(!place.path("c").exists());
    }
}
