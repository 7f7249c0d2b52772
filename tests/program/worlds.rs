//! Worlds that are not what their author meant, from outside: what is refused, and what `check` says.

use crate::program::Program;
use assert_cmd::assert::Assert;
use predicates::prelude::*;

/// A scenario `x.toml` and an edge list `world.csv` in an empty folder, and what `check` says to them.
struct Checked(Assert);

fn check(scenario: &str, edges: &str) -> Checked {
    let program = Program::new();
    program.file("x.toml", scenario);
    program.file("world.csv", edges);
    let assert = program.call(&["check", "x.toml"]).assert();
    Checked(assert)
}

impl Checked {
    #[track_caller]
    fn refuses(self, words: &[&str]) {
        let mut assert = self.0.code(3).stdout("");
        for word in words {
            assert = assert.stderr(predicate::str::contains(*word));
        }
    }

    /// Accepted, with this optimum and so many warnings, which have these words.
    #[track_caller]
    fn accepts(self, optimum: &str, warnings: usize, words: &[&str]) {
        let assert = self.0.code(0);
        let output = assert.get_output();
        let (out, err) = (&output.stdout, &output.stderr);
        let (out, err) = (String::from_utf8_lossy(out), String::from_utf8_lossy(err));
        assert!(out.contains(optimum), "{out}");
        assert_eq!(err.matches("warning: ").count(), warnings, "{err}");
        for word in words {
            assert!(err.contains(word), "{word}: {err}");
        }
    }
}

fn edge_list(rest: &str) -> String {
    format!("[env]\nkind = \"edge-list\"\nfile = \"world.csv\"\n{rest}\n")
}

#[test]
fn a_quote_left_open_is_refused_on_its_line() {
    let scenario = edge_list("start = \"a\"\ngoals = [{ at = \"c\" }]");
    let header = "from,action,to\na,go,c\n";
    for (line, words) in [
        (
            "a,alt,\"b\nb,go,c\nb,back,a\n",
            "column 7: a quote is not closed",
        ),
        (
            "a,alt,\"b\nb,go,\"c\nb,back,a\n",
            "column 7: a quote is not closed",
        ),
        (
            "a,alt,\"b\"x\nb,go,c\n",
            "column 10: text after a closing quote",
        ),
        (
            "a,alt,b \"x\"\nb,go,c\n",
            "column 9: a quote inside a field",
        ),
    ] {
        let said = ["x.toml:3:8", "world.csv, line 3", words];
        check(&scenario, &format!("{header}{line}")).refuses(&said);
    }
    check(&scenario, "from,action,\"to\na,go,c\n").refuses(&["line 1", "a quote is not closed"]);
    let quoted =
        "\"from\",\"action\",to\r\n\"a\",go,\"the \"\"sea\"\"\"\r\n\"the \"\"sea\"\"\",go,c\r\n";
    check(&scenario, quoted).accepts("2 steps, return -2 ", 0, &[]);
}

#[test]
fn a_reward_that_the_file_leaves_no_room_for_is_refused() {
    let own = edge_list("start = \"a\"\ngoals = [{ at = \"c\", reward = 100.0 }]");
    let all = "from,action,to,probability,reward\na,go,b,1,-1\nb,go,c,1,-1\n";
    let words = [
        "x.toml:5",
        "env.goals[0].reward",
        "means nothing here",
        "\"go\" from \"b\"",
    ];
    check(&own, all).refuses(&words);
    // −1, then −1 and 100.
    let into_goal = all.replace("b,go,c,1,-1", "b,go,c,1,");
    check(&own, &into_goal).accepts("2 steps, return 98 ", 0, &[]);
    let both = format!("{into_goal}a,jump,c,1,5\n");
    check(&own, &both).refuses(&["means nothing here", "\"jump\" from \"a\""]);
    let zero = own.replace("100.0", "0.0");
    check(&zero, all).accepts("2 steps, return -2 ", 0, &[]);

    let scheme =
        |reward: &str| edge_list(&format!("goals = [{{ at = \"c\" }}]\nreward = {reward}"));
    let words = [
        "x.toml:5",
        "env.reward",
        "the bonus of a goal, 100",
        "means nothing here",
    ];
    check(&scheme("\"goal-bonus\""), all).refuses(&words);
    check(&scheme("\"goal-bonus\""), &into_goal).accepts("return 98 ", 0, &[]);
    let words = ["env.reward", "step = -3 means nothing here"];
    check(&scheme("{ step = -3.0, goal = 0.0 }"), all).refuses(&words);
    check(&scheme("\"step-cost\""), all).accepts("return -2 ", 0, &[]);
}

#[test]
fn a_state_may_be_called_what_it_likes() {
    let from_random = edge_list("start = \"random\"\ngoals = [{ at = \"c\" }]");
    // Two steps from the state of that name, one and a half from anywhere.
    let named = "from,action,to\nrandom,go,b\nb,go,c\n";
    check(&from_random, named).accepts(" 2 steps, return -2 ", 0, &[]);
    let unnamed = named.replace("random", "a");
    check(&from_random, &unnamed).accepts(" 1.5 steps, return -1.5 ", 0, &[]);
    let words = "from,action,to\ntop-left,go,farthest\nfarthest,go,random\nrandom,go,center\n";
    for (start, goal, steps) in [
        ("top-left", "center", 3),
        ("farthest", "random", 1),
        ("random", "center", 1),
    ] {
        let text = edge_list(&format!(
            "start = \"{start}\"\ngoals = [{{ at = \"{goal}\" }}]"
        ));
        check(&text, words).accepts(&format!(" {steps} steps, return -{steps} "), 0, &[]);
    }
    let misspelt = edge_list("start = \"a\"\ngoals = [{ at = \"c\" }, { at = \"bb\" }]");
    let words = [
        "x.toml:5",
        "env.goals[1].at",
        "no state is named \"bb\"; did you mean \"b\"?",
    ];
    check(&misspelt, &unnamed).refuses(&words);
}

