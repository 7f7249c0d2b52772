//! A new scenario with every key, its default and what it means, from the types themselves.

use super::Scenario;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

/// Longest line of a comment.
const WIDTH: usize = 110;

/// A scenario file that says what every key means. The keys are commented out: what is not said keeps its default.
pub fn template(name: &str) -> String {
    let schema = Scenario::json_schema();
    let mut defaults = Scenario::default();
    defaults.complete(Path::new(name));
    let defaults = toml::Table::try_from(&defaults).expect("a scenario is a table");
    let mut text = format!(
        "# {name}: what it shows.\n# What to expect.\n\nname = {}\n",
        toml::Value::from(name)
    );
    for (section, about) in properties(&schema, &schema) {
        let Some(section_default) = defaults.get(&section).and_then(toml::Value::as_table) else {
            continue;
        };
        let _ = write!(text, "\n{}[{section}]\n", comment(&about));
        let keys = properties(&schema, resolve(&schema, &schema["properties"][&section]));
        for (key, about) in keys {
            let value = section_default.get(&key);
            let assignment = value.map_or_else(|| format!("{key} ="), |v| format!("{key} = {v}"));
            let _ = write!(text, "{}#{assignment}\n", comment(&about));
        }
    }
    text
}

/// Names and descriptions of an object's properties, in the order of the types.
fn properties(schema: &Value, object: &Value) -> Vec<(String, String)> {
    let properties = object["properties"].as_object().into_iter().flatten();
    properties
        .map(|(name, property)| {
            let own = property["description"].as_str();
            let referred = resolve(schema, property)["description"].as_str();
            (name.clone(), own.or(referred).unwrap_or_default().to_owned())
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
