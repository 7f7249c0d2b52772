//! What the page's script draws, as plain values.

use crate::env::layouts::{Layout, Tile};
use crate::report::band::{Band, interval};
use crate::report::recorded::{RecordedRun, RecordedSeed};
use crate::report::validity::{Check, cell, validity};
use crate::runner::Snapshot;
use crate::scenario::World;
use serde::Serialize;

/// Points of a curve at most.
const MAX_POINTS: usize = 400;

/// Everything on the page.
#[derive(Serialize)]
pub(super) struct PageData {
    pub(super) title: String,
    program: &'static str,
    /// Whether frames were left out to keep the file small.
    thinned: bool,
    arms: Vec<Arm>,
}

/// One run.
#[derive(Serialize)]
struct Arm {
    name: String,
    command: String,
    resolved: String,
    seeds: Vec<u64>,
    facts: Vec<(&'static str, String)>,
    /// Episode numbers, from 1, of the points of the curves.
    episodes: Vec<usize>,
    length: Band,
    regret: Band,
    plain: Band,
    shaped: Band,
    checks: Vec<Check>,
    map: Option<Map>,
    /// Cell of each state on the map, or nothing.
    cells: Vec<Option<u32>>,
    /// Undirected edges, where there is no map.
    edges: Vec<(u32, u32)>,
    frames: Vec<Snapshot>,
    visits: Vec<u64>,
    greedy: Vec<Option<u16>>,
    solver: Vec<Effort>,
}

#[derive(Serialize)]
struct Map {
    rows: usize,
    cols: usize,
    walls: Vec<u32>,
    start: Option<u32>,
    goals: Vec<u32>,
}

#[derive(Serialize)]
struct Effort {
    step: u64,
    applications: Option<usize>,
    solves: Option<usize>,
    residual: Option<f64>,
    loss: Option<f64>,
}

impl PageData {
    /// All of it.
    ///
    /// # Panics
    /// If there are no runs.
    pub(super) fn new(runs: &[RecordedRun]) -> Self {
        Self {
            title: runs[0].scenario.name.clone(),
            program: concat!("eigentrail ", env!("CARGO_PKG_VERSION")),
            thinned: false,
            arms: runs.iter().map(Arm::new).collect(),
        }
    }

    /// Drops every second frame of the arm with the most numbers; false if nothing is left to drop.
    pub(super) fn thin(&mut self) -> bool {
        self.thinned = true;
        let weight = |arm: &&mut Arm| arm.frames.iter().map(|f| f.potential.len()).sum::<usize>();
        let Some(arm) = self.arms.iter_mut().max_by_key(weight) else {
            return false;
        };
        if arm.frames.len() > 1 {
            let mut left = arm.frames.len();
            // Counted from the end, so that the last frame stays.
            arm.frames.retain(|_| {
                left -= 1;
                left % 2 == 0
            });
            return true;
        }
        arm.frames.iter_mut().any(|frame| {
            let had = !frame.vectors.is_empty();
            frame.vectors.clear();
            had
        })
    }
}

impl Arm {
    fn new(run: &RecordedRun) -> Self {
        let seed = &run.seeds[0];
        let last = seed.episodes.len().saturating_sub(1);
        let layout = match run.scenario.world_in(seed.seed, last) {
            Ok(World::Grid(world)) => Some(world.layout().clone()),
            _ => None,
        };
        let episodes = shown_episodes(run);
        let band = |value: fn(&crate::report::EpisodeRow) -> f64| {
            Band::over(run.seeds.len(), episodes.len(), |seed, i| {
                value(&run.seeds[seed].episodes[episodes[i] - 1])
            })
        };
        Self {
            name: run.name.clone(),
            command: command(run),
            resolved: run.resolved.clone(),
            seeds: run.seeds.iter().map(|seed| seed.seed).collect(),
            facts: facts(run),
            length: band(|row| row.length as f64),
            regret: band(|row| row.regret),
            plain: band(|row| row.plain_return),
            shaped: band(|row| row.shaped_return),
            episodes,
            checks: validity(run),
            cells: cells(seed, layout.as_ref()),
            edges: match layout {
                Some(_) => Vec::new(),
                None => edges(seed),
            },
            map: layout.as_ref().map(Map::new),
            frames: seed.snapshots.clone(),
            visits: seed.policy.iter().map(|row| row.visits).collect(),
            greedy: seed.policy.iter().map(|row| row.greedy).collect(),
            solver: efforts(seed),
        }
    }
}

/// Numbers of the episodes that all seeds have, thinned evenly.
fn shown_episodes(run: &RecordedRun) -> Vec<usize> {
    let common = run.seeds.iter().map(|seed| seed.episodes.len()).min();
    let common = common.unwrap_or(0);
    let stride = common.div_ceil(MAX_POINTS).max(1);
    (1..=common).step_by(stride).collect()
}

/// The command that makes the run again, without the name of its folder.
fn command(run: &RecordedRun) -> String {
    let mut words = vec!["eigentrail".to_owned()];
    let mut arguments = run.arguments.iter().skip(1);
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "--out" => {
                arguments.next();
            }
            "--force" | "--resume" => {}
            _ if word.starts_with("--out=") => {}
            _ => words.push(word.clone()),
        }
    }
    words.join(" ")
}

