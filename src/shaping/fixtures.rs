//! Small graphs and decision processes for the tests of this module.

use super::absorbing_chain::AbsorbingChain;
use super::decision_process::{Choices, DecisionProcess};
use super::fit_context::FitContext;
use super::learnt_model::LearntModel;
use super::return_context::ReturnContext;
use super::shortest_path::ShortestPathProblem;
use super::transition_matrix::TransitionMatrix;
use crate::graph::{StateId, SymmetricCsr};
use faer::Mat;
use proptest::prelude::*;

/// An undirected graph with unit weights; an edge given twice weighs 1 all the same.
pub fn graph(n: usize, edges: &[(usize, usize)]) -> SymmetricCsr {
    let mut directed: Vec<_> = edges.iter().flat_map(|&(i, j)| [(i, j), (j, i)]).collect();
    directed.sort_unstable();
    directed.dedup();
    let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
    directed
        .iter()
        .for_each(|&(i, j)| triplets.add_triplet(i, j, 1.0));
    SymmetricCsr::new(triplets.to_csr()).unwrap()
}

/// The path 0 – 1 – … – (n−1).
pub fn path(n: usize) -> SymmetricCsr {
    graph(n, &(1..n).map(|i| (i - 1, i)).collect::<Vec<_>>())
}

/// The grid of `rows` × `columns` cells, numbered row by row, without the edges that touch `walls`.
pub fn grid(rows: usize, columns: usize, walls: &[usize]) -> SymmetricCsr {
    let mut edges = Vec::new();
    for i in 0..rows * columns {
        if i % columns + 1 < columns {
            edges.push((i, i + 1));
        }
        if i + columns < rows * columns {
            edges.push((i, i + columns));
        }
    }
    edges.retain(|(i, j)| !walls.contains(i) && !walls.contains(j));
    graph(rows * columns, &edges)
}

/// Unit costs and goals of equal worth.
pub fn chain(adjacency: &SymmetricCsr, goals: &[u32]) -> AbsorbingChain {
    AbsorbingChain::by_hops(&TransitionMatrix::undirected(adjacency), goals)
}

/// Graphs of 2 to 24 nodes, any density, connected or not, with self-loops.
pub fn any_graph() -> impl Strategy<Value = SymmetricCsr> {
    (2_usize..24).prop_flat_map(|n| {
        prop::collection::vec((0..n, 0..n), 0..4 * n).prop_map(move |edges| graph(n, &edges))
    })
}

/// Graphs of 40 nodes where nearly all neighbours are far: complete, in the layers 0 – {1, 2, 3} – {4 … 39}, and a star with 0 on a ray.
pub fn far_reaching_graphs() -> [SymmetricCsr; 3] {
    let joined = |keep: fn(usize, usize) -> bool| {
        let pairs = (0..40).flat_map(|i| (0..i).map(move |j| (j, i)));
        let edges: Vec<_> = pairs.filter(|&(j, i)| keep(j, i)).collect();
        graph(40, &edges)
    };
    [
        joined(|_, _| true),
        joined(|j, i| (j == 0 && i < 4) || (1..4).contains(&j) && i >= 4),
        joined(|j, i| j == 0 && i == 1 || j == 1),
    ]
}

