//! The eigensolver alone: the lowest eigenvectors of a graph that grows, kept up to date, no learning involved.
//!
//! A strip of 20 × n nodes grows by one row at a time. Run it with `cargo run --release --example track_spectrum`.

use eigentrail::graph::Adjacency;
use eigentrail::spectral::{ProtoValueFunctions, SpectralError, SpectralParams};

const WIDTH: u32 = 20;

/// One more row of nodes, each joined to its left neighbour and to the one above.
fn add_row(graph: &mut Adjacency) {
    for _ in 0..WIDTH {
        let node = graph.add_node();
        if !node.is_multiple_of(WIDTH) {
            graph.add_edge(node - 1, node, 1.0);
        }
        if node >= WIDTH {
            graph.add_edge(node - WIDTH, node, 1.0);
        }
    }
}

fn main() -> Result<(), SpectralError> {
    let params = SpectralParams {
        num_eigenpairs: 8,
        ..Default::default()
    };
    let mut spectrum = ProtoValueFunctions::new(params, 0);
    let mut graph = Adjacency::new();
    println!("nodes  start  applications  residual      λ_2       λ_8");
    for row in 1..=100 {
        add_row(&mut graph);
        // The solver starts from the last eigenvectors; refreshing at each row is more often than need be.
        let refresh = spectrum.refresh(&graph.to_csr())?;
        if row % 20 == 0 {
            println!(
                "{:>5}  {}  {:>12}  {:>8.1e}  {:.6}  {:.6}",
                graph.num_nodes(),
                if refresh.cold_start { " cold" } else { " warm" },
                refresh.convergence.applications,
                refresh.convergence.max_relative_residual,
                refresh.eigenvalues[1],
                refresh.eigenvalues[7],
            );
        }
    }
    Ok(())
}
