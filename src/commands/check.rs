//! `eigentrail check`

use super::{BadInput, Ending};
use crate::cli;
use crate::output::{print, print_json};
use anyhow::Result;
use comfy_table::{Table, presets};
use eigentrail::agent::AgentKind;
use eigentrail::error::Error;
use eigentrail::report::grouped;
use eigentrail::runner::{estimated_bytes, require_memory};
use eigentrail::scenario::{
    Actions, ArmParams, Loaded, Location, Mistake, Scenario, ScenarioError, World,
};
use eigentrail::telemetry::say;
use serde::Serialize;
use std::path::Path;

pub fn check(args: &cli::Check) -> Result<Ending> {
    let loaded = match Scenario::load(&args.scenario.scenario, &args.scenario.sets) {
        Err(error) if args.json => return Err(refused(&Refused::of(&error)).into()),
        loaded => loaded.map_err(Error::from)?,
    };
    if args.resolved {
        print(&loaded.scenario.to_toml());
        return Ok(Ending::Done);
    }
    let facts = match Facts::of(&loaded) {
        Err(error) if args.json => {
            let refusal = Refused::as_a_whole(&args.scenario.scenario, &loaded, &error);
            return Err(refused(&refusal).into());
        }
        facts => facts?,
    };
    match args.json {
        true => print_json(&facts),
        false => print(&table(&loaded, &facts)),
    }
    for warning in &facts.warnings {
        say(format!("warning: {warning}"));
    }
    Ok(Ending::Done)
}

/// Prints why a scenario is not accepted. The error has no more to say than how much that is.
fn refused(refusal: &Refused<'_>) -> BadInput {
    print_json(refusal);
    let count = match refusal.mistakes.len() {
        1 => "1 mistake".to_owned(),
        n => format!("{n} mistakes"),
    };
    BadInput(format!("{count} in {}", refusal.file.display()))
}

/// A scenario that is not accepted, as `check --json` prints it.
#[derive(Serialize)]
struct Refused<'a> {
    #[serde(skip)]
    file: &'a Path,
    /// Its name, if that much could be read.
    scenario: Option<&'a str>,
    mistakes: Vec<MistakeLine>,
}

#[derive(Serialize)]
struct MistakeLine {
    file: String,
    /// From 1; none if it is no place in the file.
    line: Option<usize>,
    column: Option<usize>,
    /// The assignment on the command line, if that is to blame.
    set: Option<String>,
    key: Option<String>,
    message: String,
}

impl<'a> Refused<'a> {
    fn of(error: &'a ScenarioError) -> Self {
        let file = error.file.display().to_string();
        let mistakes = error.mistakes.iter();
        Self {
            file: &error.file,
            scenario: error.scenario.as_deref(),
            mistakes: mistakes.map(|m| MistakeLine::of(&file, m)).collect(),
        }
    }

    /// One that is sound and still cannot be.
    fn as_a_whole(file: &'a Path, loaded: &'a Loaded, error: &anyhow::Error) -> Self {
        Self {
            file,
            scenario: Some(&loaded.scenario.name),
            mistakes: vec![MistakeLine {
                file: file.display().to_string(),
                line: None,
                column: None,
                set: None,
                key: None,
                message: error.to_string(),
            }],
        }
    }
}

impl MistakeLine {
    fn of(file: &str, mistake: &Mistake) -> Self {
        let mut line = Self {
            file: file.to_owned(),
            line: None,
            column: None,
            set: None,
            key: mistake.key().map(str::to_owned),
            message: mistake.message(),
        };
        match mistake.place() {
            Location::Position {
                line: row, column, ..
            } => (line.line, line.column) = (Some(row), Some(column)),
            Location::File(_) => {}
            Location::Flag(set) => line.set = Some(set),
            place @ (Location::Arm(..) | Location::Grid(_)) => {
                line.message = format!("{place}: {}", line.message);
            }
        }
        line
    }
}

/// What a scenario amounts to, as `check --json` prints it.
#[derive(Serialize)]
struct Facts<'a> {
    scenario: &'a str,
    /// `env.kind`.
    kind: &'static str,
    states: usize,
    /// Those that can be reached from where episodes begin.
    reachable: usize,
    actions: usize,
    /// After how many steps an episode is cut off.
    max_steps: usize,
    #[serde(flatten)]
    best: Best,
    /// Of a continuing task, what the best policy earns a step.
    optimal_gain: Option<f64>,
    /// Steps between the two states farthest from each other, ends leading back to the starts.
    diameter: Option<f64>,
    /// The reason, if there is none.
    why_no_diameter: Option<String>,
    /// Σ 1 / (V* − Q*) under `agent.gamma`, over the actions that are not the best.
    sum_of_inverse_gaps: Option<f64>,
    /// The reason, if there is none.
    why_no_sum_of_inverse_gaps: Option<String>,
    gamma: f64,
    agent: String,
    potential: String,
    exploration: String,
    num_eigenpairs: usize,
    episodes: usize,
    /// What a run needs, about.
    memory_bytes: u64,
    /// What changes when the goals move, if they do.
    moved: Option<Moved>,
    /// What the scenario's author may not have meant.
    warnings: Vec<String>,
    /// None: it is accepted.
    mistakes: [MistakeLine; 0],
}

/// An episode of the best policy.
#[derive(Serialize)]
struct Best {
    optimal_steps: f64,
    optimal_return: f64,
}

#[derive(Serialize)]
struct Moved {
    /// Episodes before the move.
    after: usize,
    #[serde(flatten)]
    best: Best,
}

impl Best {
    fn of(world: &World) -> Self {
        let optimum = world.optimum();
        Self {
            optimal_steps: optimum.expected_steps,
            optimal_return: optimum.expected_return,
        }
    }
}

