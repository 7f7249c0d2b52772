//! `eigentrail show`

use super::show_json::Sight;
use super::{BadInput, Ending, stdout_ink};
use crate::cli;
use crate::output::{print, print_drawn, print_json};
use anyhow::{Result, bail};
use eigentrail::archive::{RecordedSeed, is_run, names, read_potential};
use eigentrail::env::GridWorld;
use eigentrail::env::layouts::{Cell, Layout};
use eigentrail::error::Error;
use eigentrail::report::{
    Charset, Ink, Look, draw_map, draw_policy, draw_values, fitting_note, grouped,
};
use eigentrail::scenario::{Loaded, MovedWorld, Scenario, World, Worlds};
use eigentrail::telemetry::say;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Names of states and their φ.
type Potentials = Vec<(String, f64)>;

pub fn show(args: &cli::Show, global: &cli::Global) -> Result<Ending> {
    let loaded =
        Scenario::load(&args.scenario.scenario, &args.scenario.sets).map_err(Error::from)?;
    if args.json {
        print_json(&Sight::of(args, &loaded)?);
        return Ok(Ending::Done);
    }
    let world = loaded.worlds.first();
    let mut text = String::new();
    match world {
        World::Grid(map) => {
            let look = look(args, global);
            if let Some(run) = &args.potential {
                let folder = folder_on(&loaded, run)?;
                text += &potential(&last_layout(&loaded, map, &folder), &folder, look)?;
            }
            if let Some(run) = &args.policy {
                let folder = folder_on(&loaded, run)?;
                text += &policy(&last_layout(&loaded, map, &folder), &folder, look)?;
            }
            if text.is_empty() {
                let moved = moved_map(&loaded.worlds, look);
                text = draw_map(map.layout(), look) + &facts(world) + &whose_goal(&loaded) + &moved;
            }
            text.extend(fitting_note(map.layout(), look).map(|note| note + "\n"));
            print_drawn(&text);
        }
        World::Listed(_, names) => {
            if let Some(run) = &args.potential {
                text += &listed_potential(&seed_folder(run)?)?;
            }
            if let Some(run) = &args.policy {
                text += &listed_policy(&seed_folder(run)?)?;
            }
            if text.is_empty() {
                text = format!("states: {}\n{}", names.states.join(", "), facts(world));
            }
            print(&text);
        }
    }
    Ok(Ending::Done)
}

fn look(args: &cli::Show, global: &cli::Global) -> Look {
    Look {
        charset: if args.ascii {
            Charset::Ascii
        } else {
            Charset::Blocks
        },
        ink: stdout_ink(global),
        width: args.width.or_else(super::terminal_width),
    }
}

/// Which of the goals it is that is drawn, if each seed has its own.
fn whose_goal(loaded: &Loaded) -> String {
    match loaded.worlds.differ_by_seed() {
        true => format!(
            "a goal at random: here that of seed {}\n",
            loaded.scenario.run.seed
        ),
        false => String::new(),
    }
}

/// The map with the goals that the run in this seed's folder ended with, which its potential leads to.
fn last_layout(loaded: &Loaded, first: &GridWorld, folder: &Path) -> Layout {
    let run = &loaded.scenario.run;
    let seed = seed_of(folder).unwrap_or(run.seed);
    match loaded.worlds.in_episode(seed, run.episodes - 1) {
        World::Grid(map) => map.layout().clone(),
        World::Listed(..) => first.layout().clone(),
    }
}

/// The map after the goals have moved, if they do.
fn moved_map(worlds: &Worlds, look: Look) -> String {
    match worlds.moved() {
        Some(MovedWorld {
            after,
            world: world @ World::Grid(map),
        }) => format!(
            "\nafter {} episodes\n{}{}",
            grouped(*after as u64),
            draw_map(map.layout(), look),
            facts(world)
        ),
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
        World::Grid(map) if map.starts().len() > 1 => {
            format!("one of {} starts, ", map.starts().len())
        }
        _ => String::new(),
    };
    let best = match world.optimal_gain() {
        Some(gain) => format!(
            "windows of {} steps, optimal life {gain:.4} a step",
            grouped(world.max_steps() as u64)
        ),
        None => format!(
            "optimal episode {:.1} steps",
            world.optimum().expected_steps
        ),
    };
    format!(
        "{size}{} states, {} reachable, {starts}{best}\n",
        grouped(states as u64),
        grouped(reachable as u64)
    )
}

/// The seed that a folder `seed-0007` is of.
fn seed_of(folder: &Path) -> Option<u64> {
    let name = folder.file_name()?.to_str()?;
    name.strip_prefix("seed-")?.parse().ok()
}

/// The seed folder of a run; refused if the run was on another map, where its scenario is still beside it.
pub(super) fn folder_on(loaded: &Loaded, run: &Path) -> Result<PathBuf> {
    let folder = seed_folder(run)?;
    let beside = folder.parent().unwrap_or(&folder).join(names::RESOLVED);
    let Ok(run) = Scenario::load(&beside, &[]) else {
        return Ok(folder);
    };
    let seed = loaded.scenario.run.seed; // the same one of both: a goal at random is to be the same
    match (run.worlds.first_for(seed), loaded.worlds.first()) {
        (World::Grid(of_run), World::Grid(map)) if of_run.layout() == map.layout() => Ok(folder),
        _ => bail!(BadInput(format!(
            "{}: the run is of another world: its map differs from the scenario's",
            folder.display()
        ))),
    }
}

