//! Worlds: what an agent acts in.
//!
//! The contract is that of dm_env and Gymnasium: [`Environment::reset`] begins an episode, each
//! [`Environment::step`] answers with the next state, the reward and how the episode stands. An episode ends in
//! one of two ways that must never be confused: **terminated** (the task is over, nothing can follow: value and
//! potential of what follows are 0) and **truncated** (the clock ran out: the state still has its value).
//!
//! What stands behind the contract:
//!
//! - [`grid_world`]: four moves on a [`layouts::Layout`] (open field, rooms, linked grids, maze, caves, ASCII map);
//! - [`edge_list`]: any finite MDP or graph from a CSV file;
//! - [`boards`]: finite worlds that papers report on;
//! - [`tabular`]: [`TabularMdp`], a finite MDP given by P and R, with what can be computed from it exactly;
//! - [`conformance`]: the contract as a test kit, for these worlds and for yours.
//!
//! Worlds draw from the generator they are given and from nothing else; they allocate when built, never in a step.

pub mod boards;
mod clock;
pub mod conformance;
pub mod edge_list;
mod error;
pub mod grid_world;
pub mod layouts;
mod starts;
pub mod tabular;

pub use boards::{Board, Fall};
pub use edge_list::{EdgeList, EdgeListGoal, EdgeListParams, EdgeListStart};
pub use error::{EdgeListProblem, EnvError};
pub use grid_world::{GridWorld, GridWorldParams, RewardScheme};
pub use layouts::{
    Cell, Direction, Doors, GoalCell, HazardCell, Landmark, Layout, Placement, StartCell, Tile,
};
pub use starts::Starts;
pub use tabular::{
    Caution, MdpState, NoGain, Optimum, Outcome, TabularEnvironment, TabularMdp, Unmeasured,
};

use serde::{Deserialize, Serialize};
use std::fmt::Debug;
use std::hash::Hash;

/// What the rewards of a run may add up to, in size: its square, and its ratio to [`SMALLEST_REWARD`], are still numbers.
pub const LARGEST_RETURN: f64 = 1e27;

/// The smallest size of a reward that is not 0: next to a smaller one others would count as infinite.
pub const SMALLEST_REWARD: f64 = 1e-30;

/// The number of an action, `0..num_actions`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Action(pub u16);

impl Action {
    /// The action as an array index.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Standing of an episode after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StepStatus {
    /// The episode goes on.
    Running,
    /// The task is over: bootstrap from 0, φ(s′) = 0.
    Terminated,
    /// The step limit was reached: bootstrap from the value of s′, keep φ(s′).
    Truncated,
}

impl StepStatus {
    /// Whether the episode is over, either way.
    pub fn is_last(self) -> bool {
        self != StepStatus::Running
    }
}

/// What an environment answers to an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Step<S> {
    /// The state s′ that was reached.
    pub state: S,
    /// The reward R(s, a, s′).
    pub reward: f64,
    /// How the episode stands.
    pub status: StepStatus,
}

/// An episodic world with finitely many actions over any hashable state.
pub trait Environment {
    /// What identifies a state.
    type State: Clone + Eq + Hash + Debug;

    /// Number of actions, the same in every state; at least 1.
    fn num_actions(&self) -> usize;

    /// Begins an episode and returns its start state. May be called at any time.
    fn reset(&mut self) -> Self::State;

    /// Takes one action.
    ///
    /// # Panics
    /// If the episode is over (or none was begun), or if `action` is out of range.
    fn step(&mut self, action: Action) -> Step<Self::State>;
}

/// A world whose true P and R are known.
///
/// For yardsticks (the optimum that regret is measured against, the oracle potential) and for tests: a learner never
/// sees it.
pub trait Model: Environment {
    /// The world as a finite MDP. Its states are all that could occur, visited or not. O(states × actions).
    fn to_mdp(&self) -> TabularMdp;

    /// The number of `state` in [`to_mdp`](Self::to_mdp); O(1).
    ///
    /// # Panics
    /// If `state` is not one of this world's states.
    fn mdp_index(&self, state: &Self::State) -> usize;

    /// Where an episode may begin, as numbers in [`to_mdp`](Self::to_mdp), with the chance of each; never empty. Of a continuing
    /// task, where its one life begins.
    fn start_distribution(&self) -> Starts;

    /// The places of [`start_distribution`](Self::start_distribution).
    fn start_states(&self) -> Vec<usize> {
        self.start_distribution().places().to_vec()
    }

    /// After how many steps an episode is truncated; at least 1.
    fn max_steps(&self) -> usize;

    /// What the best policy earns in an episode and how long it takes; see [`TabularMdp::optimum`] for the cost.
    fn optimum(&self) -> Optimum {
        self.to_mdp()
            .optimum(self.start_distribution(), self.max_steps())
    }

    /// Of a continuing task, whose resets break nothing off, what the best policy earns a step; `None` where episodes
    /// begin anew.
    fn optimal_gain(&self) -> Option<f64> {
        None
    }
}
