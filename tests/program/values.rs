//! Numbers from outside: what counts as near the best return, how large rewards may be, and that whatever is written can be
//! read back.

use crate::program::Program;
use predicates::prelude::*;
use serde_json::Value;
use std::fs;

/// What these tests ask besides.
trait Results {
    fn settings(&self, folder: &str, arm: &str) -> Vec<String>;
    fn column(&self, name: &str, column: &str) -> Vec<f64>;
}

impl Results for Program {
    /// The settings of an arm of the comparison in `folder`, as arguments.
    fn settings(&self, folder: &str, arm: &str) -> Vec<String> {
        let about = self.json(&format!("{folder}/arms.json"));
        let settings = about["arms"][arm].as_array().unwrap().iter();
        let settings = settings.map(|set| set.as_str().unwrap().to_owned());
        settings.flat_map(|set| ["--set".to_owned(), set]).collect()
    }

    /// A column of a table of numbers.
    fn column(&self, name: &str, column: &str) -> Vec<f64> {
        let mut reader = csv::Reader::from_path(self.path(name)).unwrap();
        let at = reader.headers().unwrap().iter().position(|h| h == column);
        let at = at.unwrap();
        let rows = reader.records().map(Result::unwrap);
        rows.map(|row| row[at].parse().unwrap()).collect()
    }
}

/// Two steps to a reward of 1; every action but `go` ends the episode with nothing, or goes back.
const HOLES: &str = "from,action,to,probability,reward\na,hole,l,1,0\na,go,b,1,0\nb,hole,l,1,0\nb,go,d,1,0\n\
                     d,go,c,1,1\nd,back,a,1,0\n";

/// A slippery world with an end that hurts, a swamp, and a goal: R* is below 0 and steps do not cost the same.
const MIXED: &str = "from,action,to,probability,reward\na,short,goal,0.7,-1\na,short,pit,0.3,-30\na,long,b,1,-2\n\
                     b,on,c,1,-1\nb,back,a,1,-1\nc,on,goal,1,-1\nc,wait,c,1,-0.5\n";

/// The best is worth nothing: in for 2, out for 2.
const EVEN: &str = "from,action,to,probability,reward\na,pay,b,1,-2\na,wait,a,1,-1\nb,take,goal,1,2\nb,wait,b,1,-1\n";

fn listed(name: &str, goals: &str) -> String {
    format!(
        "name = \"{name}\"\n[env]\nkind = \"edge-list\"\nfile = \"{name}.csv\"\nstart = \"a\"\ngoals = [{goals}]\n\
         [run]\nepisodes = 120\n"
    )
}

mod near {
    use super::*;

    /// The first moment when the mean of 20 returns is at least `least`: (episodes, steps).
    fn arrival(returns: &[f64], steps: &[f64], least: f64) -> Option<(u64, u64)> {
        let near = |end: &usize| {
            let sum: f64 = returns[end - 20..*end].iter().sum();
            sum / 20.0 >= least - 1e-9 * least.abs()
        };
        let end = (20..=returns.len()).find(near)?;
        Some((end as u64, steps[end - 1] as u64))
    }

