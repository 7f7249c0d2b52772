//! `eigentrail show`

use super::{BadInput, Ending, print};
use crate::cli;
use anyhow::{Result, bail};
use eigentrail::env::GridWorld;
use eigentrail::env::layouts::{Cell, Layout};
use eigentrail::error::Error;
use eigentrail::report::{Charset, draw_map, draw_values, grouped};
use eigentrail::runner::{is_run, read_potential};
use eigentrail::scenario::{MovedWorld, Scenario, World};
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

pub fn show(args: &cli::Show) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    let scenario = &loaded.scenario;
    let world = scenario.world(scenario.run.seed);
    let world = world.expect("the scenario was checked when it was loaded");
    let charset = if args.ascii {
        Charset::Ascii
    } else {
        Charset::Blocks
    };
    let text = match (&world, &args.potential) {
        (World::Grid(map), None) => {
            let moved = moved_map(scenario, charset);
            draw_map(map.layout(), charset) + &facts(&world) + &moved
        }
        (World::Grid(map), Some(run)) => {
            let folder = seed_folder(run)?;
            same_map(map.layout(), &folder)?;
            potential(&last_layout(scenario, map), &folder, charset)?
        }
        (World::Listed(_, names), None) => {
            format!("states: {}\n{}", names.join(", "), facts(&world))
        }
        (World::Listed(..), Some(run)) => listed_potential(&seed_folder(run)?)?,
    };
    print(&text)?;
    Ok(Ending::Done)
}

/// The map with the goals that a run ends with, which its potential leads to.
fn last_layout(scenario: &Scenario, first: &GridWorld) -> Layout {
    let last = scenario.run.episodes - 1;
    match scenario.world_in(scenario.run.seed, last) {
        Ok(World::Grid(map)) => map.layout().clone(),
        _ => first.layout().clone(),
    }
}

/// The map after the goals have moved, if they do.
fn moved_map(scenario: &Scenario, charset: Charset) -> String {
    match scenario.moved_world(scenario.run.seed) {
        Ok(Some(MovedWorld { after, world })) => match &world {
            World::Grid(map) => format!(
                "\nafter {} episodes\n{}{}",
                grouped(after as u64),
                draw_map(map.layout(), charset),
                facts(&world)
            ),
            World::Listed(..) => String::new(),
        },
        _ => String::new(),
    }
}

/// Size and distance below the map.
fn facts(world: &World) -> String {
    let (states, reachable) = world.num_states();
    let size = match world {
        World::Grid(map) => format!("{} × {} cells, ", map.layout().rows(), map.layout().cols()),
        World::Listed(..) => String::new(),
    };
    let starts = match world {
        World::Grid(map) if map.params().random_start => "random start, ".to_owned(),
        _ => String::new(),
    };
    format!(
        "{size}{} states, {} reachable, {starts}optimal episode {:.1} steps\n",
        grouped(states as u64),
        grouped(reachable as u64),
        world.optimum().expected_steps
    )
}

/// Refuses the potential of a run on another map, where the run's scenario is still beside it.
fn same_map(layout: &Layout, folder: &Path) -> Result<()> {
    let beside = folder.parent().unwrap_or(folder).join("resolved.toml");
    let Ok(run) = Scenario::load(&beside, &[]) else {
        return Ok(());
    };
    let world = run.scenario.world(run.scenario.run.seed);
    match world.expect("the scenario was checked when it was loaded") {
        World::Grid(map) if map.layout() == layout => Ok(()),
        _ => bail!(BadInput(format!(
            "{}: the run is of another world: its map differs from the scenario's",
            folder.display()
        ))),
    }
}

/// The map, shaded by φ.
fn potential(layout: &Layout, folder: &Path, charset: Charset) -> Result<String> {
    let rows = read_potential(folder).map_err(Error::from)?;
    let mut phi: HashMap<Cell, f64> = HashMap::new();
    for (label, value) in &rows {
        let place = label
            .split_once(',')
            .and_then(|(row, col)| layout.cell(row.parse().ok()?, col.parse().ok()?));
        match place {
            Some(cell) => phi.insert(cell, *value),
            None => bail!(BadInput(format!(
                "{}: the run is of another world: state {label} is not on this map",
                folder.display()
            ))),
        };
    }
    let values = || phi.values().copied();
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let (first, last) = match charset {
        Charset::Blocks => ('▁', '█'),
        Charset::Ascii => ('0', '9'),
    };
    let map = draw_values(layout, |cell| phi.get(&cell).copied(), charset);
    Ok(format!(
        "{map}φ from {low:.2} ({first}) to {high:.2} ({last}), {} states\n",
        phi.len()
    ))
}

fn listed_potential(folder: &Path) -> Result<String> {
    let rows = read_potential(folder).map_err(Error::from)?;
    Ok(rows
        .iter()
        .map(|(name, phi)| format!("{phi:10.3}  {name}\n"))
        .collect())
}

/// The seed folder that `run` is, or the first one in it.
fn seed_folder(run: &Path) -> Result<PathBuf> {
    if run.join("potential.npy").is_file() {
        return Ok(run.to_owned());
    }
    let entries = fs::read_dir(run).into_iter().flatten().flatten();
    let seeds = entries
        .map(|entry| entry.path())
        .filter(|path| path.join("potential.npy").is_file());
    match seeds.min() {
        Some(folder) => Ok(folder),
        None if is_run(run) => bail!(BadInput(format!(
            "{}: no seed of this run has ended yet",
            run.display()
        ))),
        None => bail!(BadInput(format!("{}: not a run folder", run.display()))),
    }
}
