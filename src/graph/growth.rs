//! How much a graph has grown since someone last looked.
//!
//! Nodes and edges are only ever appended, so the pair of counts identifies a moment in the life of a graph, and the
//! difference of two pairs is everything that schedule and warm start need to know.

use serde::{Deserialize, Serialize};

/// A moment in the life of one graph: how many nodes and undirected edges it had.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Revision {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of undirected edges.
    pub edges: usize,
}

/// What was added between two revisions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Growth {
    /// Nodes added.
    pub nodes: usize,
    /// Undirected edges added.
    pub edges: usize,
}

impl Revision {
    /// What was added from `earlier` up to this revision.
    ///
    /// # Panics
    /// If `earlier` has more nodes or edges: it is later, or of another graph.
    pub fn since(self, earlier: Revision) -> Growth {
        assert!(
            earlier.nodes <= self.nodes && earlier.edges <= self.edges,
            "{earlier:?} is not earlier than {self:?}"
        );
        Growth {
            nodes: self.nodes - earlier.nodes,
            edges: self.edges - earlier.edges,
        }
    }
}

impl Growth {
    /// Whether nothing was added.
    pub fn is_empty(self) -> bool {
        self == Growth::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_the_difference_of_two_revisions() {
        let now = Revision { nodes: 7, edges: 9 };
        let then = Revision { nodes: 5, edges: 9 };
        assert_eq!(now.since(then), Growth { nodes: 2, edges: 0 });
        assert!(now.since(now).is_empty() && !now.since(then).is_empty());
    }

    #[test]
    #[should_panic(expected = "is not earlier than")]
    fn a_later_revision_is_refused() {
        Revision::default().since(Revision { nodes: 1, edges: 0 });
    }
}
