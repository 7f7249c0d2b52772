//! A new scenario with every key, its default and what it means, from the types themselves.

use super::{EnvKind, Scenario};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// Longest line of a comment.
const WIDTH: usize = 110;

/// A scenario file that says what every key means. The keys are commented out: what is not said keeps its default.
pub fn template(name: &str) -> String {
    let schema = Scenario::json_schema();
    let defaults = examples();
    let mut text = format!(
        "# {name}: what it shows.\n# What to expect.\n\nname = {}\n",
        toml::Value::from(name)
    );
    for (section, about) in properties(&schema, &schema) {
        let Some(section_default) = defaults.get(&section).and_then(toml::Value::as_table) else {
            continue;
        };
        let _ = writeln!(text, "\n{}[{section}]", comment(&about));
        let keys = properties(&schema, resolve(&schema, &schema["properties"][&section]));
        for (key, about) in keys {
            let assignment = match section_default.get(&key) {
                Some(value) => format!("{key} = {value}"),
                None => format!("{key} =    # not set"),
            };
            let _ = writeln!(text, "{}#{assignment}", comment(&about));
        }
    }
    text
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

    #[test]
    fn a_template_is_the_default_scenario_and_so_is_each_line_of_it() {
        let path = Path::new("x.toml");
        let text = template("x");
        let plain = Scenario::parse(path, text.clone(), &[]).unwrap().scenario;
        let empty = Scenario::parse(path, String::new(), &[]).unwrap().scenario;
        assert_eq!(plain, empty);
        // Uncommented, every key that applies to the default kind must still mean the default.
        let own = |line: &&str| {
            line.starts_with('#') && !line.starts_with("# ") && !line.ends_with("# not set")
        };
        let foreign = [
            "room", "doors", "corridor", "loops", "fill", "rounds", "seed = 0",
        ];
        let mut in_env = false;
        let uncommented: Vec<&str> = text
            .lines()
            .filter_map(|line| {
                in_env = if line.starts_with('[') {
                    line == "[env]"
                } else {
                    in_env
                };
                match line {
                    _ if !own(&line) => Some(line),
                    _ if in_env && foreign.iter().any(|f| line[1..].starts_with(f)) => None,
                    _ => Some(&line[1..]),
                }
            })
            .collect();
        let text = uncommented.join("\n");
        assert!(text.contains("\nnum_eigenpairs = "), "{text}");
        let full = Scenario::parse(path, text, &[]).unwrap().scenario;
        assert_eq!(full, empty);
    }
}
