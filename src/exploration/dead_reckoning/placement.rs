//! Places of states when actions slip: the most likely positions, given how often each action led where.
//!
//! ```text
//! ℓ(s→s′, d) = Σ_a  k ln p(d|a) + (n − k) ln(1 − p(d|a)),     n = N(s, a),  k = N(s, a, s′)
//! ```
//!
//! is the log-likelihood that the way from s to s′ is the displacement d, where p(d|a) is the chance of action a to move
//! by d, the same in every state. How often an action led *elsewhere* counts as much as how often it led there: along a
//! path that is walked often even the slips to one side are many. The same sum for the way back, with −d, is added.
//!
//! States are placed one after the other, the most certain one first, each where its placed neighbours together say, and
//! where no other state is.

use super::action_noise::ActionNoise;
use super::chart::Occupied;
use super::moves::Moves;
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// ℓ of a way that is none of the displacements; relative to the best, as all ℓ are.
const IMPOSSIBLE: f64 = -30.0;
/// Nothing that is possible is less likely: the model may be wrong.
const UNLIKELY: f64 = -20.0;

/// A state next to placed ones: by how much its best place is more likely than the second best.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Waiting {
    margin: f64,
    state: u32,
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_margin = self.margin.total_cmp(&other.margin);
        by_margin.then(other.state.cmp(&self.state))
    }
}

/// Positions of the states that are connected with state 0.
#[derive(Debug)]
pub(super) struct Placement<'a> {
    graph: &'a TransitionGraph,
    moves: &'a Moves,
    /// Where the edges of each state begin.
    offsets: Vec<usize>,
    /// ℓ by directed edge and displacement, row-major; at most 0.
    likelihoods: Vec<f64>,
    /// By state.
    pub positions: Vec<Option<Vec<i32>>>,
    pub occupied: Occupied,
}

impl<'a> Placement<'a> {
    /// Places every state in reach of state 0. O(m (A² + log m)) for m edges, if no state has more than A neighbours.
    pub fn new(graph: &'a TransitionGraph, moves: &'a Moves, noise: &ActionNoise) -> Self {
        let n = graph.num_states();
        let mut offsets = vec![0; n + 1];
        for s in 0..n {
            offsets[s + 1] = offsets[s] + graph.adjacency().neighbors(s as u32).len();
        }
        let mut placement = Self {
            graph,
            moves,
            likelihoods: vec![0.0; offsets[n] * moves.num_actions()],
            offsets,
            positions: vec![None; n],
            occupied: Occupied::default(),
        };
        placement.weigh_edges(noise);
        placement.place_all();
        placement
    }

    /// The noise that these positions speak of, counted on top of the prior. Also how many different transitions are
    /// displacements, and how many are none. O(transitions · actions).
    pub fn count_noise(&self) -> (ActionNoise, u64, u64) {
        let num_actions = self.moves.num_actions();
        let mut counts = ActionNoise::pseudo_counts(self.moves);
        let (mut agree, mut disagree) = (0, 0);
        for (s, position) in self.positions.iter().enumerate() {
            let from = StateId(s as u32);
            let outcomes = self.graph.outcomes(from);
            for outcome in outcomes.filter(|outcome| outcome.next != from) {
                let next = &self.positions[outcome.next.index()];
                let ends = position.as_ref().zip(next.as_ref());
                match ends.and_then(|(from, to)| self.moves.between(from, to)) {
                    Some(d) => {
                        agree += 1;
                        let place = outcome.action.index() * num_actions + d;
                        counts[place] += f64::from(outcome.count);
                    }
                    None => disagree += 1,
                }
            }
        }
        let noise = ActionNoise::normalised(num_actions, counts);
        (noise, agree, disagree)
    }

    /// Where ℓ of the edge from `from` to its neighbour `to` begins.
    fn row(&self, from: u32, to: u32) -> usize {
        let neighbors = self.graph.adjacency().neighbors(from);
        let place = neighbors.iter().position(|&next| next == to);
        let place = place.expect("edges go both ways");
        (self.offsets[from as usize] + place) * self.moves.num_actions()
    }

