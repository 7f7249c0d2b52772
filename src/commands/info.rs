//! `eigentrail schema | list | new | completions | man`: what the program says of itself.

use super::{BadInput, Ending};
use crate::cli::{Cli, List, New};
use crate::completions;
use crate::output::{print, print_json};
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_complete::Shell;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, presets};
use eigentrail::scenario::{BUILT_IN_ARMS, EnvKind, Scenario, check_name, shipped, template};
use serde_json::{Value, json};

pub fn schema() -> Result<Ending> {
    print(&serde_json::to_string_pretty(&Scenario::json_schema())?);
    Ok(Ending::Done)
}

/// Keys whose words are listed, after the name of the list in JSON.
const LISTED: [(&str, &str, &str); 6] = [
    ("kinds", "env", "kind"),
    ("potentials", "shaping", "potential"),
    ("explorations", "exploration", "kind"),
    ("agents", "agent", "kind"),
    ("updates", "agent", "update"),
    ("features", "agent", "features"),
];

pub fn list(args: &List) -> Result<Ending> {
    match args.json {
        true => print_json(&lists()),
        false => print(&list_text()),
    }
    Ok(Ending::Done)
}

fn list_text() -> String {
    let scenarios = shipped().iter();
    let scenarios = scenarios.map(|scenario| [scenario.name, scenario.shows()]);
    let mut text = format!("scenarios\n{}", described(scenarios));
    let schema = Scenario::json_schema();
    for (_, section, key) in LISTED {
        let choices = choices(&schema, section, key);
        let words = choices.iter().map(|(word, about)| [word.as_str(), about]);
        text += &format!("{section}.{key}\n{}", described(words));
    }
    let arms = BUILT_IN_ARMS.iter().map(|arm| [arm.name, arm.about]);
    text + "compare --arms (a scenario may add its own: [arms.NAME])\n" + &described(arms)
}

/// Names and what they mean, in lines that fit the terminal.
fn described<'a>(rows: impl Iterator<Item = [&'a str; 2]>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).add_rows(rows);
    if let Some(width) = super::terminal_width() {
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(u16::try_from(width).unwrap_or(u16::MAX));
    }
    let names = table.column_mut(0).expect("rows have two columns");
    names.set_padding((2, 0));
    names.set_constraint(ColumnConstraint::ContentWidth);
    table.trim_fmt() + "\n"
}

/// `list --json`
fn lists() -> Value {
    let entry = |name: &str, about: &str| json!({ "name": name, "description": about });
    let scenarios = shipped().iter();
    let scenarios = scenarios.map(|scenario| entry(scenario.name, scenario.shows()));
    let mut lists = json!({ "scenarios": scenarios.collect::<Vec<_>>() });
    let schema = Scenario::json_schema();
    for (list, section, key) in LISTED {
        let words = choices(&schema, section, key).into_iter();
        lists[list] = words.map(|(word, about)| entry(&word, &about)).collect();
    }
    let arms = BUILT_IN_ARMS.iter().map(|arm| {
        let mut entry = entry(arm.name, arm.about);
        entry["settings"] = json!(arm.settings);
        entry
    });
    lists["arms"] = arms.collect();
    lists
}

/// The words that a key may have, with the first line of what they mean.
fn choices(schema: &Value, section: &str, key: &str) -> Vec<(String, String)> {
    let section = resolve(schema, &schema["properties"][section]);
    let key = resolve(schema, &section["properties"][key]);
    let alternatives = key["oneOf"].as_array().into_iter().flatten();
    alternatives
        .filter_map(|choice| {
            let word = choice["const"].as_str()?;
            let about = choice["description"].as_str().unwrap_or_default();
            let first = about.lines().next().unwrap_or_default();
            Some((word.to_owned(), first.to_owned()))
        })
        .collect()
}

fn resolve<'a>(schema: &'a Value, value: &'a Value) -> &'a Value {
    let pointer = value["$ref"].as_str().and_then(|r| r.strip_prefix('#'));
    pointer.and_then(|p| schema.pointer(p)).unwrap_or(value)
}

pub fn new(args: &New) -> Result<Ending> {
    check_name(&args.name).map_err(|rule| BadInput(rule.message))?;
    let named = EnvKind::ALL
        .into_iter()
        .find(|kind| kind.name() == args.name);
    print(&template(&args.name, args.kind.or(named)));
    Ok(Ending::Done)
}

pub fn completions(shell: Shell) -> Result<Ending> {
    let script = completions::script(&shell.to_string());
    let script = script.context("there is no script for this shell")??;
    print(&String::from_utf8_lossy(&script));
    Ok(Ending::Done)
}

/// The page of the program, then one for each subcommand.
pub fn man() -> Result<Ending> {
    let mut program = Cli::command();
    let mut pages = Vec::new();
    clap_mangen::Man::new(program.clone()).render(&mut pages)?;
    program.build(); // tells the subcommands whose they are
    for subcommand in program.get_subcommands() {
        clap_mangen::Man::new(subcommand.clone()).render(&mut pages)?;
    }
    print(&String::from_utf8_lossy(&pages));
    Ok(Ending::Done)
}
