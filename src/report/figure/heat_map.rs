//! A function of the cells, as colours on the map.

use super::{Anchor, Drawing};
use crate::env::layouts::{Cell, Layout, Tile};
use crate::report::color::viridis;
use std::fmt::Write;

/// A square on the page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// Width and height.
    pub size: f64,
}

impl Drawing {
    /// Draws the map into `frame`, coloured by `value` from `range.0` to `range.1`; cells without one stay
    /// pale, but for the start and the goals.
    pub(super) fn heat_map(
        &mut self,
        layout: &Layout,
        frame: Frame,
        range: (f64, f64),
        value: impl Fn(Cell) -> Option<f64>,
    ) {
        let side = frame.size / layout.rows().max(layout.cols()) as f64;
        let corner = |cell| {
            let (row, col) = layout.position(cell);
            (frame.x + col as f64 * side, frame.y + row as f64 * side)
        };
        let look = |cell| match (layout.tile(cell), value(cell)) {
            (Tile::Wall, _) => r#"class="wall""#.to_owned(),
            (_, None) if layout.is_start(cell) => r#"class="start""#.to_owned(),
            (_, None) if layout.goals.iter().any(|goal| goal.cell == cell) => {
                r#"class="goal""#.to_owned()
            }
            (_, None) if layout.is_hazard(cell) => r##"class="hazard" fill="#cc79a7""##.to_owned(),
            (_, None) => r#"class="unseen""#.to_owned(),
            (_, Some(v)) => {
                let share = (v - range.0) / (range.1 - range.0).max(f64::MIN_POSITIVE);
                format!(r#"fill="{}""#, viridis(share))
            }
        };
        self.body.push_str("<g shape-rendering=\"crispEdges\">\n");
        for row in 0..layout.rows() {
            let mut looks = (0..layout.cols())
                .filter_map(|col| layout.cell(row, col))
                .map(look);
            let mut from = 0;
            let mut present = looks.next();
            // Neighbours that look the same are one rectangle.
            while let Some(here) = present {
                let mut cells = 1;
                present = looks.next();
                while present.as_ref() == Some(&here) {
                    cells += 1;
                    present = looks.next();
                }
                let (x, y) = (frame.x + from as f64 * side, frame.y + row as f64 * side);
                // A hair wider than the cells, so that no seams show.
                let (wide, high) = (cells as f64 * side + 0.3, side + 0.3);
                let _ = writeln!(
                    self.body,
                    r#"<rect x="{x:.1}" y="{y:.1}" width="{wide:.1}" height="{high:.1}" {here}/>"#
                );
                from += cells;
            }
        }
        self.body.push_str("</g>\n");
        let letters = self.letters;
        let start = layout.start.map(|cell| (cell, "S"));
        for (cell, mark) in start
            .into_iter()
            .chain(layout.hazards.iter().map(|h| (h.cell, "X")))
            .chain(layout.goals.iter().map(|g| (g.cell, "G")))
        {
            let (x, y) = corner(cell);
            let high = side * layout.rows() as f64;
            let wide = side * layout.cols() as f64;
            // Whole letters, also where a cell is smaller than one.
            self.text(
                (x + side / 2.0)
                    .max(frame.x + letters * 0.46)
                    .min(frame.x + wide - letters * 0.46),
                (y + side / 2.0)
                    .max(frame.y + letters * 0.54)
                    .min(frame.y + high - letters * 0.54)
                    + letters * 0.35,
                Anchor::Middle,
                "on",
                mark,
            );
        }
    }
}
