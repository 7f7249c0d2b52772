//! A = C S Cᵀ by the multifrontal method (Duff & Reid 1983; Liu 1992), for one part of a factor.
//!
//! Each supernode assembles a dense *front*: its columns of the matrix, and what the elimination of
//! its children left behind. It eliminates its columns and leaves an update for its parent. In
//! postorder those updates form a stack. A count of negative pivots needs no factor: then the front's
//! columns are thrown away.

use super::dense_front::{BadPivot, Definiteness, Front, Pivots};
use super::permuted::PermutedLaplacian;
use super::subtrees::{Incoming, Part};
use super::supernodes::Shape;

/// Places for the eliminated columns.
pub(crate) enum Columns<'a> {
    /// All of the factor's values.
    Kept(&'a mut [f64]),
    Forgotten,
}

/// The matrix A = L + `shift` · I, and what is asked of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task<'a> {
    pub(crate) laplacian: &'a PermutedLaplacian,
    pub(crate) shift: f64,
    pub(crate) kind: Definiteness,
    /// Threads that may share a large front.
    pub(crate) threads: usize,
}

/// Matrix that the elimination of a part leaves.
#[derive(Debug, Default)]
pub(crate) struct Remainder {
    pub(crate) pivots: Pivots,
    /// Where the update of each root starts in `updates`.
    starts: Vec<usize>,
    updates: Vec<f64>,
}

impl Remainder {
    /// The update of a root with `rows` rows: lower triangle of a column-major square.
    fn update(&self, root: usize, rows: usize) -> &[f64] {
        &self.updates[self.starts[root]..][..rows * rows]
    }
}

/// Eliminates the columns of `part`. `incoming` are updates from other parts, which `others` hold.
pub(crate) fn eliminate(
    task: Task<'_>,
    part: &Part,
    columns: Columns<'_>,
    (incoming, others): (&[Incoming], &[Remainder]),
) -> Result<Remainder, BadPivot> {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut worker = Worker {
                fronts: Fronts::new(task, part, (incoming, others)),
                stack: Vec::new(),
                pending: Vec::new(),
            };
            worker.run(columns)
        },
    )
}

/// The stack of updates.
struct Worker<'a> {
    fronts: Fronts<'a>,
    /// Updates of supernodes whose parent is still to come, and the pattern of each.
    stack: Vec<f64>,
    pending: Vec<(usize, u32)>,
}

impl Worker<'_> {
    #[inline(always)]
    fn run(&mut self, mut columns: Columns<'_>) -> Result<Remainder, BadPivot> {
        let mut pivots = Pivots::default();
        let mut scratch = Vec::new();
        let supernodes = &self.fronts.part.supernodes;
        for s in 0..supernodes.len() {
            let shape = supernodes.shape(s);
            let panel = match &mut columns {
                Columns::Kept(values) => &mut values[shape.values.clone()],
                Columns::Forgotten => {
                    scratch.resize(shape.values.len(), 0.0);
                    &mut scratch[..]
                }
            };
            let base = self.open(&shape);
            let (below, update) = self.stack.split_at_mut(base);
            let from = self.pending.len() - shape.children;
            let children = self.pending[from..].iter().map(|&(start, child)| {
                let rows = supernodes.shape(child as usize).rows;
                (rows, &below[start..])
            });
            pivots = pivots.join(self.fronts.eliminate(&shape, panel, update, children)?);
            self.close(s, &shape, base, from);
        }
        Ok(Remainder {
            pivots,
            starts: self.pending.iter().map(|&(start, _)| start).collect(),
            updates: std::mem::take(&mut self.stack),
        })
    }

    /// Room for the update, set to zero, above those of the children; returns where it starts.
    #[inline(always)]
    fn open(&mut self, shape: &Shape<'_>) -> usize {
        let base = self.stack.len();
        self.stack
            .resize(base + shape.rows.len() * shape.rows.len(), 0.0);
        base
    }

    /// Moves the update down to where those of the children were.
    #[inline(always)]
    fn close(&mut self, s: usize, shape: &Shape<'_>, base: usize, from: usize) {
        let start = self.pending.get(from).map_or(base, |&(start, _)| start);
        self.pending.truncate(from);
        let length = shape.rows.len() * shape.rows.len();
        if start < base {
            self.stack.copy_within(base..base + length, start);
        }
        self.stack.truncate(start + length);
        if length > 0 {
            self.pending.push((start, s as u32));
        }
    }
}

