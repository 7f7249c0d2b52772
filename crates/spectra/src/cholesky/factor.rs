//! M = L + σI = C Cᵀ by sparse Cholesky, and the inertia of L − μI by C S Cᵀ, S = diag(±1).
//!
//! The elimination tree is cut into parts ([`super::subtrees`]), each factored by fronts
//! ([`super::multifrontal`]) and solved with ([`super::triangular`]) on its own, and a separator that joins
//! them: first all parts, then the separator; on the way back first the separator. Parts are what threads share.
//!
//! Sylvester's law of inertia: L − μI has as many negative pivots as L has eigenvalues below μ.

use super::dense_front::{BadPivot, Definiteness, Pivots};
use super::elimination::EliminationOrder;
use super::inertia::Inertia;
use super::levels::eliminate_by_levels;
use super::multifrontal::{Columns, Remainder, Task, eliminate};
use super::permuted::PermutedLaplacian;
use super::subtrees::{Part, Subtrees};
use super::triangular::{Backward, Forward};
use crate::block::simd::for_each_panel;
use crate::block::{LANES, RowBlock};
use rayon::prelude::*;
use std::ops::Range;

/// A Cholesky factor of L + σI, or the pattern of one not yet computed.
#[derive(Debug)]
pub(crate) struct CholeskyFactor {
    structure: Subtrees,
    /// Those of each part in turn, then those of the separator.
    values: Vec<f64>,
    threads: usize,
}

/// The matrix is not numerically positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotPositiveDefinite;

/// Factorisations that tests let fail.
#[cfg(test)]
pub(crate) mod faults {
    use std::cell::Cell;

    thread_local! {
        static LEFT: Cell<u32> = const { Cell::new(0) };
    }

    /// Lets the next `count` factorisations of this thread fail.
    pub fn inject(count: u32) {
        LEFT.set(count);
    }

    pub(super) fn comes_now() -> bool {
        let left = LEFT.get();
        LEFT.set(left.saturating_sub(1));
        left > 0
    }
}

/// Memory whose contents a factorisation no longer needs, kept for the next one.
#[derive(Debug, Default)]
pub(crate) struct FactorBuffers {
    values: Vec<f64>,
}

impl CholeskyFactor {
    /// Structure of the factor of a matrix with the pattern of `laplacian`, which is in `order`;
    /// `None` if the factor does not fit in 32-bit indices.
    pub(crate) fn analyze(
        laplacian: &PermutedLaplacian,
        order: &EliminationOrder,
        threads: usize,
        buffers: FactorBuffers,
    ) -> Option<Self> {
        Some(Self {
            structure: Subtrees::new(laplacian, &order.parent, threads)?,
            values: buffers.values,
            threads,
        })
    }

    /// Numbers that it holds.
    pub(crate) fn num_values(&self) -> usize {
        self.structure
            .all()
            .map(|p| p.supernodes.num_values())
            .sum()
    }

    /// Multiplications that computing it takes.
    pub(crate) fn operations(&self) -> f64 {
        self.structure
            .all()
            .map(|p| p.supernodes.operations())
            .sum()
    }

    /// Gives the memory back for another factor.
    pub(crate) fn into_buffers(self) -> FactorBuffers {
        FactorBuffers {
            values: self.values,
        }
    }

