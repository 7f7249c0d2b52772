//! `eigentrail check`

use super::Ending;
use crate::cli;
use crate::output::print;
use anyhow::Result;
use comfy_table::{Table, presets};
use eigentrail::error::Error;
use eigentrail::report::grouped;
use eigentrail::runner::{estimated_bytes, require_memory};
use eigentrail::scenario::{ArmParams, Loaded, Scenario, World, Worlds};
use eigentrail::telemetry::say;

pub fn check(args: &cli::Check) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    if args.resolved {
        print(&loaded.scenario.to_toml());
    } else {
        print(&summary(&loaded)?);
        warn_of(&loaded.worlds);
    }
    Ok(Ending::Done)
}

/// Says on stderr what the author of the world may not have meant.
fn warn_of(worlds: &Worlds) {
    for caution in worlds.first().cautions() {
        say(format!("warning: {caution}"));
    }
    let moved = worlds.moved();
    for caution in moved.iter().flat_map(|moved| moved.world.cautions()) {
        say(format!("warning: since the goals moved, {caution}"));
    }
    for caution in worlds.potential_cautions() {
        say(format!("warning: {caution}"));
    }
}

/// What the scenario amounts to; refused if it cannot fit into this machine.
fn summary(loaded: &Loaded) -> Result<String> {
    let (scenario, world) = (&loaded.scenario, loaded.worlds.first());
    require_memory(scenario, world, 1).map_err(Error::from)?;
    let (states, reachable) = world.num_states();
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["scenario", &scenario.name]);
    table.add_rows([
        ["world", &describe(scenario, world)],
        [
            "states",
            &format!(
                "{}, {} of them reachable",
                grouped(states as u64),
                grouped(reachable as u64)
            ),
        ],
        ["actions", &world.num_actions().to_string()],
        [
            "step limit of an episode",
            &grouped(world.max_steps() as u64),
        ],
        ["optimal episode", &optimal(world)],
        ["agent", &kind_of(scenario, "agent", "kind")],
        ["potential", &kind_of(scenario, "shaping", "potential")],
        ["exploration", &kind_of(scenario, "exploration", "kind")],
        ["eigenpairs", &scenario.spectral.num_eigenpairs.to_string()],
        ["episodes", &episodes(scenario)],
        [
            "memory, about",
            &megabytes(estimated_bytes(scenario, reachable, world.num_actions())),
        ],
    ]);
    if let Some(moved) = loaded.worlds.moved() {
        table.add_row([
            "optimal episode since the goals moved",
            &optimal(&moved.world),
        ]);
    }
    for (name, arm) in &scenario.arms {
        table.add_row([format!("arm {name}"), describe_arm(arm)]);
    }
    Ok(table.trim_fmt())
}

fn optimal(world: &World) -> String {
    let optimum = world.optimum();
    format!(
        "{:.6} steps, return {:.6}",
        Short(optimum.expected_steps),
        Short(optimum.expected_return)
    )
}

fn episodes(scenario: &Scenario) -> String {
    let episodes = grouped(scenario.run.episodes as u64);
    match scenario.goals_move_after() {
        Some(after) => format!("{episodes}, the goals move after {}", grouped(after as u64)),
        None => episodes,
    }
}

/// What it is, or else what it is made of.
fn describe_arm(arm: &ArmParams) -> String {
    if let Some(about) = &arm.about {
        return about.clone();
    }
    let base = arm.base.as_deref().unwrap_or("this scenario");
    let settings = arm.settings.iter();
    settings.fold(base.to_owned(), |text, (key, value)| {
        format!("{text}, {key} = {value}")
    })
}

fn describe(scenario: &Scenario, world: &World) -> String {
    match world {
        World::Grid(world) => {
            let layout = world.layout();
            format!(
                "{}, {} × {} cells",
                scenario.env.kind.name(),
                layout.rows(),
                layout.cols()
            )
        }
        World::Listed(..) => scenario.env.kind.name().to_owned(),
    }
}

/// The word in the resolved scenario.
fn kind_of(scenario: &Scenario, section: &str, key: &str) -> String {
    let table = toml::Table::try_from(scenario).unwrap_or_default();
    let word = table.get(section).and_then(|s| s.get(key));
    word.and_then(|w| w.as_str()).unwrap_or_default().to_owned()
}

/// A number with at most as many decimals as asked for, and none that are 0.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let precision = f.precision().unwrap_or(3);
        let size = self.0.abs();
        if size >= 1e15 || (size > 0.0 && size < 0.1_f64.powi(precision as i32)) {
            return write!(f, "{:.precision$e}", self.0);
        }
        let digits = format!("{:.precision$}", self.0);
        f.write_str(digits.trim_end_matches('0').trim_end_matches('.'))
    }
}

fn megabytes(bytes: u64) -> String {
    match bytes.div_ceil(1_000_000) {
        1 => "1 MB".to_owned(),
        megabytes => format!("{} MB", grouped(megabytes)),
    }
}
