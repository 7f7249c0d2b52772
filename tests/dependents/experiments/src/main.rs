//! What a user writes who reads graphs and runs experiments without the command line, as a Python package would.

use eigentrail::archive::Existing;
use eigentrail::graph::matrix_market;
use eigentrail::runner::{RunRequest, Watch, run};
use eigentrail::scenario::Scenario;
use std::error::Error;
use std::sync::atomic::AtomicBool;

fn main() -> Result<(), Box<dyn Error>> {
    let loaded = Scenario::load("smoke".as_ref(), &[])?;
    let request = RunRequest {
        seeds: vec![0],
        out: None,
        existing: Existing::Refuse,
        arguments: Vec::new(),
    };
    let watch = Watch {
        stop: &AtomicBool::new(false),
        observers: &|_| Ok(Vec::new()),
    };
    let run = run(&loaded, &request, watch)?;
    println!(
        "{} with regret {}",
        run.folder.path().display(),
        run.seeds[0].result.regret
    );
    if let Some(file) = std::env::args().nth(1) {
        println!("{} nodes", matrix_market::load(file)?.num_nodes());
    }
    Ok(())
}
