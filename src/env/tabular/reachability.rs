//! Reachability between states: breadth-first search along transitions of positive probability.

use super::TabularMdp;

/// The transitions backwards: for each state, the (state, action) pairs that may lead to it.
pub(super) struct Predecessors {
    /// State s owns `pairs[offsets[s]..offsets[s + 1]]`.
    offsets: Vec<usize>,
    /// s · |A| + a; a pair is listed once per outcome.
    pairs: Vec<u32>,
}

impl Predecessors {
    /// Counting sort of the outcomes by where they lead; O(states + outcomes).
    pub(super) fn of(mdp: &TabularMdp) -> Self {
        let mut offsets = vec![0_usize; mdp.num_states() + 1];
        for outcome in &mdp.outcomes {
            offsets[outcome.next as usize + 1] += 1;
        }
        for state in 0..mdp.num_states() {
            offsets[state + 1] += offsets[state];
        }
        let mut free = offsets.clone();
        let mut pairs = vec![0; mdp.outcomes.len()];
        for pair in 0..mdp.offsets.len() - 1 {
            for outcome in &mdp.outcomes[mdp.offsets[pair]..mdp.offsets[pair + 1]] {
                let slot = &mut free[outcome.next as usize];
                pairs[*slot] = pair as u32;
                *slot += 1;
            }
        }
        Predecessors { offsets, pairs }
    }

    /// Transitions to the nearest of `targets`, through pairs that `allowed` lets pass.
    pub(super) fn search(
        &self,
        num_actions: usize,
        targets: impl IntoIterator<Item = usize>,
        allowed: impl Fn(usize) -> bool,
    ) -> Vec<Option<u32>> {
        let mut distance = vec![None; self.offsets.len() - 1];
        let mut queue: Vec<u32> = Vec::new();
        for target in targets {
            if distance[target].replace(0).is_none() {
                queue.push(target as u32);
            }
        }
        let mut visited = 0;
        while let Some(&state) = queue.get(visited) {
            visited += 1;
            let next = distance[state as usize].map(|transitions| transitions + 1);
            for &pair in &self.pairs[self.offsets[state as usize]..self.offsets[state as usize + 1]]
            {
                let before = pair as usize / num_actions;
                if distance[before].is_none() && allowed(pair as usize) {
                    distance[before] = next;
                    queue.push(before as u32);
                }
            }
        }
        distance
    }
}

impl TabularMdp {
    /// The fewest transitions from each state to a terminal one; `None` where there is no way. O(outcomes).
    pub fn distances_to_terminal(&self) -> Vec<Option<u32>> {
        let terminals = (0..self.num_states()).filter(|&state| self.terminal[state]);
        Predecessors::of(self).search(self.num_actions, terminals, |_| true)
    }

    /// The fewest transitions from each state to one of `targets`; `None` where there is no way. O(outcomes).
    ///
    /// # Panics
    /// If a target is no state.
    pub fn distances_to(&self, targets: &[usize]) -> Vec<Option<u32>> {
        Predecessors::of(self).search(self.num_actions, targets.iter().copied(), |_| true)
    }

    /// Which states can be reached from `starts`, themselves included. O(outcomes).
    ///
    /// # Panics
    /// If a start is no state.
    pub fn reachable_from(&self, starts: &[usize]) -> Vec<bool> {
        let distances = self.distances_from(starts);
        distances.iter().map(Option::is_some).collect()
    }

    /// The fewest transitions to each state from one of `starts`; `None` where there is no way. O(outcomes).
    ///
    /// # Panics
    /// If a start is no state.
    pub fn distances_from(&self, starts: &[usize]) -> Vec<Option<u32>> {
        let mut distance = vec![None; self.num_states()];
        let mut queue = Vec::new();
        for &start in starts {
            if distance[start].replace(0).is_none() {
                queue.push(start);
            }
        }
        let mut visited = 0;
        while let Some(&state) = queue.get(visited) {
            visited += 1;
            let next = distance[state].map(|transitions: u32| transitions + 1);
            for outcome in self.outcomes_of_state(state) {
                let after = outcome.next as usize;
                if distance[after].is_none() {
                    distance[after] = next;
                    queue.push(after);
                }
            }
        }
        distance
    }

    /// From which states some policy ends the episode with probability 1.
    ///
    /// The largest set from which a terminal state can be reached by actions that cannot leave the set: found by removing
    /// what cannot, until nothing changes. O(outcomes) a round; one or two rounds unless traps lie behind traps.
    pub fn can_surely_end(&self) -> Vec<bool> {
        let predecessors = Predecessors::of(self);
        let mut inside = vec![true; self.num_states()];
        loop {
            let stays = |pair: usize| {
                let outcomes = &self.outcomes[self.offsets[pair]..self.offsets[pair + 1]];
                outcomes.iter().all(|outcome| inside[outcome.next as usize])
            };
            let terminals = (0..self.num_states()).filter(|&state| self.terminal[state]);
            let distance = predecessors.search(self.num_actions, terminals, stays);
            let next: Vec<_> = distance.iter().map(Option::is_some).collect();
            if next == inside {
                return inside;
            }
            inside = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Outcome;

    fn half(next: u32) -> Outcome {
        Outcome {
            next,
            probability: 0.5,
            reward: -1.0,
        }
    }

    fn sure(next: u32) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward: -1.0,
        }]
    }

    /// 0 → 1 → 2 (end), and a trap 3 that 1 may fall into.
    fn with_trap() -> TabularMdp {
        let actions = [
            vec![sure(1), sure(0)],
            vec![vec![half(2), half(3)], sure(1)],
            vec![],
            vec![sure(3), sure(3)],
        ];
        TabularMdp::new(&actions, vec![false, false, true, false]).unwrap()
    }

    #[test]
    fn distance_counts_possible_transitions() {
        assert_eq!(
            with_trap().distances_to_terminal(),
            [Some(2), Some(1), Some(0), None]
        );
        assert_eq!(
            with_trap().distances_to(&[3, 3]),
            [Some(2), Some(1), None, Some(0)]
        );
        assert_eq!(
            with_trap().distances_from(&[1, 1]),
            [None, Some(0), Some(1), Some(1)]
        );
        assert_eq!(
            with_trap().reachable_from(&[1, 1]),
            [false, true, true, true]
        );
    }

    #[test]
    fn a_way_that_may_end_in_a_trap_is_not_sure() {
        assert_eq!(with_trap().can_surely_end(), [false, false, true, false]);
        let retry = [vec![vec![half(0), half(1)]], vec![]];
        let mdp = TabularMdp::new(&retry, vec![false, true]).unwrap();
        assert_eq!(mdp.can_surely_end(), [true, true]);
    }
}
