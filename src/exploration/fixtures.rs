//! Worlds for the tests of this module: a table of moves, and random walled grids.

use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use proptest::prelude::*;

/// A deterministic world: `moves[s][a]` is where action a leads.
#[derive(Clone, Debug)]
pub struct World {
    pub moves: Vec<Vec<usize>>,
}

impl World {
    pub fn num_states(&self) -> usize {
        self.moves.len()
    }

    pub fn num_actions(&self) -> usize {
        self.moves[0].len()
    }

    /// A rectangle, moves in the order up, right, down, left; `blocked(cell, direction)` stays in place.
    pub fn grid(rows: usize, cols: usize, blocked: impl Fn(usize, usize) -> bool) -> Self {
        let step = |cell: usize, direction: usize| {
            let (row, col) = (cell / cols, cell % cols);
            let inside = [row > 0, col + 1 < cols, row + 1 < rows, col > 0];
            let next = [
                cell.wrapping_sub(cols),
                cell + 1,
                cell + cols,
                cell.wrapping_sub(1),
            ];
            match inside[direction] && !blocked(cell, direction) {
                true => next[direction],
                false => cell,
            }
        };
        let row = |cell| (0..4).map(|direction| step(cell, direction)).collect();
        World {
            moves: (0..rows * cols).map(row).collect(),
        }
    }

    /// The same on a torus, without walls.
    pub fn torus(rows: usize, cols: usize) -> Self {
        let row = |cell: usize| {
            let (r, c) = (cell / cols, cell % cols);
            let at = |r: usize, c: usize| (r % rows) * cols + c % cols;
            vec![
                at(r + rows - 1, c),
                at(r, c + 1),
                at(r + 1, c),
                at(r, c + cols - 1),
            ]
        };
        World {
            moves: (0..rows * cols).map(row).collect(),
        }
    }

    /// A turtle on an open square: its state is (cell, heading); it can go ahead, turn left, turn right.
    pub fn turtle(side: usize) -> Self {
        Self::grid(side, side, |_, _| false).turning()
    }

    /// The same on the cells of this world, whose actions are the steps ahead by heading, in the order of turns to the right.
    pub fn turning(&self) -> Self {
        let k = self.num_actions();
        let row = |state: usize| {
            let (cell, heading) = (state / k, state % k);
            vec![
                self.moves[cell][heading] * k + heading,
                cell * k + (heading + k - 1) % k,
                cell * k + (heading + 1) % k,
            ]
        };
        World {
            moves: (0..self.num_states() * k).map(row).collect(),
        }
    }

    /// A rectangle of the triangular lattice, moves in the order of turns by a sixth.
    pub fn honeycomb(rows: usize, cols: usize) -> Self {
        const STEPS: [(i32, i32); 6] = [(0, 1), (1, 0), (1, -1), (0, -1), (-1, 0), (-1, 1)];
        let step = |cell: usize, (down, right): (i32, i32)| {
            let row = (cell / cols) as i32 + down;
            let col = (cell % cols) as i32 + right;
            let inside = (0..rows as i32).contains(&row) && (0..cols as i32).contains(&col);
            match inside {
                true => row as usize * cols + col as usize,
                false => cell,
            }
        };
        let row = |cell: usize| STEPS.map(|by| step(cell, by)).to_vec();
        World {
            moves: (0..rows * cols).map(row).collect(),
        }
    }

    /// The same with one action more: `to[s]` is where it leads.
    pub fn with_action(mut self, to: impl Fn(usize) -> usize) -> Self {
        for (state, moves) in self.moves.iter_mut().enumerate() {
            moves.push(to(state));
        }
        self
    }

    /// The successor when three moves in ten go to one of the neighbouring directions instead; `draw` in 0..1.
    pub fn slipped(&self, state: usize, action: usize, draw: f64) -> usize {
        let n = self.num_actions();
        let action = match draw {
            _ if draw < 0.15 => (action + 1) % n,
            _ if draw < 0.3 => (action + n - 1) % n,
            _ => action,
        };
        self.moves[state][action]
    }

    /// Steps from `from` to every state; `None` out of reach.
    pub fn hops_from(&self, from: usize) -> Vec<Option<u32>> {
        let mut hops = vec![None; self.num_states()];
        let mut layer = vec![from];
        hops[from] = Some(0);
        for depth in 1.. {
            let mut next = Vec::new();
            for &to in layer.iter().flat_map(|&state| &self.moves[state]) {
                if hops[to].is_none() {
                    hops[to] = Some(depth);
                    next.push(to);
                }
            }
            if next.is_empty() {
                break;
            }
            layer = next;
        }
        hops
    }
}

/// Grids of up to 6 × 6 cells with random walls between neighbours, some of which can be passed one way.
pub fn walled_grids() -> impl Strategy<Value = World> {
    (1usize..=6, 2usize..=6).prop_flat_map(|(rows, cols)| {
        prop::collection::vec(0u8..10, rows * cols * 4).prop_map(move |walls| {
            let one_sided = |cell: usize, direction: usize| walls[cell * 4 + direction];
            World::grid(rows, cols, |cell, direction| {
                let back = match direction {
                    0 => cell.checked_sub(cols).map(|next| (next, 2)),
                    1 => Some((cell + 1, 3)),
                    2 => Some((cell + cols, 0)),
                    _ => cell.checked_sub(1).map(|next| (next, 1)),
                };
                // 0, 1: a wall on both sides; 2: this way only is closed.
                let beyond = back.filter(|&(next, _)| next < rows * cols);
                one_sided(cell, direction) <= 2
                    || beyond.is_some_and(|(next, back)| one_sided(next, back) <= 1)
            })
        })
    })
}

/// What may have been seen of worlds of up to 8 states: transitions anyhow.
pub fn small_graphs() -> impl Strategy<Value = TransitionGraph> {
    (1u32..=8, 1u16..=3).prop_flat_map(|(states, actions)| {
        let seen = (0..states, 0..actions, 0..states);
        prop::collection::vec(seen, 0..24).prop_map(move |seen| {
            let mut graph = TransitionGraph::new(usize::from(actions));
            for _ in 0..states {
                graph.add_state();
            }
            for (from, action, to) in seen {
                graph.record(StateId(from), Action(action), -1.0, StateId(to), false);
            }
            graph
        })
    })
}
