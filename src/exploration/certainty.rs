//! Chance with which a step goes where it goes most often.
//!
//! ```text
//! p = median over (s, a) of max_s′ P̂(s′|s, a)
//! ```
//!
//! Where actions slip, a way of d hops takes d / p steps or so. That is how a bound on ways that nobody has walked, which is one in hops, compares with
//! what the best policy known may be expected to cost. The median, because some places may be more dangerous than others:
//! falls from a bridge do not make the way round it longer.

use crate::graph::{StateId, TransitionGraph};

/// Fewer tries tell little of an action: of two that agree, it is as likely as not that they would have agreed by chance.
const ENOUGH_TRIES: u32 = 4;

/// p, over the actions that were tried often enough and mostly lead elsewhere; 1 if there are none. O(n · actions + transitions).
pub(super) fn typical_certainty(graph: &TransitionGraph) -> f64 {
    let mut certainties = Vec::new();
    // By action: tries, the largest count of an outcome, and whether that leads elsewhere.
    let mut actions = vec![(0, 0, false); graph.num_actions()];
    for state in (0..graph.num_states() as u32).map(StateId) {
        actions.fill((0, 0, false));
        for seen in graph.outcomes(state) {
            let (tries, most, leaves) = &mut actions[seen.action.index()];
            *tries = u32::saturating_add(*tries, seen.count);
            if seen.count > *most {
                (*most, *leaves) = (seen.count, seen.next != state);
            }
        }
        let telling = actions
            .iter()
            .filter(|(tries, _, leaves)| *leaves && *tries >= ENOUGH_TRIES);
        certainties.extend(telling.map(|(tries, most, _)| f64::from(*most) / f64::from(*tries)));
    }
    if certainties.is_empty() {
        return 1.0;
    }
    let middle = certainties.len() / 2;
    *certainties.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;

    /// A world of `states`, in which `steps` (from, action, to, times) were taken.
    fn seen(states: u32, steps: &[(u32, u16, u32, u32)]) -> TransitionGraph {
        let mut graph = TransitionGraph::new(2);
        (0..states).for_each(|_| {
            graph.add_state();
        });
        for &(from, action, to, times) in steps {
            (0..times).for_each(|_| {
                graph.record(StateId(from), Action(action), -1.0, StateId(to), false);
            });
        }
        graph
    }

    #[test]
    fn the_median_of_what_was_tried_often_and_leads_elsewhere() {
        let slips = [(0, 0, 1, 6), (0, 0, 2, 2), (1, 0, 2, 9), (1, 0, 1, 1)];
        // A wall, and a pair tried too seldom.
        let silent = [(2, 0, 2, 9), (2, 0, 1, 1), (2, 1, 0, 1), (2, 1, 1, 2)];
        let graph = seen(3, &[&slips[..], &silent[..]].concat());
        assert_eq!(typical_certainty(&graph), 0.9);
        // One dangerous place among many.
        let bridge = [(0, 0, 1, 4), (0, 0, 3, 6), (0, 1, 1, 5), (1, 0, 2, 4)];
        assert_eq!(typical_certainty(&seen(4, &bridge)), 1.0);
    }

    #[test]
    fn without_evidence_everything_is_certain() {
        assert_eq!(typical_certainty(&seen(0, &[])), 1.0);
        assert_eq!(
            typical_certainty(&seen(2, &[(0, 0, 1, 1), (0, 0, 0, 2)])),
            1.0
        );
    }
}
