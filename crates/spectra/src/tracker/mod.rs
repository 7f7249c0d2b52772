//! Following a graph that grows: which route to take, what to carry over, how to write it down.

#[cfg(feature = "serde")]
mod checkpoint;
mod dispatch;
mod growing_eigensolver;
mod prefixes;
mod procrustes;
mod route;
mod track;

pub use growing_eigensolver::{GrowingEigensolver, SpectrumRefresh};
pub use procrustes::{procrustes, with_fixed_signs};
pub use route::Route;
pub use track::{TrackParams, TrackStatistics, TrackUpdate, TrackedSpectrum, track};
