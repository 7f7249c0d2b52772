//! A new scenario with every key, its default and what it means, from the types themselves.

use super::{EnvKind, EnvParams, GoalSpec, Goals, Place, Scenario, Start};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// Longest line of a comment.
const WIDTH: usize = 110;

/// A scenario file that says what every key means. The keys are commented out: what is not said keeps its default. With a kind
/// of world, the keys that make one of it are not, and those of other kinds are left out.
pub fn template(name: &str, kind: Option<EnvKind>) -> String {
    let schema = Scenario::json_schema();
    let world = kind.map(world_of).unwrap_or_default();
    let defaults = examples();
    let mut text = format!(
        "# {name}: what it shows.\n# What to expect.\n\nname = {}\n",
        toml::Value::from(name)
    );
    if kind == Some(EnvKind::EdgeList) {
        text += EDGE_LIST;
    }
    for (section, about) in properties(&schema, &schema) {
        let Some(section_default) = defaults.get(&section).and_then(toml::Value::as_table) else {
            continue;
        };
        let _ = writeln!(text, "\n{}[{section}]", comment(&about));
        let object = resolve(&schema, &schema["properties"][&section]);
        for (key, about) in properties(&schema, object) {
            if section == "env" && kind.is_some_and(|kind| !kind.has_use_for(&key)) {
                continue;
            }
            let about = about + &choices(&schema, &object["properties"][&key]);
            if let Some(value) = world.get(&key).filter(|_| section == "env") {
                let _ = writeln!(text, "{}{key} = {value}", comment(&about));
                continue;
            }
            let assignment = match section_default.get(&key) {
                Some(value) => format!("{key} = {value}"),
                None => format!("{key} = {}{NOT_SET}", example(&object["properties"][&key])),
            };
            let _ = writeln!(text, "{}#{assignment}", comment(&about));
        }
    }
    text + ARMS
}

/// The end of a line whose key has no default.
const NOT_SET: &str = "    # not set; for example";

/// Arms have names of their own, so that there is no table to list the keys of.
const ARMS: &str = "
# Arms of your own for `compare --arms`, beside those that are built in (see `list`): each begins as its base, or as this
# scenario if it names none, and sets keys of any section but [env] and [run].
#[arms.steep]
#base = \"gcn\"
#about = \"a potential twice as steep\"
#\"shaping.scale_factor\" = 8.0
";

/// What stands beside a scenario of an edge list.
const EDGE_LIST: &str = "
# The edges stand in a CSV file beside this one, and start and goals name states of it. Here, in world.csv:
#
#from,action,to,probability,reward
#hall,north,kitchen,0.9,
#hall,north,hall,0.1,
#hall,east,stairs,,-2
#kitchen,east,garden,,
#stairs,down,garden,,
#
# probability and reward may be left out. With from,to alone each line is an action of its own.
";

/// The keys of [env] that make a world of this kind.
fn world_of(kind: EnvKind) -> toml::Table {
    let mut env = EnvParams {
        kind,
        ..EnvParams::default()
    };
    match kind {
        EnvKind::Ascii => env.map = Some("S..#\n...G\n".to_owned()),
        EnvKind::EdgeList => {
            env.file = Some("world.csv".into());
            let starts = ["hall", "kitchen"].map(|name| Place::from(name).into());
            env.start = Some(Start::Drawn(starts.to_vec()));
            let goal = GoalSpec {
                at: Place::from("garden"),
                reward: None,
            };
            env.goals = Some(Goals::Listed(vec![goal]));
        }
        _ => {}
    }
    env.fill_defaults();
    let mut keys = toml::Table::try_from(&env).expect("a section is a table");
    let shared = ["kind", "start", "goals"];
    keys.retain(|key, _| shared.contains(&key) || kind.own_keys().contains(&key));
    keys
}

