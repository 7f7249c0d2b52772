//! Exploration: guidance where the reward does not reach yet.
//!
//! Before the first goal no potential leads to one, and most of what an agent will ever lose it loses there. The
//! `frontier` exploration advises the policy instead of the reward: it adds to the logits of the actor (look-ahead
//! advice, Wiewiora, Cottrell & Elkan 2003), so that values and shaped rewards stay what they are.
//!
//! | type | is |
//! |---|---|
//! | [`ExplorationModel`] | what is known of a world, shared by all explorers in it: what actions do, goals and hops to them, look-ahead advice |
//! | [`Explorer`] | where one of them stands: its plan, a shortest known path to the nearest state with something left to try |
//! | [`CountBonus`] | β/√N, the peer |

mod barren_starts;
mod certainty;
mod count_bonus;
mod dead_reckoning;
mod distances;
mod expected_return;
mod explorer;
#[cfg(test)]
mod fixtures;
#[cfg(test)]
mod follower;
mod frontier;
mod look_ahead;
mod model;
mod objective;
mod params;
mod search_budget;
mod stale;
#[cfg(test)]
mod tests;
mod way_back;

pub use count_bonus::CountBonus;
pub use explorer::Explorer;
pub use model::{Destination, ExplorationModel, RecordedStep};
pub use params::{ExplorationKind, ExplorationParams, Optimism, SearchOrder};
