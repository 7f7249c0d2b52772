//! The program from outside.

mod bounds;
mod cli;
mod compare;
mod completions;
mod default_agent;
mod export;
mod interruptions;
mod json;
mod listed_names;
mod live_page;
mod own_graphs;
mod potential_kinds;
#[path = "../common/program.rs"]
mod program;
mod readme;
mod report_page;
#[path = "../common/runs.rs"]
mod runs;
mod seeds;
#[path = "../common/served.rs"]
mod served;
mod sweep;
mod tensorboard;
mod values;
mod worlds;
