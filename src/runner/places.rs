//! Places of the states of a run, on a map or in a list of names, and what its actions are called.

use super::observer::{Knowledge, KnownMap};
use crate::engine::ShapingPipeline;
use crate::env::layouts::{Cell, Layout};
use crate::env::{Action, GridWorld, MdpState};
use crate::graph::StateId;
use crate::scenario::Names;
use std::hash::Hash;

/// Names of the states of a world, and where they are on the map if there is one.
pub(super) trait Places<S> {
    /// Row and column of a state, or its name.
    fn label(&self, state: &S) -> Vec<String>;

    /// Name of an action.
    fn action(&self, action: Action) -> &str;

    /// The map, if there is one.
    fn map(&self) -> Option<Map<'_, S>>;
}

/// Map, and the cell of a state on it.
pub(super) type Map<'a, S> = (&'a Layout, fn(&S) -> Cell);

/// Places on a map.
impl Places<Cell> for Layout {
    fn label(&self, cell: &Cell) -> Vec<String> {
        let (row, col) = self.position(*cell);
        vec![row.to_string(), col.to_string()]
    }

    fn action(&self, action: Action) -> &str {
        GridWorld::ACTION_NAMES[action.index()]
    }

    fn map(&self) -> Option<Map<'_, Cell>> {
        Some((self, |cell| *cell))
    }
}

/// Names by number.
impl Places<MdpState> for Names {
    fn label(&self, state: &MdpState) -> Vec<String> {
        vec![self.states[state.index()].clone()]
    }

    fn action(&self, action: Action) -> &str {
        &self.actions[action.index()]
    }

    fn map(&self) -> Option<Map<'_, MdpState>> {
        None
    }
}

/// What `pipeline` knows of a world whose states are in these places.
pub(super) fn knowledge<'a, S: Clone + Eq + Hash>(
    pipeline: &'a ShapingPipeline<S>,
    places: &'a dyn Places<S>,
) -> Knowledge<'a> {
    let state = |state: StateId| pipeline.graph().state(state);
    let map = places.map().map(|(layout, cell)| KnownMap {
        layout,
        cell: Box::new(move |id| cell(state(id))),
    });
    Knowledge {
        graph: pipeline.transitions(),
        potential: pipeline.potential(),
        eigenpairs: pipeline.spectrum().eigenpairs(),
        label: Box::new(move |id| places.label(state(id))),
        action: Box::new(|action| places.action(action)),
        map,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_called_by_row_and_column() {
        let layout = Layout::open(2, 3).unwrap();
        let cell = layout.cell(1, 2).unwrap();
        assert_eq!(layout.label(&cell), ["1", "2"]);
        assert_eq!(layout.map().unwrap().1(&cell), cell);
    }
}
