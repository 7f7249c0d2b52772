//! One scenario at a glance: φ at four moments while the graph grows, and the regret against learning without it.

use super::curves::Curve;
use super::heat_map::Frame;
use super::{Anchor, Drawing};
use crate::archive::Snapshot;
use crate::archive::{RecordedRun, RecordedSeed};
use crate::env::layouts::{Cell, Layout};
use crate::report::grouped;
use crate::report::terminal::whole;
use std::collections::HashMap;

/// Letters are large, for on a phone the figure is half as wide.
const LETTERS: f64 = 20.0;
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 680.0;
const EDGE: f64 = 6.0;
const GAP: f64 = 20.0;
/// Side of one of four maps.
const MAP: f64 = (WIDTH - 2.0 * EDGE - 3.0 * GAP) / 4.0;
/// Upper edge of the maps.
const TOP: f64 = 40.0;

/// The figure as SVG: maps of the seed of `shaped` that met its goal with the fewest states known, because its φ has
/// the most to grow; regret over all seeds of both runs.
///
/// # Panics
/// If a run has no seeds; [`RecordedRun::read`] never returns such a one.
pub fn overview(layout: &Layout, shaped: &RecordedRun, sparse: &RecordedRun) -> String {
    let mut drawing = Drawing::new(LETTERS);
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
    drawing.text(EDGE, 24.0, Anchor::Start, "h", &title);
    let moments = moments(&seed.snapshots);
    // One scale for all of them, so that equal colours are equal values.
    let ranges = moments.iter().map(|snapshot| range(&snapshot.potential));
    let whole = ranges.reduce(|(low, high), (l, h)| (low.min(l), high.max(h)));
    let Some(whole) = whole else { return };
    for (i, snapshot) in moments.into_iter().enumerate() {
        let frame = Frame {
            x: i as f64 * (MAP + GAP) + EDGE,
            y: TOP,
            size: MAP,
        };
        drawing.heat_map(layout, frame, whole, |cell| {
            let state = *cells.get(&cell)?;
            snapshot.potential.get(state).map(|&phi| f64::from(phi))
        });
        let middle = frame.x + MAP / 2.0;
        let lines = [
            format!("step {}", grouped(snapshot.step)),
            format!("{} states", grouped(snapshot.nodes as u64)),
        ];
        for (line, text) in lines.iter().enumerate() {
            let y = frame.y + MAP + LETTERS * (1.2 + 1.2 * line as f64);
            drawing.text(middle, y, Anchor::Middle, "", text);
        }
    }
    let y = TOP + MAP + 3.2 * LETTERS;
    drawing.color_bar(EDGE, y, WIDTH - 2.0 * EDGE, whole);
    let below = y + 12.0 + LETTERS;
    drawing.text(WIDTH / 2.0, below, Anchor::Middle, "", "φ");
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
    let seeds = match shaped.seeds.len() {
        1 => "one seed".to_owned(),
        seeds => format!("mean of {seeds} seeds with 95 % intervals"),
    };
    let (right, bottom) = (WIDTH - 210.0, HEIGHT - 64.0);
    let title = format!("Regret in reward, {seeds}");
    drawing.versus_panel([84.0, 384.0, right, bottom], &title, curves.each_ref());
}

fn regret(run: &RecordedRun) -> Curve {
    Curve::over(run, |row| row.regret)
}

fn regret_at_end(run: &RecordedRun) -> String {
    whole(regret(run).at_end().max(0.0))
}
