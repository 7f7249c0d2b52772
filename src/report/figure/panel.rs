//! Panels that several figures are made of: a map with its scale, a graph, a chart.

use super::curves::{Curve, LogChart};
use super::heat_map::Frame;
use super::{Anchor, Drawing};
use crate::archive::RecordedSeed;
use crate::env::layouts::{Cell, Layout};
use crate::report::color::viridis;
use crate::report::validity::cell;
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;

/// Steps of a colour bar.
const SHADES: usize = 64;

/// Place of each state on the map, where its label names one.
pub(super) fn places(layout: &Layout, seed: &RecordedSeed) -> Vec<Option<Cell>> {
    let place = |label: &String| cell(layout, label);
    seed.labels.iter().map(place).collect()
}

impl Drawing {
    /// A map coloured by `values` below its title, and its scale.
    pub(super) fn map_panel(
        &mut self,
        layout: &Layout,
        frame: Frame,
        title: &str,
        values: &HashMap<Cell, f64>,
    ) {
        let fold =
            |start: f64, pick: fn(f64, f64) -> f64| values.values().copied().fold(start, pick);
        let range = (
            fold(f64::INFINITY, f64::min),
            fold(f64::NEG_INFINITY, f64::max),
        );
        self.text(frame.x, frame.y - 14.0, Anchor::Start, "h", title);
        self.heat_map(layout, frame, range, |cell| values.get(&cell).copied());
        if range.0 < range.1 {
            let high = layout.rows() as f64 / layout.rows().max(layout.cols()) as f64;
            self.color_bar(
                frame.x,
                frame.y + frame.size * high + 14.0,
                frame.size,
                range,
            );
        }
    }

    /// The colours from `low` to `high`, with these numbers below.
    pub(super) fn color_bar(&mut self, x: f64, y: f64, width: f64, (low, high): (f64, f64)) {
        let step = width / SHADES as f64;
        for i in 0..SHADES {
            let (left, wide) = (x + i as f64 * step, step + 0.3);
            let fill = viridis(i as f64 / (SHADES - 1) as f64);
            let _ = writeln!(
                self.body,
                r#"<rect x="{left:.1}" y="{y:.1}" width="{wide:.1}" height="9" shape-rendering="crispEdges" fill="{fill}"/>"#
            );
        }
        let end = |value: f64| format!("{value:.1}").replace(".0", "").replace('-', "−");
        let below = y + 12.0 + self.letters;
        self.text(x, below, Anchor::Start, "", &end(low));
        self.text(x + width, below, Anchor::End, "", &end(high));
    }

    /// The discovered graph: a dot for each state where it is on the map, numbered in the order of the map, and a line
    /// for each edge.
    pub(super) fn graph_panel(
        &mut self,
        layout: &Layout,
        frame: Frame,
        title: &str,
        seed: &RecordedSeed,
    ) {
        let side = frame.size / layout.rows().max(layout.cols()) as f64;
        let centre = |cell| {
            let (row, col) = layout.position(cell);
            let at = |i: usize| (i as f64 + 0.5) * side;
            (frame.x + at(col), frame.y + at(row))
        };
        let places = places(layout, seed);
        let place = |state: u32| places.get(state as usize).copied().flatten();
        self.text(frame.x, frame.y - 14.0, Anchor::Start, "h", title);
        let steps = seed.graph.iter().filter(|row| row.from != row.to);
        let edges: BTreeSet<_> = steps
            .map(|row| (row.from.min(row.to), row.from.max(row.to)))
            .collect();
        for (from, to) in edges {
            if let (Some(from), Some(to)) = (place(from), place(to)) {
                self.line(centre(from), centre(to), "edge");
            }
        }
        for cell in places.iter().flatten().copied() {
            let (x, y) = centre(cell);
            let class = match cell {
                cell if layout.is_start(cell) => r#"class="start""#,
                cell if layout.goals.iter().any(|goal| goal.cell == cell) => r#"class="goal""#,
                cell if layout.is_hazard(cell) => r##"class="hazard" fill="#cc79a7""##,
                _ => r#"class="state""#,
            };
            let radius = side * 0.29;
            let _ = writeln!(
                self.body,
                r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" {class}/>"#
            );
            let number = (cell.index() + 1).to_string();
            self.text(x, y + 0.35 * self.letters, Anchor::Middle, "in", &number);
        }
    }

    /// Two curves over episodes, both axes logarithmic, each with its name where it ends: `a` with shaping, `b` without.
    pub(super) fn versus_panel(&mut self, edges: [f64; 4], title: &str, [a, b]: [&Curve; 2]) {
        let chart = LogChart::around(edges, [a, b]);
        self.log_axes(&chart, "episode", title);
        let (right, below) = self.band(&chart, b, "b");
        let (_, above) = self.band(&chart, a, "a");
        let [above, below] = apart([above, below], 1.2 * self.letters);
        for (y, class, name) in [
            (above, "at", "eigentrail"),
            (below, "bt", "actor-critic alone"),
        ] {
            let (x, y) = (right + 8.0, y + 0.35 * self.letters);
            self.text(x, y, Anchor::Start, class, name);
        }
    }
}

/// Two heights, moved apart as far as they are nearer than `gap`.
fn apart([a, b]: [f64; 2], gap: f64) -> [f64; 2] {
    let missing = (gap - (a - b).abs()).max(0.0) / 2.0;
    match a <= b {
        true => [a - missing, b + missing],
        false => [a + missing, b - missing],
    }
}

#[cfg(test)]
mod tests {
    use super::apart;

    #[test]
    fn names_of_curves_do_not_overlap() {
        assert_eq!(apart([50.0, 90.0], 20.0), [50.0, 90.0]);
        assert_eq!(apart([80.0, 80.0], 20.0), [70.0, 90.0]);
        assert_eq!(apart([84.0, 80.0], 20.0), [92.0, 72.0]);
    }
}
