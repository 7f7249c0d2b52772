//! The graph against independent oracles: rebuilt from scratch, petgraph, nalgebra-sparse.

use eigentrail::env::Action;
use eigentrail::graph::connectivity::{Entering, UNREACHED, hops};
use eigentrail::graph::{Adjacency, StateGraph, StateId, SymmetricCsr, TransitionGraph};
use petgraph::graph::{NodeIndex, UnGraph};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// One step of a random walk over at most `n` states with 3 actions: (from, action, to, terminal).
fn steps(n: u32, most: usize) -> impl Strategy<Value = Vec<(u32, u16, u32, bool)>> {
    proptest::collection::vec((0..n, 0..3_u16, 0..n, any::<bool>()), 0..most)
}

/// Undirected edges over `n` nodes, weights multiples of 1/4, so that sums are exact; repetitions and loops come up.
fn edges(n: u32, most: usize) -> impl Strategy<Value = Vec<(u32, u32, f64)>> {
    proptest::collection::vec(
        (
            0..n,
            0..n,
            (1..9).prop_map(|quarters| f64::from(quarters) / 4.0),
        ),
        0..most,
    )
}

/// What a graph must be after `edges`: the first weight of each pair counts.
fn from_scratch(n: usize, edges: &[(u32, u32, f64)]) -> BTreeMap<(usize, usize), f64> {
    let mut entries = BTreeMap::new();
    for &(u, v, weight) in edges {
        assert!((u as usize) < n && (v as usize) < n);
        if !entries.contains_key(&(u as usize, v as usize)) {
            entries.insert((u as usize, v as usize), weight);
            entries.insert((v as usize, u as usize), weight);
        }
    }
    entries
}

fn csr_of(n: usize, entries: &BTreeMap<(usize, usize), f64>) -> SymmetricCsr {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
    entries
        .iter()
        .for_each(|(&(row, column), &weight)| triplets.add_triplet(row, column, weight));
    SymmetricCsr::new(triplets.to_csr()).unwrap()
}

fn check_growth(n: u32, edges: &[(u32, u32, f64)], check_each: bool) -> Adjacency {
    let mut grown = Adjacency::new();
    for (index, &(u, v, weight)) in edges.iter().enumerate() {
        // Nodes come as late as they can.
        while grown.num_nodes() <= u.max(v) as usize {
            grown.add_node();
        }
        let known = from_scratch(n as usize, &edges[..if check_each { index } else { 0 }]);
        let is_new = grown.add_edge(u, v, weight);
        if check_each {
            grown.assert_consistent();
            assert_eq!(is_new, !known.contains_key(&(u as usize, v as usize)));
        }
    }
    while grown.num_nodes() < n as usize {
        grown.add_node();
    }
    grown.assert_consistent();
    let expected = from_scratch(n as usize, edges);
    assert_eq!(grown.to_csr(), csr_of(n as usize, &expected));
    assert_eq!(
        grown.num_edges(),
        expected.keys().filter(|(u, v)| u <= v).count()
    );
    for (row, &degree) in grown.degrees().iter().enumerate() {
        assert_eq!(
            degree,
            expected
                .range((row, 0)..=(row, usize::MAX))
                .map(|(_, weight)| weight)
                .sum::<f64>()
        );
    }
    grown
}

