//! `eigentrail inspect`

use super::Ending;
use crate::cli;
use crate::output::{print, print_json};
use anyhow::Result;
use comfy_table::{Table, presets};
use eigentrail::archive::Checkpoint;
use eigentrail::error::Error;
use eigentrail::report::grouped;
use serde::Serialize;

/// What a checkpoint is of, as `inspect --json` prints it.
#[derive(Serialize)]
struct Facts<'a> {
    program: &'a str,
    scenario: String,
    seed: u64,
    steps: u64,
    episodes: usize,
    states: usize,
    /// Of the whole file.
    bytes: u64,
}

/// Reading it is the check: a checkpoint that is damaged is refused with the reason.
pub fn inspect(args: &cli::Inspect) -> Result<Ending> {
    let checkpoint = Checkpoint::read(&args.checkpoint).map_err(Error::from)?;
    let facts = Facts {
        program: &checkpoint.program,
        scenario: name(&checkpoint.scenario),
        seed: checkpoint.seed,
        steps: checkpoint.steps,
        episodes: checkpoint.episodes,
        states: checkpoint.states,
        bytes: args.checkpoint.metadata()?.len(),
    };
    match args.json {
        true => print_json(&facts),
        false => print(&table(&facts)),
    }
    Ok(Ending::Done)
}

/// The name in a scenario with every default.
fn name(scenario: &str) -> String {
    let table: toml::Table = scenario.parse().unwrap_or_default();
    let name = table.get("name").and_then(|name| name.as_str());
    name.unwrap_or_default().to_owned()
}

fn table(facts: &Facts<'_>) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["checkpoint", "whole"]);
    let count = |number: u64| grouped(number);
    for (name, value) in [
        ("written by", facts.program.to_owned()),
        ("scenario", facts.scenario.clone()),
        ("seed", facts.seed.to_string()),
        ("steps", count(facts.steps)),
        ("episodes ended", count(facts.episodes as u64)),
        ("states known", count(facts.states as u64)),
        ("bytes", count(facts.bytes)),
    ] {
        table.add_row([name, &value]);
    }
    table.trim_fmt()
}
