//! From a start block to the lowest eigenpairs, and the proof that none was missed.

mod assess;
mod certify;
mod chebyshev;
mod extend;
mod filter;
mod gain_history;
mod lanczos;
mod null_space;
mod orthonormal;
mod products;
mod search;
mod shift_invert;
mod solver;
mod start;
mod subspace;
mod warm_start;

pub(crate) use assess::tolerance_floor;
pub(crate) use gain_history::GainHistory;
pub(crate) use null_space::NullSpace;
#[cfg(test)]
pub(crate) use orthonormal::orthonormalize;
pub(crate) use products::first_filter;
pub(crate) use search::{Found, PROOF_LIMIT, Search, Start};
pub use solver::smallest_eigenpairs;
pub(crate) use solver::{DENSE_LIMIT, residual_norms};
pub(crate) use warm_start::WarmStart;
