#![doc = include_str!("../README.md")]
//!
//! # Conventions
//!
//! Blocks of vectors are n × b; eigenvalues ascend and repeat by multiplicity; vectors are orthonormal; tolerances
//! are relative to λ_k. Null vectors, one per connected component, are known in closed form and have λ = 0 exactly.
//!
//! # Parts
//!
//! Each folder of `src` knows only those above it.
//!
//! | folder | parts |
//! |---|---|
//! | | [`SymmetricCsr`], [`Laplacian`], [`SymmetricOperator`], [`symmetric_eigen`] |
//! | `block` | tall thin blocks of vectors by rows, their products and Rayleigh–Ritz steps, in registers of fixed order |
//! | `cholesky` | minimum degree that mends an earlier order, the multifrontal factor, solves, inertia |
//! | `iteration` | filters, subspace iteration, start from earlier vectors, proof; [`smallest_eigenpairs`] |
//! | `tracker` | [`GrowingEigensolver`], its routes; [`track`](fn@track), [`procrustes`](fn@procrustes) |

#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod block;
mod cholesky;
mod dense;
mod eigenpairs;
mod error;
mod iteration;
mod laplacian;
mod operator;
mod params;
#[cfg(feature = "serde")]
pub mod plain;
mod random;
mod symmetric_csr;
#[cfg(test)]
mod testing;
mod tracker;

pub use dense::symmetric_eigen;
pub use eigenpairs::{Convergence, Eigenpairs, LAMBDA_FLOOR};
pub use error::{ParameterError, SpectralError};
pub use iteration::smallest_eigenpairs;
pub use laplacian::Laplacian;
pub use operator::SymmetricOperator;
pub use params::{LaplacianKind, Method, SpectralParams};
pub use symmetric_csr::SymmetricCsr;
pub use tracker::{
    GrowingEigensolver, Route, SpectrumRefresh, TrackParams, TrackStatistics, TrackUpdate,
    TrackedSpectrum, procrustes, track, with_fixed_signs,
};

// Types of theirs are in signatures.
pub use faer;
pub use sprs;