proptest! {
    #[test]
    fn grown_edge_by_edge_is_built_from_scratch(edges in edges(8, 40)) {
        let grown = check_growth(8, &edges, true);
        prop_assert_eq!(Adjacency::from_csr(&grown.to_csr()).to_csr(), grown.to_csr());
    }

    #[test]
    fn the_matrix_is_symmetric_and_sorted(edges in edges(8, 40)) {
        let csr = check_growth(8, &edges, false).to_csr();
        prop_assert_eq!(&csr.as_csr().transpose_view().to_csr(), csr.as_csr());
        for row in csr.as_csr().outer_iterator() {
            prop_assert!(row.indices().is_sorted_by(|a, b| a < b));
        }
    }

    #[test]
    fn a_prefix_is_the_induced_subgraph(edges in edges(8, 40), m in 0..=8_usize) {
        let inside: Vec<_> = edges.iter().copied().filter(|&(u, v, _)| u.max(v) < m as u32).collect();
        let prefix = check_growth(8, &edges, false).prefix_csr(m);
        prop_assert_eq!(prefix, csr_of(m, &from_scratch(m, &inside)));
    }

    #[test]
    fn hops_agree_with_petgraph(edges in edges(12, 16), source in 0..12_u32) {
        let graph = check_growth(12, &edges, false);
        let mut oracle = UnGraph::<(), ()>::from_edges(edges.iter().map(|&(u, v, _)| (u, v)));
        while oracle.node_count() < 12 {
            oracle.add_node(());
        }
        let distances = petgraph::algo::dijkstra(&oracle, source.into(), None, |_| 1_u32);
        for (node, &far) in hops(&graph, [StateId(source)]).iter().enumerate() {
            let expected = distances.get(&NodeIndex::from(node as u32)).copied();
            prop_assert_eq!(far, expected.unwrap_or(UNREACHED));
        }
    }

    #[test]
    fn transitions_are_counted_as_in_a_table(steps in steps(6, 60)) {
        let mut graph = TransitionGraph::new(3);
        (0..6).for_each(|_| { graph.add_state(); });
        let mut table: BTreeMap<(u32, u16, u32), (u32, f64, bool)> = BTreeMap::new();
        let mut undirected = BTreeSet::new();
        for (index, &(from, action, to, terminal)) in steps.iter().enumerate() {
            let reward = index as f64 - 3.0;
            let is_new = graph.record(StateId(from), Action(action), reward, StateId(to), terminal);
            graph.assert_consistent();
            prop_assert_eq!(is_new, from != to && undirected.insert((from.min(to), from.max(to))));
            let entry = table.entry((from, action, to)).or_default();
            *entry = (entry.0 + 1, entry.1 + reward, entry.2 | terminal);
        }
        prop_assert_eq!(graph.num_transitions(), table.len());
        for from in 0..6 {
            let found: BTreeMap<_, _> = graph.outcomes(StateId(from))
                .map(|seen| ((from, seen.action.0, seen.next.0), (seen.count, seen.reward_sum, seen.terminal))).collect();
            let expected: BTreeMap<_, _> = table.range((from, 0, 0)..(from + 1, 0, 0)).map(|(&key, &value)| (key, value)).collect();
            prop_assert_eq!(found, expected);
            let total = table.range((from, 0, 0)..(from + 1, 0, 0)).fold((0, 0.0), |sum, (_, seen)| (sum.0 + seen.0, sum.1 + seen.1));
            prop_assert_eq!(graph.mean_step_reward(StateId(from)), (total.0 > 0).then(|| total.1 / f64::from(total.0)));
        }
    }

    #[test]
    fn the_likely_successor_is_the_mode(ends in proptest::collection::vec(0..4_u32, 1..20)) {
        let mut graph = TransitionGraph::new(1);
        (0..4).for_each(|_| { graph.add_state(); });
        ends.iter().for_each(|&to| { graph.record(StateId(0), Action(0), 1.0, StateId(to), false); });
        let count = |to| ends.iter().filter(|&&end| end == to).count();
        // Of equals, the one seen first: max_by_key takes the last of them.
        let mode = ends.iter().rev().copied().max_by_key(|&to| count(to));
        prop_assert_eq!(graph.likely_successor(StateId(0), Action(0)), mode.map(StateId));
        prop_assert_eq!(graph.mean_reward(StateId(0), Action(0)), Some(1.0));
        prop_assert_eq!(graph.mean_reward(StateId(1), Action(0)), None);
    }

    #[test]
    fn saved_transitions_come_back(steps in steps(5, 40)) {
        let mut graph = StateGraph::new(3);
        for &(from, action, to, terminal) in &steps {
            let [from, to] = [from, to].map(|state| graph.intern(&state).0);
            graph.record(from, Action(action), 0.5, to, terminal);
        }
        let text = serde_json::to_string(&graph).unwrap();
        let loaded: StateGraph<u32> = serde_json::from_str(&text).unwrap();
        loaded.assert_consistent();
        prop_assert_eq!(loaded.transitions().adjacency().to_csr(), graph.transitions().adjacency().to_csr());
        prop_assert_eq!(serde_json::to_string(&loaded).unwrap(), text);
    }

    #[test]
    fn hops_against_the_arrows_are_steps_to_the_goal(steps in steps(8, 20)) {
        let mut graph = TransitionGraph::new(3);
        (0..8).for_each(|_| { graph.add_state(); });
        for &(from, action, to, terminal) in &steps {
            graph.record(StateId(from), Action(action), 0.0, StateId(to), terminal);
        }
        let found = hops(&Entering(&graph), [StateId(0)]);
        for (from, &far) in found.iter().enumerate() {
            let ways = petgraph::algo::dijkstra(graph.digraph(), (from as u32).into(), Some(0.into()), |_| 1_u32);
            prop_assert_eq!(far, ways.get(&NodeIndex::from(0)).copied().unwrap_or(UNREACHED));
        }
    }
}

