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

    fn color_bar(&mut self, x: f64, y: f64, width: f64, (low, high): (f64, f64)) {
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
        self.text(x, y + 25.0, Anchor::Start, "", &end(low));
        self.text(x + width, y + 25.0, Anchor::End, "", &end(high));
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
            self.text(x, y + 4.5, Anchor::Middle, "in", &number);
        }
    }

    /// Two curves over episodes, both axes logarithmic: `a` with shaping, `b` without.
    pub(super) fn versus_panel(&mut self, edges: [f64; 4], title: &str, [a, b]: [&Curve; 2]) {
        let values = || [a, b].into_iter().flat_map(|c| &c.band.middle).copied();
        let lowest = values().filter(|&v| v > 0.0).fold(f64::INFINITY, f64::min);
        let highest = [a, b].into_iter().flat_map(|c| &c.band.high);
        let highest = highest.copied().fold(10.0, f64::max);
        let chart = LogChart {
            edges,
            x: (
                0.0,
                libm::log10(a.num_episodes().max(b.num_episodes()).max(2) as f64),
            ),
            y: (
                libm::log10(lowest.min(highest / 10.0)).floor(),
                libm::log10(highest).ceil(),
            ),
        };
        self.log_axes(&chart, "episode", title);
        self.band(&chart, b, "b");
        self.band(&chart, a, "a");
        let [_, top, right, _] = edges;
        self.text(right, top + 14.0, Anchor::End, "at", "eigentrail");
        self.text(right, top + 32.0, Anchor::End, "bt", "sparse reward alone");
    }
}