    /// Computes the factor of L + σI.
    pub(crate) fn factorize(
        &mut self,
        laplacian: &PermutedLaplacian,
        sigma: f64,
    ) -> Result<(), NotPositiveDefinite> {
        #[cfg(test)]
        if faults::comes_now() {
            return Err(NotPositiveDefinite);
        }
        self.values.resize(self.num_values(), 0.0);
        let mut rest = &mut self.values[..];
        let values = self.structure.all().map(|part| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(part.supernodes.num_values());
            rest = after;
            Columns::Kept(own)
        });
        let task = Task {
            laplacian,
            shift: sigma,
            kind: Definiteness::Positive,
            threads: self.threads,
        };
        let values = values.collect();
        match run(task, &self.structure, values) {
            Ok(_) => Ok(()),
            Err(BadPivot) => Err(NotPositiveDefinite),
        }
    }

    /// How many eigenvalues of L lie below `mu`; `None` if a pivot vanished, which another `mu` avoids.
    /// Leaves the factor as it is.
    pub(crate) fn count_below(&self, laplacian: &PermutedLaplacian, mu: f64) -> Option<Inertia> {
        let task = Task {
            laplacian,
            shift: -mu,
            kind: Definiteness::Any,
            threads: self.threads,
        };
        let nothing = self.structure.all().map(|_| Columns::Forgotten).collect();
        let pivots = run(task, &self.structure, nothing).ok()?;
        Some(Inertia::new(pivots, mu, laplacian, &self.structure))
    }

    /// x ← (L + σI)⁻¹ x.
    pub(crate) fn solve(&self, x: &mut RowBlock) {
        let width = x.width();
        let mut blocks = self.separator_blocks(x);
        let mut shares = self.shares(x);
        self.each(&mut shares, |share| share.forward(width));
        self.each(&mut blocks, |separator| {
            shares.iter().for_each(|share| separator.add(share));
            separator.solve(self);
        });
        self.each(&mut shares, |share| {
            blocks
                .iter()
                .for_each(|separator| separator.hand_down(share));
            share.backward(width);
        });
        for separator in &blocks {
            for j in 0..separator.block.rows() {
                x.row_mut(self.structure.separator.column(j))[separator.columns.clone()]
                    .copy_from_slice(separator.block.row(j));
            }
        }
    }

    /// The separator's rows of `x`. Threads share its columns, which never meet.
    fn separator_blocks(&self, x: &RowBlock) -> Vec<SeparatorBlock> {
        let separator = &self.structure.separator;
        let lanes = x.width() / LANES;
        let parts = self.threads.clamp(1, lanes);
        let part = |p: usize| {
            let columns = p * lanes / parts * LANES..(p + 1) * lanes / parts * LANES;
            let mut block = RowBlock::zeros(separator.num_columns(), columns.len());
            for j in 0..block.rows() {
                block
                    .row_mut(j)
                    .copy_from_slice(&x.row(separator.column(j))[columns.clone()]);
            }
            SeparatorBlock { columns, block }
        };
        (0..parts).map(part).collect()
    }

    /// What each part works on.
    fn shares<'a>(&'a self, x: &'a mut RowBlock) -> Vec<Share<'a>> {
        let width = x.width();
        let mut rest = x.as_mut_slice();
        let (mut values, mut position) = (&self.values[..], 0);
        let mut shares = Vec::with_capacity(self.structure.parts.len());
        for part in &self.structure.parts {
            let first = part.column(0);
            let skipped = &mut std::mem::take(&mut rest)[(first - position) * width..];
            let (own, after) = skipped.split_at_mut(part.num_columns() * width);
            let (its, others) = values.split_at(part.supernodes.num_values());
            (rest, values) = (after, others);
            position = first + part.num_columns();
            shares.push(Share {
                part,
                values: its,
                own,
                outside: RowBlock::zeros(part.boundary_in_separator().len(), width),
            });
        }
        shares
    }

    fn each<T: Send>(&self, parts: &mut [T], work: impl Fn(&mut T) + Sync + Send) {
        if self.threads > 1 {
            parts.par_iter_mut().with_max_len(1).for_each(work);
        } else {
            parts.iter_mut().for_each(work);
        }
    }
}

/// Eliminates all parts, then the separator.
fn run(
    task: Task<'_>,
    structure: &Subtrees,
    mut columns: Vec<Columns<'_>>,
) -> Result<Pivots, BadPivot> {
    let for_separator = columns.pop().expect("the last is the separator's");
    let alone = Task { threads: 1, ..task };
    let work = |(part, columns): (&Part, Columns<'_>)| eliminate(alone, part, columns, (&[], &[]));
    let jobs = structure.parts.iter().zip(columns);
    let remainders: Result<Vec<Remainder>, BadPivot> = if task.threads > 1 {
        let jobs: Vec<_> = jobs.collect();
        jobs.into_par_iter().with_max_len(1).map(work).collect()
    } else {
        jobs.map(work).collect()
    };
    let remainders = remainders?;
    let entering = (&structure.incoming[..], &remainders[..]);
    let separator = if task.threads > 1 {
        eliminate_by_levels(task, &structure.separator, for_separator, entering)?
    } else {
        eliminate(task, &structure.separator, for_separator, entering)?.pivots
    };
    Ok(remainders
        .iter()
        .fold(separator, |all, r| all.join(r.pivots)))
}

/// A part of the structure, with its share of the factor and of a block.
struct Share<'a> {
    part: &'a Part,
    values: &'a [f64],
    own: &'a mut [f64],
    outside: RowBlock,
}

impl Share<'_> {
    fn forward(&mut self, width: usize) {
        for_each_panel(
            width,
            Forward {
                supernodes: &self.part.supernodes,
                values: self.values,
                own: self.own,
                outside: self.outside.as_mut_slice(),
            },
        );
    }

    fn backward(&mut self, width: usize) {
        for_each_panel(
            width,
            Backward {
                supernodes: &self.part.supernodes,
                values: self.values,
                own: self.own,
                outside: self.outside.as_slice(),
            },
        );
    }
}

/// Some columns of the separator's rows of a block.
struct SeparatorBlock {
    columns: Range<usize>,
    block: RowBlock,
}

impl SeparatorBlock {
    /// Adds what a part has done to its boundary.
    fn add(&mut self, share: &Share<'_>) {
        for (k, &row) in share.part.boundary_in_separator().iter().enumerate() {
            let source = &share.outside.row(k)[self.columns.clone()];
            for (t, v) in self.block.row_mut(row as usize).iter_mut().zip(source) {
                *t += v;
            }
        }
    }