    /// One seed of an arm as `compare` saw it, against the rows of the same run; R* by hand.
    #[track_caller]
    fn agrees(file: &str, text: &str, table: Option<&str>, arm: &str, best: f64, scale: f64) {
        let program = Program::new();
        let scenario = file.to_owned() + ".toml";
        program.file(&scenario, text);
        if let Some(table) = table {
            program.file(&(file.to_owned() + ".csv"), table);
        }
        let compare = ["compare", &scenario, "--seeds", "3..4", "--arms", arm];
        let told = program.prints_json(&[&compare[..], &["--out", "c", "--json", "-q"]].concat());
        let sets = program.settings("c", arm);
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let run = ["run", &scenario, "--seed", "3", "--out", "r", "-q"];
        program.prints(&[&run[..], &sets].concat());
        let rows = "r/seed-0003/episodes.csv";
        let (returns, steps) = (program.column(rows, "return"), program.column(rows, "step"));
        let trial = &program.json(&format!("c/arms/{arm}/seed-0003.json"))["result"];
        for (key, times) in [("within_1_5x", 1.5), ("within_1_1x", 1.1)] {
            let expected = arrival(&returns, &steps, best - (times - 1.0) * scale);
            let found = trial[key]["episodes"].as_u64();
            assert_eq!(found, expected.map(|(episodes, _)| episodes), "{key}");
            let found = trial[key]["steps"].as_u64();
            assert_eq!(found, expected.map(|(_, steps)| steps), "{key}");
        }
        let tail = returns.len() - 20.max(returns.len() / 10);
        let mean = returns[tail..].iter().sum::<f64>() / (returns.len() - tail) as f64;
        let close = |x: &Value, y: f64| {
            let x = x.as_f64().unwrap();
            assert!((x - y).abs() <= 1e-12 * y.abs().max(1.0), "{x} {y}");
        };
        close(&trial["optimal_return"], best);
        close(&trial["final_return"], mean);
        close(&trial["final_ratio"], 1.0 + (best - mean) / scale);
        let summary = &program.json("r/summary.json")["seeds"][0];
        close(&summary["optimal_return"], best);
        close(&summary["final_return"], mean);
        let arm = &told["arms"][0];
        close(&arm["final_return"]["median"], mean);
        for key in ["low", "high"] {
            close(&arm["final_return"][key], mean);
        }
        close(&arm["final_ratio"], 1.0 + (best - mean) / scale);
        // The sparse arm stands first, asked for or not.
        let written = program.column("c/compare.csv", "final_return");
        let written = written[written.len() - 1];
        close(&written.into(), mean);
    }

    #[test]
    fn what_counts_is_the_return() {
        let holes = listed("holes", "{ at = \"c\" }, { at = \"l\" }");
        let mixed = listed("mixed", "{ at = \"goal\" }, { at = \"pit\" }");
        let even = listed("even", "{ at = \"goal\" }");
        for arm in ["sparse", "gcn", "planner", "q-learning"] {
            agrees("holes", &holes, Some(HOLES), arm, 1.0, 1.0);
            // The long way costs 4; the short one .7 · 1 + .3 · 30 = 9.7. An episode has 60 steps.
            agrees("mixed", &mixed, Some(MIXED), arm, -4.0, 4.0);
            agrees("even", &even, Some(EVEN), arm, 0.0, 2.0);
        }
    }

    #[test]
    fn a_goal_that_pays_is_measured_by_what_it_pays() {
        let world = |reward: &str| {
            format!("[env]\nrows = 4\ncols = 4\nreward = {reward}\n[run]\nepisodes = 100\n")
        };
        for arm in ["sparse", "gcn"] {
            // Six steps.
            agrees("bonus", &world("\"goal-bonus\""), None, arm, 94.0, 94.0);
            let free = world("{ step = 0, goal = 1 }");
            agrees("free", &free, None, arm, 1.0, 1.0);
            let tenth = world("{ step = -0.1, goal = 0 }");
            agrees("tenth", &tenth, None, arm, -0.6, 0.6);
        }
    }

