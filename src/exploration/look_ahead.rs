//! Look-ahead advice: r̂ + c + Σ_s′ P̂(s′|s, a) φ(s′) − φ(s), the rise of the potential that action a may be expected to bring, with what
//! it pays beyond the mean cost −c of a step, times K / (K + n(s)).
//!
//! Rewards count because φ is 0 after an end, whatever that pays: φ falls where a bonus is taken and rises where lava is entered. Where each step costs c the
//! sum is the rise of φ alone.
//!
//! n(s) are the tries in s: advice is for what was not learnt yet, and yields to what was. And φ says nothing for standing still: where
//! every way on leads down, an action that was only seen to go nowhere is advised no more than the best of them.

use super::model::ExplorationModel;
use crate::env::Action;
use crate::exploration::dead_reckoning::Prediction;
use crate::graph::{ObservedOutcome, StateId, TransitionGraph};
use crate::shaping::Potential;

/// κ: what was seen anywhere weighs as much as so many tries here.
const POOLED_TRIES: f64 = 32.0;
/// K: tries in a state after which half of the advice there is left; some hundreds of episodes pass through a state by then.
const TRIES_TO_HALF: f64 = 1000.0;

impl ExplorationModel {
    /// Writes the part of the advice for `state` that lasts, one logit per action: `potential_advice` times the expected
    /// rise of `potential` along each action, rewards included, in units of `unit` > 0, the rise that one step towards the goal is worth
    /// on average. All 0 before the first goal, and where `potential_advice` is 0. O(out-degree · actions).
    ///
    /// # Panics
    /// If `state` is not in `graph`, or `advice` is shorter than the actions are many.
    pub fn look_ahead(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        advice.fill(0.0);
        if !self.destinations.is_empty() && self.params.potential_advice > 0.0 {
            self.advise_climb(graph, state, potential, unit, advice);
        }
    }

    /// Once a goal is known.
    fn advise_climb(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        let weight = self.params.potential_advice / unit;
        if self.reckoning.noise().is_some() {
            self.advise_pooled(graph, state, potential, weight, advice);
        } else {
            self.advise_potential(graph, state, potential, weight, advice);
        }
        advise_to_leave(graph, state, advice);
        self.advise_untried(graph, state, advice);
        yield_to_evidence(graph, state, advice);
    }

    /// Where actions slip alike in all states: the expected rise with P̂ between what was seen here and
    /// what was seen anywhere, P̂ = (N(s, a, s′) + κ p(s′ − s | a)) / (N(s, a) + κ).
    fn advise_pooled(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        weight: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        for towards in (0..advice.len() as u16).map(Action) {
            let next = self.reckoning.neighbor_towards(graph, state, towards);
            let Some((next, noise)) = next.zip(self.reckoning.noise()) else {
                continue;
            };
            let rise = potential.value(next) - here;
            for (a, logit) in advice.iter_mut().enumerate() {
                *logit += POOLED_TRIES * noise.share(Action(a as u16), towards) * rise;
            }
        }
        for outcome in graph.outcomes(state) {
            let rise = potential.value(outcome.next) - here + self.beyond_a_step(&outcome);
            advice[outcome.action.index()] += f64::from(outcome.count) * rise;
        }
        for (a, logit) in advice.iter_mut().enumerate() {
            let tries = f64::from(graph.tries(state, Action(a as u16)));
            *logit *= weight / (tries + POOLED_TRIES);
        }
    }

    /// The expected rise of the potential along each action whose outcome is known.
    fn advise_potential(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        weight: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        for (i, logit) in advice.iter_mut().enumerate() {
            let action = Action(i as u16);
            if graph.tries(state, action) == 0
                && let Prediction::Undo(next) = self.reckoning.predict(graph, state, action)
            {
                *logit = weight * (potential.value(next) - here);
            }
        }
        for outcome in graph.outcomes(state) {
            let tries = f64::from(graph.tries(state, outcome.action)) + self.doubt();
            let share = f64::from(outcome.count) / tries;
            let rise = potential.value(outcome.next) - here + self.beyond_a_step(&outcome);
            advice[outcome.action.index()] += weight * share * rise;
        }
        if self.stochastic {
            self.add_doubt(graph, state, potential, weight, advice);
        }
    }

    /// r̂ + c of an outcome.
    fn beyond_a_step(&self, outcome: &ObservedOutcome) -> f64 {
        outcome.reward_sum / f64::from(outcome.count) + self.step_cost
    }

    /// Where no known action leads uphill, the way up must be one that was never tried.
    fn advise_untried(&self, graph: &TransitionGraph, state: StateId, advice: &mut [f64]) {
        if advice.iter().all(|&logit| logit <= 0.0) {
            for (i, logit) in advice.iter_mut().enumerate() {
                if graph.tries(state, Action(i as u16)) == 0 {
                    *logit = self.params.frontier_advice;
                }
            }
        }
    }

