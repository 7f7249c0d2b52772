//! The library against independent oracles, and the rules of its making.

mod agents;
mod architecture;
mod best_in_the_limit;
mod dependents;
mod engine;
#[path = "../common/env_worlds.rs"]
mod env_worlds;
mod environments;
mod gcn_gradients;
mod goals_and_hazards;
mod graph_export;
mod graph_properties;
#[path = "../common/graphs.rs"]
mod graphs;
mod idle_keys;
mod matrix_market;
mod mistakes;
mod potentials;
mod scenarios;
mod search_by_value;
mod shaping_invariance;
mod simulator;
mod spectrum_growth;
mod spectrum_oracle;
mod starts;
mod turns;
mod walkers;
