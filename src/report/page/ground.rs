//! The world of a seed, as far as a page has a use for it.

use crate::env::layouts::Layout;
use crate::scenario::{EnvKind, Scenario, World};

/// Map of a world, if it has one, and the names of its actions.
pub(super) struct Ground {
    pub layout: Option<Layout>,
    pub actions: Vec<String>,
}

impl Ground {
    /// The world in which a seed plays this episode. An edge list, which has no map, is read for the names of its actions only.
    pub fn of(scenario: &Scenario, seed: u64, episode: usize) -> Self {
        let layout = match scenario.env.kind {
            EnvKind::EdgeList => None,
            _ => match scenario.world_in(seed, episode) {
                Ok(World::Grid(world)) => Some(world.layout().clone()),
                _ => None,
            },
        };
        let actions = scenario.env.action_names();
        Self { layout, actions }
    }
}
