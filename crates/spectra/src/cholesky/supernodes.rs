//! The structure of a Cholesky factor: which rows each column fills, columns of like pattern together.
//!
//! Column j of the factor has the rows of column j of the matrix and those of its children in the
//! elimination tree, j itself left out (George & Liu 1981). A run of columns each of which is the
//! parent of the one before, with nearly nested patterns, is a *supernode*: one dense trapezoid, one
//! list of rows. A few zeros are stored so that runs get longer (*relaxed* supernodes, Ashcraft &
//! Grimes 1989).

use std::ops::Range;

/// Share of stored zeros up to which a column joins a supernode of at most so many columns.
const RELAXED: [(usize, f64); 3] = [(4, 0.25), (16, 0.12), (usize::MAX, 0.03)];

/// The structure of some columns of a factor. Rows are numbered from the first of these columns on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Supernodes {
    /// First column of each supernode, and the number of columns.
    starts: Vec<u32>,
    /// Where in `rows` each one's rows start, and their number.
    row_starts: Vec<u32>,
    /// Rows below the dense triangles, ascending within each supernode.
    rows: Vec<u32>,
    /// Where each supernode's values start, and their number.
    value_starts: Vec<u32>,
    /// Children of each supernode among these columns.
    children: Vec<u32>,
}

/// One supernode: a dense triangle of `size` columns above `rows.len()` further rows, column-major.
#[derive(Clone, Debug)]
pub(crate) struct Shape<'a> {
    pub(crate) first: usize,
    pub(crate) size: usize,
    pub(crate) rows: &'a [u32],
    /// Where its values are.
    pub(crate) values: Range<usize>,
    pub(crate) children: usize,
}

impl Shape<'_> {
    /// Rows of triangle and rectangle.
    #[inline(always)]
    pub(crate) fn height(&self) -> usize {
        self.size + self.rows.len()
    }
}

impl Supernodes {
    /// The structure of `columns` columns. `below(j, out)` appends the rows of the matrix below the
    /// diagonal of column j, ascending. `incoming` are patterns of columns outside, the parent of
    /// each among these: each ascending, and they by their first rows. `None` if the values cannot be
    /// numbered in 32 bits.
    ///
    /// Cost: O(entries of the matrix + rows stored).
    pub(crate) fn new(
        columns: usize,
        below: impl FnMut(usize, &mut Vec<u32>),
        incoming: &[Vec<u32>],
    ) -> Option<Self> {
        let mut draft = Draft::new(columns);
        draft.run(below, incoming);
        draft.compact()
    }

    pub(crate) fn len(&self) -> usize {
        self.children.len()
    }

    pub(crate) fn columns(&self) -> usize {
        self.starts.last().map_or(0, |&end| end as usize)
    }

    /// Values to store.
    pub(crate) fn num_values(&self) -> usize {
        self.value_starts.last().map_or(0, |&end| end as usize)
    }

    /// Multiplications that the factorisation takes.
    pub(crate) fn operations(&self) -> f64 {
        let of_front = |s: usize| {
            let shape = self.shape(s);
            let (size, rest) = (shape.size as f64, shape.rows.len() as f64);
            size * (size * size / 6.0 + size * rest / 2.0 + rest * rest / 2.0)
        };
        (0..self.len()).map(of_front).sum()
    }

    #[inline(always)]
    pub(crate) fn shape(&self, s: usize) -> Shape<'_> {
        let range = |starts: &[u32]| starts[s] as usize..starts[s + 1] as usize;
        let columns = range(&self.starts);
        Shape {
            first: columns.start,
            size: columns.len(),
            rows: &self.rows[range(&self.row_starts)],
            values: range(&self.value_starts),
            children: self.children[s] as usize,
        }
    }

    /// Renumbers all rows from `first` on by the monotone `f`.
    pub(crate) fn renumber(&mut self, first: u32, f: impl Fn(u32) -> u32) {
        for row in self.rows.iter_mut().filter(|row| **row >= first) {
            *row = f(*row);
        }
    }

    /// Supernodes without a parent among these columns but with rows beyond them.
    pub(crate) fn roots(&self) -> impl Iterator<Item = usize> {
        let columns = self.columns() as u32;
        (0..self.len()).filter(move |&s| self.shape(s).rows.first().is_some_and(|&r| r >= columns))
    }
}

