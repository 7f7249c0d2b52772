//! Worlds where actions turn: which do, by how much, and which go ahead.
//!
//! An action that brings the agent back to where it was after k times, wherever it is taken, and never bumps turns by a k-th. What else leads
//! where one of its powers does, turns as far as that. What moves and does not turn goes ahead, or to the side of that: of all sides the one is taken that
//! the loops seen confirm best. The whole is believed only if it explains the loops as well as any other chart has to.

use super::DeadReckoning;
use super::chart::{AxisDirection, Chart, Effect, MIN_AGREEMENT, is_lattice};
use crate::env::Action;
use crate::graph::{StateId, TransitionGraph};
use serde::{Deserialize, Serialize};

/// The longest cycle that may be a turn, and the room for counts of cycles by length.
const LONGEST: usize = 6;
const LENGTHS: usize = LONGEST + 1;
/// Cycles, or steps that a power of the turn takes as well, before an action is taken for a turn.
const MIN_CYCLES: u32 = 2;

/// Loops that steps ahead have closed before they are believed to go ahead.
const MIN_STEP_LOOPS: u64 = 2;

/// Cycles of one action: (a, a, …, a) from a state back to it. Memory O(actions).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Cycles {
    /// By action and length, row-major.
    counts: Vec<u32>,
    /// Transitions to be known before the next trial.
    next_trial: usize,
}

impl Cycles {
    pub fn new(num_actions: usize) -> Self {
        Self {
            counts: vec![0; num_actions * LENGTHS],
            next_trial: 0,
        }
    }

    /// Takes in a step, seen for the first time: it may have closed a cycle. O(degree).
    pub fn learn(&mut self, graph: &TransitionGraph, from: StateId, action: Action, to: StateId) {
        let mut here = to;
        for length in 1..=LONGEST {
            if here == from {
                self.counts[action.index() * LENGTHS + length] += 1;
                return;
            }
            match graph.likely_successor(here, action) {
                Some(next) if next != here => here = next,
                _ => return,
            }
        }
    }

    /// The length of all cycles of `action`, if they are many enough, alike, and those of a lattice's turn.
    fn order(&self, action: Action) -> Option<usize> {
        let counts = &self.counts[action.index() * LENGTHS..][..LENGTHS];
        let length = counts.iter().position(|&count| count >= MIN_CYCLES)?;
        let total: u32 = counts.iter().sum();
        (counts[length] == total && is_lattice(length)).then_some(length)
    }
}

impl DeadReckoning {
    /// Looks whether a chart with headings explains what was seen, if none is trusted and there are cycles that may be turns. Amortised O(1) a
    /// transition for a fixed number of actions.
    pub(super) fn try_headings(&mut self, graph: &TransitionGraph) {
        if self.trusted() || graph.num_transitions() < self.cycles.next_trial {
            return;
        }
        let Some((turn, order)) = self.widest_turn() else {
            return;
        };
        self.cycles.next_trial = 2 * graph.num_transitions();
        let turns = self.turns_like(graph, turn, order);
        match self.best_chart(graph, &turns, order) {
            Some(chart) => {
                self.chart = chart;
                self.revision += 1;
            }
            None if self.chart.has_headings() => self.rebuild_axes(),
            None => {}
        }
    }

    /// The action of the longest cycles that never bumps, and their length.
    fn widest_turn(&self) -> Option<(Action, usize)> {
        let actions = (0..self.num_actions as u16).map(Action);
        let orders = actions
            .filter(|action| self.bumps_of[action.index()] == 0)
            .filter_map(|action| Some((action, self.cycles.order(action)?)));
        orders.rev().max_by_key(|&(_, order)| order)
    }