    /// Outcomes not seen that count beside those seen: where actions slip, one bad try must not rule an action out.
    fn doubt(&self) -> f64 {
        if self.stochastic { 1.0 } else { 0.0 }
    }

    /// The unseen outcome of every tried action might be the best neighbour of `state`.
    fn add_doubt(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        weight: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        let neighbors = graph.adjacency().neighbors(state.0).iter();
        let best = neighbors
            .map(|&next| potential.value(StateId(next)) - here)
            .fold(0.0, f64::max);
        for (i, logit) in advice.iter_mut().enumerate() {
            let tries = graph.tries(state, Action(i as u16));
            if tries > 0 {
                *logit += weight * best * self.doubt() / (f64::from(tries) + self.doubt());
            }
        }
    }
}

/// What was only seen to go nowhere is advised no more than the best action that leaves `state`, if one is known.
fn advise_to_leave(graph: &TransitionGraph, state: StateId, advice: &mut [f64]) {
    let leaves = |action: Action| {
        let mut outcomes = graph.outcomes(state);
        outcomes.any(|outcome| outcome.action == action && outcome.next != state)
    };
    let actions = (0..advice.len() as u16).map(Action);
    let leaving = actions.filter(|&action| leaves(action));
    let best = leaving
        .map(|action| advice[action.index()])
        .reduce(f64::max);
    let Some(best) = best else {
        return;
    };
    for (a, logit) in advice.iter_mut().enumerate() {
        let action = Action(a as u16);
        if graph.tries(state, action) > 0 && !leaves(action) {
            *logit = logit.min(best);
        }
    }
}

/// The more was tried in `state`, the less is advised there.
fn yield_to_evidence(graph: &TransitionGraph, state: StateId, advice: &mut [f64]) {
    let tries = |a: usize| f64::from(graph.tries(state, Action(a as u16)));
    let in_state: f64 = (0..advice.len()).map(tries).sum();
    let left = TRIES_TO_HALF / (TRIES_TO_HALF + in_state);
    advice.iter_mut().for_each(|logit| *logit *= left);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exploration::{Destination, ExplorationParams};
    use crate::shaping::PotentialTable;

    /// From 0 two actions lead to 1 and one stays; φ is highest in 0. Advice after `rounds` of all three.
    fn advice_on_a_peak(rounds: u32) -> Vec<f64> {
        let mut graph = TransitionGraph::new(3);
        let (peak, below) = (graph.add_state(), graph.add_state());
        for _ in 0..rounds {
            for (action, next) in [(0, below), (1, peak), (2, below)] {
                graph.record(peak, Action(action), -1.0, next, false);
            }
        }
        let mut potential = PotentialTable::new();
        potential.extend(peak, 0.0);
        potential.extend(below, -1.0);
        let params = ExplorationParams {
            potential_advice: 20.0,
            ..Default::default()
        };
        let mut model = ExplorationModel::new(params, 3);
        model.set_returns(&graph, -1.0, 1.0);
        let goal = Destination {
            state: below,
            handicap: 0,
        };
        model.set_destinations(&graph, &[goal]);
        let mut advice = vec![0.0; 3];
        model.look_ahead(&graph, peak, &potential, 1.0, &mut advice);
        advice
    }

    /// φ is 0 after the end, whatever it paid: without rewards the way past it would lead higher.
    #[test]
    fn what_an_end_pays_counts() {
        let mut graph = TransitionGraph::new(2);
        let (here, past, end) = (graph.add_state(), graph.add_state(), graph.add_state());
        graph.record(here, Action(0), -1.0, past, false);
        graph.record(here, Action(1), 10.0, end, true);
        let mut potential = PotentialTable::new();
        for (state, phi) in [(here, 9.0), (past, 8.0), (end, 0.0)] {
            potential.extend(state, phi);
        }
        let params = ExplorationParams {
            potential_advice: 20.0,
            ..Default::default()
        };
        let mut model = ExplorationModel::new(params, 2);
        model.set_returns(&graph, 10.0, 1.0);
        let goal = Destination {
            state: end,
            handicap: 0,
        };
        model.set_destinations(&graph, &[goal]);
        let mut advice = vec![0.0; 2];
        model.look_ahead(&graph, here, &potential, 1.0, &mut advice);
        let left = TRIES_TO_HALF / (TRIES_TO_HALF + 2.0);
        for (advice, rise) in advice.iter().zip([-1.0, 2.0]) {
            assert!((advice - 20.0 * left * rise).abs() < 1e-9, "{advice}");
        }
    }

    #[test]
    fn nothing_is_said_for_standing_still_and_less_and_less_for_anything() {
        let few = advice_on_a_peak(1);
        assert!(few.iter().all(|&logit| logit == few[0] && logit < -19.0));
        let many = advice_on_a_peak(1_000_000);
        assert!(many.iter().all(|&logit| logit.abs() < 0.01), "{many:?}");
    }
}