/// The first example that the schema gives for a property, as TOML on one line.
fn example(property: &Value) -> String {
    let example = &property["examples"][0];
    match toml::Value::try_from(example) {
        // Of strings JSON's notation is TOML's too, and keeps line breaks as escapes.
        Ok(value) if !value.is_str() => value.to_string(),
        _ => example.to_string(),
    }
}

/// The default of every key that has one; of keys that belong to some kinds of worlds, that of the first such kind.
fn examples() -> toml::Table {
    let of_kind = |kind: EnvKind| {
        let mut scenario = Scenario::default();
        scenario.env.kind = kind;
        scenario.complete(Path::new(""));
        toml::Table::try_from(&scenario).expect("a scenario is a table")
    };
    let mut defaults = of_kind(EnvKind::default());
    for kind in EnvKind::ALL {
        let other = of_kind(kind);
        if let (Some(env), Some(toml::Value::Table(more))) =
            (defaults["env"].as_table_mut(), other.get("env"))
        {
            for (key, value) in more {
                env.entry(key).or_insert_with(|| value.clone());
            }
        }
    }
    defaults
}

/// Names and descriptions of an object's properties, in the order of the types.
fn properties(schema: &Value, object: &Value) -> Vec<(String, String)> {
    let properties = object["properties"].as_object().into_iter().flatten();
    properties
        .map(|(name, property)| {
            let own = property["description"].as_str();
            let referred = resolve(schema, property)["description"].as_str();
            (
                name.clone(),
                own.or(referred).unwrap_or_default().to_owned(),
            )
        })
        .collect()
}

/// The end of a comment: the words that a key may have, if it may have any.
fn choices(schema: &Value, property: &Value) -> String {
    let mut words = Vec::new();
    let are_all = collect_words(schema, property, &mut words);
    let words: Vec<String> = words.into_iter().map(|word| format!("{word:?}")).collect();
    match (words.as_slice(), are_all) {
        ([] | [_], _) => String::new(), // what else there is, the description says
        (words, true) => format!(" One of: {}.", words.join(", ")),
        (words, false) => format!(" Its words: {}.", words.join(", ")),
    }
}

/// Adds the words that `value` allows. Whether it allows nothing else.
fn collect_words<'a>(schema: &'a Value, value: &'a Value, words: &mut Vec<&'a str>) -> bool {
    let value = resolve(schema, value);
    let word = value["const"].as_str();
    words.extend(word);
    let alternatives = ["oneOf", "anyOf"].map(|kind| value[kind].as_array());
    let alternatives: Vec<&Value> = alternatives.into_iter().flatten().flatten().collect();
    let mut are_all = word.is_some() || value["type"] == "null" || !alternatives.is_empty();
    for alternative in alternatives {
        are_all &= collect_words(schema, alternative, words);
    }
    are_all
}

/// What a `$ref` refers to; the value itself, if it is none.
fn resolve<'a>(schema: &'a Value, value: &'a Value) -> &'a Value {
    let reference = value["$ref"].as_str();
    let pointer = reference.and_then(|r| r.strip_prefix('#'));
    pointer.and_then(|p| schema.pointer(p)).unwrap_or(value)
}

