//! The scenarios that come with the program: each is what it claims to be.

use eigentrail::scenario::{Scenario, Shipped, World, report_scenarios, shipped};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

fn load(file: &Shipped) -> Scenario {
    let path = format!("scenarios/{}.toml", file.name);
    let loaded = Scenario::load(Path::new(&path), &[]);
    loaded.unwrap_or_else(|error| panic!("{error}")).scenario
}

#[test]
fn every_file_of_the_folder_is_shipped() {
    let listed: BTreeSet<String> = shipped()
        .iter()
        .map(|s| format!("{}.toml", s.name))
        .collect();
    let there: BTreeSet<String> = std::fs::read_dir("scenarios")
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    assert_eq!(listed, there);
}

#[test]
fn every_file_behind_the_figures_is_there_and_valid() {
    let there = std::fs::read_dir("scenarios/report").unwrap();
    assert_eq!(there.count(), report_scenarios().len());
    for file in report_scenarios() {
        let path = format!("scenarios/report/{}.toml", file.name);
        let loaded = Scenario::load(Path::new(&path), &[]);
        let scenario = loaded.unwrap_or_else(|error| panic!("{error}")).scenario;
        assert_eq!(scenario.name, file.name);
        assert!(file.text.starts_with("# Figure ") && file.text.contains("\n# Expect "));
        assert!(file.text.contains("\n#:schema ../schema.json\n"));
    }
}

#[test]
fn every_file_opens_with_what_it_shows_and_what_to_expect() {
    for file in shipped() {
        let mut lines = file.text.lines();
        for what in ["what it shows", "what to expect"] {
            let line = lines.next().unwrap_or_default();
            assert!(
                line.starts_with("# ") && line.len() > 20,
                "{}: {what}: {line}",
                file.name
            );
        }
        assert!(
            file.text.contains("\n#:schema schema.json\n"),
            "{}",
            file.name
        );
    }
}

#[test]
fn every_file_is_valid_and_named_after_itself() {
    for file in shipped() {
        assert_eq!(load(file).name, file.name);
    }
}

#[test]
fn resolving_is_a_fixed_point() {
    for file in shipped() {
        let scenario = load(file);
        let text = scenario.to_toml();
        let path = Path::new("resolved.toml");
        let again = Scenario::parse(path, text.clone(), &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.scenario, scenario, "{}", file.name);
        assert_eq!(again.scenario.to_toml(), text, "{}", file.name);
    }
}

#[test]
fn the_schema_in_the_folder_is_the_present_one() {
    let there = std::fs::read_to_string("scenarios/schema.json").unwrap_or_default();
    let now = serde_json::to_string_pretty(&Scenario::json_schema()).unwrap() + "\n";
    assert!(
        there == now,
        "write it anew: cargo run -- schema > scenarios/schema.json"
    );
}

#[test]
fn the_schema_accepts_every_file_and_no_slips() {
    let schema = Scenario::json_schema();
    for file in shipped() {
        for text in [file.text.to_owned(), load(file).to_toml()] {
            let value: Value = toml::from_str(&text).unwrap();
            accepts(&schema, &schema, &value).unwrap_or_else(|why| panic!("{}: {why}", file.name));
        }
    }
    for slip in [
        "colour = 1",
        "[agent]\ngama = 1.0",
        "[agent]\ngamma = \"high\"",
        "[agent]\nkind = \"robot\"",
        "[env]\nmax_steps = \"none\"",
        "[env]\nstart = 3",
        "[env]\ngoals = [{ on = \"center\" }]",
        "[env]\nreward = { step = 1.0 }",
    ] {
        let value: Value = toml::from_str(slip).unwrap();
        assert!(
            accepts(&schema, &schema, &value).is_err(),
            "the schema accepts {slip}"
        );
    }
}