#[test]
fn a_goal_that_is_not_worth_reaching_is_named() {
    let map = |goal: f64| {
        format!(
            "[env]\nkind = \"ascii\"\nmap = \"S..G\"\nreward = {{ step = -1.0, goal = {goal:.1} }}\n"
        )
    };
    // Three steps to the goal, forty of the limit: it is worth reaching down to −37.
    check(&map(-36.0), "").accepts("3 steps, return -39 ", 0, &[]);
    let words = ["never reaching a goal is best", "-40"];
    check(&map(-38.0), "").accepts("40 steps, return -40 ", 1, &words);
    check(&map(-50.0), "").accepts("40 steps, return -40 ", 1, &words);
    let moved = "[env]\nkind = \"ascii\"\nmap = \"S..G\"\nmoved_goals = [{ at = [0, 2], reward = -60.0 }]\n";
    let words = ["since the goals moved, never reaching a goal is best"];
    check(moved, "").accepts("3 steps, return -3 ", 1, &words);
}

#[test]
fn a_limit_shorter_than_the_way_is_named() {
    let map = |limit: usize, map: &str| {
        format!("[env]\nkind = \"ascii\"\nmap = \"{map}\"\nmax_steps = {limit}\n")
    };
    let words = ["no goal can be reached", "3 steps away", "max_steps is 2"];
    check(&map(2, "S..G"), "").accepts("2 steps, return -2 ", 1, &words);
    check(&map(3, "S..G"), "").accepts("3 steps, return -3 ", 0, &[]);
    let words = [
        "the goal [0, 5] cannot be reached",
        "4 steps away, max_steps is 3",
    ];
    check(&map(3, "G S    G".trim()), "").accepts(
        "2 steps",
        1,
        &["the goal [0, 7]", "5 steps away"],
    );
    check(&map(3, "GS   G"), "").accepts("1 steps", 1, &words);
    // Each step succeeds once in four times: 1 − .75³ = 57.8 % in three steps, 43.75 % in two.
    let coin = "from,action,to,probability\na,go,c,0.25\na,go,a,0.75\n";
    let limit =
        |steps: usize| edge_list(&format!("goals = [{{ at = \"c\" }}]\nmax_steps = {steps}"));
    check(&limit(3), coin).accepts("", 0, &[]);
    check(&limit(2), coin).accepts("", 1, &["43.75 % at best", "max_steps is 2"]);
}

#[test]
fn a_loop_that_pays_for_ever_is_named() {
    let scenario = edge_list("start = \"a\"\ngoals = [{ at = \"c\" }]");
    let header = "from,action,to,probability,reward\n";
    let staying = format!("{header}a,loop,a,1,1\na,go,b,1,-1\nb,go,c,1,-1\n");
    let words = [
        "a loop pays for ever, 1 a step",
        "30 steps",
        "never reaching a goal",
    ];
    check(&scenario, &staying).accepts("30 steps, return 30 ", 2, &words);
    // Half a unit a step there and back; fifteen times round is 15, and 14 times and the goal 14 + 3 + 10.
    let round = format!("{header}a,go,b,1,3\nb,back,a,1,-2\nb,go,c,1,10\n");
    check(&scenario, &round).accepts("return 27 ", 1, &["0.5 a step"]);
    // A round that costs what it pays is no such loop.
    let level = round.replace("-2", "-3");
    check(&scenario, &level).accepts("return 13 ", 0, &[]);
}

#[test]
fn a_continuing_task_is_measured_by_its_gain_and_may_pay_for_ever() {
    let round = "from,action,to,reward\na,on,b,1\na,off,a,0\nb,on,a,4\nb,off,b,-1\n";
    let scenario = edge_list("continuing = true\nmax_steps = 8\n[agent]\ngamma = 0.9");
    check(&scenario, round).accepts("2.5 a step", 0, &[]);
    check(&scenario, round).accepts("8 steps, return 20 ", 0, &[]);
    let endless = scenario.replace("0.9", "1.0");
    check(&endless, round).accepts("2.5 a step", 1, &["agent.gamma below 1"]);
    let planner = endless.clone() + "\nkind = \"planner\"";
    check(&planner, round).accepts("2.5 a step", 0, &[]);
    let trap = "from,action,to,reward\na,on,b,1\nb,on,b,4\n";
    check(&scenario, trap).refuses(&["x.toml:4:14", "\"a\" cannot be reached from \"b\""]);
    let with_goal = scenario.replace("continuing", "goals = [{ at = \"b\" }]\ncontinuing");
    check(&with_goal, round).refuses(&["x.toml:4:9", "episodes end at goals"]);
    let board = |kind: &str| format!("[env]\nkind = \"{kind}\"\ncontinuing = true\n");
    check(&board("cliff"), "").refuses(&["x.toml:3:14", "\"[3, 11]\" is one and can be reached"]);
    check(&board("open"), "").refuses(&["x.toml:3:14", "has goals, where episodes end"]);
}
