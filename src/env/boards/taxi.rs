//! Taxi: fetch a passenger at one of four places and set them down at another, in a yard of 5 × 5 cells with walls.
//!
//! A step costs 1, the passenger at the destination pays 20 and ends the episode, fetching or setting down elsewhere than
//! at one of the places costs 10. Episodes begin with the taxi anywhere, the passenger at one place and bound for another:
//! 300 starts.

use super::{Board, TabularMdp, surely};
use crate::env::EnvError;

const SIDE: usize = 5;
/// Red, green, yellow, blue: the four places.
const PLACES: [(usize, usize); 4] = [(0, 0), (0, 4), (4, 0), (4, 3)];
/// The passenger's place when in the taxi.
const RIDING: usize = 4;
/// Row and column of the cells that have a wall on their right.
const WALLS: [(usize, usize); 6] = [(0, 1), (1, 1), (3, 0), (3, 2), (4, 0), (4, 2)];
const MAX_STEPS: usize = 200;

/// Taxi, passenger and destination.
#[derive(Clone, Copy)]
struct Yard {
    row: usize,
    col: usize,
    passenger: usize,
    destination: usize,
}

impl Yard {
    /// As Gymnasium numbers them.
    fn of(number: usize) -> Self {
        let (rest, destination) = (number / 4, number % 4);
        let (rest, passenger) = (rest / 5, rest % 5);
        Self {
            row: rest / SIDE,
            col: rest % SIDE,
            passenger,
            destination,
        }
    }

    fn number(self) -> usize {
        ((self.row * SIDE + self.col) * 5 + self.passenger) * 4 + self.destination
    }

    fn name(self) -> String {
        let passenger = ["red", "green", "yellow", "blue", "riding"][self.passenger];
        let destination = ["red", "green", "yellow", "blue"][self.destination];
        format!("[{}, {}] {passenger} to {destination}", self.row, self.col)
    }

    /// Where the action leads, and what it pays: 0 down, 1 up, 2 right, 3 left, 4 fetch, 5 set down.
    fn after(mut self, action: usize) -> (Self, f64) {
        let here = PLACES
            .iter()
            .position(|&place| place == (self.row, self.col));
        match action {
            0 => self.row = (self.row + 1).min(SIDE - 1),
            1 => self.row = self.row.saturating_sub(1),
            2 if !WALLS.contains(&(self.row, self.col)) => self.col = (self.col + 1).min(SIDE - 1),
            3 if self.col > 0 && !WALLS.contains(&(self.row, self.col - 1)) => self.col -= 1,
            4 if here == Some(self.passenger) => self.passenger = RIDING,
            5 if self.passenger == RIDING && here.is_some() => {
                self.passenger = here.unwrap_or(RIDING);
                if here == Some(self.destination) {
                    return (self, 20.0);
                }
            }
            4 | 5 => return (self, -10.0),
            _ => {} // against a wall
        }
        (self, -1.0)
    }

    /// Whether the passenger is where they want to be.
    fn is_done(self) -> bool {
        self.passenger == self.destination
    }
}

/// The board of 500 states.
///
/// # Errors
/// None; the type is that of all boards.
pub fn taxi() -> Result<Board, EnvError> {
    let states: Vec<Yard> = (0..SIDE * SIDE * 5 * 4).map(Yard::of).collect();
    let terminal = states.iter().map(|state| state.is_done()).collect();
    let mdp = TabularMdp::from_fn(6, terminal, |state, action, outcomes| {
        let (next, reward) = states[state].after(action.index());
        outcomes.push(surely(next.number(), reward));
    })?;
    let begins = |&state: &usize| states[state].passenger != RIDING && !states[state].is_done();
    Ok(Board {
        mdp,
        names: states.iter().map(|state| state.name()).collect(),
        actions: &["south", "north", "east", "west", "pickup", "dropoff"],
        starts: (0..states.len()).filter(begins).collect(),
        reward_deviations: Vec::new(),
        max_steps: MAX_STEPS,
    })
}
