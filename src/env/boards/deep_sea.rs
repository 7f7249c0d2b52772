//! Deep sea: N rows, one step down each; a treasure at the bottom right for whoever always goes right.
//!
//! In row i the agent goes right or left; which of its two actions is which is drawn for every cell. A step right costs
//! 0.01 / N, the last one from the bottom right corner pays 1. The episode ends after N steps: 0.99 for the one best
//! policy of 2^N, nothing for doing nothing, and every other way right costs.

use super::{Board, TabularMdp, surely};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// What all steps right cost together, with a minus.
const COST: f64 = 0.01;

/// The largest board: its cells are as many as the largest map has.
const LARGEST: usize = 4096;

/// The board of `size` rows, N; `rng` draws which action goes right in each cell. N (N + 1) / 2 cells and the end.
///
/// # Errors
/// [`EnvError::LayoutParameter`] unless 2 ≤ `size` ≤ 4 096.
pub fn deep_sea(size: usize, rng: &mut ChaCha8Rng) -> Result<Board, EnvError> {
    if !(2..=LARGEST).contains(&size) {
        return Err(EnvError::LayoutParameter {
            parameter: "size",
            value: size.to_string(),
            rule: "must be from 2 to 4096 for a deep sea",
        });
    }
    let cells: Vec<(usize, usize)> = (0..size)
        .flat_map(|row| (0..=row).map(move |col| (row, col)))
        .collect();
    let number = |row: usize, col: usize| row * (row + 1) / 2 + col;
    let end = cells.len();
    let right: Vec<u16> = cells.iter().map(|_| rng.random_range(0..2)).collect();
    let mut terminal = vec![false; end];
    terminal.push(true);
    let mdp = TabularMdp::from_fn(2, terminal, |state, action, outcomes| {
        let (row, col) = cells[state];
        let goes_right = action.0 == right[state];
        let next_col = if goes_right {
            col + 1
        } else {
            col.saturating_sub(1)
        };
        let next = if row + 1 == size {
            end
        } else {
            number(row + 1, next_col)
        };
        let treasure = if goes_right && col + 1 == size {
            1.0
        } else {
            0.0
        };
        let cost = if goes_right { COST / size as f64 } else { 0.0 };
        outcomes.push(surely(next, treasure - cost));
    })?;
    let mut names: Vec<String> = cells
        .iter()
        .map(|(row, col)| format!("[{row}, {col}]"))
        .collect();
    names.push("end".to_owned());
    Ok(Board {
        mdp,
        names,
        starts: vec![0],
        max_steps: size,
    })
}
