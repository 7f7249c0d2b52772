//! One scenario at a glance: φ at four moments while the graph grows, and the regret against learning without it.

use super::curves::{Curve, LogChart};
use super::heat_map::Frame;
use super::{Anchor, Drawing};
use crate::archive::Snapshot;
use crate::archive::{RecordedRun, RecordedSeed};
use crate::env::layouts::{Cell, Layout};
use crate::report::grouped;
use crate::report::terminal::whole;
use std::collections::HashMap;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 590.0;
const MAP: f64 = 208.0;
const GAP: f64 = 30.0;

/// The figure as SVG: maps of the seed of `shaped` that met its goal with the fewest states known, because its φ has
/// the most to grow; regret over all seeds of both runs.
///
/// # Panics
/// If a run has no seeds; [`RecordedRun::read`] never returns such a one.
pub fn overview(layout: &Layout, shaped: &RecordedRun, sparse: &RecordedRun) -> String {
    let mut drawing = Drawing::default();
    let first_fit = |seed: &&RecordedSeed| {
        let fitted = seed.snapshots.iter().find(|s| is_fitted(s));
        fitted.map_or(usize::MAX, |snapshot| snapshot.nodes)
    };
    let seed = shaped.seeds.iter().min_by_key(first_fit);
    let seed = seed.expect("a recorded run has seeds");
    draw_moments(&mut drawing, layout, seed);
    draw_regret(&mut drawing, shaped, sparse);
    let description = format!(
        "Above: the potential on the map at four moments of one run, covering {} states at last. Below: mean regret \
         over the episodes, {} with search, advice and shaping, {} of the actor-critic alone.",
        seed.labels.len(),
        regret_at_end(shaped),
        regret_at_end(sparse),
    );
    let title = format!("{}: potential and regret", shaped.scenario.name);
    drawing.finish(WIDTH, HEIGHT, &title, &description)
}

fn draw_moments(drawing: &mut Drawing, layout: &Layout, seed: &RecordedSeed) {
    let cells: HashMap<Cell, usize> = (seed.labels.iter().enumerate())
        .filter_map(|(state, label)| {
            let (row, col) = label.split_once(',')?;
            Some((layout.cell(row.parse().ok()?, col.parse().ok()?)?, state))
        })
        .collect();
    let title = format!(
        "Potential φ on the graph discovered so far (seed {})",
        seed.seed
    );
    drawing.text(6.0, 16.0, Anchor::Start, "h", &title);
    for (i, snapshot) in moments(&seed.snapshots).into_iter().enumerate() {
        let (low, high) = range(&snapshot.potential);
        let frame = Frame {
            x: i as f64 * (MAP + GAP) + 6.0,
            y: 32.0,
            size: MAP,
        };
        drawing.heat_map(layout, frame, (low, high), |cell| {
            let state = *cells.get(&cell)?;
            snapshot.potential.get(state).map(|&phi| f64::from(phi))
        });
        let caption = format!(
            "step {} · {} states",
            grouped(snapshot.step),
            grouped(snapshot.nodes as u64)
        );
        let middle = frame.x + MAP / 2.0;
        let scale = format!("φ from {low:.0} (violet) to {high:.0} (yellow)");
        drawing.text(middle, frame.y + MAP + 20.0, Anchor::Middle, "", &caption);
        drawing.text(middle, frame.y + MAP + 38.0, Anchor::Middle, "", &scale);
    }
}

/// Four frames at equal distances in discovered states, from the first that has a potential to the last.
fn moments(snapshots: &[Snapshot]) -> Vec<&Snapshot> {
    let mut fitted: Vec<&Snapshot> = Vec::new();
    for snapshot in snapshots {
        let grew = fitted.last().is_none_or(|last| last.nodes < snapshot.nodes);
        if is_fitted(snapshot) && grew {
            fitted.push(snapshot);
        }
    }
    let (Some(first), Some(last)) = (fitted.first(), fitted.last()) else {
        return Vec::new();
    };
    let (first, last) = (first.nodes as f64, last.nodes as f64);
    let mut chosen: Vec<&Snapshot> = (0..4)
        .filter_map(|i| {
            let target = first + (last - first) * f64::from(i) / 3.0;
            let distance = |s: &&Snapshot| (s.nodes as f64 - target).abs();
            fitted
                .iter()
                .copied()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .collect();
    chosen.dedup_by_key(|snapshot| snapshot.step);
    chosen
}

/// Whether φ is not flat.
fn is_fitted(snapshot: &Snapshot) -> bool {
    let (low, high) = range(&snapshot.potential);
    high > low
}

fn range(values: &[f32]) -> (f64, f64) {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        values.iter().map(|&v| f64::from(v)).fold(start, pick)
    };
    (
        fold(f64::INFINITY, f64::min),
        fold(f64::NEG_INFINITY, f64::max),
    )
}

fn draw_regret(drawing: &mut Drawing, shaped: &RecordedRun, sparse: &RecordedRun) {
    let curves = [shaped, sparse].map(regret);
    let episodes = curves.iter().map(Curve::num_episodes).max().unwrap_or(1);
    let highest = curves.iter().flat_map(|curve| &curve.band.high);
    let highest = highest.copied().fold(10.0, f64::max);
    let values = curves.iter().flat_map(|curve| &curve.band.middle);
    let lowest = values.copied().filter(|&v| v > 0.0);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    let chart = LogChart {
        edges: [76.0, 330.0, 800.0, 540.0],
        x: (0.0, libm::log10(episodes as f64)),
        y: (
            libm::log10(lowest.min(highest / 10.0)).floor(),
            libm::log10(highest).ceil(),
        ),
    };
    let seeds = shaped.seeds.len();
    let band = if seeds > 1 {
        ", with 95 % intervals"
    } else {
        ""
    };
    let title =
        format!("Regret: reward lost against the best policy (mean of {seeds} seeds{band})");
    drawing.log_axes(&chart, "episode", &title);
    for (curve, class, name) in [(1, "b", "actor-critic alone"), (0, "a", "eigentrail")] {
        let (x, y) = drawing.band(&chart, &curves[curve], class);
        let class = format!("{class}t");
        drawing.text(x + 8.0, y + 4.5, Anchor::Start, &class, name);
    }
}

fn regret(run: &RecordedRun) -> Curve {
    Curve::over(run, |row| row.regret)
}

fn regret_at_end(run: &RecordedRun) -> String {
    whole(regret(run).at_end().max(0.0))
}
