//! The subtrees of a factor, which do not depend on one another, and the separator above, which depends on all of them.
//!
//! Columns in different subtrees of the elimination tree never meet (Liu 1990): each part is a
//! stretch of whole subtrees, factored and solved with on its own. What it does to the columns above
//! goes through its *boundary*, the rows outside that its columns fill. The cut depends on the tree
//! alone, so that results do not depend on the number of threads.

use super::etree::ROOT;
use super::permuted::PermutedLaplacian;
use super::supernodes::Supernodes;
use rayon::prelude::*;
use std::ops::Range;

/// Parts that a large tree is cut into, about.
const PARTS: usize = 24;

/// Least number of columns of which parts are made.
const LEAST_COLUMNS: usize = 1024;

/// Which columns of the matrix a part has.
#[derive(Clone, Debug)]
enum Columns {
    Stretch(Range<usize>),
    /// Ascending.
    Scattered(Vec<u32>),
}

/// A part of the factor: some of its columns. Rows are numbered: first its own columns, then its boundary.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    columns: Columns,
    /// Rows outside, ascending, in the numbering of the matrix.
    boundary: Vec<u32>,
    /// The same rows in the numbering of the separator.
    in_separator: Vec<u32>,
    pub(crate) supernodes: Supernodes,
    /// Supernodes whose parents are outside.
    pub(crate) roots: Vec<u32>,
}

/// An update that the separator takes from a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Incoming {
    pub(crate) part: usize,
    /// Which of the part's roots.
    pub(crate) root: usize,
    /// Its rows in the numbering of the separator.
    pub(crate) rows: Vec<u32>,
}

/// The subtrees of a factor, in parts of like size, and the separator.
#[derive(Clone, Debug)]
pub(crate) struct Subtrees {
    pub(crate) parts: Vec<Part>,
    pub(crate) separator: Part,
    /// By the column of the separator that each one enters.
    pub(crate) incoming: Vec<Incoming>,
}

impl Subtrees {
    /// The structure of the factor of `laplacian`; `parent` is its elimination tree, postordered.
    /// `None` if 32 bits do not suffice for its indices.
    pub(crate) fn new(
        laplacian: &PermutedLaplacian,
        parent: &[u32],
        threads: usize,
    ) -> Option<Self> {
        let (stretches, separator) = cut(parent);
        let part = |stretch: &Range<usize>| Part::below(laplacian, stretch.clone(), &separator);
        let parts: Option<Vec<Part>> = if threads > 1 {
            stretches.par_iter().map(part).collect()
        } else {
            stretches.iter().map(part).collect()
        };
        let parts = parts?;
        let incoming = incoming(&parts);
        let separator = Part::separator(laplacian, separator, &incoming)?;
        Some(Self {
            parts,
            separator,
            incoming,
        })
    }

    /// The parts and, last, the separator.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Part> {
        self.parts.iter().chain([&self.separator])
    }
}

impl Part {
    fn below(
        laplacian: &PermutedLaplacian,
        columns: Range<usize>,
        separator: &[u32],
    ) -> Option<Self> {
        let first = columns.start as u32;
        let mut supernodes = Supernodes::new(
            columns.len(),
            |j, out| {
                out.extend(
                    laplacian
                        .below(columns.start + j)
                        .0
                        .iter()
                        .map(|r| r - first),
                )
            },
            &[],
        )?;
        let roots: Vec<u32> = supernodes.roots().map(|s| s as u32).collect();
        let outside = roots
            .iter()
            .flat_map(|&s| supernodes.shape(s as usize).rows);
        let mut boundary: Vec<u32> = outside.copied().collect();
        boundary.sort_unstable();
        boundary.dedup();
        let own = columns.len() as u32;
        supernodes.renumber(own, |row| own + index_in(&boundary, row));
        boundary.iter_mut().for_each(|row| *row += first);
        Some(Self {
            columns: Columns::Stretch(columns),
            in_separator: boundary
                .iter()
                .map(|&row| index_in(separator, row))
                .collect(),
            boundary,
            supernodes,
            roots,
        })
    }

    fn separator(
        laplacian: &PermutedLaplacian,
        columns: Vec<u32>,
        incoming: &[Incoming],
    ) -> Option<Self> {
        let patterns: Vec<Vec<u32>> = incoming.iter().map(|i| i.rows.clone()).collect();
        let local = |&row: &u32| index_in(&columns, row);
        let supernodes = Supernodes::new(
            columns.len(),
            |j, out| out.extend(laplacian.below(columns[j] as usize).0.iter().map(local)),
            &patterns,
        )?;
        Some(Self {
            columns: Columns::Scattered(columns),
            boundary: Vec::new(),
            in_separator: Vec::new(),
            supernodes,
            roots: Vec::new(),
        })
    }

