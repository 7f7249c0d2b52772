//! Deep sea: N rows, one step down each; a treasure at the bottom right for whoever always goes right.
//!
//! In row i the agent goes right or left; which of its two actions is which is drawn for every cell. A step right costs
//! 0.01 / N, the last one from the bottom right corner pays 1. The episode ends after N steps: 0.99 for the one best
//! policy of 2^N, nothing for doing nothing, and every other way right costs.
//!
//! In the stochastic sea a step right leads straight down with probability 1/N, at the same cost, and a standard normal number is
//! added to what the last step pays at either end of the bottom row, whatever the action. The best policy goes right until
//! a step fails:
//!
//! ```text
//! q = 1 − 1/N,     R* = q^(N−1) − (0.01 / N) Σ_{i<N} q^i = q^(N−1) − 0.01 (1 − q^N)
//! ```

use super::{Board, TabularMdp, likely, surely};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// What all steps right cost together, with a minus.
const COST: f64 = 0.01;

/// The largest board: its cells are as many as the largest map has.
const LARGEST: usize = 4096;

/// Whether steps right always succeed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Current {
    None,
    Down,
}

/// The board of `size` rows, N; `rng` draws which action goes right in each cell. N (N + 1) / 2 cells and the end.
///
/// # Errors
/// [`EnvError::LayoutParameter`] unless 2 ≤ `size` ≤ 4 096.
pub fn deep_sea(size: usize, rng: &mut ChaCha8Rng) -> Result<Board, EnvError> {
    board(size, Current::None, rng)
}

/// The same with steps that fail and rewards that are noisy.
///
/// # Errors
/// As [`deep_sea`].
pub fn stochastic_deep_sea(size: usize, rng: &mut ChaCha8Rng) -> Result<Board, EnvError> {
    board(size, Current::Down, rng)
}

fn board(size: usize, current: Current, rng: &mut ChaCha8Rng) -> Result<Board, EnvError> {
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
    let end = cells.len();
    let below = |row: usize, col: usize| match row + 1 == size {
        true => end,
        false => (row + 1) * (row + 2) / 2 + col,
    };
    let right: Vec<u16> = cells.iter().map(|_| rng.random_range(0..2)).collect();
    let mut terminal = vec![false; end];
    terminal.push(true);
    let fails = 1.0 / size as f64;
    let mdp = TabularMdp::from_fn(2, terminal, |state, action, outcomes| {
        let (row, col) = cells[state];
        if action.0 != right[state] {
            outcomes.push(surely(below(row, col.saturating_sub(1)), 0.0));
            return;
        }
        let treasure = if col + 1 == size { 1.0 } else { 0.0 };
        let pays = treasure - COST / size as f64;
        let (next, beside) = (below(row, col + 1), below(row, col));
        if current == Current::None || next == beside {
            outcomes.push(surely(next, pays));
        } else {
            outcomes.extend([likely(1.0 - fails, next, pays), likely(fails, beside, pays)]);
        }
    })?;
    let mut names: Vec<String> = cells
        .iter()
        .map(|(row, col)| format!("[{row}, {col}]"))
        .collect();
    names.push("end".to_owned());
    let reward_deviations = match current {
        Current::None => Vec::new(),
        Current::Down => {
            let ends_of_the_last_row = [end - size, end - 1];
            let deviation = |state| f64::from(u8::from(ends_of_the_last_row.contains(&state)));
            (0..=end).map(deviation).collect()
        }
    };
    Ok(Board {
        mdp,
        names,
        actions: &["0", "1"], // which of them goes right is another one in each cell
        starts: vec![0],
        reward_deviations,
        max_steps: size,
    })
}