    /// Overwrites a part's boundary by the solution there.
    fn hand_down(&self, share: &mut Share<'_>) {
        for (k, &row) in share.part.boundary_in_separator().iter().enumerate() {
            share.outside.row_mut(k)[self.columns.clone()]
                .copy_from_slice(self.block.row(row as usize));
        }
    }

    fn solve(&mut self, factor: &CholeskyFactor) {
        let supernodes = &factor.structure.separator.supernodes;
        let values = &factor.values[factor.values.len() - supernodes.num_values()..];
        let width = self.columns.len();
        for_each_panel(
            width,
            Forward {
                supernodes,
                values,
                own: self.block.as_mut_slice(),
                outside: &mut [],
            },
        );
        for_each_panel(
            width,
            Backward {
                supernodes,
                values,
                own: self.block.as_mut_slice(),
                outside: &[],
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Laplacian, LaplacianKind, SymmetricCsr, testing};

    fn analyzed(graph: &SymmetricCsr, threads: usize) -> (PermutedLaplacian, CholeskyFactor) {
        let laplacian = Laplacian::new(graph, LaplacianKind::Normalized);
        let order = EliminationOrder::new(&laplacian, None);
        let mut l = PermutedLaplacian::default();
        l.assign(&laplacian, &order, 1);
        let factor = CholeskyFactor::analyze(&l, &order, threads, FactorBuffers::default());
        (l, factor.unwrap())
    }

    fn right_hand_side(rows: usize, width: usize) -> RowBlock {
        let mut b = RowBlock::zeros(rows, width);
        for (i, v) in b.as_mut_slice().iter_mut().enumerate() {
            *v = ((i * 7919) % 1000) as f64 / 500.0 - 1.0;
        }
        b
    }

    /// One part or several, small fronts or large ones, with rows of the boundary or without.
    fn graphs() -> Vec<SymmetricCsr> {
        let parts = [
            testing::grid(50, 60),
            testing::cycle(700),
            testing::star(1500),
        ];
        vec![
            testing::path(400),
            testing::complete(150),
            testing::complete(400),
            testing::grid(100, 100),
            testing::maze(100, 100, 0.05, 1),
            testing::disjoint(&parts),
        ]
    }

    #[test]
    fn solving_undoes_multiplying() {
        for graph in graphs() {
            let (l, mut factor) = analyzed(&graph, 1);
            let sigma = 0.3;
            factor.factorize(&l, sigma).unwrap();
            for width in [8, 24, 56] {
                let b = right_hand_side(l.dim(), width);
                let mut x = b.clone();
                factor.solve(&mut x);
                let error = l.product_error(&x, sigma, &b);
                assert!(error < 1e-12, "{} nodes, width {width}: {error}", l.dim());
            }
        }
    }

    #[test]
    fn factors_and_solutions_are_the_same_bits_at_any_thread_count() {
        let mut graphs = graphs();
        graphs.push(testing::complete(900));
        for graph in graphs {
            let run = |threads| {
                let (l, mut factor) = analyzed(&graph, threads);
                factor.factorize(&l, 1e-3).unwrap();
                let mut x = right_hand_side(l.dim(), 8);
                factor.solve(&mut x);
                (factor.values, x.as_slice().to_vec())
            };
            let one = run(1);
            for threads in [2, 4] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let several = pool.build().unwrap().install(|| run(threads));
                assert!(
                    one == several,
                    "{} nodes, {threads} threads",
                    graph.num_nodes()
                );
            }
        }
    }

    #[test]
    fn inertia_agrees_with_the_dense_spectrum() {
        for graph in [
            testing::complete(300),
            testing::grid(20, 30),
            testing::random(500, 6.0, 1),
        ] {
            let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
            let (values, _) = crate::dense::laplacian_eigen(&laplacian).unwrap();
            let (l, factor) = analyzed(&graph, 1);
            for mu in [-0.01, 1e-4, 0.03, 0.3, 0.7, 0.98, 1.3, 2.01] {
                let expected = values.iter().filter(|&&v| v < mu).count();
                let count = factor.count_below(&l, mu).unwrap();
                assert_eq!(count.negative, expected, "below {mu}");
                assert!(count.certain < mu, "{count:?}");
            }
        }
    }

    #[test]
    fn inertia_counts_the_eigenvalues_of_a_path() {
        let n = 400;
        let (l, factor) = analyzed(&testing::path(n), 1);
        let value = |j: usize| 1.0 - (std::f64::consts::PI * j as f64 / (n - 1) as f64).cos();
        let count = |mu| factor.count_below(&l, mu).unwrap().negative;
        for j in [0, 1, 17, 200] {
            assert_eq!(count((value(j) + value(j + 1)) / 2.0), j + 1);
        }
        assert_eq!(count(-0.1), 0);
        assert_eq!(count(2.1), n);
    }

    #[test]
    fn a_negative_shift_is_not_positive_definite() {
        let (l, mut factor) = analyzed(&testing::grid(20, 20), 1);
        assert_eq!(factor.factorize(&l, -0.5), Err(NotPositiveDefinite));
    }
}
