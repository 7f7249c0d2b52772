//! The fronts of one part, shared among threads: those of equal height in the tree at a time.
//!
//! A front needs the updates of its children only, which are lower (Liu 1990). Each takes them in the
//! order in which one thread would, so that the factor is the same to the last bit.

use super::dense_front::{BadPivot, Pivots};
use super::multifrontal::{Columns, Fronts, Remainder, Task};
use super::subtrees::{Incoming, Part};
use super::supernodes::Supernodes;
use pulp::Arch;
use rayon::prelude::*;

/// Eliminates the columns of `part`, which has no rows beyond them.
pub(crate) fn eliminate_by_levels(
    task: Task<'_>,
    part: &Part,
    columns: Columns<'_>,
    others: (&[Incoming], &[Remainder]),
) -> Result<Pivots, BadPivot> {
    let supernodes = &part.supernodes;
    let tree = Tree::new(supernodes);
    let mut panels = split(columns, supernodes);
    let mut updates: Vec<Vec<f64>> = vec![Vec::new(); supernodes.len()];
    let mut pivots = Pivots::default();
    for level in &tree.levels {
        let jobs: Vec<_> = level
            .iter()
            .map(|&s| (s as usize, panels[s as usize].take()))
            .collect();
        let eliminate = |fronts: &mut Fronts<'_>, (s, panel): (usize, Option<&mut [f64]>)| {
            Arch::new().dispatch(
                #[inline(always)]
                || one_front(fronts, s, panel, &tree.children[s], &updates),
            )
        };
        let done: Result<Vec<_>, BadPivot> = jobs
            .into_par_iter()
            .map_init(|| Fronts::new(task, part, others), eliminate)
            .collect();
        for (&s, (update, found)) in level.iter().zip(done?) {
            for &child in &tree.children[s as usize] {
                updates[child as usize] = Vec::new();
            }
            updates[s as usize] = update;
            pivots = pivots.join(found);
        }
    }
    Ok(pivots)
}

/// Each supernode's part of the values, `None` where the columns are not kept.
fn split<'a>(columns: Columns<'a>, supernodes: &Supernodes) -> Vec<Option<&'a mut [f64]>> {
    let Columns::Kept(mut rest) = columns else {
        return (0..supernodes.len()).map(|_| None).collect();
    };
    let mut panels = Vec::with_capacity(supernodes.len());
    for s in 0..supernodes.len() {
        let (panel, after) = rest.split_at_mut(supernodes.shape(s).values.len());
        rest = after;
        panels.push(Some(panel));
    }
    panels
}

/// Eliminates supernode `s`; returns its update.
#[inline(always)]
fn one_front(
    fronts: &mut Fronts<'_>,
    s: usize,
    panel: Option<&mut [f64]>,
    children: &[u32],
    updates: &[Vec<f64>],
) -> Result<(Vec<f64>, Pivots), BadPivot> {
    let supernodes = &fronts.part.supernodes;
    let shape = supernodes.shape(s);
    let mut forgotten = Vec::new();
    let panel = panel.unwrap_or_else(|| {
        forgotten.resize(shape.values.len(), 0.0);
        &mut forgotten
    });
    let mut update = vec![0.0; shape.rows.len() * shape.rows.len()];
    let children = children.iter().map(|&child| {
        let child = child as usize;
        (supernodes.shape(child).rows, &updates[child][..])
    });
    let pivots = fronts.eliminate(&shape, panel, &mut update, children)?;
    Ok((update, pivots))
}

/// The tree of a part's supernodes.
struct Tree {
    /// Of each supernode, ascending.
    children: Vec<Vec<u32>>,
    /// Supernodes by height, leaves first.
    levels: Vec<Vec<u32>>,
}

impl Tree {
    fn new(supernodes: &Supernodes) -> Self {
        let count = supernodes.len();
        let mut owner = vec![0u32; supernodes.columns()];
        for s in 0..count {
            let shape = supernodes.shape(s);
            owner[shape.first..shape.first + shape.size].fill(s as u32);
        }
        let mut children = vec![Vec::new(); count];
        let mut heights = vec![0usize; count];
        let mut levels: Vec<Vec<u32>> = Vec::new();
        for s in 0..count {
            let height = heights[s];
            if height == levels.len() {
                levels.push(Vec::new());
            }
            levels[height].push(s as u32);
            if let Some(&row) = supernodes.shape(s).rows.first() {
                let parent = owner[row as usize] as usize;
                children[parent].push(s as u32);
                heights[parent] = heights[parent].max(height + 1);
            }
        }
        Self { children, levels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_are_lower_and_every_supernode_has_a_level() {
        // 0 and 1 below 3, 2 below 4, 3 and 4 below 5: columns with one row each, none merged by zeros.
        let below: [&[u32]; 6] = [&[3, 5], &[3, 5], &[4, 5], &[5], &[5], &[]];
        let supernodes = Supernodes::new(6, |j, out| out.extend_from_slice(below[j]), &[]).unwrap();
        let tree = Tree::new(&supernodes);
        let all: usize = tree.levels.iter().map(Vec::len).sum();
        assert_eq!(all, supernodes.len());
        let level = |s: u32| tree.levels.iter().position(|l| l.contains(&s));
        let mut edges = 0;
        for (s, children) in tree.children.iter().enumerate() {
            assert_eq!(children.len(), supernodes.shape(s).children);
            for &child in children {
                assert!(level(child) < level(s as u32));
                edges += 1;
            }
        }
        assert_eq!(edges + 1, supernodes.len());
    }
}
