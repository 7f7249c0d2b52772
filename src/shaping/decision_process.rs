//! A Markov decision process, laid out in memory in the order in which returns flow away from the ends of episodes.
//!
//! ```text
//! Q(i, c) = r_c + Σ_j P_cj V_j                     c: a choice of state i, a priori as likely as w_c; Σ_c w_c = 1
//!
//! position:   0 1 …                      m−1
//!             nearest to an end … farthest        states in which episodes end: left out, their V is 0
//! row i:      [ near: columns < i | far: columns > i ]
//! ```
//!
//! What P lacks to 1 is the chance that the episode ends. A sweep over the rows is one pass through contiguous memory, and carries
//! news from the ends as far as nearer states lead.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// The choices of every state, by state number, while they are written down.
#[derive(Clone, Debug, Default)]
pub(super) struct Choices {
    /// For each state the end of its choices.
    ends_of_states: Vec<usize>,
    choices: Vec<Choice>,
    outcomes: Vec<(u32, f64)>,
}

/// A choice of some state.
#[derive(Clone, Copy, Debug)]
struct Choice {
    reward: f64,
    prior: f64,
    /// Whether the episode may end.
    may_end: bool,
    /// End of its outcomes.
    end: usize,
}

impl Choices {
    /// Adds a choice to the state under way: its mean reward, its weight beside the state's others, whether it may end the episode, and the
    /// states that it may lead to, others than itself, with their chances.
    pub fn push(
        &mut self,
        reward: f64,
        weight: f64,
        may_end: bool,
        outcomes: impl IntoIterator<Item = (u32, f64)>,
    ) {
        self.outcomes.extend(outcomes);
        self.choices.push(Choice {
            reward,
            prior: weight,
            may_end,
            end: self.outcomes.len(),
        });
    }

    /// Number of choices of the state under way.
    pub fn pending(&self) -> usize {
        self.choices.len() - self.ends_of_states.last().copied().unwrap_or(0)
    }

    /// Ends the choices of a state, and makes their weights add up to 1. A state without choices is one in which episodes end.
    pub fn end_state(&mut self) {
        let begin = self.ends_of_states.last().copied().unwrap_or(0);
        let choices = &mut self.choices[begin..];
        let total: f64 = choices.iter().map(|choice| choice.prior).sum();
        choices.iter_mut().for_each(|choice| choice.prior /= total);
        self.ends_of_states.push(self.choices.len());
    }

    fn num_states(&self) -> usize {
        self.ends_of_states.len()
    }

    fn of(&self, state: usize) -> Range<usize> {
        let begin = state.checked_sub(1).map_or(0, |s| self.ends_of_states[s]);
        begin..self.ends_of_states[state]
    }

    fn outcomes(&self, choice: usize) -> &[(u32, f64)] {
        let begin = choice.checked_sub(1).map_or(0, |c| self.choices[c].end);
        &self.outcomes[begin..self.choices[choice].end]
    }

    /// States and choices that may lead to each state: offsets, and entries.
    fn predecessors(&self) -> (Vec<usize>, Vec<(u32, u32)>) {
        let mut offsets = vec![0; self.num_states() + 1];
        for &(target, _) in &self.outcomes {
            offsets[target as usize + 1] += 1;
        }
        (0..self.num_states()).for_each(|s| offsets[s + 1] += offsets[s]);
        let mut next = offsets.clone();
        let mut sources = vec![(0, 0); self.outcomes.len()];
        for state in 0..self.num_states() {
            for choice in self.of(state) {
                for &(target, _) in self.outcomes(choice) {
                    let place = &mut next[target as usize];
                    sources[*place] = (state as u32, choice as u32);
                    *place += 1;
                }
            }
        }
        (offsets, sources)
    }

    /// Reward of the best choice after which nothing may follow; 0 if there is none.
    fn best_end(&self) -> f64 {
        let ends = self.choices.iter().filter(|choice| choice.may_end);
        let best = ends.map(|choice| choice.reward).reduce(f64::max);
        best.unwrap_or(0.0)
    }
}

/// Costs of steps that count in the order, in typical steps. The floor keeps them positive.
const COST_RANGE: (f64, f64) = (0.05, 20.0);

/// A process with its layout; vectors that go with it are by position.
#[derive(Clone, Debug)]
pub struct DecisionProcess {
    num_states: usize,
    /// State at each position.
    order: Vec<u32>,
    /// Positions from here on lead to no end.
    num_reached: usize,
    /// Typical steps to the end that each position up to there is nearest to.
    distances: Vec<f64>,
    /// `len + 1` offsets of choices.
    choices: Vec<usize>,
    rewards: Vec<f64>,
    priors: Vec<f64>,
    /// `len + 1` offsets of entries.
    offsets: Vec<usize>,
    first_far: Vec<usize>,
    columns: Vec<u32>,
    probabilities: Vec<f64>,
    /// By entry: the choice that it belongs to.
    owners: Vec<u32>,
}

