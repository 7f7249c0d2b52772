//! A = C S Cᵀ by the multifrontal method (Duff & Reid 1983; Liu 1992), for one piece of a factor.
//!
//! Each supernode assembles a dense *front*: its columns of the matrix, and what the elimination of
//! its children left behind. It eliminates its columns and leaves an update for its parent. In
//! postorder those updates form a stack. A count of negative pivots needs no factor: then the front's
//! columns are thrown away.

use super::front::{BadPivot, Definiteness, Front, Pivots};
use super::permuted::PermutedLaplacian;
use super::pieces::{Incoming, Piece};
use super::supernodes::Shape;

/// Where the eliminated columns go.
pub(super) enum Columns<'a> {
    /// All of the factor's values.
    Kept(&'a mut [f64]),
    Forgotten,
}

/// The matrix A = L + `shift` · I, and what is asked of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task<'a> {
    pub(super) laplacian: &'a PermutedLaplacian,
    pub(super) shift: f64,
    pub(super) kind: Definiteness,
    /// Threads that may share a large front.
    pub(super) threads: usize,
}

/// What the elimination of a piece leaves.
#[derive(Debug, Default)]
pub(super) struct Remainder {
    pub(super) pivots: Pivots,
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

/// Eliminates the columns of `piece`. `incoming` are updates from other pieces, which `others` hold.
pub(super) fn eliminate(
    task: Task<'_>,
    piece: &Piece,
    columns: Columns<'_>,
    (incoming, others): (&[Incoming], &[Remainder]),
) -> Result<Remainder, BadPivot> {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            let mut worker = Worker::new(task, piece);
            worker.run(columns, incoming, others)
        },
    )
}

struct Worker<'a> {
    task: Task<'a>,
    piece: &'a Piece,
    /// Row of the piece → row of the present front.
    place: Vec<u32>,
    /// Updates of supernodes whose parent is still to come, and the pattern of each.
    stack: Vec<f64>,
    pending: Vec<(usize, u32)>,
    signs: Vec<f64>,
    scratch: Vec<f64>,
}

impl<'a> Worker<'a> {
    fn new(task: Task<'a>, piece: &'a Piece) -> Self {
        Self {
            task,
            piece,
            place: vec![0; piece.num_rows()],
            stack: Vec::new(),
            pending: Vec::new(),
            signs: Vec::new(),
            scratch: Vec::new(),
        }
    }

    #[inline(always)]
    fn run(
        &mut self,
        mut columns: Columns<'_>,
        incoming: &[Incoming],
        others: &[Remainder],
    ) -> Result<Remainder, BadPivot> {
        let mut pivots = Pivots::default();
        let mut incoming = incoming.iter().peekable();
        let mut scratch = std::mem::take(&mut self.scratch);
        for s in 0..self.piece.supernodes.len() {
            let shape = self.piece.supernodes.shape(s);
            let panel = match &mut columns {
                Columns::Kept(values) => {
                    let panel = &mut values[shape.values.clone()];
                    panel.fill(0.0);
                    panel
                }
                Columns::Forgotten => {
                    scratch.clear();
                    scratch.resize(shape.values.len(), 0.0);
                    &mut scratch[..]
                }
            };
            for (k, &row) in shape.rows.iter().enumerate() {
                self.place[row as usize] = (shape.size + k) as u32;
            }
            self.scatter_matrix(&shape, panel);
            let base = self.open(&shape);
            let (below, update) = self.stack.split_at_mut(base);
            let mut front = Assembly {
                shape: &shape,
                place: &self.place,
                panel,
                update,
            };
            let from = self.pending.len() - shape.children;
            for &(start, child) in &self.pending[from..] {
                let rows = self.piece.supernodes.shape(child as usize).rows;
                front.add(rows, &below[start..]);
            }
            let end = (shape.first + shape.size) as u32;
            while let Some(i) = incoming.next_if(|i| i.rows[0] < end) {
                front.add(&i.rows, others[i.piece].update(i.root, i.rows.len()));
            }
            let mut front = Front {
                size: shape.size,
                panel: front.panel,
                rest: shape.rows.len(),
                update: front.update,
            };
            let found = front.eliminate(self.task.kind, &mut self.signs, self.task.threads)?;
            pivots = pivots.join(found);
            self.close(s, &shape, base, from);
        }
        Ok(Remainder {
            pivots,
            starts: self.pending.iter().map(|&(start, _)| start).collect(),
            updates: std::mem::take(&mut self.stack),
        })
    }

    /// The supernode's columns of the matrix.
    #[inline(always)]
    fn scatter_matrix(&self, shape: &Shape<'_>, panel: &mut [f64]) {
        let height = shape.height();
        for c in 0..shape.size {
            let j = self.piece.column(shape.first + c);
            let column = &mut panel[c * height..(c + 1) * height];
            column[c] = self.task.laplacian.diagonal(j) + self.task.shift;
            let (rows, values) = self.task.laplacian.below(j);
            for (&row, &value) in rows.iter().zip(values) {
                let row = self.piece.local(row);
                let at = if row < shape.first + shape.size {
                    row - shape.first
                } else {
                    self.place[row] as usize
                };
                column[at] = value;
            }
        }
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

/// A front under assembly.
struct Assembly<'a> {
    shape: &'a Shape<'a>,
    place: &'a [u32],
    panel: &'a mut [f64],
    update: &'a mut [f64],
}

impl Assembly<'_> {
    /// Adds the lower triangle of a child's update, whose rows are `rows`.
    #[inline(always)]
    fn add(&mut self, rows: &[u32], child: &[f64]) {
        let (first, size) = (self.shape.first, self.shape.size);
        let (count, height, rest) = (rows.len(), self.shape.height(), self.shape.rows.len());
        let place = |row: u32| {
            let row = row as usize;
            if row < first + size {
                row - first
            } else {
                self.place[row] as usize
            }
        };
        for (j, &column) in rows.iter().enumerate() {
            let source = &child[j * count + j..(j + 1) * count];
            let at = place(column);
            let (target, offset) = if at < size {
                (&mut self.panel[at * height..(at + 1) * height], 0)
            } else {
                let column = at - size;
                (&mut self.update[column * rest..(column + 1) * rest], size)
            };
            let low = at - offset;
            let high = place(rows[count - 1]) - offset;
            if high - low + 1 == source.len() {
                // The rows are consecutive in the front.
                for (t, v) in target[low..=high].iter_mut().zip(source) {
                    *t += v;
                }
            } else {
                for (&row, v) in rows[j..].iter().zip(source) {
                    target[place(row) - offset] += v;
                }
            }
        }
    }
}
