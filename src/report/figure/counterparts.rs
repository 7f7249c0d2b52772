//! Counterparts of figures 4 to 9 of the source paper, each from runs of our own.

use super::Drawing;
use super::curves::Curve;
use super::heat_map::Frame;
use super::panel::places;
use crate::archive::{RecordedRun, RecordedSeed};
use crate::env::layouts::{Cell, Layout};
use crate::scenario::World;
use std::collections::HashMap;

/// The runs that the figures are made of, one for each file of `scenarios/report/`; of two, the second is without
/// potential and exploration.
#[derive(Clone, Debug)]
pub struct PaperRuns {
    /// Figure 4.
    pub graph: RecordedRun,
    /// Figure 5, and 6 (a).
    pub reward: RecordedRun,
    /// Figure 6 (b).
    pub scale: RecordedRun,
    /// Figure 7 (a).
    pub two_goals: RecordedRun,
    /// Figure 7 (b).
    pub centre_goal: RecordedRun,
    /// Figure 8.
    pub learning: [RecordedRun; 2],
    /// Figure 9.
    pub linked: [RecordedRun; 2],
}

/// One figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its number in the paper.
    pub number: u32,
    /// What it shows, in a sentence.
    pub caption: String,
    /// Files of `scenarios/report/` behind it.
    pub scenarios: &'static [&'static str],
    /// The picture.
    pub svg: String,
}

/// Height of letters: large, for on a phone the figures are half as wide.
const LETTERS: f64 = 20.0;
/// Side of a map, gap, upper edge of panels, in pixels.
const MAP: f64 = 340.0;
const GAP: f64 = 60.0;
const TOP: f64 = 34.0;
/// Width of a figure, height of a chart.
const WIDTH: f64 = 2.0 * MAP + GAP + 12.0;
const CHART: f64 = 330.0;

/// All of them, in order. Equal runs give equal bytes.
///
/// # Panics
/// If a run has no map.
pub fn counterparts(runs: &PaperRuns) -> Vec<Figure> {
    vec![
        fig4(&runs.graph),
        fig5(&runs.reward),
        fig6(&runs.reward, &runs.scale),
        fig7(&runs.two_goals, &runs.centre_goal),
        fig8(&runs.learning),
        fig9(&runs.linked),
    ]
}

fn fig4(run: &RecordedRun) -> Figure {
    let (layout, seed) = (layout(run), &run.seeds[0]);
    let last = seed.snapshots.last().map_or((0, 0), |s| (s.nodes, s.edges));
    let mut drawing = Drawing::new(LETTERS);
    drawing.graph_panel(&layout, frame(0), "The grid as a graph", seed);
    figure(
        4,
        format!(
            "The {} × {} grid as a random walk has drawn it: {} states, {} edges. Blue: start, vermilion: goal.",
            layout.rows(),
            layout.cols(),
            last.0,
            last.1
        ),
        &["fig4_graph"],
        drawing,
        (MAP + 12.0, TOP + MAP + 6.0),
    )
}

fn fig5(run: &RecordedRun) -> Figure {
    let (layout, seed) = (layout(run), &run.seeds[0]);
    let mut drawing = Drawing::new(LETTERS);
    drawing.map_panel(
        &layout,
        frame(0),
        "(a) Reward of a step (eq. 2)",
        &rewards(&layout, seed),
    );
    drawing.map_panel(
        &layout,
        frame(1),
        "(b) Potential φ",
        &potential(&layout, seed),
    );
    figure(
        5,
        "The sparse reward is the same everywhere but at the goal; the potential tells every state where the goal is."
            .to_owned(),
        &["fig5_reward"],
        drawing,
        two_maps(),
    )
}

fn fig6(small: &RecordedRun, large: &RecordedRun) -> Figure {
    let mut drawing = Drawing::new(LETTERS);
    for (i, (run, letter)) in [(small, "a"), (large, "b")].into_iter().enumerate() {
        let layout = layout(run);
        let title = format!(
            "({letter}) Potential φ, {} × {}",
            layout.rows(),
            layout.cols()
        );
        drawing.map_panel(
            &layout,
            frame(i),
            &title,
            &potential(&layout, &run.seeds[0]),
        );
    }
    figure(
        6,
        "The potential grows with the grid: its scale is the distance to the goal.".to_owned(),
        &["fig5_reward", "fig6_scale"],
        drawing,
        two_maps(),
    )
}

fn fig7(two: &RecordedRun, centre: &RecordedRun) -> Figure {
    let mut drawing = Drawing::new(LETTERS);
    let panels = [(two, "(a) Two goals"), (centre, "(b) A goal in the middle")];
    for (i, (run, title)) in panels.into_iter().enumerate() {
        let layout = layout(run);
        drawing.map_panel(&layout, frame(i), title, &potential(&layout, &run.seeds[0]));
    }
    figure(
        7,
        "Other goals, nothing else changed: the potential rises towards the nearer of two, and from every side to one \
         in the middle."
            .to_owned(),
        &["fig7a_two_goals", "fig7b_centre_goal"],
        drawing,
        two_maps(),
    )
}

