//! A goal somewhere: at one of the places where it can be reached, each equally likely.

use super::{Cell, Direction, GoalCell, Layout, Tile};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

impl Layout {
    /// The same map with one goal instead of those it has: at a cell that `rng` draws from all that can be entered coming
    /// from the start, or, if episodes begin anywhere, from any other cell; hazards are no such places. It pays what the reward scheme says. O(cells).
    ///
    /// # Errors
    /// [`EnvError::NoPlaceForGoal`] if there is none; [`EnvError::NoStart`], and [`EnvError::StartInWall`] if the start is.
    pub fn with_random_goal(
        mut self,
        random_start: bool,
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, EnvError> {
        self.goals.clear();
        let places = self.places_for_goal(random_start)?;
        if places.is_empty() {
            return Err(EnvError::NoPlaceForGoal);
        }
        let cell = places[rng.random_range(0..places.len() as u32) as usize];
        self.goals.push(GoalCell::new(cell));
        Ok(self)
    }

    /// The cells where a single goal could be reached, in reading order.
    fn places_for_goal(&self, random_start: bool) -> Result<Vec<Cell>, EnvError> {
        if random_start {
            let is_entered = |cell: Cell| {
                let ways = Direction::ALL.into_iter();
                let mut before = ways.filter_map(|direction| self.predecessor(cell, direction));
                before.any(|cell| !self.is_hazard(cell))
            };
            let places = self.free_cells().filter(|&cell| !self.is_hazard(cell));
            return Ok(places.filter(|&cell| is_entered(cell)).collect());
        }
        let start = self.start.ok_or(EnvError::NoStart)?;
        if self.tile(start) == Tile::Wall {
            let (row, col) = self.position(start);
            return Err(EnvError::StartInWall { row, col });
        }
        let distances = self.distances_from(start);
        let is_reached = |cell: Cell| distances[cell.index()].is_some_and(|moves| moves > 0);
        let places = self.free_cells().filter(|&cell| !self.is_hazard(cell));
        Ok(places.filter(|&cell| is_reached(cell)).collect())
    }
}
