//! From the section `[env]` to a world one can act in.

use super::Scenario;
use super::env::{EnvKind, EnvParams};
use super::error::BrokenRule;
use super::place::Place;
use crate::env::{
    EdgeList, EdgeListGoal, EdgeListParams, GridWorld, Model, Optimum, TabularEnvironment,
};
use crate::seeds::{Stream, stream};

/// Any world that a scenario can describe.
#[derive(Clone, Debug)]
pub enum World {
    /// A map.
    Grid(GridWorld),
    /// An edge list, with the names of its states by their numbers.
    Listed(TabularEnvironment, Vec<String>),
}

impl Scenario {
    /// The world; `seed` is the run's and draws slips and random starts. O(states).
    ///
    /// # Errors
    /// If the section `[env]` does not describe one, with the key to blame.
    pub fn world(&self, seed: u64) -> Result<World, BrokenRule> {
        let rng = stream(seed, Stream::Environment);
        let env = &self.env;
        if env.kind != EnvKind::EdgeList {
            let world = GridWorld::new(env.layout()?, env.grid_world_params(), rng);
            return Ok(World::Grid(world.map_err(|error| env.blame(error))?));
        }
        let path = env.file.as_deref().unwrap_or("".as_ref());
        let list = EdgeList::read(path).map_err(|error| env.blame(error))?;
        let names: Vec<String> = list.state_names().map(str::to_owned).collect();
        let params = env.edge_list_params(&names[0])?;
        let world = list.environment(&params, rng);
        let world = world.map_err(|error| env.blame(error))?;
        Ok(World::Listed(world, names))
    }
}

impl EnvParams {
    /// The numbers that an edge list needs to become a world; it starts in `first` unless told otherwise.
    fn edge_list_params(&self, first: &str) -> Result<EdgeListParams, BrokenRule> {
        let start = match &self.start {
            None => Some(first.to_owned()),
            Some(_) if self.starts_anywhere() => None,
            Some(place) => Some(state_name("env.start", place)?),
        };
        let goals = self.goals.iter().flatten().enumerate().map(|(i, goal)| {
            Ok(EdgeListGoal {
                at: state_name(&format!("env.goals[{i}].at"), &goal.at)?,
                reward: goal.reward,
            })
        });
        Ok(EdgeListParams {
            start,
            goals: goals.collect::<Result<_, BrokenRule>>()?,
            rewards: self.reward,
            max_steps: self.max_steps.given(),
        })
    }
}

/// A state of an edge list.
fn state_name(key: &str, place: &Place) -> Result<String, BrokenRule> {
    match place {
        Place::Named(name) => Ok(name.clone()),
        Place::Cell(_) => Err(BrokenRule::new(
            key,
            format!("{place} is a place on a map; an edge list has names"),
        )),
    }
}

impl World {
    /// Number of actions in every state.
    pub fn num_actions(&self) -> usize {
        use crate::env::Environment;
        match self {
            World::Grid(world) => world.num_actions(),
            World::Listed(world, _) => world.num_actions(),
        }
    }

    /// States there are, and states that can be reached from where episodes begin. O(states × actions).
    pub fn num_states(&self) -> (usize, usize) {
        let (mdp, starts) = match self {
            World::Grid(world) => (world.to_mdp(), world.start_states()),
            World::Listed(world, _) => (world.to_mdp(), world.start_states()),
        };
        let reached = mdp.reachable_from(&starts);
        (mdp.num_states(), reached.iter().filter(|&&r| r).count())
    }

    /// After how many steps an episode is cut off.
    pub fn max_steps(&self) -> usize {
        match self {
            World::Grid(world) => Model::max_steps(world),
            World::Listed(world, _) => Model::max_steps(world),
        }
    }

    /// What the best policy earns in an episode and how long it takes.
    pub fn optimum(&self) -> Optimum {
        match self {
            World::Grid(world) => world.optimum(),
            World::Listed(world, _) => world.optimum(),
        }
    }
}
