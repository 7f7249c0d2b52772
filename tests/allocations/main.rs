//! What allocates nothing: steps among known states, without a refresh.

mod agents;
mod engine;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../common/env_worlds.rs"]
mod env_worlds;

use eigentrail_testing::allocations::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
