//! Caves: a cellular automaton that turns noise into rooms and passages.
//!
//! Each cell is a wall with probability `fill`. Then, a few times over, a cell becomes a wall if at least five of the
//! nine cells around and including it are walls (beyond the edge counts as wall). The largest connected part stays,
//! the others are filled up, so that every free cell can be reached from every other. Seeds give maps of one family.

use super::{Cell, Direction, Layout, Tile};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// More rounds change nothing but the time they take.
const MOST_ROUNDS: usize = 1000;

impl Layout {
    /// Caves on `rows` × `cols` cells; `fill` = 0.4 and `rounds` = 4 give winding caves. O(cells × rounds).
    ///
    /// # Errors
    /// [`EnvError::LayoutParameter`] for a share outside [0, 1) or too many rounds, [`EnvError::NoFreeCell`] if the walls grow together,
    /// [`EnvError::EmptyMap`], [`EnvError::MapTooLarge`].
    pub fn caves(
        rows: usize,
        cols: usize,
        fill: f64,
        rounds: usize,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        if !(0.0..1.0).contains(&fill) {
            let rule = "the share of walls lies in [0, 1)";
            return Err(EnvError::LayoutParameter {
                parameter: "fill",
                value: fill.to_string(),
                rule,
            });
        }
        if rounds > MOST_ROUNDS {
            let rule = "at most 1000 rounds; caves no longer change after a few";
            return Err(EnvError::LayoutParameter {
                parameter: "rounds",
                value: rounds.to_string(),
                rule,
            });
        }
        let mut layout = Layout::filled(rows, cols, Tile::Free)?;
        for cell in layout.cells() {
            if rng.random::<f64>() < fill {
                layout.set_tile(cell, Tile::Wall);
            }
        }
        for _ in 0..rounds {
            layout = smoothed(&layout);
        }
        keep_largest_part(&mut layout)?;
        Ok(layout)
    }
}

/// One round of the automaton.
fn smoothed(layout: &Layout) -> Layout {
    let mut next = layout.clone();
    for cell in layout.cells() {
        let (row, col) = layout.position(cell);
        let free = |r: usize, c: usize| {
            layout
                .cell(r, c)
                .is_some_and(|near| layout.tile(near) == Tile::Free)
        };
        let around = (0..9).filter(|i| {
            // One row up and one column left of the first row or column wraps to a number beyond the map: not free.
            free((row + i / 3).wrapping_sub(1), (col + i % 3).wrapping_sub(1))
        });
        let walls = 9 - around.count();
        next.set_tile(cell, if walls >= 5 { Tile::Wall } else { Tile::Free });
    }
    next
}

/// Fills every free cell outside the largest connected part; of two equally large ones the first stays.
fn keep_largest_part(layout: &mut Layout) -> Result<(), EnvError> {
    let mut part_of = vec![0_u32; layout.num_cells()];
    let mut sizes = vec![0_usize];
    for cell in layout.free_cells() {
        if part_of[cell.index()] == 0 {
            let label = sizes.len() as u32;
            sizes.push(label_part(layout, cell, label, &mut part_of));
        }
    }
    let largest = (1..sizes.len())
        .rev()
        .max_by_key(|&part| sizes[part])
        .ok_or(EnvError::NoFreeCell)?;
    for cell in layout.cells() {
        if part_of[cell.index()] as usize != largest {
            layout.set_tile(cell, Tile::Wall);
        }
    }
    Ok(())
}

/// Labels every cell that can be reached from `from`, itself included, and returns how many there are.
fn label_part(layout: &Layout, from: Cell, label: u32, part_of: &mut [u32]) -> usize {
    let mut found = vec![from];
    part_of[from.index()] = label;
    let mut visited = 0;
    while visited < found.len() {
        let cell = found[visited];
        visited += 1;
        for next in Direction::ALL
            .into_iter()
            .filter_map(|direction| layout.neighbor(cell, direction))
        {
            if part_of[next.index()] == 0 {
                part_of[next.index()] = label;
                found.push(next);
            }
        }
    }
    visited
}