impl DecisionProcess {
    /// Lays out `choices`. Near is what is few typical steps of cost `step_reward` > 0 away from the best end; a worse end is as much farther
    /// as it pays less. Where `step_reward` is ∞ all steps cost the same. O((n + outcomes) log n).
    pub(super) fn new(choices: &Choices, step_reward: f64) -> Self {
        let (distance, order) = nearest_first(choices, step_reward);
        let num_reached = order.len();
        let distances = order.iter().map(|&s| distance[s as usize]).collect();
        let mut position = vec![u32::MAX; choices.num_states()];
        for (p, &state) in order.iter().enumerate() {
            position[state as usize] = p as u32;
        }
        let mut order = order;
        for (state, position) in position.iter_mut().enumerate() {
            if *position == u32::MAX && !choices.of(state).is_empty() {
                *position = order.len() as u32;
                order.push(state as u32);
            }
        }
        let (states, outcomes) = (choices.num_states(), choices.outcomes.len());
        let mut process = Self {
            order,
            distances,
            ..Self::empty(states, num_reached, choices.choices.len(), outcomes)
        };
        let mut entries = Vec::new();
        for p in 0..process.order.len() {
            for choice in choices.of(process.order[p] as usize) {
                let owner = process.rewards.len() as u32;
                process.rewards.push(choices.choices[choice].reward);
                process.priors.push(choices.choices[choice].prior);
                let outcomes = choices.outcomes(choice).iter();
                let placed = outcomes.map(|&(target, chance)| (position[target as usize], chance));
                let inside = placed.filter(|&(column, _)| column != u32::MAX);
                entries.extend(inside.map(|(column, chance)| (column, chance, owner)));
            }
            process.choices.push(process.rewards.len());
            process.push_entries(p as u32, &mut entries);
        }
        process
    }

    /// The same process with its rows in the order of these positions, a permutation of all of which the first
    /// [`num_reached`](Self::num_reached) lead to an end. O(outcomes).
    pub(super) fn rearranged(&self, order: &[u32]) -> Self {
        let mut position = vec![0; self.len()];
        for (p, &old) in order.iter().enumerate() {
            position[old as usize] = p as u32;
        }
        let olds = || order.iter().map(|&old| old as usize);
        let mut process = Self {
            order: olds().map(|old| self.order[old]).collect(),
            distances: olds()
                .take(self.num_reached)
                .map(|old| self.distances[old])
                .collect(),
            ..Self::empty(
                self.num_states,
                self.num_reached,
                self.rewards.len(),
                self.columns.len(),
            )
        };
        let mut entries = Vec::new();
        for (p, old) in olds().enumerate() {
            let choices = self.choices_of(old);
            let moved = process.rewards.len() as u32;
            process.rewards.extend(&self.rewards[choices.clone()]);
            process.priors.extend(&self.priors[choices.clone()]);
            entries.extend(self.range(old).map(|e| {
                let owner = self.owners[e] - choices.start as u32 + moved;
                (
                    position[self.columns[e] as usize],
                    self.probabilities[e],
                    owner,
                )
            }));
            process.choices.push(process.rewards.len());
            process.push_entries(p as u32, &mut entries);
        }
        process
    }

    /// No rows yet, room for so many choices and entries.
    fn empty(num_states: usize, num_reached: usize, choices: usize, entries: usize) -> Self {
        Self {
            num_states,
            order: Vec::new(),
            num_reached,
            distances: Vec::new(),
            choices: vec![0],
            rewards: Vec::with_capacity(choices),
            priors: Vec::with_capacity(choices),
            offsets: vec![0],
            first_far: Vec::new(),
            columns: Vec::with_capacity(entries),
            probabilities: Vec::with_capacity(entries),
            owners: Vec::with_capacity(entries),
        }
    }

    /// By column: offsets, and the (row, entry) of each outcome that leads there. O(outcomes).
    pub(super) fn predecessors(&self) -> (Vec<usize>, Vec<(u32, u32)>) {
        let mut offsets = vec![0; self.len() + 1];
        for &column in &self.columns {
            offsets[column as usize + 1] += 1;
        }
        (0..self.len()).for_each(|p| offsets[p + 1] += offsets[p]);
        let mut next = offsets.clone();
        let mut sources = vec![(0, 0); self.columns.len()];
        for row in 0..self.len() {
            for entry in self.range(row) {
                let place = &mut next[self.columns[entry] as usize];
                sources[*place] = (row as u32, entry as u32);
                *place += 1;
            }
        }
        (offsets, sources)
    }