/// The text as comment lines.
fn comment(about: &str) -> String {
    let mut lines = String::new();
    let mut line = String::from("#");
    for word in about.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH {
            lines += &line;
            lines.push('\n');
            line = String::from("#");
        }
        line.push(' ');
        line += word;
    }
    if line.len() > 1 {
        lines += &line;
        lines.push('\n');
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: String) -> Scenario {
        let loaded = Scenario::parse(Path::new("x.toml"), text, &[]);
        loaded.unwrap_or_else(|error| panic!("{error}")).scenario
    }

    /// The template with the `#` of those assignments removed that `wanted` picks by section and line.
    fn uncommented(wanted: impl Fn(&str, &str) -> bool) -> String {
        let mut section = String::new();
        let mut text = String::new();
        for line in template("x", None).lines() {
            let bare = line.strip_prefix('#').filter(|bare| !bare.starts_with(' '));
            if let Some(header) = bare.unwrap_or(line).strip_prefix('[') {
                section = header.trim_end_matches(']').to_owned();
            }
            let taken = bare.filter(|bare| wanted(&section, bare));
            text += taken.unwrap_or(line);
            text.push('\n');
        }
        text
    }

    #[test]
    fn a_template_is_the_default_scenario_and_so_is_each_line_of_it() {
        let empty = parse(String::new());
        assert_eq!(
            Scenario {
                name: "x".to_owned(),
                ..empty.clone()
            },
            parse(template("x", None))
        );
        // Uncommented, every key that applies to the default kind must still mean the default.
        let foreign = [
            "room",
            "doors",
            "corridor",
            "loops",
            "fill",
            "rounds",
            "size",
            "stochastic",
            "fall",
            "seed = 0",
        ];
        let text = uncommented(|section, line| {
            let other_kind = section == "env" && foreign.iter().any(|f| line.starts_with(f));
            !other_kind && !line.ends_with(NOT_SET) && !section.starts_with("arms")
        });
        assert!(text.contains("\nnum_eigenpairs = "), "{text}");
        assert_eq!(parse(text), empty);
    }

    #[test]
    fn a_template_of_a_kind_is_a_scenario_of_it() {
        for kind in EnvKind::ALL {
            let folder = tempfile::tempdir().unwrap();
            let text = template("x", Some(kind));
            // The example of a file is one that goes with the keys.
            let csv = text.lines().skip_while(|line| !line.starts_with("#from,"));
            let csv = csv.map_while(|line| line.strip_prefix('#').filter(|row| !row.is_empty()));
            let rows: String = csv.map(|row| format!("{row}\n")).collect();
            std::fs::write(folder.path().join("world.csv"), rows).unwrap();
            let loaded = Scenario::parse(&folder.path().join("x.toml"), text.clone(), &[]);
            let mut made = loaded.unwrap_or_else(|error| panic!("{error}")).scenario;
            assert_eq!(made.env.kind, kind);
            for key in kind.own_keys().iter().filter(|key| **key != "rewards") {
                assert!(
                    text.contains(&format!("\n{key} = ")),
                    "{}: {key}",
                    kind.name()
                );
            }
            assert_eq!(text.contains("doors = "), kind == EnvKind::Rooms);
            if !matches!(kind, EnvKind::Ascii | EnvKind::EdgeList) {
                // What is written out is the default of the kind.
                let bare = format!("name = \"x\"\n[env]\nkind = \"{}\"\n", kind.name());
                made.env.fill_defaults();
                assert_eq!(made, parse(bare));
            }
        }
    }

    #[test]
    fn the_arm_and_every_example_can_be_uncommented() {
        let arms = uncommented(|section, _| section.starts_with("arms"));
        assert_eq!(parse(arms).arms["steep"].base.as_deref(), Some("gcn"));
        let text = template("x", None);
        let examples: Vec<&str> = text.lines().filter(|l| l.ends_with(NOT_SET)).collect();
        assert!(examples.len() > 5, "{examples:?}");
        for example in examples {
            let text = uncommented(|_, line| example[1..] == *line);
            let table: toml::Table = toml::from_str(&text).unwrap_or_else(|e| panic!("{e}"));
            let value = |name: &str| table.get(name).and_then(toml::Value::as_table);
            let set: usize = ["env", "shaping", "agent", "exploration"]
                .iter()
                .filter_map(|s| value(s))
                .map(toml::Table::len)
                .sum();
            assert_eq!(set, 1, "{example}");
            // Types are right; what else the key needs (another kind, a file) is for the scenario to say.
            if let Err(error) = Scenario::parse(Path::new("x.toml"), text, &[]) {
                let message = error.to_string();
                let section = ["env.", "shaping."].iter().any(|s| message.contains(s));
                assert!(section, "{example}: {message}");
                assert!(!message.contains("invalid"), "{example}: {message}");
            }
        }
    }
}