/// Calls `check` with a context on a 9 × 8 grid with two walls, goal in a corner, and `features` columns of features. The agent
/// has had the returns of shortest ways, from everywhere.
pub fn on_grid(features: usize, check: impl FnOnce(&ReturnContext<'_>)) {
    let adjacency = grid(9, 8, &[17, 18, 19, 44, 45]);
    let features = Mat::from_fn(72, features, |i, c| {
        ((i * (c + 2) * 37) % 29) as f64 / 14.0 - 1.0
    });
    let model = LearntModel::uniform(&adjacency, &[StateId(0)]);
    check(&ReturnContext {
        model: &model,
        adjacency: &adjacency,
        features: features.as_ref(),
        returns: &model.optimal_returns(),
    });
}

/// Calls `check` with a context of this problem on this graph, without features and labels.
pub fn on_problem<T>(
    adjacency: &SymmetricCsr,
    problem: &ShortestPathProblem,
    check: impl FnOnce(&FitContext<'_>) -> T,
) -> T {
    check(&FitContext {
        problem,
        adjacency,
        features: Mat::zeros(0, 0).as_ref(),
        labels: &[],
    })
}

/// A choice as tests write it down.
#[derive(Clone, Debug)]
pub struct Alternative {
    pub reward: f64,
    /// Beside the other choices of the state.
    pub weight: f64,
    pub may_end: bool,
    /// States, and chances.
    pub outcomes: Vec<(u32, f64)>,
}

impl Alternative {
    /// One of weight 1 that leads to these states with these chances, and otherwise ends the episode.
    pub fn new(reward: f64, may_end: bool, outcomes: &[(u32, f64)]) -> Self {
        Self {
            reward,
            weight: 1.0,
            may_end,
            outcomes: outcomes.to_vec(),
        }
    }
}

/// The process with these alternatives by state; without any, the state is one in which episodes end.
pub fn process(states: &[Vec<Alternative>], step_reward: f64) -> DecisionProcess {
    let mut choices = Choices::default();
    for options in states {
        for o in options {
            choices.push(o.reward, o.weight, o.may_end, o.outcomes.iter().copied());
        }
        choices.end_state();
    }
    DecisionProcess::new(&choices, step_reward)
}

/// Each edge of `adjacency` is an option that pays what `reward` says of the state it leaves; state 0 is where episodes end. Loops are left out.
pub fn walks(adjacency: &SymmetricCsr, reward: impl Fn(usize) -> f64) -> Vec<Vec<Alternative>> {
    let options = |i: usize| {
        let (columns, weights) = adjacency.row(i);
        let edges = columns
            .iter()
            .zip(weights)
            .filter(|(j, _)| **j as usize != i);
        edges
            .map(|(&j, &weight)| Alternative {
                weight,
                ..Alternative::new(reward(i), j == 0, &[(j, 1.0)])
            })
            .collect()
    };
    let others = (1..adjacency.num_nodes()).map(options);
    std::iter::once(vec![]).chain(others).collect()
}

/// 1 to 12 states with up to 4 options each, of rewards of both signs and 1 to 3 outcomes, after each of which the episode ends by itself with at
/// least this chance. In some of the states episodes end.
pub fn any_process(least_end: f64) -> impl Strategy<Value = Vec<Vec<Alternative>>> {
    let option = (
        -3.0_f64..2.0,
        0.1_f64..5.0,
        any::<bool>(),
        prop::collection::vec((0_u32..12, 0.05_f64..1.0), 1..4),
        0.0_f64..0.5,
    );
    let states = prop::collection::vec(prop::collection::vec(option, 0..5), 1..13);
    states.prop_map(move |states| {
        let n = states.len() as u32;
        let states = states.into_iter().enumerate();
        let place = |i: usize, (reward, weight, may_end, outcomes, end): (_, _, _, Vec<(u32, f64)>, f64)| {
            let total: f64 = outcomes.iter().map(|(_, chance)| chance).sum();
            let goes_on = (1.0 - end).min(1.0 - least_end) / total;
            let others = outcomes.iter().map(|&(j, chance)| (j % n, goes_on * chance));
            let outcomes = others.filter(|&(j, _)| j as usize != i).collect();
            Alternative { reward, weight, may_end, outcomes }
        };
        states
            .map(|(i, options)| options.into_iter().map(|o| place(i, o)).collect())
            .collect()
    })
}

/// V by state for temperatures by state, by plain value iteration; chances of outcomes add up to less than 1.
pub fn value_iteration(states: &[Vec<Alternative>], tau: &[f64]) -> Vec<f64> {
    let mut v = vec![0.0; states.len()];
    for _ in 0..200_000 {
        let before = v.clone();
        for (i, options) in states
            .iter()
            .enumerate()
            .filter(|(_, options)| !options.is_empty())
        {
            v[i] = soft_maximum(options, tau[i], &before);
        }
        let changes = v.iter().zip(&before).map(|(new, old)| (new - old).abs());
        if changes.fold(0.0, f64::max) < 1e-13 {
            return v;
        }
    }
    panic!("value iteration goes on and on");
}

/// What the options are worth where `v` is what states are worth.
pub fn worths(options: &[Alternative], v: &[f64]) -> Vec<f64> {
    let worth = |o: &Alternative| {
        let next = o.outcomes.iter().map(|&(j, chance)| chance * v[j as usize]);
        o.reward + next.sum::<f64>()
    };
    options.iter().map(worth).collect()
}

fn soft_maximum(options: &[Alternative], tau: f64, v: &[f64]) -> f64 {
    let worths = worths(options, v);
    let best = worths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if tau == 0.0 {
        return best;
    }
    let total: f64 = options.iter().map(|o| o.weight).sum();
    let terms = worths.iter().zip(options);
    let mean: f64 = terms
        .map(|(q, o)| o.weight / total * ((q - best) / tau).exp())
        .sum();
    best + tau * mean.ln()
}