fn fig8([shaped, sparse]: &[RecordedRun; 2]) -> Figure {
    let mut drawing = Drawing::new(LETTERS);
    let regret = [shaped, sparse].map(|run| Curve::over(run, |row| row.regret));
    let steps =
        [shaped, sparse].map(|run| Curve::over(run, |row| row.length as f64 / row.episodes as f64));
    let panels = [
        ("(a) Regret ρ (reward)", &regret),
        ("(b) Steps to the goal", &steps),
    ];
    for (i, (title, curves)) in panels.into_iter().enumerate() {
        drawing.versus_panel(chart(i as f64 * CHART), title, curves.each_ref());
    }
    figure(
        8,
        format!(
            "Regret and steps over {} episodes: means of {} seeds with 95 % intervals. At the end the regret is {:.0}, \
             of the actor-critic alone {:.0}.",
            regret[0].num_episodes(),
            shaped.seeds.len(),
            regret[0].at_end(),
            regret[1].at_end()
        ),
        &["fig8_learning"],
        drawing,
        (WIDTH, 2.0 * CHART),
    )
}

fn fig9([shaped, sparse]: &[RecordedRun; 2]) -> Figure {
    let layout = layout(shaped);
    // φ has the most to show where most of the map is known.
    let seed = shaped.seeds.iter().max_by_key(|seed| seed.labels.len());
    let seed = seed.expect("a recorded run has seeds");
    let mut drawing = Drawing::new(LETTERS);
    drawing.map_panel(&layout, frame(0), "(a) Four linked grids", &HashMap::new());
    drawing.map_panel(
        &layout,
        frame(1),
        "(b) Potential φ, discovered",
        &potential(&layout, seed),
    );
    let regret = [shaped, sparse].map(|run| Curve::over(run, |row| row.regret));
    let (width, maps) = two_maps();
    drawing.versus_panel(chart(maps), "(c) Regret ρ (reward)", regret.each_ref());
    figure(
        9,
        format!(
            "Grids joined by corridors, which the paper leaves open: the potential leads through them. Regret at the \
             end {:.0}, of the actor-critic alone {:.0} (means of {} seeds, 95 % intervals).",
            regret[0].at_end(),
            regret[1].at_end(),
            shaped.seeds.len()
        ),
        &["fig9_linked_grids"],
        drawing,
        (width, maps + CHART),
    )
}

fn figure(
    number: u32,
    caption: String,
    scenarios: &'static [&'static str],
    drawing: Drawing,
    (width, height): (f64, f64),
) -> Figure {
    let title = format!("Figure {number}");
    Figure {
        number,
        scenarios,
        svg: drawing.finish(width, height, &title, &caption),
        caption,
    }
}

/// The i-th map of a row.
fn frame(i: usize) -> Frame {
    Frame {
        x: 6.0 + i as f64 * (MAP + GAP),
        y: TOP,
        size: MAP,
    }
}

/// Width and height of two maps with their scales.
fn two_maps() -> (f64, f64) {
    (WIDTH, TOP + MAP + 56.0)
}

/// Edges of a chart of the whole width, its title included, that begins at `y`.
fn chart(y: f64) -> [f64; 4] {
    [84.0, y + 44.0, WIDTH - 205.0, y + CHART - 66.0]
}

fn layout(run: &RecordedRun) -> Layout {
    match run.scenario.world(run.seeds[0].seed) {
        Ok(World::Grid(world)) => world.layout().clone(),
        _ => panic!("the scenario {} has no map", run.scenario.name),
    }
}

/// φ at the end of the run.
fn potential(layout: &Layout, seed: &RecordedSeed) -> HashMap<Cell, f64> {
    let last = seed
        .snapshots
        .last()
        .map_or(&[][..], |last| &last.potential);
    let values = last.iter().map(|&phi| f64::from(phi));
    let cells = places(layout, seed);
    let pairs = cells.iter().zip(values);
    pairs
        .filter_map(|(cell, phi)| Some(((*cell)?, phi)))
        .collect()
}

/// Mean reward of the steps from each cell; 0 where episodes end, because nothing is paid there.
fn rewards(layout: &Layout, seed: &RecordedSeed) -> HashMap<Cell, f64> {
    let cells = places(layout, seed);
    let mut sums: HashMap<Cell, (f64, f64)> = HashMap::new();
    for row in &seed.graph {
        let place = |state: u32| cells.get(state as usize).copied().flatten();
        if let Some(cell) = place(row.from) {
            let sum = sums.entry(cell).or_default();
            *sum = (sum.0 + row.reward_sum, sum.1 + f64::from(row.count));
        }
        if let Some(end) = place(row.to).filter(|_| row.terminal) {
            sums.insert(end, (0.0, 1.0));
        }
    }
    let mean = |(cell, (sum, count)): (Cell, (f64, f64))| (cell, sum / count);
    sums.into_iter().map(mean).collect()
}
