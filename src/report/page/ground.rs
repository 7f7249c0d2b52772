//! The map of a seed's world, as far as a page has a use for it.

use crate::env::layouts::Layout;
use crate::scenario::{EnvKind, Scenario, World};

/// Map of the world in which a seed plays this episode, if it has one. Edge lists, which have none, are not read.
pub(super) fn map_of(scenario: &Scenario, seed: u64, episode: usize) -> Option<Layout> {
    if scenario.env.kind == EnvKind::EdgeList {
        return None;
    }
    match scenario.world_in(seed, episode) {
        Ok(World::Grid(world)) => Some(world.layout().clone()),
        _ => None,
    }
}