    fn weigh_edges(&mut self, noise: &ActionNoise) {
        let graph = self.graph;
        let mut gains = vec![0.0; self.moves.num_actions()];
        for s in 0..graph.num_states() as u32 {
            for &next in graph.adjacency().neighbors(s) {
                self.weigh_edge(s, next, noise, &mut gains);
                let (there, back) = (self.row(s, next), self.row(next, s));
                for (d, gain) in gains.iter().enumerate() {
                    self.likelihoods[there + d] += gain;
                    self.likelihoods[back + self.moves.inverse[d]] += gain;
                }
            }
        }
        for edge in self.likelihoods.chunks_mut(self.moves.num_actions()) {
            let best = edge.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            edge.iter_mut().for_each(|l| *l = (*l - best).max(UNLIKELY));
        }
    }

    /// Writes into `gains` what the tries in `from` say about the way to `to`, by displacement.
    fn weigh_edge(&self, from: u32, to: u32, noise: &ActionNoise, gains: &mut [f64]) {
        gains.fill(0.0);
        for action in (0..self.moves.num_actions() as u16).map(Action) {
            let tries = f64::from(self.graph.tries(StateId(from), action));
            if tries == 0.0 {
                continue;
            }
            let arrivals = self.graph.outcomes(StateId(from));
            let hits: f64 = arrivals
                .filter(|outcome| outcome.action == action && outcome.next.0 == to)
                .map(|outcome| f64::from(outcome.count))
                .sum();
            for (d, gain) in gains.iter_mut().enumerate() {
                let (hit, miss) = noise.logs(action, d);
                *gain += hits * hit + (tries - hits) * miss;
            }
        }
    }

    fn place_all(&mut self) {
        if self.positions.is_empty() {
            return;
        }
        let origin = vec![0; self.moves.shifts[0].len()];
        let mut waiting = BinaryHeap::new();
        self.put(0, origin, &mut waiting);
        while let Some(Waiting { state, .. }) = waiting.pop() {
            if self.positions[state as usize].is_none()
                && let Some((position, _)) = self.best_place(state)
            {
                self.put(state, position, &mut waiting);
            }
        }
    }

    fn put(&mut self, state: u32, position: Vec<i32>, waiting: &mut BinaryHeap<Waiting>) {
        self.occupied.insert(position.clone(), StateId(state));
        self.positions[state as usize] = Some(position);
        for &next in self.graph.adjacency().neighbors(state) {
            if self.positions[next as usize].is_none()
                && let Some((_, margin)) = self.best_place(next)
            {
                let state = next;
                waiting.push(Waiting { margin, state });
            }
        }
    }

    /// The free place that the placed neighbours of `state` together find most likely, and by how much.
    fn best_place(&self, state: u32) -> Option<(Vec<i32>, f64)> {
        let neighbors = self.graph.adjacency().neighbors(state).iter();
        let placed: Vec<(usize, &[i32])> = neighbors
            .filter_map(|&next| {
                let position = self.positions[next as usize].as_deref()?;
                Some((self.row(next, state), position))
            })
            .collect();
        let mut best: Option<(Vec<i32>, f64)> = None;
        let mut second = IMPOSSIBLE * placed.len() as f64;
        for (anchor, shift) in placed
            .iter()
            .flat_map(|(_, anchor)| self.moves.shifts.iter().map(move |shift| (anchor, shift)))
        {
            let place: Vec<i32> = anchor.iter().zip(shift).map(|(a, b)| a + b).collect();
            let is_best = best.as_ref().is_some_and(|(known, _)| *known == place);
            if is_best || self.occupied.contains_key(&place) {
                continue;
            }
            let ways = placed
                .iter()
                .map(|&(row, from)| self.likelihood(row, from, &place));
            let likelihood: f64 = ways.sum();
            match &best {
                Some((_, known)) if *known >= likelihood => second = second.max(likelihood),
                _ => {
                    second = best.map_or(second, |(_, known)| known.max(second));
                    best = Some((place, likelihood));
                }
            }
        }
        best.map(|(place, likelihood)| (place, likelihood - second))
    }

    /// ℓ of the edge whose row begins at `row` and whose ends lie at these positions.
    fn likelihood(&self, row: usize, from: &[i32], to: &[i32]) -> f64 {
        let displacement = self.moves.between(from, to);
        displacement.map_or(IMPOSSIBLE, |d| self.likelihoods[row + d])
    }
}