/// Assembles and eliminates one front after another.
pub(crate) struct Fronts<'a> {
    task: Task<'a>,
    pub(crate) part: &'a Part,
    incoming: &'a [Incoming],
    others: &'a [Remainder],
    /// Row of the part → row of the present front.
    place: Vec<u32>,
    /// The same for the rows of the present child.
    at: Vec<u32>,
    signs: Vec<f64>,
}

impl<'a> Fronts<'a> {
    /// `incoming` are updates from other parts, which `others` hold.
    pub(crate) fn new(
        task: Task<'a>,
        part: &'a Part,
        (incoming, others): (&'a [Incoming], &'a [Remainder]),
    ) -> Self {
        Self {
            task,
            part,
            incoming,
            others,
            place: vec![0; part.num_rows()],
            at: Vec::new(),
            signs: Vec::new(),
        }
    }

    /// Eliminates a supernode: its columns of the factor overwrite `panel`, what it leaves to its parent
    /// is added to `update`. `children` are their rows and updates, in order.
    #[inline(always)]
    pub(crate) fn eliminate<'b>(
        &mut self,
        shape: &Shape<'_>,
        panel: &mut [f64],
        update: &mut [f64],
        children: impl Iterator<Item = (&'b [u32], &'b [f64])>,
    ) -> Result<Pivots, BadPivot> {
        for c in 0..shape.size {
            self.place[shape.first + c] = c as u32;
        }
        for (k, &row) in shape.rows.iter().enumerate() {
            self.place[row as usize] = (shape.size + k) as u32;
        }
        panel.fill(0.0);
        self.scatter_matrix(shape, panel);
        for (rows, child) in children {
            self.add(shape, panel, update, (rows, child));
        }
        let end = (shape.first + shape.size) as u32;
        let enters = |i: &Incoming, column: usize| (i.rows[0] as usize) < column;
        let first = self.incoming.partition_point(|i| enters(i, shape.first));
        for i in self.incoming[first..]
            .iter()
            .take_while(|i| i.rows[0] < end)
        {
            let child = self.others[i.part].update(i.root, i.rows.len());
            self.add(shape, panel, update, (&i.rows, child));
        }
        let mut front = Front {
            size: shape.size,
            panel,
            rest: shape.rows.len(),
            update,
        };
        front.eliminate(self.task.kind, &mut self.signs, self.task.threads)
    }

    /// The supernode's columns of the matrix.
    #[inline(always)]
    fn scatter_matrix(&self, shape: &Shape<'_>, panel: &mut [f64]) {
        let height = shape.height();
        for c in 0..shape.size {
            let j = self.part.column(shape.first + c);
            let column = &mut panel[c * height..(c + 1) * height];
            column[c] = self.task.laplacian.diagonal(j) + self.task.shift;
            let (rows, values) = self.task.laplacian.below(j);
            for (&row, &value) in rows.iter().zip(values) {
                column[self.place[self.part.local(row)] as usize] = value;
            }
        }
    }

    /// Adds the lower triangle of a child's update, column by column.
    #[inline(always)]
    fn add(
        &mut self,
        shape: &Shape<'_>,
        panel: &mut [f64],
        update: &mut [f64],
        (rows, child): (&[u32], &[f64]),
    ) {
        let (size, height, rest) = (shape.size, shape.height(), shape.rows.len());
        self.at.clear();
        self.at
            .extend(rows.iter().map(|&row| self.place[row as usize]));
        let Some(&high) = self.at.last() else {
            return;
        };
        for (j, source) in child.chunks_exact(rows.len()).take(rows.len()).enumerate() {
            let (source, at) = (&source[j..], &self.at[j..]);
            let low = at[0] as usize;
            let (target, offset) = if low < size {
                (&mut panel[low * height..(low + 1) * height], 0)
            } else {
                let column = low - size;
                (&mut update[column * rest..(column + 1) * rest], size)
            };
            if high as usize - low + 1 == source.len() {
                // The rows are consecutive in the front.
                let target = &mut target[low - offset..][..source.len()];
                for (t, v) in target.iter_mut().zip(source) {
                    *t += v;
                }
            } else {
                for (&row, v) in at.iter().zip(source) {
                    target[row as usize - offset] += v;
                }
            }
        }
    }
}