    /// Where every step costs the same, all is as lengths have it.
    #[test]
    fn equal_costs_are_measured_in_steps() {
        let program = Program::new();
        let text = "[env]\nkind = \"rooms\"\nroom = [3, 3]\nslip = 0.1\nstart = \"random\"\n[run]\nepisodes = 150\n";
        let file = program.file("steps.toml", text);
        for arm in ["sparse", "gcn"] {
            let out = format!("c-{arm}");
            program.prints(&[
                "compare", file, "--seeds", "0..1", "--arms", arm, "--out", &out,
            ]);
            let sets = program.settings(&out, arm);
            let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
            let folder = format!("r-{arm}");
            program.prints(&[&["run", file, "--out", &folder, "-q"], &sets[..]].concat());
            let rows = format!("{folder}/seed-0000/episodes.csv");
            let (lengths, steps) = (
                program.column(&rows, "length"),
                program.column(&rows, "step"),
            );
            let trial = &program.json(&format!("{out}/arms/{arm}/seed-0000.json"))["result"];
            let optimal = trial["optimal_steps"].as_f64().unwrap();
            for (key, times) in [("within_1_5x", 1.5), ("within_1_1x", 1.1)] {
                let short = |end: &usize| {
                    lengths[end - 20..*end].iter().sum::<f64>() <= 20.0 * times * optimal
                };
                let end = (20..=lengths.len()).find(short);
                let found = trial[key]["steps"].as_f64();
                assert_eq!(found, end.map(|end| steps[end - 1]), "{arm} {key}");
            }
            let ratio = trial["final_mean_steps"].as_f64().unwrap() / optimal;
            assert_eq!(
                trial["final_ratio"].as_f64().unwrap(),
                ratio,
                "to the last bit"
            );
        }
    }

    #[test]
    fn tables_and_pages_say_what_was_earned() {
        let program = Program::new();
        program.file("holes.csv", HOLES);
        let holes = listed("holes", "{ at = \"c\" }, { at = \"l\" }");
        let file = program.file("holes.toml", &holes);
        let compare = [
            "compare", file, "--seeds", "0..2", "--arms", "sparse", "--out", "c", "--wide",
        ];
        let text = program.prints(&compare);
        for words in [
            "optimal episode 3.0 steps, return 1.00",
            " of 1.00 ",
            "≥ 0.9 R*",
        ] {
            assert!(text.contains(words), "no {words} in\n{text}");
        }
        let page = fs::read_to_string(program.path("c/report.html")).unwrap();
        assert!(page.contains("final return"));
        let text = program.prints(&["run", file, "--out", "r", "-q"]);
        assert!(text.contains(" of 1.00, "), "{text}");
        let page = fs::read_to_string(program.path("r/report.html")).unwrap();
        assert!(page.contains("optimal return") && page.contains(" of 1.00 and "));
    }
}

mod magnitudes {
    use super::*;

    /// `check`, `run` and `compare` refuse alike, and leave nothing behind.
    #[track_caller]
    fn refused(scenario: &str, table: Option<&str>, sets: &[&str], words: &[&str]) {
        let program = Program::new();
        let file = program.file("x.toml", scenario);
        if let Some(table) = table {
            program.file("x.csv", table);
        }
        for command in [
            &["check", file][..],
            &["run", file, "--out", "o"],
            &[
                "compare", file, "--seeds", "0..2", "--arms", "gcn", "--out", "o",
            ],
        ] {
            program.refuses(&[command, sets].concat(), 3, words);
            assert!(!program.path("o").exists());
        }
    }

    const LISTED: &str =
        "[env]\nkind = \"edge-list\"\nfile = \"x.csv\"\nstart = \"a\"\ngoals = [{ at = \"c\" }]\n";

    #[test]
    fn rewards_that_overflow_are_refused_with_their_line() {
        for reward in [
            "1e308",
            "-1.7976931348623157e308",
            "1e200",
            "-1e155",
            "1e30",
        ] {
            let table = format!("from,action,to,reward\na,go,b,-1\nb,go,c,{reward}\n");
            let words = [
                "x.toml:3:8",
                "x.csv, line 3, column reward",
                "too large",
                "1e27",
            ];
            refused(LISTED, Some(&table), &[], &words);
        }
        let table = "from,action,to,reward\na,go,b,-1e-300\nb,go,c,2\n";
        let words = ["x.csv, line 2, column reward", "-1e-300", "too small"];
        refused(LISTED, Some(table), &[], &words);
        // Each alone is small enough; it is the run that is too long.
        let table = "from,action,to,reward\na,go,b,-1\nb,go,c,1e20\n";
        refused(
            LISTED,
            Some(table),
            &["--set", "env.max_steps=100000"],
            &["line 3", "500 episodes of up to 100000 steps"],
        );
    }

