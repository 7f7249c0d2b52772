//! The map of a grid world for a walker that turns: MiniGrid's three actions (Chevalier-Boisvert et al. 2023).
//!
//! A state is a cell with a heading. Action 0 turns left, 1 turns right, 2 goes forward; an episode begins heading east,
//! MiniGrid's direction 0. P: turns never fail; forward leads where the grid world's move in the direction of the heading
//! leads, slips to its sides included, and never changes the heading. So walls, edges and one-way cells are the same, and a
//! cell can be reached from another one exactly if it can by moves. R and the ends are those of the cells, whatever the
//! heading.

use super::GridWorld;
use crate::env::layouts::{Cell, Direction, MAX_CELLS};
use crate::env::tabular::{Outcome, TabularEnvironment, TabularMdp};
use crate::env::{Action, EnvError};

/// Headings in MiniGrid's order, clockwise, with their names.
const HEADINGS: [(Direction, &str); 4] = [
    (Direction::Right, "east"),
    (Direction::Down, "south"),
    (Direction::Left, "west"),
    (Direction::Up, "north"),
];
/// The number of the heading that episodes begin with.
const EAST: usize = 0;

const LEFT: Action = Action(0);
const RIGHT: Action = Action(1);

impl GridWorld {
    /// The world on the same map with three actions: turn left, turn right, forward. State 4 c + h is cell c of
    /// [`mdp_cells`](Self::mdp_cells) with heading h of east, south, west, north. Without a limit of its own, an episode is
    /// truncated after ten times as many steps as there are states. O(cells) time and memory: about 500 bytes a cell.
    ///
    /// # Errors
    /// [`EnvError::MapTooLarge`] above a quarter of the cells of the largest map, for each counts four times.
    pub fn turning(&self) -> Result<TabularEnvironment, EnvError> {
        let limit = MAX_CELLS / HEADINGS.len();
        if self.layout.num_cells() > limit {
            return Err(EnvError::MapTooLarge {
                rows: self.layout.rows(),
                cols: self.layout.cols(),
                limit,
            });
        }
        let mdp = self.turning_mdp();
        let max_steps = self.params.resolved_max_steps(mdp.num_states());
        let starts = self
            .starts
            .map(|start| turned(self.ranks[start.index()], EAST) as usize);
        TabularEnvironment::new(mdp, starts, max_steps, self.rng.clone())
    }

    /// Names of the states of [`turning`](Self::turning), in the order of their numbers: `row,column,heading`.
    pub fn turning_names(&self) -> Vec<String> {
        let cells = self.mdp_cells().map(|cell| self.layout.position(cell));
        let names = cells
            .flat_map(|(row, col)| HEADINGS.map(|(_, heading)| format!("{row},{col},{heading}")));
        names.collect()
    }

    /// Names of the actions of [`turning`](Self::turning), in the order of their numbers.
    pub const TURNING_ACTION_NAMES: [&str; 3] = ["left", "right", "forward"];

    fn turning_mdp(&self) -> TabularMdp {
        let cells: Vec<_> = self.mdp_cells().collect();
        let headings = HEADINGS.len();
        let ends = |&cell: &Cell| [self.is_end(cell); HEADINGS.len()];
        let terminal = cells.iter().flat_map(ends).collect();
        TabularMdp::from_fn(3, terminal, |state, action, outcomes| {
            let (rank, heading) = (state / headings, state % headings);
            let turn = |by: usize| Outcome {
                next: turned(rank as u32, (heading + by) % headings),
                probability: 1.0,
                reward: self.params.rewards.step(),
            };
            match action {
                LEFT => outcomes.push(turn(headings - 1)),
                RIGHT => outcomes.push(turn(1)),
                _ => {
                    let (direction, _) = HEADINGS[heading];
                    self.outcomes(cells[rank], direction.action(), outcomes);
                    for outcome in outcomes {
                        outcome.next = turned(outcome.next, heading);
                    }
                }
            }
        })
        .expect("a validated world has finite rewards and probabilities that sum to 1")
    }
}

/// The number of a state, by its cell's and its heading's.
fn turned(rank: u32, heading: usize) -> u32 {
    rank * HEADINGS.len() as u32 + heading as u32
}