/// The values by cell of what a run says about states.
fn by_cell<T>(
    layout: &Layout,
    folder: &Path,
    rows: impl Iterator<Item = (String, T)>,
) -> Result<HashMap<Cell, T>> {
    let mut cells = HashMap::new();
    for (label, value) in rows {
        let place = label
            .split_once(',')
            .and_then(|(row, col)| layout.cell(row.parse().ok()?, col.parse().ok()?));
        match place {
            Some(cell) => cells.insert(cell, value),
            None => bail!(BadInput(format!(
                "{}: the run is of another world: state {label} is not on this map",
                folder.display()
            ))),
        };
    }
    Ok(cells)
}

pub(super) fn read(folder: &Path) -> Result<Potentials> {
    Ok(read_potential(folder).map_err(Error::from)?)
}

/// The map, shaded by φ.
fn potential(layout: &Layout, folder: &Path, look: Look) -> Result<String> {
    let phi = by_cell(layout, folder, read(folder)?.into_iter())?;
    let values = || phi.values().copied();
    let (low, high) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let (first, last) = match (look.ink, look.charset) {
        (Ink::Cube | Ink::True, _) => ("violet", "yellow"),
        (Ink::None, Charset::Blocks) => ("▁", "█"),
        (Ink::None, Charset::Ascii) => ("0", "9"),
    };
    let map = draw_values(layout, |cell| phi.get(&cell).copied(), look);
    Ok(format!(
        "{map}φ from {low:.2} ({first}) to {high:.2} ({last}), {} states\n",
        phi.len()
    ))
}

/// The map with an arrow where the agent has learnt what to do, on φ if there are colours.
fn policy(layout: &Layout, folder: &Path, look: Look) -> Result<String> {
    let phi = by_cell(layout, folder, read(folder)?.into_iter())?;
    let seed = RecordedSeed::read_sights(folder, 0).map_err(Error::from)?;
    let rows = seed
        .policy
        .iter()
        .map(|row| row.greedy.filter(|_| row.visits > 0));
    let held = by_cell(layout, folder, seed.labels.iter().cloned().zip(rows))?;
    let map = draw_policy(
        layout,
        |cell| held.get(&cell).copied().flatten(),
        |cell| phi.get(&cell).copied(),
        look,
    );
    let learnt = held.values().flatten().count();
    Ok(format!(
        "{map}greedy policy, learnt in {learnt} of {} states\n",
        held.len()
    ))
}

fn listed_potential(folder: &Path) -> Result<String> {
    Ok(read(folder)?
        .iter()
        .map(|(name, phi)| format!("{phi:10.3}  {name}\n"))
        .collect())
}

/// Each state, the action held best there, and where that has led most often.
fn listed_policy(folder: &Path) -> Result<String> {
    let seed = RecordedSeed::read_sights(folder, 0).map_err(Error::from)?;
    let mut text = String::new();
    for (name, row) in seed.labels.iter().zip(&seed.policy) {
        let held = seed
            .graph
            .iter()
            .filter(|edge| edge.from == row.state && Some(edge.action) == row.greedy);
        let next = held.max_by_key(|edge| edge.count);
        let next = next.and_then(|edge| seed.labels.get(edge.to as usize));
        let action = row.greedy.zip(seed.actions.as_ref());
        let action = action.and_then(|(number, names)| names.get(usize::from(number)));
        text += &match (next, action) {
            (Some(next), Some(action)) => format!("{name}: {action} → {next}\n"),
            (Some(next), None) => format!("{name} → {next}\n"),
            (None, _) => format!("{name}\n"),
        };
    }
    Ok(text)
}

/// The seed folder that `run` is, or the first one in it.
pub(super) fn seed_folder(run: &Path) -> Result<PathBuf> {
    if run.join(names::POTENTIAL).is_file() {
        return Ok(run.to_owned());
    }
    let entries = fs::read_dir(run).into_iter().flatten().flatten();
    let seeds = entries
        .map(|entry| entry.path())
        .filter(|path| path.join(names::POTENTIAL).is_file());
    let mut seeds: Vec<PathBuf> = seeds.collect();
    seeds.sort();
    if let [first, .., last] = &seeds[..] {
        let (count, first, last) = (seeds.len(), first.display(), last.display());
        say(format!(
            "the first of {count} seeds, {first}; name another to see that, {last}"
        ));
    }
    match seeds.into_iter().next() {
        Some(folder) => Ok(folder),
        None if is_run(run) => bail!(BadInput(format!(
            "{}: no seed of this run has ended yet",
            run.display()
        ))),
        None => bail!(BadInput(format!("{}: not a run folder", run.display()))),
    }
}
