//! What growth leaves as it was: the subtrees of an elimination tree none of whose nodes has other
//! neighbours than before.

use super::elimination::EliminationOrder;
use super::etree::ROOT;
use std::ops::Range;

/// Part of no unchanged subtree.
pub(crate) const NONE: u32 = u32::MAX;

/// The largest subtrees that have not changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct UnchangedSubtrees {
    /// The positions that each takes up in the previous order, ascending; its root is the last of them.
    pub(crate) stretches: Vec<Range<usize>>,
    /// Which of them each position of the previous order belongs to; [`NONE`] if to none.
    pub(crate) owner: Vec<u32>,
}

impl UnchangedSubtrees {
    /// As if everything had changed.
    pub(crate) fn nothing(previous: &EliminationOrder) -> Self {
        Self {
            stretches: Vec::new(),
            owner: vec![NONE; previous.node.len()],
        }
    }

    /// `fingerprint` is that of the graph that has grown; its nodes may have more neighbours, and there may be more of them.
    pub(crate) fn new(previous: &EliminationOrder, fingerprint: &[u64]) -> Self {
        let old = previous.node.len();
        let mut changed: Vec<bool> = previous
            .node
            .iter()
            .map(|&u| fingerprint[u as usize] != previous.fingerprint[u as usize])
            .collect();
        let mut first: Vec<u32> = (0..old as u32).collect();
        for j in 0..old {
            let parent = previous.parent[j] as usize;
            if previous.parent[j] != ROOT {
                changed[parent] |= changed[j];
                first[parent] = first[parent].min(first[j]);
            }
        }
        let is_root = |&j: &usize| {
            let parent = previous.parent[j];
            !changed[j] && (parent == ROOT || changed[parent as usize])
        };
        let stretches: Vec<_> = (0..old)
            .filter(is_root)
            .map(|j| first[j] as usize..j + 1)
            .collect();
        let mut owner = vec![NONE; old];
        for (s, stretch) in stretches.iter().enumerate() {
            owner[stretch.clone()].fill(s as u32);
        }
        Self { stretches, owner }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(parent: Vec<u32>) -> EliminationOrder {
        let n = parent.len() as u32;
        EliminationOrder {
            node: (0..n).rev().collect(),
            position: (0..n).rev().collect(),
            fingerprint: vec![0; n as usize],
            parent,
            ..Default::default()
        }
    }

    #[test]
    fn a_changed_node_thaws_its_ancestors_and_nothing_else() {
        // Two trees: 0, 1 → 2 and 3 → 4, both below 6, 5 below 6 too; 7 → 8.
        let previous = order(vec![2, 2, 6, 4, 6, 6, ROOT, 8, ROOT]);
        let mut fingerprint = vec![0; 10];
        // Position 1 is node 7; node 9 is new.
        fingerprint[7] = 1;
        let unchanged = UnchangedSubtrees::new(&previous, &fingerprint);
        assert_eq!(unchanged.stretches, [0..1, 3..5, 5..6, 7..9]);
        assert_eq!(unchanged.owner, [0, NONE, NONE, 1, 1, 2, NONE, 3, 3]);
    }

    #[test]
    fn without_changes_whole_trees_are_frozen() {
        let previous = order(vec![1, ROOT, ROOT]);
        let unchanged = UnchangedSubtrees::new(&previous, &[0; 3]);
        assert_eq!(unchanged.stretches, [0..2, 2..3]);
        assert_eq!(UnchangedSubtrees::nothing(&previous).owner, [NONE; 3]);
    }
}
