//! Distances on a map, in moves: breadth-first search, O(cells).
//!
//! An episode ends at a goal and at a hazard, so no path leads through one: they are entered and never left.

use super::{Cell, Direction, Layout};
use std::collections::VecDeque;

impl Layout {
    /// Moves from `from` to each cell; `None` for walls and for what cannot be reached.
    ///
    /// # Panics
    /// If `from` is not on the map.
    pub fn distances_from(&self, from: Cell) -> Vec<Option<u32>> {
        let is_end = self.end_mask();
        self.search(&[from], |cell, direction| {
            let ends = is_end[cell.index()] && cell != from;
            if ends {
                None
            } else {
                self.neighbor(cell, direction)
            }
        })
    }

    /// Moves from each cell to the nearest of `targets`; `None` for walls and where there is no way.
    ///
    /// # Panics
    /// If a target is not on the map.
    pub fn distances_to(&self, targets: &[Cell]) -> Vec<Option<u32>> {
        let is_end = self.end_mask();
        self.search(targets, |cell, direction| {
            self.predecessor(cell, direction)
                .filter(|before| !is_end[before.index()])
        })
    }

    /// Moves from each cell to the nearest goal.
    pub fn distances_to_goals(&self) -> Vec<Option<u32>> {
        let goals: Vec<_> = self.goals.iter().map(|goal| goal.cell).collect();
        self.distances_to(&goals)
    }

    fn end_mask(&self) -> Vec<bool> {
        let mut mask = vec![false; self.num_cells()];
        let goals = self.goals.iter().map(|goal| goal.cell);
        for cell in goals.chain(self.hazards.iter().map(|hazard| hazard.cell)) {
            mask[cell.index()] = true;
        }
        mask
    }

    fn search(
        &self,
        sources: &[Cell],
        neighbor: impl Fn(Cell, Direction) -> Option<Cell>,
    ) -> Vec<Option<u32>> {
        let mut distance = vec![None; self.num_cells()];
        let mut queue = VecDeque::with_capacity(sources.len());
        for &cell in sources {
            if distance[cell.index()].replace(0).is_none() {
                queue.push_back((cell, 0));
            }
        }
        while let Some((cell, moves)) = queue.pop_front() {
            for next in Direction::ALL
                .into_iter()
                .filter_map(|direction| neighbor(cell, direction))
            {
                if distance[next.index()].is_none() {
                    distance[next.index()] = Some(moves + 1);
                    queue.push_back((next, moves + 1));
                }
            }
        }
        distance
    }
}