    /// Column `j` of the part in the numbering of the matrix.
    pub(crate) fn column(&self, j: usize) -> usize {
        match &self.columns {
            Columns::Stretch(range) => range.start + j,
            Columns::Scattered(columns) => columns[j] as usize,
        }
    }

    /// Row of the matrix in the numbering of the part.
    #[inline(always)]
    pub(crate) fn local(&self, row: u32) -> usize {
        match &self.columns {
            Columns::Stretch(range) if (row as usize) < range.end => row as usize - range.start,
            Columns::Stretch(range) => range.len() + index_in(&self.boundary, row) as usize,
            Columns::Scattered(columns) => index_in(columns, row) as usize,
        }
    }

    /// Rows of the boundary in the numbering of the separator, ascending.
    pub(crate) fn boundary_in_separator(&self) -> &[u32] {
        &self.in_separator
    }

    pub(crate) fn num_columns(&self) -> usize {
        self.supernodes.columns()
    }

    /// Its own columns and its boundary.
    pub(crate) fn num_rows(&self) -> usize {
        self.num_columns() + self.boundary.len()
    }
}

fn index_in(ascending: &[u32], value: u32) -> u32 {
    ascending
        .binary_search(&value)
        .expect("rows of the factor are rows of the matrix or fill between them") as u32
}

/// Stretches of whole subtrees, and the columns above all of them.
fn cut(parent: &[u32]) -> (Vec<Range<usize>>, Vec<u32>) {
    let n = parent.len();
    let limit = (n.div_ceil(PARTS)).max(LEAST_COLUMNS);
    let mut size = vec![1u32; n];
    for j in 0..n {
        if parent[j] != ROOT {
            size[parent[j] as usize] += size[j];
        }
    }
    let (mut stretches, mut separator): (Vec<Range<usize>>, _) = (Vec::new(), Vec::new());
    for j in 0..n {
        if size[j] as usize > limit {
            separator.push(j as u32);
        } else if parent[j] == ROOT || size[parent[j] as usize] as usize > limit {
            let subtree = j + 1 - size[j] as usize..j + 1;
            match stretches.last_mut() {
                Some(last) if last.end == subtree.start && subtree.end - last.start <= limit => {
                    last.end = subtree.end;
                }
                _ => stretches.push(subtree),
            }
        }
    }
    (stretches, separator)
}

/// What leaves the parts, by the column of the separator where it enters.
fn incoming(parts: &[Part]) -> Vec<Incoming> {
    let mut all = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let own = part.num_columns();
        for (root, &s) in part.roots.iter().enumerate() {
            let rows = part.supernodes.shape(s as usize).rows;
            let in_separator = |&row: &u32| part.in_separator[row as usize - own];
            all.push(Incoming {
                part: p,
                root,
                rows: rows.iter().map(in_separator).collect(),
            });
        }
    }
    all.sort_by_key(|i| (i.rows[0], i.part, i.root));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::elimination::EliminationOrder;
    use crate::{Laplacian, LaplacianKind, testing};

    #[test]
    fn pieces_cover_all_columns_and_meet_only_in_the_top() {
        let parts = [
            testing::grid(80, 90),
            testing::cycle(3000),
            testing::star(2500),
        ];
        let graph = testing::disjoint(&parts);
        let n = graph.num_nodes();
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let order = EliminationOrder::new(&laplacian, None);
        let (stretches, separator) = cut(&order.parent);
        let mut owner = vec![usize::MAX; n];
        for (p, stretch) in stretches.iter().enumerate() {
            owner[stretch.clone()].iter_mut().for_each(|o| *o = p);
        }
        let owned = owner.iter().filter(|&&o| o != usize::MAX).count();
        assert_eq!(owned, stretches.iter().map(Range::len).sum::<usize>());
        assert_eq!(owned + separator.len(), n);
        assert!(separator.iter().all(|&j| owner[j as usize] == usize::MAX));
        assert!(stretches.len() > 1 && !separator.is_empty());
        for (j, &p) in order.parent.iter().enumerate() {
            if p != ROOT && owner[p as usize] != usize::MAX {
                assert_eq!(
                    owner[j], owner[p as usize],
                    "a child of a part is in the part"
                );
            }
        }
    }
}
