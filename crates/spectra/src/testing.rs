//! The generators of the tests, through the door.

pub(crate) use eigentrail_testing::graphs::sizes;

eigentrail_testing::checked_graphs!(crate::SymmetricCsr);
