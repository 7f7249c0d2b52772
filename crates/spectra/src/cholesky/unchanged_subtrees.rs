//! What growth leaves as it was: the subtrees of an elimination tree none of whose nodes has other
//! neighbours than before.

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
    /// As if everything had changed, in an order of so many positions.
    pub(crate) fn nothing(positions: usize) -> Self {
        Self {
            stretches: Vec::new(),
            owner: vec![NONE; positions],
        }
    }

    /// Those of the tree `parent` of the previous order; `changed` says of each of its positions whether the node there has
    /// other neighbours than before.
    pub(crate) fn new(parent: &[u32], mut changed: Vec<bool>) -> Self {
        let old = parent.len();
        let mut first: Vec<u32> = (0..old as u32).collect();
        for j in 0..old {
            if parent[j] != ROOT {
                let parent = parent[j] as usize;
                changed[parent] |= changed[j];
                first[parent] = first[parent].min(first[j]);
            }
        }
        let is_root =
            |&j: &usize| !changed[j] && (parent[j] == ROOT || changed[parent[j] as usize]);
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

    #[test]
    fn a_changed_node_thaws_its_ancestors_and_nothing_else() {
        // Two trees: 0, 1 → 2 and 3 → 4, both below 6, 5 below 6 too; 7 → 8.
        let parent = [2, 2, 6, 4, 6, 6, ROOT, 8, ROOT];
        let mut changed = vec![false; 9];
        changed[1] = true;
        let unchanged = UnchangedSubtrees::new(&parent, changed);
        assert_eq!(unchanged.stretches, [0..1, 3..5, 5..6, 7..9]);
        assert_eq!(unchanged.owner, [0, NONE, NONE, 1, 1, 2, NONE, 3, 3]);
    }

    #[test]
    fn without_changes_whole_trees_are_frozen() {
        let unchanged = UnchangedSubtrees::new(&[1, ROOT, ROOT], vec![false; 3]);
        assert_eq!(unchanged.stretches, [0..2, 2..3]);
        assert_eq!(UnchangedSubtrees::nothing(3).owner, [NONE; 3]);
    }
}
