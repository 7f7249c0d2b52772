//! d_i = c_i + min_{j ∈ succ(i)} d_j, and d = D_g on goals: Dijkstra backwards from the goals.
//!
//! The same pass yields the order in which states are settled. A state is settled after its best successor, so
//! walking the order forwards carries values away from the goals, and backwards carries gradients towards them.

use super::transition_matrix::TransitionMatrix;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cheapest known way from every state to a goal.
#[derive(Clone, Debug, PartialEq)]
pub struct CostToGo {
    /// By state; ∞ where no goal can be reached.
    pub distance: Vec<f64>,
    /// Goals as given, then the other states from which a goal can be reached, nearest first.
    pub order: Vec<u32>,
}

/// A heap entry: non-negative floats order as their bits do, and the state number settles ties.
type Entry = Reverse<(u64, u32)>;

fn entry(distance: f64, state: u32) -> Entry {
    Reverse((distance.to_bits(), state))
}

/// Cost-to-go with step cost `costs[i]` for leaving i and `terminal[g]` for ending at the g-th of `goals`.
/// Goals absorb: no way leads through one. O((n + nnz) log n).
///
/// # Panics
/// If lengths differ, a goal is out of range, or a cost is negative or NaN.
pub fn cost_to_go(
    transitions: &TransitionMatrix,
    costs: &[f64],
    goals: &[u32],
    terminal: &[f64],
) -> CostToGo {
    let n = transitions.num_states();
    assert_eq!(costs.len(), n, "one cost per state");
    assert_eq!(goals.len(), terminal.len(), "one terminal cost per goal");
    assert!(
        costs.iter().chain(terminal).all(|&c| c >= 0.0),
        "costs must not be negative"
    );
    let (offsets, sources) = transitions.predecessors();
    let mut distance = vec![f64::INFINITY; n];
    let mut heap = BinaryHeap::new();
    for (&goal, &cost) in goals.iter().zip(terminal) {
        // `+ 0.0` turns −0.0, whose bits would sort last, into 0.0.
        distance[goal as usize] = cost + 0.0;
        heap.push(entry(cost + 0.0, goal));
    }
    let mut settled = vec![false; n];
    goals.iter().for_each(|&g| settled[g as usize] = true);
    let is_goal = settled.clone();
    let mut order = goals.to_vec();
    while let Some(Reverse((_, j))) = heap.pop() {
        let j = j as usize;
        if !is_goal[j] {
            if std::mem::replace(&mut settled[j], true) {
                continue;
            }
            order.push(j as u32);
        }
        for &i in &sources[offsets[j]..offsets[j + 1]] {
            let through = costs[i as usize] + distance[j];
            if !settled[i as usize] && through < distance[i as usize] {
                distance[i as usize] = through;
                heap.push(entry(through, i));
            }
        }
    }
    CostToGo { distance, order }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{any_graph, grid};
    use proptest::prelude::*;

    #[test]
    fn a_wall_is_walked_around_and_what_it_encloses_is_out_of_reach() {
        // 0 1 2 3
        // 4 # # 7        cell 5 and 6 are walls
        // 8 9 …
        let transitions = TransitionMatrix::undirected(&grid(3, 4, &[5, 6]));
        let reach = cost_to_go(&transitions, &[1.0; 12], &[0], &[0.0]);
        assert_eq!(reach.distance[..5], [0.0, 1.0, 2.0, 3.0, 1.0]);
        assert_eq!(reach.distance[7], 4.0);
        assert!(reach.distance[5].is_infinite() && reach.distance[6].is_infinite());
        assert_eq!(reach.order.len(), 10);
    }

    /// A goal absorbs: the way to the good goal does not lead through the poor one.
    #[test]
    fn no_way_leads_through_a_goal() {
        let transitions = TransitionMatrix::undirected(&grid(1, 5, &[]));
        let reach = cost_to_go(&transitions, &[1.0; 5], &[0, 2], &[0.0, 7.0]);
        assert_eq!(reach.distance, [0.0, 1.0, 7.0, 8.0, 9.0]);
    }

    #[test]
    fn a_goal_that_forgoes_minus_nothing_is_as_near_as_any() {
        let transitions = TransitionMatrix::undirected(&grid(1, 5, &[]));
        let reach = cost_to_go(&transitions, &[1.0; 5], &[0, 4], &[-0.0, 0.0]);
        assert_eq!(reach.distance, [0.0, 1.0, 2.0, 1.0, 0.0]);
    }

    proptest! {
        /// Bellman's equation, and the order that the chain relies on.
        #[test]
        fn distances_satisfy_bellman(
            adjacency in any_graph(),
            costs in prop::collection::vec(0.05_f64..9.0, 24),
        ) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let n = adjacency.num_nodes();
            let CostToGo { distance, order } = cost_to_go(&transitions, &costs[..n], &[1], &[0.5]);
            prop_assert_eq!(distance[1], 0.5);
            for i in (0..n).filter(|&i| i != 1) {
                let next = transitions.row(i).0.iter().map(|&j| distance[j as usize]);
                let best = next.fold(f64::INFINITY, f64::min);
                prop_assert_eq!(distance[i], costs[i] + best);
            }
            prop_assert_eq!(order.len(), distance.iter().filter(|d| d.is_finite()).count());
            prop_assert!(order[1..].is_sorted_by_key(|&s| distance[s as usize]));
        }
    }
}
