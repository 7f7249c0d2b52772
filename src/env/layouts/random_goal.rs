//! A goal somewhere: at one of the places where it can be reached, each equally likely.

use super::{Cell, Direction, GoalCell, Layout, Tile};
use crate::env::EnvError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

impl Layout {
    /// The same map with one goal instead of those it has: at a cell that `rng` draws from all that can be entered coming
    /// from the start, or, if episodes begin anywhere, from any other cell. It pays what the reward scheme says. O(cells).
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
            let is_entered = |cell: &Cell| {
                let mut ways = Direction::ALL.into_iter();
                ways.any(|direction| self.predecessor(*cell, direction).is_some())
            };
            return Ok(self.free_cells().filter(is_entered).collect());
        }
        let start = self.start.ok_or(EnvError::NoStart)?;
        if self.tile(start) == Tile::Wall {
            let (row, col) = self.position(start);
            return Err(EnvError::StartInWall { row, col });
        }
        let distances = self.distances_from(start);
        let is_reached = |cell: &Cell| distances[cell.index()].is_some_and(|moves| moves > 0);
        Ok(self.free_cells().filter(is_reached).collect())
    }
}
