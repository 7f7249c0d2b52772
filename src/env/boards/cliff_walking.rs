//! Cliff walking: 4 × 12 cells, start and goal at the ends of the bottom row, a cliff between them. A step costs 1; over
//! the edge it costs 100 and leads back to the start. The shortest way, 13 steps, runs along the edge.

use super::{Board, Rectangle, TabularMdp, surely};
use crate::env::EnvError;

const ROWS: usize = 4;
const COLS: usize = 12;
const START: usize = (ROWS - 1) * COLS;
const GOAL: usize = ROWS * COLS - 1;
const FALL: f64 = -100.0;

/// Steps after which episodes are cut off here; Gymnasium has no limit of its own.
const MAX_STEPS: usize = 1000;

/// The board. Actions 0 up, 1 right, 2 down, 3 left.
///
/// # Errors
/// None; the type is that of all boards.
pub fn cliff_walking() -> Result<Board, EnvError> {
    let field = Rectangle {
        rows: ROWS,
        cols: COLS,
    };
    let terminal = (0..field.num_cells()).map(|cell| cell == GOAL).collect();
    let moves = [[-1, 0], [0, 1], [1, 0], [0, -1]];
    let mdp = TabularMdp::from_fn(moves.len(), terminal, |cell, action, outcomes| {
        let next = field.moved(cell, moves[action.index()]);
        let falls = next > START && next < GOAL;
        outcomes.push(match falls {
            true => surely(START, FALL),
            false => surely(next, -1.0),
        });
    })?;
    Ok(Board {
        mdp,
        names: field.names(),
        actions: &["up", "right", "down", "left"],
        starts: vec![START],
        reward_deviations: Vec::new(),
        max_steps: MAX_STEPS,
    })
}
