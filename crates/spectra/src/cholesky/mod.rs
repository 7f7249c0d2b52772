//! Sparse Cholesky of L + σI: the order of elimination, mended where the graph grew, and the factor.

mod dense_front;
mod elimination;
mod etree;
mod factor;
mod inertia;
mod levels;
mod minimum_degree;
mod multifrontal;
mod permuted;
mod subtrees;
mod supernodes;
mod triangular;
mod unchanged_subtrees;

pub(crate) use elimination::EliminationOrder;
#[cfg(test)]
pub(crate) use factor::faults;
pub(crate) use factor::{CholeskyFactor, FactorBuffers};
pub(crate) use inertia::Inertia;
pub(crate) use permuted::PermutedLaplacian;
