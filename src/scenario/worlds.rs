//! The worlds of a scenario, read and built once for all its seeds.

use super::Scenario;
use super::env::GoalList;
use super::error::BrokenRule;
use super::world::{MovedWorld, World};
use crate::seeds::{Stream, stream};

/// Worlds of a run: the one that it begins with, and the one that its goals move to. A file that they were read from is not
/// looked at again.
#[derive(Clone, Debug)]
pub struct Worlds {
    first: World,
    moved: Option<MovedWorld>,
    /// Whether each seed has a goal of its own.
    draw_goal: bool,
}

impl Worlds {
    /// The worlds that the sections `[env]` and `[run]` describe. Reads the edge list, if there is one. O(states).
    ///
    /// # Errors
    /// If they do not describe any, with the key to blame.
    pub fn of(scenario: &Scenario) -> Result<Self, BrokenRule> {
        let list = scenario.env.edge_list()?;
        let (list, seed) = (list.as_ref(), scenario.run.seed);
        Ok(Self {
            first: scenario.first_world(list, seed)?,
            moved: scenario.world_after_move(list, seed)?,
            draw_goal: GoalList::First.is_drawn(&scenario.env),
        })
    }

    /// The world that runs begin with, whatever their seed; where [each has its own](Self::differ_by_seed), that of `run.seed`.
    pub fn first(&self) -> &World {
        &self.first
    }

    /// The world whose goals have moved, whatever the seed; none if they do not move.
    pub fn moved(&self) -> Option<&MovedWorld> {
        self.moved.as_ref()
    }

    /// Whether the goal that a run begins with is at another place for each seed.
    pub fn differ_by_seed(&self) -> bool {
        self.draw_goal
    }

    /// The first one for a run with this seed, which draws slips, random starts and a random goal. O(states).
    pub fn first_for(&self, seed: u64) -> World {
        let mut world = self.first.clone();
        if self.draw_goal {
            world.draw_goal(seed);
        }
        world.reseed(stream(seed, Stream::Environment));
        world
    }

    /// The one with the goals that a run with this seed ends with; none if they do not move.
    pub fn moved_for(&self, seed: u64) -> Option<MovedWorld> {
        let mut moved = self.moved.clone()?;
        moved.world.reseed(stream(seed, Stream::MovedEnvironment));
        Some(moved)
    }

    /// The one in which a run with this seed plays episode number `episode`, from 0.
    pub fn in_episode(&self, seed: u64, episode: usize) -> World {
        match self.moved_for(seed) {
            Some(moved) if moved.after <= episode => moved.world,
            _ => self.first_for(seed),
        }
    }
}
