//! Frozen lake: ice with holes. A move goes as meant, or to either side of that, with 1/3 each. Reaching the goal pays 1,
//! falling into a hole ends the episode and pays nothing.

use super::{Board, Rectangle, TabularMdp, likely};
use crate::env::EnvError;

const LAKE_4: &str = "SFFFFHFHFFFHHFFG";
const LAKE_8: &str = "SFFFFFFFFFFFFFFFFFFHFFFFFFFFFHFFFFFHFFFFFHHFFFHFFHFFHFHFFFFHFFFG";

/// The lake of `size` × `size` cells, one of the two that everybody has: 4, cut off after 100 steps, or 8, after 200.
/// Actions 0 left, 1 down, 2 right, 3 up.
///
/// # Errors
/// [`EnvError::LayoutParameter`] for another `size`.
pub fn frozen_lake(size: usize) -> Result<Board, EnvError> {
    let (lake, max_steps) = match size {
        4 => (LAKE_4.as_bytes(), 100),
        8 => (LAKE_8.as_bytes(), 200),
        _ => {
            return Err(EnvError::LayoutParameter {
                parameter: "size",
                value: size.to_string(),
                rule: "must be 4 or 8 for a frozen lake",
            });
        }
    };
    let field = Rectangle {
        rows: size,
        cols: size,
    };
    let terminal = lake.iter().map(|tile| b"HG".contains(tile)).collect();
    let moves = [[0, -1], [1, 0], [0, 1], [-1, 0]];
    let mdp = TabularMdp::from_fn(moves.len(), terminal, |cell, action, outcomes| {
        for turn in [3, 0, 1] {
            let next = field.moved(cell, moves[(action.index() + turn) % 4]);
            let pays = if lake[next] == b'G' { 1.0 } else { 0.0 };
            outcomes.push(likely(1.0 / 3.0, next, pays));
        }
    })?;
    Ok(Board {
        mdp,
        names: field.names(),
        actions: &["left", "down", "right", "up"],
        starts: vec![0],
        reward_deviations: Vec::new(),
        max_steps,
    })
}