fn facts(run: &RecordedRun) -> Vec<(&'static str, String)> {
    let over = |value: fn(&crate::report::SeedResult) -> f64| {
        let values: Vec<f64> = run.summary.seeds.iter().map(value).collect();
        let (mean, low, high) = interval(&values);
        let mean = short(mean);
        if high > low {
            format!("{mean} [{}, {}]", short(low), short(high))
        } else {
            mean
        }
    };
    let found = run
        .summary
        .seeds
        .iter()
        .filter(|s| s.first_goal_step.is_some());
    let mut facts = vec![
        ("seeds", run.seeds.len().to_string()),
        ("episodes", over(|s| s.episodes as f64)),
        ("regret (reward)", over(|s| s.regret)),
        ("steps of the last episodes", over(|s| s.final_mean_steps)),
        ("optimal steps", over(|s| s.optimal_steps)),
        ("seeds that found the goal", found.count().to_string()),
        ("states discovered", over(|s| s.nodes as f64)),
        ("spectrum refreshes", over(|s| s.spectrum_refreshes as f64)),
        ("fits", over(|s| s.gcn_fits as f64)),
    ];
    if let Some(after) = run.summary.seeds.iter().find_map(|s| s.goals_moved_after) {
        let note = format!("after {after} episodes; map, optimal and last episodes: since then");
        facts.insert(2, ("goals moved", note));
    }
    facts
}

/// To a tenth, without a needless one.
fn short(number: f64) -> String {
    let text = format!("{number:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

fn cells(seed: &RecordedSeed, layout: Option<&Layout>) -> Vec<Option<u32>> {
    let cell_of = |label: &String| cell(layout?, label).map(|cell| cell.0);
    seed.labels.iter().map(cell_of).collect()
}

fn edges(seed: &RecordedSeed) -> Vec<(u32, u32)> {
    let rows = seed.graph.iter().filter(|row| row.from != row.to);
    let mut edges: Vec<_> = rows
        .map(|row| (row.from.min(row.to), row.from.max(row.to)))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn efforts(seed: &RecordedSeed) -> Vec<Effort> {
    let stride = seed.refreshes.len().div_ceil(MAX_POINTS).max(1);
    (seed.refreshes.iter().step_by(stride))
        .map(|row| Effort {
            step: row.step,
            applications: row.applications,
            solves: row.solves,
            residual: row.max_relative_residual,
            loss: row.loss,
        })
        .collect()
}

impl Map {
    fn new(layout: &Layout) -> Self {
        let all = (0..layout.num_cells())
            .filter_map(|i| layout.cell(i / layout.cols(), i % layout.cols()));
        Self {
            rows: layout.rows(),
            cols: layout.cols(),
            walls: all
                .filter(|&cell| layout.tile(cell) == Tile::Wall)
                .map(|cell| cell.0)
                .collect(),
            start: layout.start.map(|cell| cell.0),
            goals: layout.goals.iter().map(|goal| goal.cell.0).collect(),
        }
    }
}
