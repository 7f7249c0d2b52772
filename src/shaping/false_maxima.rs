//! False maxima: states at which φ would hold up an agent that follows it.
//!
//! Counted are states that are no ends, and from which a goal can be reached over the moves seen, if one of these holds:
//!
//! - **none of the moves leads higher**: φ(s′) ≤ φ(s) for all s′ but s. A goal is as high as what it pays, since its φ is 0;
//! - **the greedy look-ahead stays**: all actions were tried, and the one with the largest r̂ + γ Σ P̂ φ(s′) has only ever stayed.

use super::absorbing_chain::AbsorbingChain;
use super::transition_matrix::TransitionMatrix;
use super::{Goal, Potential};
use crate::graph::{StateId, TransitionGraph};

/// False maxima of `potential` on the world as far as it was observed, ascending; `ends` by state (shorter if the last ones are
/// none). None without a goal. O((n + transitions) log n).
///
/// # Panics
/// If a goal is out of range.
pub fn false_maxima(
    graph: &TransitionGraph,
    goals: &[Goal],
    ends: &[bool],
    potential: &impl Potential,
    gamma: f64,
) -> Vec<StateId> {
    let goal_states: Vec<u32> = goals.iter().map(|goal| goal.state.0).collect();
    let transitions = TransitionMatrix::observed(graph, &graph.adjacency().to_csr());
    let chain = AbsorbingChain::by_hops(&transitions, &goal_states);
    let heights = |p: u32| match goals.get(p as usize) {
        Some(goal) => goal.reward.max(potential.value(goal.state)),
        None => potential.value(StateId(chain.order()[p as usize])),
    };
    let is_end = |state: StateId| ends.get(state.index()).copied().unwrap_or(false);
    let mut found: Vec<StateId> = (goals.len()..chain.len())
        .filter(|&p| {
            let (state, here) = (StateId(chain.order()[p]), heights(p as u32));
            let is_higher = |&j: &u32| match (j as usize) < goals.len() {
                true => heights(j) >= here,
                false => heights(j) > here,
            };
            let is_top = !chain.columns_of(p).iter().any(is_higher);
            !is_end(state) && (is_top || stays(graph, state, ends, potential, gamma))
        })
        .map(|p| StateId(chain.order()[p]))
        .collect();
    found.sort_unstable();
    found
}

/// Whether the look-ahead is greedy for an action that has only ever stayed; not where some action is untried. O(out-degree · log).
fn stays(
    graph: &TransitionGraph,
    state: StateId,
    ends: &[bool],
    potential: &impl Potential,
    gamma: f64,
) -> bool {
    if graph.untried_actions(state) > 0 {
        return false;
    }
    let mut seen: Vec<_> = graph.outcomes(state).collect();
    seen.sort_by_key(|outcome| outcome.action);
    let (mut staying, mut leaving) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for outcomes in seen.chunk_by(|a, b| a.action == b.action) {
        let ahead = |next: StateId| match ends.get(next.index()) {
            Some(true) => 0.0,
            _ => gamma * potential.value(next),
        };
        let (sum, tries) = outcomes.iter().fold((0.0, 0.0), |(sum, tries), o| {
            let count = f64::from(o.count);
            (sum + o.reward_sum + count * ahead(o.next), tries + count)
        });
        let best = match outcomes.iter().all(|o| o.next == state) {
            true => &mut staying,
            false => &mut leaving,
        };
        *best = best.max(sum / tries);
    }
    staying >= leaving && staying > f64::NEG_INFINITY
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;
    use crate::shaping::{PotentialFit, PotentialTable};

    fn table(values: &[f64]) -> PotentialTable {
        let mut table = PotentialTable::new();
        let fit = PotentialFit {
            values: values.to_vec(),
            ..PotentialFit::default()
        };
        table.replace(&fit).unwrap();
        table
    }

    /// 0 –bridge→ 2 (the goal), or back far down to 1 –→ 0; action 1 stays, action 2 in 0 goes to 3, a safe way to 2.
    fn bridge() -> TransitionGraph {
        let mut graph = TransitionGraph::new(3);
        (0..4).for_each(|_| {
            graph.add_state();
        });
        let mut step = |from, action, reward, to, count, end| {
            for _ in 0..count {
                graph.record(StateId(from), Action(action), reward, StateId(to), end);
            }
        };
        step(0, 0, -1.0, 2, 7, true);
        step(0, 0, -1.0, 1, 3, false);
        step(0, 1, -1.0, 0, 1, false);
        step(0, 2, -1.0, 3, 1, false);
        for action in 0..3 {
            step(1, action, -1.0, 0, 1, false);
            step(3, action, -1.0, 2, 1, true);
        }
        graph
    }

    fn found(values: &[f64], reward: f64) -> Vec<u32> {
        let goal = Goal {
            state: StateId(2),
            reward,
        };
        let ends = [false, false, true];
        let found = false_maxima(&bridge(), &[goal], &ends, &table(values), 1.0);
        found.into_iter().map(|state| state.0).collect()
    }

    #[test]
    fn a_place_where_the_look_ahead_stays_counts() {
        assert_eq!(found(&[-2.0, -3.0, 0.0, -1.0], -1.0), Vec::<u32>::new());
        // The bridge leads higher, but for the chance to fall far, and the safe way lower: it waits.
        assert_eq!(found(&[-2.0, -400.0, 0.0, -6.0], -1.0), [0]);
    }

    #[test]
    fn a_goal_is_as_high_as_what_it_pays() {
        assert_eq!(found(&[7.0, 5.0, 0.0, 9.0], 10.0), Vec::<u32>::new());
        assert_eq!(found(&[7.0, 5.0, 0.0, 11.0], 10.0), [3]);
    }
}
