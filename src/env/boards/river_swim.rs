//! River swim: a chain against the current. Left always succeeds and pays 5 at the left end; right mostly stays where it is
//! and pays 10 000 at the right end, when it holds its place there.
//!
//! ```text
//! right:  first state  stay .4, on .6      between  back .05, stay .6, on .35      last state  back .4, stay .6
//! ```
//!
//! No state ends an episode; the step limit does: 20 steps for the board of 6 states, 5 N for others.

use super::{Board, TabularMdp, likely, surely};
use crate::env::EnvError;

const NEAR: f64 = 5.0;
const FAR: f64 = 10_000.0;
const LARGEST: usize = 1_000_000;

/// The board of `size` states, N. Action 0 goes left, 1 right.
///
/// # Errors
/// [`EnvError::LayoutParameter`] unless 3 ≤ `size` ≤ 1 000 000.
pub fn river_swim(size: usize) -> Result<Board, EnvError> {
    if !(3..=LARGEST).contains(&size) {
        return Err(EnvError::LayoutParameter {
            parameter: "size",
            value: size.to_string(),
            rule: "must be from 3 to 1000000 for a river",
        });
    }
    let last = size - 1;
    let mdp = TabularMdp::from_fn(2, vec![false; size], |state, action, outcomes| {
        if action.0 == 0 {
            let pays = if state == 0 { NEAR } else { 0.0 };
            outcomes.push(surely(state.saturating_sub(1), pays));
        } else if state == 0 {
            outcomes.extend([likely(0.4, 0, 0.0), likely(0.6, 1, 0.0)]);
        } else if state == last {
            outcomes.extend([likely(0.4, last - 1, 0.0), likely(0.6, last, FAR)]);
        } else {
            outcomes.extend([
                likely(0.05, state - 1, 0.0),
                likely(0.6, state, 0.0),
                likely(0.35, state + 1, 0.0),
            ]);
        }
    })?;
    Ok(Board {
        mdp,
        names: (0..size).map(|state| format!("s{state}")).collect(),
        actions: &["left", "right"],
        starts: vec![0],
        reward_deviations: Vec::new(),
        max_steps: if size == 6 { 20 } else { 5 * size },
    })
}
