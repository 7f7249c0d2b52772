//! The k lowest eigenpairs of a graph's Laplacian, kept up to date while the graph grows.
//!
//! L v = λ v, 0 = λ_1 ≤ λ_2 ≤ …: the low eigenvectors vary slowly over the graph and serve as features
//! of its nodes (*proto-value functions*: Mahadevan & Maggioni 2007). On large grids the low end of
//! the spectrum is crowded near 0, so that iterations with L itself need thousands of products.
//! Those with the inverse of the shifted matrix M = L + σI need a handful:
//!
//! 1. order the nodes so that the Cholesky factor of M fills little, and factor it;
//! 2. extend the last eigenvectors to the new nodes, add guard vectors and a random one;
//! 3. filter the block by a polynomial in M⁻¹, take the Rayleigh–Ritz step, measure residuals;
//!    repeat until ‖Lv − λv‖ ≤ tol · λ_k and each λ is accurate to tol² · λ_k.
//!
//! Conventions: blocks of vectors are n × b; eigenvalues ascend and repeat by multiplicity; vectors
//! are orthonormal; tolerances are relative to λ_k. Null vectors, one per connected component, are
//! known in closed form and have λ = 0 exactly. Results are the same at any number of threads.
//!
//! | layer | modules |
//! |---|---|
//! | operators | [`SymmetricOperator`], [`Laplacian`], `shift_invert` |
//! | sparse algebra | `elimination`, `frozen`, `minimum_degree`, `etree`, `permuted`, `factor`, `triangular`, `tiles`, `simd`, `block` |
//! | recurrences | `lanczos`, `filter`, `chebyshev`, `rayleigh_ritz`, `orthonormal`, [`symmetric_eigen`] |
//! | policy | `effort`, `assess`, `subspace`, `search`, `certify`, `inertia`, `products`, [`smallest_eigenpairs`] |
//! | growing graphs | `extend`, `kept`, `start`, `routes`, [`LowSpectrum`], [`procrustes`](fn@procrustes), [`ProtoValueFunctions`], [`track`](fn@track) |

mod assess;
mod block;
mod certify;
mod chebyshev;
mod dense;
mod effort;
mod eigenpairs;
mod elimination;
mod error;
mod etree;
mod extend;
mod factor;
mod filter;
mod front;
mod frontal;
mod frozen;
mod inertia;
mod kept;
mod lanczos;
mod laplacian;
mod levels;
mod low_spectrum;
mod minimum_degree;
mod null_space;
mod operator;
mod orthonormal;
mod params;
mod permuted;
mod pieces;
mod prefixes;
mod procrustes;
mod products;
mod proto_value;
mod rayleigh_ritz;
mod route;
mod routes;
mod search;
mod shift_invert;
mod simd;
mod solver;
mod start;
mod subspace;
mod supernodes;
mod tiles;
mod track;
mod triangular;

pub use dense::symmetric_eigen;
pub use eigenpairs::{Convergence, Eigenpairs, LAMBDA_FLOOR};
pub use error::SpectralError;
pub use laplacian::{Laplacian, check_symmetric};
pub use low_spectrum::{LowSpectrum, SpectrumRefresh};
pub use operator::SymmetricOperator;
pub use params::{LaplacianKind, Method, SpectralParams};
pub use procrustes::procrustes;
pub use proto_value::ProtoValueFunctions;
pub use route::Route;
pub use solver::smallest_eigenpairs;
pub use track::{TrackParams, TrackReport, TrackUpdate, TrackedSpectrum, track};

#[cfg(test)]
#[path = "../../tests/common/graphs.rs"]
mod testing;
