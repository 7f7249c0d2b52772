//! Bridge: a short way of 4 steps, each of which falls with probability 0.3, and a safe way of 12. A step costs 1.
//!
//! ```text
//!        A ─go─▶ b1 ─go─▶ b2 ─go─▶ b3 ─go─▶ G          each step on: 0.7, else a fall
//!        └side─▶ s1 ─go─▶ …  ─go─▶ s11 ─go─▶ G
//! ```
//!
//! | a fall | leads | the bridge is worth |
//! |---|---|---:|
//! | `pit` | to an end, at a cost of 100 | −77.8 |
//! | `swamp` | into a chain of 30 steps back to A | −105.5 |
//! | `back` | to A, at a cost of 20 | −70.7 |
//!
//! The best policy takes the safe way in all three, for −12. Whoever follows hops takes the bridge.

use super::{Board, TabularMdp, likely, surely};
use crate::env::EnvError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Consequence of a fall from the bridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fall {
    /// The end of the episode, at a cost of 100.
    #[default]
    Pit,
    /// A chain of 30 steps back to the start.
    Swamp,
    /// Back to the start, at a cost of 20.
    Back,
}

const SAFE: f64 = 0.7;
const STEP: f64 = -1.0;
const MAX_STEPS: usize = 400;
/// States between the start and the goal, by way.
const ON_BRIDGE: usize = 3;
const ON_SAFE_WAY: usize = 11;
const IN_SWAMP: usize = 30;

/// Numbers of the states: A, b1 …, s1 …, then the goal, then the pit or the swamp.
const START: usize = 0;
const FIRST_ON_BRIDGE: usize = 1;
const FIRST_ON_SAFE_WAY: usize = FIRST_ON_BRIDGE + ON_BRIDGE;
const GOAL: usize = FIRST_ON_SAFE_WAY + ON_SAFE_WAY;
const BELOW: usize = GOAL + 1;

/// The board. Actions 0 go, 1 side, 2 back; `side` stays where it is but in A.
///
/// # Errors
/// None; the type is that of all boards.
pub fn bridge(fall: Fall) -> Result<Board, EnvError> {
    let below = match fall {
        Fall::Pit => 1,
        Fall::Swamp => IN_SWAMP,
        Fall::Back => 0,
    };
    let fallen = match fall {
        Fall::Pit => likely(1.0 - SAFE, BELOW, -100.0),
        Fall::Swamp => likely(1.0 - SAFE, BELOW, STEP),
        Fall::Back => likely(1.0 - SAFE, START, -20.0),
    };
    let states = BELOW + below;
    let terminal = (0..states)
        .map(|state| state == GOAL || (fall == Fall::Pit && state == BELOW))
        .collect();
    let mdp = TabularMdp::from_fn(3, terminal, |state, action, outcomes| {
        let on_bridge = state < FIRST_ON_SAFE_WAY;
        let next = match (state, action.0) {
            (state, 0) if on_bridge => {
                let next = if state + 1 == FIRST_ON_SAFE_WAY {
                    GOAL
                } else {
                    state + 1
                };
                outcomes.extend([likely(SAFE, next, STEP), fallen]);
                return;
            }
            (START, 1) => FIRST_ON_SAFE_WAY,
            (state, _) if state >= BELOW => match state + 1 == states {
                true => START,
                false => state + 1,
            },
            (FIRST_ON_SAFE_WAY, 2) => START,
            (state, 0) => state + 1,
            (state, 2) => state.saturating_sub(1),
            (state, _) => state,
        };
        outcomes.push(surely(next, STEP));
    })?;
    Ok(Board {
        mdp,
        names: (0..states).map(|state| name(state, fall)).collect(),
        actions: &["go", "side", "back"],
        starts: vec![START],
        reward_deviations: Vec::new(),
        max_steps: MAX_STEPS,
    })
}

fn name(state: usize, fall: Fall) -> String {
    match state {
        START => "A".to_owned(),
        GOAL => "G".to_owned(),
        BELOW if fall == Fall::Pit => "PIT".to_owned(),
        _ if state < FIRST_ON_SAFE_WAY => format!("b{state}"),
        _ if state < GOAL => format!("s{}", state + 1 - FIRST_ON_SAFE_WAY),
        _ => format!("w{}", state - GOAL),
    }
}
