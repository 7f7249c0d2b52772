//! The generators of `eigentrail-testing`, their graphs in the type that says what they guarantee.

pub use eigentrail::graph::SymmetricCsr;
#[allow(unused_imports, reason = "each test and bench uses its own part")]
pub use eigentrail_testing::graphs::sizes;

eigentrail_testing::checked_graphs!(eigentrail::graph::SymmetricCsr);
