//! The world of a scenario as an edge list, every state, action and outcome of it:
//! `cargo run --release --example world_as_edges -- SCENARIO.toml > world.csv`.
//!
//! On top stand the states whose rewards are noisy, with the standard deviation, the starts, the ends and the step limit, as
//! comments that begin with `#`.

use eigentrail::env::{Action, GridWorld, MdpState, Model};
use eigentrail::scenario::{Scenario, World};
use std::error::Error;
use std::fmt::Display;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which scenario?")?;
    let loaded = Scenario::load(Path::new(&path), &[])?;
    match loaded.worlds.first() {
        World::Listed(world, names) => {
            for (state, name) in (0..).zip(&names.states) {
                match world.reward_deviation(MdpState(state)) {
                    0.0 => {}
                    deviation => println!("# noise {deviation} {name}"),
                }
            }
            print(world, |state| names.states[state].clone(), &names.actions);
        }
        World::Grid(world) => {
            let cells: Vec<_> = world.mdp_cells().collect();
            print(
                world,
                |state| {
                    let (row, col) = world.layout().position(cells[state]);
                    format!("[{row}, {col}]")
                },
                &GridWorld::ACTION_NAMES,
            );
        }
    }
    Ok(())
}

fn print(world: &impl Model, name: impl Fn(usize) -> String, actions: &[impl Display]) {
    let mdp = world.to_mdp();
    for start in world.start_states() {
        println!("# start {}", name(start));
    }
    for end in (0..mdp.num_states()).filter(|&state| mdp.is_terminal(state)) {
        println!("# end {}", name(end));
    }
    println!("# max_steps {}", world.max_steps());
    println!("from,action,to,probability,reward");
    for state in 0..mdp.num_states() {
        for action in (0..mdp.num_actions()).map(|a| Action(a as u16)) {
            for outcome in mdp.outcomes(state, action) {
                println!(
                    "\"{}\",\"{}\",\"{}\",{},{}",
                    name(state),
                    actions[action.index()],
                    name(outcome.next as usize),
                    outcome.probability,
                    outcome.reward
                );
            }
        }
    }
}
