//! The grid world as an MDP: its free cells, numbered in reading order.

use super::GridWorld;
use crate::env::layouts::{Cell, Tile};
use crate::env::tabular::{Outcome, TabularMdp};
use crate::env::{Action, Model, Starts};

impl GridWorld {
    /// The cells in the order of their numbers in [`to_mdp`](Model::to_mdp).
    pub fn mdp_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.layout.free_cells()
    }

    /// The outcomes of `action` in `cell`, those that lead to the same cell joined.
    pub(super) fn outcomes(&self, cell: Cell, action: Action, outcomes: &mut Vec<Outcome>) {
        let slip = self.params.slip;
        let chosen = action.index();
        for (direction, probability) in [
            (chosen, 1.0 - slip),
            ((chosen + 1) % 4, slip / 2.0),
            ((chosen + 3) % 4, slip / 2.0),
        ] {
            let to = self.moved(cell, direction);
            let next = self.ranks[to.index()];
            match outcomes.iter_mut().find(|outcome| outcome.next == next) {
                Some(known) => known.probability += probability,
                None => outcomes.push(Outcome {
                    next,
                    probability,
                    reward: self.reward_on_entering(to),
                }),
            }
        }
    }
}

impl Model for GridWorld {
    fn to_mdp(&self) -> TabularMdp {
        let cells: Vec<_> = self.mdp_cells().collect();
        let terminal = cells.iter().map(|&cell| self.is_end(cell)).collect();
        TabularMdp::from_fn(4, terminal, |state, action, outcomes| {
            self.outcomes(cells[state], action, outcomes)
        })
        .expect("a validated world has finite rewards and probabilities that sum to 1")
    }

    fn mdp_index(&self, state: &Cell) -> usize {
        assert!(
            self.layout.tile(*state) != Tile::Wall,
            "{state:?} is a wall"
        );
        self.ranks[state.index()] as usize
    }

    fn start_distribution(&self) -> Starts {
        self.starts.map(|start| self.mdp_index(start))
    }

    fn max_steps(&self) -> usize {
        self.clock.max_steps()
    }
}
