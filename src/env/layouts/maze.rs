//! Mazes: a random spanning tree of a lattice, plus a share of loops.
//!
//! The lattice has a node in every second row and column, so a map of (2n − 1) × (2m − 1) cells holds n m nodes and no
//! outer wall. A randomised depth-first search opens n m − 1 of the walls between neighbours: exactly one way between
//! any two cells, long and winding. Each further wall that is opened closes one loop.

use super::{Layout, Tile};
use crate::env::EnvError;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// Steps from a node to its neighbours on the lattice, in (rows, columns).
const STEPS: [(isize, isize); 4] = [(-1, 0), (0, 1), (1, 0), (0, -1)];

impl Layout {
    /// A maze of `rows` × `cols` cells, both odd, in which the share `loops` of the walls left standing between
    /// neighbours is opened (0: a tree, 1: none is left). O(cells).
    ///
    /// # Errors
    /// [`EnvError::LayoutParameter`] for an even side or a share outside [0, 1]; [`EnvError::MapTooLarge`].
    pub fn maze(
        rows: usize,
        cols: usize,
        loops: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        require_odd("rows", rows)?;
        require_odd("cols", cols)?;
        if !(0.0..=1.0).contains(&loops) {
            let rule = "the share of walls to open lies in [0, 1]";
            return Err(EnvError::LayoutParameter {
                parameter: "loops",
                value: loops.to_string(),
                rule,
            });
        }
        let mut layout = Layout::filled(rows, cols, Tile::Wall)?;
        carve_tree(&mut layout, rng);
        open_loops(&mut layout, loops, rng);
        Ok(layout)
    }
}

fn require_odd(parameter: &'static str, value: usize) -> Result<(), EnvError> {
    let rule = "a maze has an odd number of rows and of columns, as walls and ways alternate";
    let error = EnvError::LayoutParameter {
        parameter,
        value: value.to_string(),
        rule,
    };
    if value % 2 == 1 { Ok(()) } else { Err(error) }
}

/// Depth-first search with its own stack: a recursive one would overflow on large mazes.
fn carve_tree(layout: &mut Layout, rng: &mut ChaCha8Rng) {
    let mut path = vec![(0_usize, 0_usize)];
    layout.carve(0, 0, 1, 1);
    while let Some(&(row, col)) = path.last() {
        let mut open = [(0, 0); 4];
        let mut count = 0;
        for (down, right) in STEPS {
            let next = row
                .checked_add_signed(2 * down)
                .zip(col.checked_add_signed(2 * right));
            if let Some((r, c)) = next
                && layout
                    .cell(r, c)
                    .is_some_and(|cell| layout.tile(cell) == Tile::Wall)
            {
                open[count] = (r, c);
                count += 1;
            }
        }
        if count == 0 {
            path.pop();
            continue;
        }
        let (r, c) = open[rng.random_range(0..count)];
        layout.carve((row + r) / 2, (col + c) / 2, 1, 1);
        layout.carve(r, c, 1, 1);
        path.push((r, c));
    }
}

/// Opens a share of the walls between two nodes, rounded to a whole number.
fn open_loops(layout: &mut Layout, loops: f64, rng: &mut ChaCha8Rng) {
    if loops == 0.0 {
        return;
    }
    // A wall between two nodes has one odd and one even coordinate; both odd is a pillar.
    let between = |&cell: &super::Cell| {
        let (row, col) = layout.position(cell);
        (row + col) % 2 == 1 && layout.tile(cell) == Tile::Wall
    };
    let mut walls: Vec<_> = layout.cells().filter(between).collect();
    let count = (loops * walls.len() as f64).round() as usize;
    let (chosen, _) = walls.partial_shuffle(rng, count);
    for &mut cell in chosen {
        layout.set_tile(cell, Tile::Free);
    }
}