    #[test]
    fn rewards_that_overflow_are_refused_with_their_key() {
        refused(
            "[env]\nrows = 3\ncols = 3\nreward = { step = -1e308, goal = -1e308 }\n",
            None,
            &[],
            &["x.toml:4:19", "env.reward.step = -1e308", "at most 1e27"],
        );
        refused(
            "[env]\nrows = 3\ncols = 3\ngoals = [{ at = [2, 2], reward = 1e300 }]\n",
            None,
            &[],
            &["x.toml:4:34", "env.goals[0].reward = 1e300"],
        );
        refused(
            "[env]\nrows = 3\ncols = 3\n",
            None,
            &["--set", "env.reward={ step = -1, goal = 1e100 }"],
            &["--set env.reward=", "env.reward.goal = 1e100"],
        );
        let table = "from,action,to\na,go,b\nb,go,c\n";
        let scenario = LISTED.replace("\"c\" }", "\"c\", reward = 1e99 }");
        let words = ["x.toml:5:31", "env.goals[0].reward = 1e99"];
        refused(&scenario, Some(table), &[], &words);
    }

    #[test]
    fn parameters_beyond_all_returns_are_refused() {
        for (set, words) in [
            (
                "shaping.scale_factor=1e308",
                "1e308: must be a positive number of at most 1e6",
            ),
            (
                "agent.actor_learning_rate=1e300",
                "1e300: must be above 0 and at most 1e27",
            ),
            ("agent.preference_clip=1e28", "agent.preference_clip"),
            ("exploration.bonus=1e308", "exploration.bonus = 1e308"),
            (
                "exploration.potential_advice=1e308",
                "exploration.potential_advice",
            ),
        ] {
            refused(
                "[env]\nrows = 3\ncols = 3\n[agent]\nkind = \"actor-critic\"\n",
                None,
                &["--set", set],
                &["--set ", words],
            );
        }
        let sets = [
            "--set",
            "agent.kind=q-learning",
            "--set",
            "agent.initial_value=-1e200",
        ];
        refused("", None, &sets, &["agent.initial_value = -1e200"]);
        let sets = [
            "--set",
            "agent.kind=planner",
            "--set",
            "agent.optimistic_value=1e200",
        ];
        refused("", None, &sets, &["agent.optimistic_value = 1e200"]);
    }
}

mod read_back {
    use super::*;

    /// No number of a table is infinite or none.
    #[track_caller]
    fn finite(program: &Program, name: &str) {
        let mut reader = csv::Reader::from_path(program.path(name)).unwrap();
        for row in reader.records().map(Result::unwrap) {
            for field in row.iter().filter_map(|field| field.parse::<f64>().ok()) {
                assert!(field.is_finite(), "{name}: {row:?}");
            }
        }
    }

    /// Everything that `run` and `compare` write is read by `report`, `export`, `--resume`, and where there is a map `figures`
    /// draws it.
    #[track_caller]
    fn survives(scenario: &str, table: Option<&str>, sets: &[&str]) {
        let program = Program::new();
        let file = program.file("x.toml", scenario);
        if let Some(table) = table {
            program.file("x.csv", table);
        }
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let call = |arguments: &[&str]| program.prints(&[arguments, &sets].concat());
        call(&["check", file]);
        call(&["run", file, "--out", "r", "-q"]);
        for table in ["episodes", "refreshes", "graph", "timings"] {
            finite(&program, &format!("r/seed-0000/{table}.csv"));
        }
        program.prints(&["report", "r", "-o", "r.html", "-q"]);
        for format in ["csv", "npz", "graphml", "dot"] {
            let out = format!("e-{format}");
            program.prints(&["export", "r", "--to", format, "-o", &out]);
        }
        if table.is_none() {
            call(&["figures", file, "--seeds", "2", "-o", "x.svg", "-q"]);
            let drawn = fs::read_to_string(program.path("x.svg")).unwrap();
            assert!(!drawn.contains("NaN") && !drawn.contains("\"inf"));
        }
        let summary = fs::read(program.path("r/summary.json")).unwrap();
        call(&["run", file, "--out", "r", "--resume", "-q"]);
        assert_eq!(fs::read(program.path("r/summary.json")).unwrap(), summary);
        let compare = [
            "compare",
            file,
            "--seeds",
            "0..3",
            "--arms",
            "gcn,q-learning",
            "-q",
        ];
        call(&[&compare[..], &["--out", "c"]].concat());
        finite(&program, "c/compare.csv");
        program.prints(&["report", "c", "-o", "c.html", "-q"]);
        let numbers = fs::read(program.path("c/compare.json")).unwrap();
        let before = fs::metadata(program.path("c/arms/gcn/seed-0000.json")).unwrap();
        call(&[&compare[..], &["--out", "c", "--resume"]].concat());
        assert_eq!(fs::read(program.path("c/compare.json")).unwrap(), numbers);
        let after = fs::metadata(program.path("c/arms/gcn/seed-0000.json")).unwrap();
        assert_eq!(
            after.modified().unwrap(),
            before.modified().unwrap(),
            "not run again"
        );
    }

