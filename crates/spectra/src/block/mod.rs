//! Tall thin blocks of vectors: how they lie in memory, their products, the Rayleigh–Ritz step.

mod rayleigh_ritz;
mod row_block;
pub(crate) mod simd;
mod tiles;

pub(crate) use rayleigh_ritz::{Ritz, gram, gram_and_product, ritz, rotate};
pub(crate) use row_block::RowBlock;
pub(crate) use simd::LANES;
