//! Boards of the field: finite worlds that papers report on, with the rewards, ends and step limits that they have there.
//!
//! | board | of | what is hard about it |
//! |---|---|---|
//! | [`deep_sea`] | bsuite (Osband et al. 2020) | one path of N steps pays, every step on it costs |
//! | [`stochastic_deep_sea`] | the same | besides, a step towards it may fail, and what pays nothing looks as if it did |
//! | [`river_swim`] | Strehl & Littman 2008 | a small reward near, a large one against the current |
//! | [`cliff_walking`] | Sutton & Barto, example 6.6 | the shortest way runs along the edge |
//! | [`frozen_lake`] | Gymnasium | ends that are no goals, and two slips in three |
//! | [`taxi`] | Dietterich 2000 | four places, a passenger, a destination |
//! | [`bridge`] | ours | the short way is a bad way |
//!
//! All of them are [`TabularMdp`]s: what can be computed of those exactly, can be of these.

mod bridge;
mod cliff_walking;
mod deep_sea;
mod frozen_lake;
mod river_swim;
mod taxi;

pub use bridge::{Fall, bridge};
pub use cliff_walking::cliff_walking;
pub use deep_sea::{deep_sea, stochastic_deep_sea};
pub use frozen_lake::frozen_lake;
pub use river_swim::river_swim;
pub use taxi::taxi;

use super::EnvError;
use super::tabular::{Outcome, TabularEnvironment, TabularMdp};
use rand_chacha::ChaCha8Rng;

/// A finite world with names for its states, where episodes begin, and after how many steps they are cut off.
#[derive(Clone, Debug, PartialEq)]
pub struct Board {
    mdp: TabularMdp,
    names: Vec<String>,
    actions: &'static [&'static str],
    /// Equally likely.
    starts: Vec<usize>,
    /// One per state, or none: then rewards are what the MDP says.
    reward_deviations: Vec<f64>,
    max_steps: usize,
}

impl Board {
    /// The world as a finite MDP.
    pub fn mdp(&self) -> &TabularMdp {
        &self.mdp
    }

    /// Names of the states, in the order of their numbers.
    pub fn state_names(&self) -> &[String] {
        &self.names
    }

    /// Names of the actions, in the order of their numbers.
    pub fn action_names(&self) -> &'static [&'static str] {
        self.actions
    }

    /// Where episodes begin, each equally likely.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// After how many steps an episode is cut off, unless told otherwise.
    pub fn max_steps(&self) -> usize {
        self.max_steps
    }

    /// The world to act in, its episodes cut off after `max_steps` or, without a number, as is usual there.
    ///
    /// # Errors
    /// [`EnvError::NoSteps`].
    pub fn environment(
        &self,
        max_steps: Option<usize>,
        rng: ChaCha8Rng,
    ) -> Result<TabularEnvironment, EnvError> {
        let max_steps = max_steps.unwrap_or(self.max_steps);
        let world = TabularEnvironment::new(self.mdp.clone(), &self.starts, max_steps, rng)?;
        Ok(match self.reward_deviations.as_slice() {
            [] => world,
            deviations => world.with_reward_noise(deviations),
        })
    }

    /// The same as a continuing task; see [`TabularEnvironment::continuing`].
    ///
    /// # Errors
    /// [`EnvError::NoSteps`], and those of [`TabularEnvironment::continuing`].
    pub fn continuing(
        &self,
        max_steps: Option<usize>,
        rng: ChaCha8Rng,
    ) -> Result<TabularEnvironment, EnvError> {
        let world = self.environment(max_steps, rng)?;
        world.continuing(|state| self.names[state].clone())
    }
}

/// The one outcome of an action that never fails.
fn surely(next: usize, reward: f64) -> Outcome {
    likely(1.0, next, reward)
}

fn likely(probability: f64, next: usize, reward: f64) -> Outcome {
    Outcome {
        next: next as u32,
        probability,
        reward,
    }
}

/// A rectangle of cells by number, row by row.
#[derive(Clone, Copy)]
struct Rectangle {
    rows: usize,
    cols: usize,
}

impl Rectangle {
    fn num_cells(self) -> usize {
        self.rows * self.cols
    }

    /// The cell one step down and right from `cell` by these numbers, 0 or ±1; the same where that is outside.
    fn moved(self, cell: usize, [down, right]: [isize; 2]) -> usize {
        let row = (cell / self.cols).saturating_add_signed(down);
        let col = (cell % self.cols).saturating_add_signed(right);
        row.min(self.rows - 1) * self.cols + col.min(self.cols - 1)
    }

    /// `[row, column]` of every cell.
    fn names(self) -> Vec<String> {
        let name = |cell| format!("[{}, {}]", cell / self.cols, cell % self.cols);
        (0..self.num_cells()).map(name).collect()
    }
}

#[cfg(test)]
mod tests;