    fn push_entries(&mut self, p: u32, entries: &mut Vec<(u32, f64, u32)>) {
        entries.sort_by_key(|&(column, _, owner)| (column, owner));
        let near = entries.partition_point(|&(column, ..)| column < p);
        self.first_far.push(self.columns.len() + near);
        for (column, chance, owner) in entries.drain(..) {
            self.columns.push(column);
            self.probabilities.push(chance);
            self.owners.push(owner);
        }
        self.offsets.push(self.columns.len());
    }

    /// Number of positions.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Whether there is no state but such where episodes end.
    pub fn is_empty(&self) -> bool {
        self.order.is_empty()
    }

    /// Number of states, those in which episodes end included.
    pub fn num_states(&self) -> usize {
        self.num_states
    }

    /// The state at each position.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Number of positions, the first ones, from which an end can be reached.
    pub fn num_reached(&self) -> usize {
        self.num_reached
    }

    /// Typical steps to the nearest end of each of those, ascending unless the process was rearranged.
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// `by_position` by state number, 0 where episodes end.
    pub fn scatter(&self, by_position: &[f64]) -> Vec<f64> {
        let mut by_state = vec![0.0; self.num_states];
        for (&state, &value) in self.order.iter().zip(by_position) {
            by_state[state as usize] = value;
        }
        by_state
    }

    /// Numbers of the choices of `p`.
    pub(super) fn choices_of(&self, p: usize) -> Range<usize> {
        self.choices[p]..self.choices[p + 1]
    }

    pub(super) fn num_choices(&self) -> usize {
        self.rewards.len()
    }

    pub(super) fn reward(&self, choice: usize) -> f64 {
        self.rewards[choice]
    }

    /// w of the choices of `p`.
    pub(super) fn priors_of(&self, p: usize) -> &[f64] {
        &self.priors[self.choices_of(p)]
    }

    pub(super) fn prior(&self, choice: usize) -> f64 {
        self.priors[choice]
    }

    /// What the mean choice of `p` pays if every outcome is as good as `p`.
    pub(super) fn worth_for_ever(&self, p: usize) -> f64 {
        let ends = |choice: usize| {
            let own = self.range(p).filter(|&e| self.owners[e] as usize == choice);
            own.fold(1.0, |end, e| end - self.probabilities[e])
        };
        self.choices_of(p)
            .map(|c| self.prior(c) * self.reward(c) / ends(c).max(1e-9))
            .sum()
    }

    pub(super) fn nnz(&self) -> usize {
        self.columns.len()
    }

    pub(super) fn range(&self, p: usize) -> Range<usize> {
        self.offsets[p]..self.offsets[p + 1]
    }

    pub(super) fn near_range(&self, p: usize) -> Range<usize> {
        self.offsets[p]..self.first_far[p]
    }

    pub(super) fn far_range(&self, p: usize) -> Range<usize> {
        self.first_far[p]..self.offsets[p + 1]
    }

    pub(super) fn columns(&self) -> &[u32] {
        &self.columns
    }

    pub(super) fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    pub(super) fn owners(&self) -> &[u32] {
        &self.owners
    }
}

/// A heap entry: non-negative floats order as their bits do, and the state number settles ties.
type Entry = Reverse<(u64, u32)>;

/// Distance of each state from its nearest end, in typical steps, ∞ if it leads to none; and the states that lead to one, nearest first.
/// A choice leads to wherever it may lead: Dijkstra backwards.
fn nearest_first(choices: &Choices, step_reward: f64) -> (Vec<f64>, Vec<u32>) {
    let n = choices.num_states();
    let (offsets, sources) = choices.predecessors();
    let best = choices.best_end();
    let mut distance = vec![f64::INFINITY; n];
    let mut heap = BinaryHeap::new();
    for (state, distance) in distance.iter_mut().enumerate() {
        let ends = choices.of(state).map(|c| choices.choices[c]);
        let short = ends
            .filter(|choice| choice.may_end)
            .map(|choice| (best - choice.reward) / step_reward);
        if let Some(short) = short.reduce(f64::min) {
            *distance = short + 1.0;
            heap.push(Reverse((distance.to_bits(), state as u32)));
        }
    }
    let cost = |choice: u32| match step_reward.is_finite() {
        true => (-choices.choices[choice as usize].reward / step_reward)
            .clamp(COST_RANGE.0, COST_RANGE.1),
        false => 1.0,
    };
    let (mut order, mut settled) = (Vec::with_capacity(n), vec![false; n]);
    while let Some(Reverse((_, j))) = heap.pop() {
        let j = j as usize;
        if std::mem::replace(&mut settled[j], true) {
            continue;
        }
        order.push(j as u32);
        for &(i, choice) in &sources[offsets[j]..offsets[j + 1]] {
            let through = cost(choice) + distance[j];
            if !settled[i as usize] && through < distance[i as usize] {
                distance[i as usize] = through;
                let entry: Entry = Reverse((through.to_bits(), i));
                heap.push(entry);
            }
        }
    }
    (distance, order)
}

#[cfg(test)]
mod tests;
