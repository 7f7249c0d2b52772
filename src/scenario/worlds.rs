//! The worlds of a scenario, read and built once for all its seeds.

use super::Scenario;
use super::env::GoalList;
use super::error::BrokenRule;
use super::potential_file::PotentialFile;
use super::world::{MovedWorld, World};
use crate::seeds::{Stream, stream};
use crate::shaping::ShapingParams;
use std::path::Path;

/// Worlds of a run: the one that it begins with, and the one that its goals move to; and what files say of the φ of their
/// states. A file that they were read from is not looked at again.
#[derive(Clone, Debug)]
pub struct Worlds {
    first: World,
    moved: Option<MovedWorld>,
    /// The scenario, if each seed has a goal of its own.
    drawn: Option<Box<Scenario>>,
    potentials: Vec<PotentialFile>,
}

impl Worlds {
    /// The worlds that the sections `[env]` and `[run]` describe. Reads the edge list and the file of φ, if there are any.
    /// O(states).
    ///
    /// # Errors
    /// If they do not describe any, with the key to blame.
    pub fn of(scenario: &Scenario) -> Result<Self, BrokenRule> {
        let list = scenario.env.edge_list()?;
        let (list, seed) = (list.as_ref(), scenario.run.seed);
        let mut worlds = Self {
            first: scenario.first_world(list, seed)?,
            moved: scenario.world_after_move(list, seed)?,
            drawn: GoalList::First
                .is_drawn(&scenario.env)
                .then(|| Box::new(scenario.clone())),
            potentials: Vec::new(),
        };
        worlds.read_potential(&scenario.shaping)?;
        Ok(worlds)
    }

    /// Reads the file of φ that `shaping` names, unless it names none or was read before.
    pub(super) fn read_potential(&mut self, shaping: &ShapingParams) -> Result<(), BrokenRule> {
        match &shaping.file {
            Some(path) if self.potential_of(path).is_none() => {
                let file = PotentialFile::read(path, &self.first)?; // goals that move move no states
                self.potentials.push(file);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// What the file at `path` says of φ; none if no scenario or arm named it.
    pub fn potential_of(&self, path: &Path) -> Option<&PotentialFile> {
        self.potentials.iter().find(|file| file.path() == path)
    }

    /// What the authors of files of φ may not have meant, in words; of the files that the scenario or an arm of its own names.
    pub fn potential_cautions(&self) -> impl Iterator<Item = String> + '_ {
        self.potentials.iter().filter_map(PotentialFile::caution)
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
        self.drawn.is_some()
    }

    /// The first one for a run with this seed, which draws slips, random starts and a random goal. O(states).
    pub fn first_for(&self, seed: u64) -> World {
        if let Some(scenario) = &self.drawn {
            let world = scenario.first_world(None, seed); // an edge list draws no goals
            return world.expect("where one seed has a goal the next one has");
        }
        let mut world = self.first.clone();
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
