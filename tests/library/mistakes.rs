//! Every mistake of a scenario is told at once, and nothing that only follows from one.

use eigentrail::scenario::{Scenario, ScenarioError};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn refused(text: &str, sets: &[&str]) -> ScenarioError {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    Scenario::parse(Path::new("x.toml"), text.to_owned(), &sets).unwrap_err()
}

fn keys(refused: &ScenarioError) -> Vec<&str> {
    let mistakes = refused.mistakes.iter();
    mistakes.filter_map(|mistake| mistake.key()).collect()
}

#[test]
fn every_place_of_a_list_is_told() {
    let text = "[env]\nstart = [9, 9]\ngoals = [[1, 9], { at = [9, 2] }, \"center\", [8, 8]]\n\
                hazards = [{ at = [77, 7], reward = -1 }, { at = [1, 78], reward = -1 }]\nrows = 5\ncols = 5\n";
    let refused = refused(text, &[]);
    insta::assert_snapshot!(refused, @"
    x.toml:2:9: env.start: [9, 9] is outside the map, which has 5 rows and 5 columns counted from 0
    x.toml:3:10: env.goals[0]: [1, 9] is outside the map, which has 5 rows and 5 columns counted from 0
    x.toml:3:25: env.goals[1].at: [9, 2] is outside the map, which has 5 rows and 5 columns counted from 0
    x.toml:3:45: env.goals[3]: [8, 8] is outside the map, which has 5 rows and 5 columns counted from 0
    x.toml:4:19: env.hazards[0].at: [77, 7] is outside the map, which has 5 rows and 5 columns counted from 0
    x.toml:4:50: env.hazards[1].at: [1, 78] is outside the map, which has 5 rows and 5 columns counted from 0
    6 mistakes in x.toml
    ");
}

#[test]
fn every_wrong_character_of_a_map_is_told_and_every_line_of_a_file() {
    let map = "[env]\nkind = \"ascii\"\nmap = \"S?.\\n.x.\\n..3\"\n";
    insta::assert_snapshot!(refused(map, &[]), @"
    x.toml:3:7: env.map: map line 1, column 2: unknown character '?'; use # (wall), . or space (free), S (start), G or 1-9 (goals), ^ v < > (one-way)
    x.toml:3:7: env.map: map line 2, column 2: unknown character 'x'; use # (wall), . or space (free), S (start), G or 1-9 (goals), ^ v < > (one-way)
    x.toml:3:7: env.map: map line 3, column 3: goal 3 has no reward; add 3 = NUMBER to the table of rewards
    3 mistakes in x.toml
    ");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.csv");
    std::fs::write(&file, "from,action,to\na,0,b\nb,x\n,0,c\nb,0,c,d,e\n").unwrap();
    let text = format!("[env]\nkind = \"edge-list\"\nfile = {file:?}\ngoals = [\"c\"]\n");
    let refused = refused(&text, &[])
        .to_string()
        .replace(&file.display().to_string(), "x.csv");
    insta::assert_snapshot!(refused, @r#"
    x.toml:3:8: env.file: x.csv, line 3: 2 fields where the header has 3
    x.toml:3:8: env.file: x.csv, line 4: the column "from" is empty: every edge needs a name there
    x.toml:3:8: env.file: x.csv, line 5: 5 fields where the header has 3
    3 mistakes in x.toml
    "#);
}

#[test]
fn a_key_without_its_section_is_found_one() {
    let refused = refused("gamma = 0.9\n[run]\n", &["seed=3"]);
    insta::assert_snapshot!(refused, @"
    x.toml:1:1: unknown key `gamma`; did you mean `agent.gamma`?
    --set seed=3: unknown key `seed`; did you mean `run.seed`?
    2 mistakes in x.toml
    ");
}

/// To find the next mistake everything is read again: a file that is something else altogether is not read a thousand times.
#[test]
fn a_hundred_mistakes_are_enough() {
    let keys: String = (0..3000).map(|key| format!("key_{key} = 1\n")).collect();
    let refused = refused(&format!("[agent]\n{keys}"), &[]);
    assert_eq!(refused.mistakes.len(), 100);
    assert!(
        refused
            .to_string()
            .ends_with("100 mistakes in x.toml, and perhaps more")
    );
}

/// Slips of every kind in every section.
const MANY: &str = r#"name = "my world"
[env]
kind = "romos"
room = [5, 5]
slip = 2.0
strat = "top-left"
goals = [{ at = "bottom-right", rewrad = 3 }, { att = "center" }]
[spectral]
num_eigenpairs = "many"
tol = 0
[agent]
gama = 1.0
kind = "q-leaning"
epsilon = 7
[shaping]
scale_factor = -1
potental = "file"
file = "x.csv"
[run]
episodes = 0
[colours]
[arms.steep]
base = "gnc"
shaping.scale_facto = 2
agent.gamma = 3
env.slip = 0.1
"#;

#[test]
fn every_mistake_is_told_in_the_order_of_the_file() {
    let refused = refused(MANY, &["agent.gammma=1", "run.seed=-3", "nonsense"]);
    insta::assert_snapshot!(refused, @r#"
    x.toml:1:8: name = "my world" names a folder: use letters, digits, -, _ and ., and no . at the beginning
    x.toml:3:8: `env.kind` cannot be "romos"; did you mean `rooms`?
    x.toml:5:8: env.slip: slip = 2: a probability from 0 up to, but not including, 1
    x.toml:6:1: unknown key `env.strat`; did you mean `start`?
    x.toml:7:33: unknown key `env.goals[0].rewrad`; did you mean `reward`?
    x.toml:7:49: unknown key `env.goals[1].att`; did you mean `at`?
    x.toml:9:18: `spectral.num_eigenpairs`: invalid type: string "many", expected a whole number from 0
    x.toml:10:7: spectral.tol = 0: must be above 0 and below 1
    x.toml:12:1: unknown key `agent.gama`; did you mean `gamma`?
    x.toml:13:8: `agent.kind` cannot be "q-leaning"; did you mean `q-learning`?
    x.toml:14:11: agent.epsilon = 7: must be within 0 and 1
    x.toml:16:16: shaping.scale_factor = -1: must be a positive number of at most 1e6
    x.toml:17:1: unknown key `shaping.potental`; did you mean `potential`?
    x.toml:20:12: run.episodes = 0: must be 1 to 1000000000
    x.toml:21:2: unknown key `colours`; it is one of name, env, spectral, deepwalk, gcn, shaping, exploration, agent, schedule, run, arms
    x.toml:23:8: arms.steep.base: there is no arm `gnc`; did you mean `gcn`?
    x.toml:24:23: unknown key `shaping.scale_facto`; did you mean `scale_factor`?
    x.toml:25:15: agent.gamma = 3: must be within 0 and 1
    x.toml:26:12: arms.steep.env.slip: an arm cannot change [env]: all arms see the same world for as long, or they could not be compared
    --set nonsense: not valid TOML: an assignment looks like section.key=value
    --set agent.gammma=1: unknown key `agent.gammma`; did you mean `gamma`?
    --set run.seed=-3: `run.seed`: invalid value: integer `-3`, expected a whole number from 0
    22 mistakes in x.toml
    "#);
    assert_eq!(refused.scenario, None, "its name is one of the mistakes");
}

#[test]
fn one_mistake_is_one_line() {
    let refused = refused("name = \"mine\"\n[agent]\ngama = 1.0\n", &[]);
    assert_eq!(
        refused.to_string(),
        "x.toml:3:1: unknown key `agent.gama`; did you mean `gamma`?"
    );
    assert_eq!(refused.scenario.as_deref(), Some("mine"));
}

#[test]
fn what_only_follows_from_a_mistake_is_not_told() {
    for (text, expected) in [
        // The start would be outside a map of the default size.
        (
            "[env]\nrows = \"wide\"\nstart = [20, 3]\n",
            vec!["env.rows"],
        ),
        ("[env]\nkind = \"rom\"\nroom = [3, 3]\n", vec!["env.kind"]),
        (
            "[env]\nkinnd = \"rooms\"\nroom = [3, 3]\n",
            vec!["env.kinnd"],
        ),
        ("[env]\nkind = \"ascii\"\nmpa = \"S.G\"\n", vec!["env.mpa"]),
        (
            "[env]\ngoals = [{ at = 3 }, { at = \"center\" }]\n",
            vec!["env.goals[0].at"],
        ),
        ("[env]\nstart = [1, \"x\"]\n", vec!["env.start"]),
        (
            "[env]\nmoved_goals = [{ at = \"center\" }]\ngoals_move_after = 600\n[run]\nepisodes = -1\n",
            vec!["run.episodes"],
        ),
        (
            "[shaping]\npotential = \"fil\"\nfile = \"phi.csv\"\n",
            vec!["shaping.potential", "shaping.file"],
        ),
        // What goes with others is told where these are sound.
        (
            "[env]\nkind = \"ascii\"\nslip = 2\n[agent]\ngamma = 2\n",
            vec!["env.map", "env.slip", "agent.gamma"],
        ),
        (
            "[env]\nroom = [3, 3]\nloops = 1\n",
            vec!["env.room", "env.loops"],
        ),
    ] {
        assert_eq!(keys(&refused(text, &[])), expected, "{text}");
    }
}

#[test]
fn elements_of_lists_keep_their_numbers() {
    let text = "[env]\nrows = 5\ncols = 5\ngoals = [{ at = [9, 9] }, { at = \"center\" }, { at = [8, 8] }]\n";
    let refused = refused(text, &[]);
    assert_eq!(keys(&refused), ["env.goals[0].at", "env.goals[2].at"]);
    let second = refused.mistakes[1].to_string();
    let begins = "x.toml:4:53: env.goals[2].at: [8, 8] is outside the map";
    assert!(second.starts_with(begins), "{second}");
}

#[test]
fn every_line_that_is_not_toml_is_told() {
    let refused = refused(
        "[agent]\ngamma = = 1\n[run]\nepisodes = 3\nepisodes = 4\n",
        &[],
    );
    let lines: Vec<String> = refused.mistakes.iter().map(|m| m.to_string()).collect();
    assert!(
        lines[0].starts_with("x.toml:2:9: not valid TOML"),
        "{lines:?}"
    );
    assert!(
        lines[1].starts_with("x.toml:5:1: not valid TOML"),
        "{lines:?}"
    );
}

/// Section, key, value: each is one mistake, whatever the others are.
const PLANTS: [(&str, &str, &str); 38] = [
    ("", "name", "\"a b\""),
    ("colours", "red", "1"),
    ("env", "slip", "2"),
    ("env", "rows", "\"x\""),
    ("env", "reward", "\"stepcosts\""),
    ("env", "max_steps", "0"),
    ("env", "colour", "1"),
    ("env", "start", "3"),
    ("env", "kind", "\"opne\""),
    ("env", "actions", "\"jumps\""),
    ("spectral", "tol", "0"),
    ("spectral", "num_eigenpairs", "0"),
    ("spectral", "laplacian", "\"normal\""),
    ("spectral", "threads", "true"),
    ("spectral", "tolerance", "1"),
    ("deepwalk", "window", "0"),
    ("deepwalk", "dimensions", "\"a\""),
    ("gcn", "hidden_dim", "0"),
    ("gcn", "learning_rate", "-1"),
    ("gcn", "features", "\"pvv\""),
    ("shaping", "mix", "2"),
    ("shaping", "scale_factor", "0"),
    ("shaping", "potential", "\"gnc\""),
    ("shaping", "temprature", "1"),
    ("exploration", "kind", "\"fronteir\""),
    ("exploration", "search_share", "1"),
    ("exploration", "order", "3"),
    ("agent", "gamma", "7"),
    ("agent", "gama", "1"),
    ("agent", "kind", "\"sarssa\""),
    ("agent", "update", "\"advantages\""),
    ("agent", "time_bonus", "\"a\""),
    ("schedule", "growth", "0"),
    ("schedule", "refit_every", "0"),
    ("schedule", "refit_share", "-1"),
    ("run", "episodes", "0"),
    ("run", "seed", "-1"),
    ("run", "sed", "1"),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// In the file or on the command line, in any company.
    #[test]
    fn exactly_the_planted_mistakes_are_found(
        planted in prop::collection::vec(prop::option::weighted(0.3, any::<bool>()), PLANTS.len())
    ) {
        let mut sections: BTreeMap<&str, String> = BTreeMap::new();
        let (mut sets, mut expected) = (Vec::new(), BTreeSet::new());
        for (&(section, key, value), &where_to) in PLANTS.iter().zip(&planted) {
            let Some(in_file) = where_to else { continue };
            let path = if section.is_empty() { key.to_owned() } else { format!("{section}.{key}") };
            if in_file {
                *sections.entry(section).or_default() += &format!("{key} = {value}\n");
            } else {
                sets.push(format!("{path}={value}"));
            }
            expected.insert(if section == "colours" { section.to_owned() } else { path });
        }
        let text: String = sections
            .iter()
            .map(|(section, keys)| match *section {
                "" => keys.clone(),
                section => format!("[{section}]\n{keys}"),
            })
            .collect();
        let parsed = Scenario::parse(Path::new("x.toml"), text, &sets);
        let found: BTreeSet<String> = match &parsed {
            Ok(_) => BTreeSet::new(),
            Err(refused) => keys(refused).into_iter().map(str::to_owned).collect(),
        };
        prop_assert_eq!(found, expected);
    }
}