impl<'a> Facts<'a> {
    /// Refused if the scenario cannot fit into this machine.
    fn of(loaded: &'a Loaded) -> Result<Self> {
        let (scenario, world) = (&loaded.scenario, loaded.worlds.first());
        require_memory(scenario, world, 1).map_err(Error::from)?;
        let (states, reachable) = world.num_states();
        let (diameter, why_no_diameter) = number_or_reason(world.diameter());
        let gaps = world.sum_of_inverse_gaps(scenario.agent.gamma);
        let (sum_of_inverse_gaps, why_no_sum_of_inverse_gaps) = number_or_reason(gaps);
        let moved = loaded.worlds.moved();
        Ok(Self {
            scenario: &scenario.name,
            kind: scenario.env.kind.name(),
            states,
            reachable,
            actions: world.num_actions(),
            max_steps: world.max_steps(),
            best: Best::of(world),
            optimal_gain: world.optimal_gain(),
            diameter,
            why_no_diameter,
            sum_of_inverse_gaps,
            why_no_sum_of_inverse_gaps,
            gamma: scenario.agent.gamma,
            agent: kind_of(scenario, "agent", "kind"),
            potential: kind_of(scenario, "shaping", "potential"),
            exploration: kind_of(scenario, "exploration", "kind"),
            num_eigenpairs: scenario.spectral.num_eigenpairs,
            episodes: scenario.run.episodes,
            memory_bytes: estimated_bytes(scenario, reachable, world.num_actions()),
            moved: moved.map(|moved| Moved {
                after: moved.after,
                best: Best::of(&moved.world),
            }),
            warnings: warnings(loaded),
            mistakes: [],
        })
    }
}

fn number_or_reason(measure: Result<f64, String>) -> (Option<f64>, Option<String>) {
    match measure {
        Ok(number) => (Some(number), None),
        Err(reason) => (None, Some(reason)),
    }
}

/// What the author of the scenario may not have meant.
fn warnings(loaded: &Loaded) -> Vec<String> {
    let (scenario, worlds) = (&loaded.scenario, &loaded.worlds);
    let mut warnings = loaded.cautions.clone();
    warnings.extend(worlds.first().cautions());
    let moved = worlds.moved();
    let since = moved.iter().flat_map(|moved| moved.world.cautions());
    warnings.extend(since.map(|caution| format!("since the goals moved, {caution}")));
    let copes = matches!(scenario.agent.kind, AgentKind::Planner | AgentKind::Random);
    if worlds.first().optimal_gain().is_some() && scenario.agent.gamma == 1.0 && !copes {
        warnings.push(
            "a continuing task has no end, and with agent.gamma = 1 what this agent learns has no bound; set agent.gamma \
             below 1, to 0.99 for example"
                .to_owned(),
        );
    }
    warnings.extend(worlds.potential_cautions());
    warnings
}

/// The facts for people.
fn table(loaded: &Loaded, facts: &Facts) -> String {
    let (scenario, world) = (&loaded.scenario, loaded.worlds.first());
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["scenario", facts.scenario]);
    let best = match facts.optimal_gain {
        Some(_) => "optimal window of that life",
        None => "optimal episode",
    };
    let mut row = |name: &str, value: String| {
        table.add_row([name, &value]);
    };
    row("world", describe(scenario, world));
    if loaded.worlds.differ_by_seed() {
        let seed = scenario.run.seed;
        row("goal", format!("at random, below that of seed {seed}"));
    }
    row(
        "states",
        format!(
            "{}, {} of them reachable",
            grouped(facts.states as u64),
            grouped(facts.reachable as u64)
        ),
    );
    row("actions", facts.actions.to_string());
    row("step limit of an episode", grouped(facts.max_steps as u64));
    if let Some(gain) = facts.optimal_gain {
        row(
            "optimal life without end",
            format!("{:.6} a step", Short(gain)),
        );
    }
    row(best, optimal(&facts.best));
    row(
        "diameter",
        match (facts.diameter, &facts.why_no_diameter) {
            (Some(steps), _) => format!("{:.3} steps", Short(steps)),
            (None, why) => why.clone().unwrap_or_default(),
        },
    );
    row(
        "Σ 1/gap",
        match (facts.sum_of_inverse_gaps, &facts.why_no_sum_of_inverse_gaps) {
            (Some(sum), _) => format!("{:.6} at gamma = {}", Short(sum), facts.gamma),
            (None, why) => why.clone().unwrap_or_default(),
        },
    );
    row("agent", facts.agent.clone());
    row("potential", facts.potential.clone());
    row("exploration", facts.exploration.clone());
    row("eigenpairs", eigenpairs(facts));
    row("episodes", episodes(scenario));
    row("memory, about", megabytes(facts.memory_bytes));
    if let Some(moved) = &facts.moved {
        row(
            "optimal episode since the goals moved",
            optimal(&moved.best),
        );
    }
    for (name, arm) in &scenario.arms {
        row(&format!("arm {name}"), describe_arm(arm));
    }
    table.trim_fmt()
}

/// How many are asked for, and how many there are at most.
fn eigenpairs(facts: &Facts) -> String {
    let (asked, reachable) = (facts.num_eigenpairs, facts.reachable);
    if asked <= reachable {
        return asked.to_string();
    }
    format!("all {reachable} of {reachable} reachable states (spectral.num_eigenpairs = {asked})")
}

fn optimal(best: &Best) -> String {
    format!(
        "{:.6} steps, return {:.6}",
        Short(best.optimal_steps),
        Short(best.optimal_return)
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
        World::Listed(..) if scenario.env.actions == Some(Actions::Turns) => {
            format!("{}, with turns", scenario.env.kind.name())
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