/// The part of JSON Schema that our schema uses.
fn accepts(root: &Value, schema: &Value, value: &Value) -> Result<(), String> {
    let refuse = |why: &str| Err(format!("{value}: {why}"));
    if let Some(reference) = schema["$ref"].as_str() {
        accepts(root, root.pointer(&reference[1..]).unwrap(), value)?;
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(choices) = schema[key].as_array() {
            let accepted = choices
                .iter()
                .filter(|c| accepts(root, c, value).is_ok())
                .count();
            if accepted == 0 || (key == "oneOf" && accepted > 1) {
                return refuse(&format!("{accepted} of {key} accept it"));
            }
        }
    }
    if !schema["const"].is_null() && schema["const"] != *value {
        return refuse("another constant");
    }
    if let Some(words) = schema["enum"].as_array()
        && !words.contains(value)
    {
        return refuse("none of the words");
    }
    let types: Vec<&str> = match &schema["type"] {
        Value::String(one) => vec![one],
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        _ => vec![],
    };
    let is = |name: &&str| match *name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "null" => value.is_null(),
        other => panic!("a new type in the schema: {other}"),
    };
    if !types.is_empty() && !types.iter().any(is) {
        return refuse(&format!("not of type {types:?}"));
    }
    if let (Some(minimum), Some(number)) = (schema["minimum"].as_f64(), value.as_f64())
        && number < minimum
    {
        return refuse("below the minimum");
    }
    if let Some(items) = value.as_array() {
        let too_few = schema["minItems"]
            .as_u64()
            .is_some_and(|n| (items.len() as u64) < n);
        let too_many = schema["maxItems"]
            .as_u64()
            .is_some_and(|n| (items.len() as u64) > n);
        if too_few || too_many {
            return refuse("wrong length");
        }
        if schema["items"].is_object() {
            items
                .iter()
                .try_for_each(|item| accepts(root, &schema["items"], item))?;
        }
    }
    if let Some(object) = value.as_object() {
        for key in schema["required"].as_array().into_iter().flatten() {
            if !object.contains_key(key.as_str().unwrap()) {
                return refuse(&format!("without {key}"));
            }
        }
        for (key, inner) in object {
            match (&schema["properties"][key], &schema["additionalProperties"]) {
                (property, _) if property.is_object() => accepts(root, property, inner)?,
                (_, Value::Bool(false)) => return refuse(&format!("unknown key {key}")),
                (_, additional) if additional.is_object() => accepts(root, additional, inner)?,
                _ => {}
            }
        }
    }
    Ok(())
}

#[test]
fn any_map_can_be_walked_by_turns_and_nothing_else_can() {
    let parse = |text: &str| Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
    // 3 × 4 cells: five moves, and a turn between them.
    for (map, names, steps) in [
        ("kind = \"open\"\nrows = 3\ncols = 4", 48, 6.0),
        ("kind = \"ascii\"\nmap = \"G.S\"", 12, 4.0),
    ] {
        let text = format!("[env]\nactions = \"turns\"\n{map}");
        let loaded = parse(&text).unwrap_or_else(|e| panic!("{text}: {e}"));
        let world = loaded.worlds.first();
        let World::Listed(_, listed) = world else {
            panic!("{text}: a map")
        };
        assert_eq!((listed.states.len(), world.num_actions()), (names, 3));
        assert_eq!(listed.states[..2], ["0,0,east", "0,0,south"]);
        assert_eq!(listed.actions, ["left", "right", "forward"]);
        assert_eq!(world.optimum().expected_steps, steps);
        assert_eq!(world.max_steps(), 10 * names);
    }
    let moves = parse("[env]\nactions = \"moves\"").unwrap();
    assert_eq!(
        moves.scenario.env,
        parse("").unwrap().scenario.env,
        "moves are the default"
    );
    for kind in ["taxi", "edge-list"] {
        let error = parse(&format!("[env]\nkind = \"{kind}\"\nactions = \"turns\"")).unwrap_err();
        let told =
            format!("env.actions means nothing for kind = \"{kind}\": it belongs to \"open\"");
        assert!(error.to_string().contains(&told), "{error}");
    }
}

#[test]
fn a_board_says_itself_what_others_are_told() {
    let parse = |text: &str| {
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        loaded.map(|loaded| loaded.worlds.first().optimum().expected_return)
    };
    for (text, best) in [
        ("[env]\nkind = \"cliff\"", -13.0),
        ("[env]\nkind = \"bridge\"\nfall = \"swamp\"", -12.0),
        ("[env]\nkind = \"deep-sea\"\nsize = 5\nseed = 3", 0.99),
        // Cut off after two steps, nothing but the near reward is in reach: 5 for each.
        ("[env]\nkind = \"river-swim\"\nmax_steps = 2", 10.0),
    ] {
        let found = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert!((found - best).abs() < 1e-9, "{text}: {found}");
    }
    for (more, told) in [
        (
            "goals = [{ at = \"center\" }]",
            "env.goals means nothing for kind = \"cliff\"",
        ),
        ("start = \"random\"", "env.start means nothing"),
        ("slip = 0.1", "env.slip means nothing"),
        ("reward = \"goal-bonus\"", "env.reward means nothing"),
        (
            "size = 4",
            "it belongs to \"deep-sea\", \"river-swim\", \"frozen-lake\"",
        ),
    ] {
        let error = parse(&format!("[env]\nkind = \"cliff\"\n{more}")).unwrap_err();
        assert!(error.to_string().contains(told), "{more}: {error}");
    }
    let error = parse("[env]\nkind = \"frozen-lake\"\nsize = 5").unwrap_err();
    assert!(
        error.to_string().contains("size = 5: must be 4 or 8"),
        "{error}"
    );
}