    const QUICK: &str = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 30\n";

    const TABLE: &str = "[env]\nkind = \"edge-list\"\nfile = \"x.csv\"\nstart = \"a\"\ngoals = [{ at = \"goal\" }, \
                         { at = \"pit\" }]\n[run]\nepisodes = 30\n";

    #[test]
    fn the_largest_and_the_smallest_rewards() {
        for (most, least) in [
            ("-5e23", "-1"),
            ("1e-30", "-1e-30"),
            ("5e23", "-1e-30"),
            ("-5e23", "-5e23"),
        ] {
            let table = format!(
                "from,action,to,probability,reward\na,short,goal,0.7,{least}\na,short,pit,0.3,{most}\na,long,b,1,{least}\n\
                 b,on,goal,1,{most}\nb,back,a,1,{least}\n"
            );
            survives(TABLE, Some(&table), &[]);
        }
        survives(QUICK, None, &["env.reward={ step = -2e23, goal = 1e-30 }"]);
        survives(QUICK, None, &["env.reward={ step = -1e-30, goal = 0 }"]);
        survives(QUICK, None, &["env.reward={ step = 0, goal = 0 }"]);
    }

    #[test]
    fn the_largest_parameters() {
        for sets in [
            &[
                "shaping.scale_factor=1e6",
                "env.reward={ step = -2e23, goal = 0 }",
            ][..],
            &[
                "agent.actor_learning_rate=1e27",
                "agent.preference_clip=1e27",
                "agent.critic_learning_rate=1",
            ],
            &[
                "agent.update=algorithm-1",
                "agent.actor_learning_rate=1e27",
                "agent.features=pvf",
            ],
            &["exploration.kind=count-bonus", "exploration.bonus=9e26"],
            &[
                "exploration.frontier_advice=9e26",
                "exploration.potential_advice=9e26",
            ],
            &["agent.kind=planner", "agent.optimistic_value=1e27"],
            &[
                "agent.kind=dyna-q",
                "agent.initial_value=-1e27",
                "agent.gamma=0.5",
            ],
        ] {
            survives(QUICK, None, sets);
        }
    }

    /// A learner that diverges is an error of its own, not a folder full of nothing.
    #[test]
    fn what_diverges_says_so() {
        let program = Program::new();
        let file = program.file("x.toml", QUICK);
        for (sets, words) in [
            (&["gcn.learning_rate=1e308"][..], "lower gcn.learning_rate"),
            (
                &[
                    "agent.kind=actor-critic",
                    "agent.features=deepwalk",
                    "deepwalk.learning_rate=1e308",
                ],
                "lower deepwalk.learning_rate",
            ),
        ] {
            let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
            let run = ["run", file, "--out", "o", "--force", "-q"];
            let mut command = program.call(&[&run[..], &sets].concat());
            command
                .assert()
                .code(1)
                .stdout("")
                .stderr(predicate::str::contains(words));
        }
    }
}