/// No supernode.
const NONE: u32 = u32::MAX;

/// A supernode that may still grow.
#[derive(Clone, Copy, Debug)]
struct Growing {
    first: u32,
    size: u32,
    /// Its rows are `rows[start..end]` of the draft.
    start: u32,
    end: u32,
    children: u32,
    /// Zeros stored.
    zeros: u64,
}

struct Draft {
    columns: usize,
    nodes: Vec<Growing>,
    rows: Vec<u32>,
    /// Per column, the supernodes whose first row it is: a list through `sibling`.
    first_child: Vec<u32>,
    sibling: Vec<u32>,
}

impl Draft {
    fn new(columns: usize) -> Self {
        Self {
            columns,
            nodes: Vec::with_capacity(columns / 2),
            rows: Vec::with_capacity(2 * columns),
            first_child: vec![NONE; columns],
            sibling: Vec::with_capacity(columns / 2),
        }
    }

    fn run(&mut self, mut below: impl FnMut(usize, &mut Vec<u32>), incoming: &[Vec<u32>]) {
        let mut incoming = incoming.iter().peekable();
        let (mut own, mut pattern, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
        for j in 0..self.columns {
            own.clear();
            below(j, &mut own);
            let alone = incoming.peek().is_none_or(|rows| rows[0] as usize != j);
            if alone && self.extends_last(j, &own) {
                continue;
            }
            pattern.clear();
            pattern.extend_from_slice(&own);
            while let Some(rows) = incoming.next_if(|rows| rows[0] as usize == j) {
                merge(&mut pattern, &rows[1..], &mut scratch);
            }
            let mut children = 0;
            let mut child = self.first_child[j];
            while child != NONE {
                let node = self.nodes[child as usize];
                let rows = &self.rows[node.start as usize + 1..node.end as usize];
                merge(&mut pattern, rows, &mut scratch);
                children += 1;
                child = self.sibling[child as usize];
            }
            self.place(j, &pattern, children);
        }
    }

    /// Whether column j only continues the last supernode, which is its only child: then no list of rows is touched.
    fn extends_last(&mut self, j: usize, own: &[u32]) -> bool {
        let child = self.first_child[j];
        if child == NONE
            || child as usize + 1 != self.nodes.len()
            || self.sibling[child as usize] != NONE
        {
            return false;
        }
        let node = &mut self.nodes[child as usize];
        let rest = &self.rows[node.start as usize + 1..node.end as usize];
        if !own.iter().all(|row| rest.binary_search(row).is_ok()) {
            return false;
        }
        node.size += 1;
        node.start += 1;
        self.link(child);
        true
    }

    /// Column j with its pattern joins the last supernode, if that is a child of it and few zeros
    /// come of it, or begins a new one.
    fn place(&mut self, j: usize, pattern: &[u32], children: u32) {
        if let Some(last) = self.nodes.last_mut()
            && last.start < last.end
            && self.rows[last.start as usize] as usize == j
        {
            let more = pattern.len() as u64 + 1 - u64::from(last.end - last.start);
            let zeros = last.zeros + u64::from(last.size) * more;
            let size = u64::from(last.size) + 1;
            let entries = size * (size + 1) / 2 + size * pattern.len() as u64;
            let limit = RELAXED.iter().find(|(most, _)| size as usize <= *most);
            if limit.is_some_and(|&(_, share)| zeros as f64 <= share * entries as f64) {
                last.size += 1;
                last.zeros = zeros;
                last.children += children - 1;
                self.rows.truncate(last.start as usize);
                self.rows.extend_from_slice(pattern);
                last.end = self.rows.len() as u32;
                self.link(self.nodes.len() as u32 - 1);
                return;
            }
        }
        let start = self.rows.len() as u32;
        self.rows.extend_from_slice(pattern);
        self.nodes.push(Growing {
            first: j as u32,
            size: 1,
            start,
            end: self.rows.len() as u32,
            children,
            zeros: 0,
        });
        self.sibling.push(NONE);
        self.link(self.nodes.len() as u32 - 1);
    }

    /// Hangs supernode `s` below the column of its first row.
    fn link(&mut self, s: u32) {
        let node = &self.nodes[s as usize];
        let parent = self.rows[node.start as usize..node.end as usize].first();
        self.sibling[s as usize] = match parent {
            Some(&p) if (p as usize) < self.columns => {
                std::mem::replace(&mut self.first_child[p as usize], s)
            }
            _ => NONE,
        };
    }

    /// Without the gaps that growing has left.
    fn compact(self) -> Option<Supernodes> {
        let count = self.nodes.len();
        let kept = self.nodes.iter().map(|s| (s.end - s.start) as usize).sum();
        let mut out = Supernodes {
            starts: Vec::with_capacity(count + 1),
            row_starts: Vec::with_capacity(count + 1),
            rows: Vec::with_capacity(kept),
            value_starts: Vec::with_capacity(count + 1),
            children: self.nodes.iter().map(|s| s.children).collect(),
        };
        let mut values = 0;
        for node in &self.nodes {
            out.starts.push(node.first);
            out.row_starts.push(out.rows.len() as u32);
            out.value_starts.push(u32::try_from(values).ok()?);
            let rows = &self.rows[node.start as usize..node.end as usize];
            values += u64::from(node.size) * (u64::from(node.size) + rows.len() as u64);
            out.rows.extend_from_slice(rows);
        }
        out.starts.push(self.columns as u32);
        out.row_starts.push(u32::try_from(kept).ok()?);
        out.value_starts.push(u32::try_from(values).ok()?);
        Some(out)
    }
}

/// a ← a ∪ b, both ascending.
fn merge(a: &mut Vec<u32>, b: &[u32], scratch: &mut Vec<u32>) {
    if b.is_empty() {
        return;
    }
    scratch.clear();
    let (mut i, mut k) = (0, 0);
    while i < a.len() && k < b.len() {
        let (x, y) = (a[i], b[k]);
        scratch.push(x.min(y));
        i += usize::from(x <= y);
        k += usize::from(y <= x);
    }
    scratch.extend_from_slice(&a[i..]);
    scratch.extend_from_slice(&b[k..]);
    std::mem::swap(a, scratch);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use std::collections::BTreeSet;

    /// Rows below the diagonal of each column of the factor, by elimination of one node after another.
    fn eliminated(mut below: Vec<BTreeSet<u32>>) -> Vec<BTreeSet<u32>> {
        for j in 0..below.len() {
            if let Some(&parent) = below[j].first() {
                let rest = below[j].iter().skip(1).copied().collect::<Vec<_>>();
                below[parent as usize].extend(rest);
            }
        }
        below
    }

    #[test]
    fn the_pattern_holds_all_fill_and_few_zeros() {
        for graph in [
            testing::path(50),
            testing::grid(12, 9),
            testing::complete(20),
            testing::random(80, 3.0, 1),
        ] {
            let n = graph.num_nodes();
            let below = |j: usize| {
                let later = graph.row(j).0.iter().filter(|&&i| i as usize > j);
                later.copied().collect::<BTreeSet<u32>>()
            };
            let exact = eliminated((0..n).map(below).collect());
            let found = Supernodes::new(n, |j, out| out.extend(below(j)), &[]).unwrap();
            let mut entries = 0;
            for s in 0..found.len() {
                let shape = found.shape(s);
                assert!(shape.rows.is_sorted());
                let end = (shape.first + shape.size) as u32;
                for j in shape.first as u32..end {
                    let stored: BTreeSet<u32> =
                        (j + 1..end).chain(shape.rows.iter().copied()).collect();
                    assert!(stored.is_superset(&exact[j as usize]), "column {j}");
                    entries += stored.len();
                }
            }
            assert_eq!(found.columns(), n);
            let least: usize = exact.iter().map(BTreeSet::len).sum();
            assert!(entries <= least + (least + n) / 3, "{entries} for {least}");
        }
    }
}
