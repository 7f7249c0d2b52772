//! What several integration tests share.

pub mod families;
pub mod graphs;