#[test]
fn a_larger_graph_grown_in_a_mixed_order_is_the_one_built_from_scratch() {
    // Each node meets some before it and the hub: long rows that move, interleaved, and compact.
    let edges: Vec<(u32, u32, f64)> = (1..3000_u32)
        .flat_map(|v| {
            [
                (v, v * 7919 % v, 0.5),
                (0, v, 1.0),
                (v, v / 2, 0.25),
                (v * 31 % 2999, v, 2.0),
            ]
        })
        .collect();
    let graph = check_growth(3000, &edges, false);
    assert!(graph.neighbors(0).len() == 3000 - usize::from(!graph.contains_edge(0, 0)));
}

#[test]
fn recording_a_known_step_grows_nothing() {
    let mut graph = TransitionGraph::new(2);
    let [a, b] = std::array::from_fn(|_| graph.add_state());
    graph.record(a, Action(0), -1.0, b, false);
    graph.record(a, Action(0), -1.0, a, false);
    let (before, capacity) = (graph.adjacency().num_edges(), graph.digraph().capacity());
    for step in 0..1000 {
        graph.record(a, Action(0), -1.0, if step % 3 == 0 { a } else { b }, false);
    }
    assert_eq!(
        (graph.num_states(), graph.adjacency().num_edges()),
        (2, before)
    );
    assert_eq!(
        (graph.digraph().capacity(), graph.num_transitions()),
        (capacity, 2)
    );
    assert_eq!(
        (
            graph.tries(a, Action(0)),
            graph.untried_actions(a),
            graph.untried_actions(b)
        ),
        (1002, 1, 2)
    );
}

#[test]
fn damaged_transitions_are_refused() {
    let load = |text: &str| {
        serde_json::from_str::<TransitionGraph>(text)
            .unwrap_err()
            .to_string()
    };
    let saved = |transitions: &str| {
        format!(r#"{{"num_actions":2,"num_states":2,"transitions":[{transitions}]}}"#)
    };
    assert!(load(&saved("[0,0,2,1,0.0,false]")).contains("node 2 does not exist"));
    assert!(load(&saved("[0,2,1,1,0.0,false]")).contains("action 2 does not exist"));
    assert!(load(&saved("[0,0,1,0,0.0,false]")).contains("0 → 1"));
    assert!(load(&saved("[0,0,1,1,0.0,false],[0,0,1,1,0.0,false]")).contains("0 → 1"));
    assert!(load(r#"{"num_actions":0,"num_states":0,"transitions":[]}"#).contains("0 actions"));
}