    /// By action: by how many k-ths it turns, if it leads where so many times `turn` do.
    fn turns_like(
        &self,
        graph: &TransitionGraph,
        turn: Action,
        order: usize,
    ) -> Vec<Option<usize>> {
        // By action and power of the turn; power 0 is for what is none of them.
        let mut votes = vec![0; self.num_actions * order];
        let mut round = Vec::with_capacity(order);
        for from in (0..graph.num_states() as u32).map(StateId) {
            round.clear();
            let next = |here: &StateId| graph.likely_successor(*here, turn);
            round.extend(std::iter::successors(Some(from), next).take(order));
            if round.len() < order {
                continue;
            }
            for seen in graph.outcomes(from) {
                let power = round.iter().position(|&state| state == seen.next);
                votes[seen.action.index() * order + power.unwrap_or(0)] += 1;
            }
        }
        let power = |votes: &[u32]| {
            let total: u32 = votes.iter().sum();
            let (power, most) = votes.iter().enumerate().skip(1).max_by_key(|vote| vote.1)?;
            let agrees = f64::from(*most) >= MIN_AGREEMENT * f64::from(total);
            (*most >= MIN_CYCLES && agrees).then_some(power)
        };
        votes.chunks(order).map(power).collect()
    }

    /// The chart with these turns, where the most moving of the other actions goes ahead, and each further one to the side, or along an axis of its
    /// own, that closes most loops; `None` if nothing goes ahead, or if what was seen does not confirm the best one.
    fn best_chart(
        &self,
        graph: &TransitionGraph,
        turns: &[Option<usize>],
        order: usize,
    ) -> Option<Chart> {
        let own_axis = |action: usize| {
            Effect::Shift(AxisDirection {
                axis: action + 2,
                sign: 1,
            })
        };
        let mut effects: Vec<Effect> = (0..self.num_actions)
            .map(|action| turns[action].map_or_else(|| own_axis(action), Effect::Turn))
            .collect();
        let is_mover = |&action: &usize| turns[action].is_none() && self.moves_of[action] > 0;
        let mut movers: Vec<usize> = (0..self.num_actions).filter(is_mover).collect();
        movers.sort_by_key(|&action| std::cmp::Reverse(self.moves_of[action]));
        let (&ahead, others) = movers.split_first()?;
        effects[ahead] = Effect::Advance(0);
        for &action in others {
            let sides = (0..order).map(Effect::Advance);
            let candidates = sides.chain([own_axis(action)]).map(|effect| {
                effects[action] = effect;
                let (chart, _) = self.drawn(graph, pack_axes(&effects), order);
                (
                    chart.loops_contradicted,
                    std::cmp::Reverse(chart.loops_confirmed),
                    effect,
                )
            });
            let best = candidates.min_by_key(|&(wrong, right, _)| (wrong, right));
            effects[action] = best.map_or_else(|| own_axis(action), |(_, _, effect)| effect);
        }
        let (chart, by_steps) = self.drawn(graph, pack_axes(&effects), order);
        (chart.trusted() && by_steps >= MIN_STEP_LOOPS).then_some(chart)
    }

    /// A chart of these effects with every state known, its loops counted; how many of them hold that no turn closes.
    fn drawn(
        &self,
        graph: &TransitionGraph,
        effects: Vec<Effect>,
        headings: usize,
    ) -> (Chart, u64) {
        let mut chart = Chart::new(effects, headings);
        for (state, entry) in self.entry.iter().enumerate() {
            let place = match *entry {
                Some((from, action)) => chart.target(from, action),
                None => chart.origin(),
            };
            chart.append(StateId(state as u32), &place);
        }
        for &(from, action) in &self.bumps {
            chart.mark_wall(from, action);
        }
        let by_steps = chart.close_loops(graph, &self.entry);
        (chart, by_steps)
    }
}

/// The same effects with the axes of shifts numbered without gaps, behind those of the plane.
fn pack_axes(effects: &[Effect]) -> Vec<Effect> {
    let mut next = 2;
    let pack = |&effect: &Effect| match effect {
        Effect::Shift(AxisDirection { sign, .. }) => {
            next += 1;
            let axis = next - 1;
            Effect::Shift(AxisDirection { axis, sign })
        }
        other => other,
    };
    effects.iter().map(pack).collect()
}
