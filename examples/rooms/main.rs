//! Rooms found by spectral clustering, potentials per room and a coarse graph of rooms, against one global solve: the
//! open question under Fig. 9 of the source paper.
//!
//! ```sh
//! cargo run --release --example rooms
//! ```
//!
//! Printed for each world: how many rooms there are and how many the spectrum finds, the edges between rooms against
//! the doors that were built, and for each potential the error mean |a v/d − 1| of v = −φ against the true distance
//! with the best a, false maxima, and milliseconds: from nothing, for another goal, and after a change in one room.
//! Eigenvectors and clustering stand apart: whoever keeps proto-value functions has the first for nothing.

mod hierarchy;
mod partition;

use eigentrail::env::{Direction, Doors, Layout, Tile};
use eigentrail::gcn::GcnParams;
use eigentrail::graph::{Adjacency, StateId, SymmetricCsr};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{PotentialKind, ShapingParams, potential_on_graph, spurious_maxima};
use eigentrail::spectral::{ProtoValueFunctions, SpectralParams};
use faer::{Mat, MatRef};
use hierarchy::Hierarchy;
use partition::{number_of_rooms, partition};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut rng = stream(0, Stream::Layout);
    let worlds = [
        ("linked 2 × 2 of 5 × 5", 4, Layout::linked(2, 2, [5, 5], 1)?),
        (
            "rooms 4 × 4 of 5 × 5",
            16,
            Layout::rooms(4, 4, [5, 5], Doors::Random, &mut rng)?,
        ),
        (
            "rooms 10 × 10 of 5 × 5",
            100,
            Layout::rooms(10, 10, [5, 5], Doors::Random, &mut rng)?,
        ),
        (
            "rooms 4 × 4 of 24 × 24",
            16,
            Layout::rooms(4, 4, [24, 24], Doors::Random, &mut rng)?,
        ),
        ("open 50 × 50", 1, Layout::open(50, 50)?),
    ];
    for (name, rooms, layout) in worlds {
        compare(name, rooms, &graph_of(&layout))?;
    }
    Ok(())
}

/// Free cells by rows, an edge between neighbours.
fn graph_of(layout: &Layout) -> SymmetricCsr {
    let mut number = vec![None; layout.num_cells()];
    let mut graph = Adjacency::new();
    for cell in layout.free_cells() {
        number[cell.index()] = Some(graph.add_node());
    }
    for cell in layout.free_cells() {
        for direction in [Direction::Right, Direction::Down] {
            if let Some(next) = layout
                .neighbor(cell, direction)
                .filter(|&c| layout.tile(c) != Tile::Wall)
            {
                let ends = (number[cell.index()], number[next.index()]);
                graph.add_edge(ends.0.expect("free"), ends.1.expect("free"), 1.0);
            }
        }
    }
    graph.to_csr()
}

fn compare(name: &str, built: usize, graph: &SymmetricCsr) -> Result<(), Box<dyn Error>> {
    let n = graph.num_nodes();
    let mut functions = ProtoValueFunctions::new(
        SpectralParams {
            num_eigenpairs: (built + 8).min(n),
            tol: 1e-3,
            ..SpectralParams::default()
        },
        0,
    );
    let begun = Instant::now();
    functions.refresh(graph)?;
    let spectrum_ms = milliseconds(begun);
    let pairs = functions.eigenpairs().expect("refreshed");
    let begun = Instant::now();
    let rooms = number_of_rooms(&pairs.values);
    let partition = partition(graph, pairs.vectors.as_ref(), rooms);
    let clustering_ms = milliseconds(begun);
    let begun = Instant::now();
    let mut hierarchy = Hierarchy::new(graph, &partition);
    let survey_ms = milliseconds(begun);

    let (goal, other_goal) = (n - 1, n / 2);
    let truth = global(graph, goal, PotentialKind::Hops, Mat::zeros(0, 0).as_ref())?.0;
    println!(
        "\n{name}: {n} states, {built} rooms built; found {} (gap after {rooms} eigenvalues), {} doors; eigenvectors {spectrum_ms:.1} ms, clustering {clustering_ms:.1} ms",
        partition.num_rooms,
        hierarchy.num_doors(),
    );
    println!(
        "| potential | error | false maxima | ms from nothing | ms another goal | ms one room changed |"
    );
    println!("|---|---|---|---|---|---|");
    let begun = Instant::now();
    let by_rooms: Vec<f64> = hierarchy.distances(goal).iter().map(|d| -d).collect();
    let first_ms = survey_ms + milliseconds(begun);
    let begun = Instant::now();
    black_box(hierarchy.distances(other_goal));
    let goal_ms = milliseconds(begun);
    let begun = Instant::now();
    hierarchy.survey(partition.room_of[n / 3]);
    black_box(hierarchy.distances(goal));
    let change_ms = milliseconds(begun);
    row(
        "rooms",
        &by_rooms,
        &truth,
        graph,
        goal,
        [first_ms, goal_ms, change_ms],
    );
    for kind in [
        PotentialKind::Hops,
        PotentialKind::Heat,
        PotentialKind::Gcn,
        PotentialKind::Report,
    ] {
        let features = functions.features().expect("refreshed");
        let (phi, ms) = global(graph, goal, kind, features)?;
        let (_, other_ms) = global(graph, other_goal, kind, features)?;
        // One global solve knows nothing of rooms: any change means another one.
        row(
            &kind.to_string(),
            &phi,
            &truth,
            graph,
            goal,
            [ms, other_ms, ms],
        );
    }
    Ok(())
}

fn milliseconds(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

fn global(
    graph: &SymmetricCsr,
    goal: usize,
    kind: PotentialKind,
    features: MatRef<'_, f64>,
) -> Result<(Vec<f64>, f64), Box<dyn Error>> {
    let (shaping, gcn) = (ShapingParams::default(), GcnParams::default());
    let goals = [StateId(goal as u32)];
    let begun = Instant::now();
    let fit = potential_on_graph(graph, &goals, kind, features, &shaping, &gcn, 0)?;
    Ok((fit.values, milliseconds(begun)))
}

fn row(name: &str, phi: &[f64], truth: &[f64], graph: &SymmetricCsr, goal: usize, ms: [f64; 3]) {
    let false_maxima = spurious_maxima(phi, graph, &[StateId(goal as u32)]).len();
    let error = relative_error(phi, truth, goal);
    println!(
        "| {name} | {error:.3} | {false_maxima} | {:.2} | {:.2} | {:.2} |",
        ms[0], ms[1], ms[2]
    );
}

/// mean |a φ/φ* − 1| with the best a.
fn relative_error(phi: &[f64], truth: &[f64], goal: usize) -> f64 {
    let others = (0..phi.len()).filter(|&i| i != goal);
    let mut ratios: Vec<f64> = others.map(|i| phi[i] / truth[i]).collect();
    ratios.sort_by(f64::total_cmp);
    // Σ |a x − 1| = Σ x |a − 1/x| is least at the median of the 1/x weighted by x.
    let half = ratios.iter().sum::<f64>() / 2.0;
    let mut sum = 0.0;
    let middle = ratios.iter().rev().find(|&&x| {
        sum += x;
        sum >= half
    });
    let a = middle.map_or(0.0, |x| 1.0 / x);
    ratios.iter().map(|x| (a * x - 1.0).abs()).sum::<f64>() / ratios.len() as f64
}
