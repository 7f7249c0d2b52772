//! How hard a world is to learn, by the two measures that bounds on regret are written in.
//!
//! ```text
//! D       = max_{s ≠ s′} min_π E[steps from s to s′]                            (Jaksch, Ortner & Auer 2010)
//! Σ 1/Δ   = Σ_{(s, a): Δ > 0} 1 / Δ(s, a),   Δ(s, a) = V*(s) − Q*(s, a)            (Simchowitz & Jamieson 2019)
//! ```
//!
//! Both are over the states that can be reached from the starts. For the diameter an episodic world is taken in its continuous
//! form (Conserva & Rauber 2022): an end is a state like others, from which the next step leads to one of the starts; the step limit is
//! left out. V* and Q* are those of the discount γ, and with γ = 1 those of policies that surely end.
//!
//! Where moves are certain, d steps lead from s to s′ within an episode and e to the nearest end, so that
//!
//! ```text
//! h(s) = min(d(s), e(s) + 1 + x),     x = mean of h over the starts,
//! ```
//!
//! by breadth-first search from each s′. Elsewhere h is a stochastic shortest path, by value iteration from below: when a
//! sweep changes nothing by more than ε, h is the least number of steps but for a share of ε / (1 − ε).

use super::reachability::Predecessors;
use super::{NoGain, Outcome, TabularMdp};
use crate::env::Action;

/// Outcomes looked at for a measure, before it is left out.
const MAX_WORK: usize = 300_000_000;
/// Share by which a number of steps may be too small.
const SHARE: f64 = 1e-6;
/// How far values may be off, relative to the largest reward.
const TOLERANCE: f64 = 1e-12;
/// A gap below this, relative to the largest value, is rounding.
const NO_GAP: f64 = 1e-9;

/// Why a measure has no number. States are numbers of the MDP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unmeasured {
    /// No way leads from one state to another, nor by the end of an episode: the diameter is infinite.
    NoWay {
        /// The one.
        from: usize,
        /// The other.
        to: usize,
    },
    /// With γ = 1 a loop pays for ever, and V* has no bound.
    PaysForEver,
    /// With γ = 1 no policy surely ends, and there is no V*.
    NeverEnds,
    /// It would take too long.
    TooMuchWork,
}

impl Unmeasured {
    /// The message; `name` says how a state is called.
    pub fn message(&self, name: impl Fn(usize) -> String) -> String {
        match *self {
            Unmeasured::NoWay { from, to } => {
                format!("infinite: no way leads from {} to {}", name(from), name(to))
            }
            Unmeasured::PaysForEver => {
                "none: with agent.gamma = 1 a loop pays for ever, and no value has a bound".to_owned()
            }
            Unmeasured::NeverEnds => {
                "none: with agent.gamma = 1 only policies that surely end have a value, and there is none".to_owned()
            }
            Unmeasured::TooMuchWork => format!(
                "left out: it would take more than {} million looks at outcomes",
                MAX_WORK / 1_000_000
            ),
        }
    }
}

impl TabularMdp {
    /// D, in steps; 0 if there is but one state. Exact where moves are certain, elsewhere short by a millionth at most.
    /// O(states × outcomes) where moves are certain, O(states × outcomes) a sweep elsewhere, and never more than some
    /// 10⁸ outcomes.
    ///
    /// # Errors
    /// [`Unmeasured::NoWay`], [`Unmeasured::TooMuchWork`].
    ///
    /// # Panics
    /// If there is no start, or one is no state.
    pub fn diameter(&self, starts: &[usize]) -> Result<f64, Unmeasured> {
        let closed = self.closed(starts);
        let states = closed
            .communicating(starts)
            .map_err(|no_gain| match no_gain {
                NoGain::NoWay(from, to) => Unmeasured::NoWay { from, to },
                NoGain::End(_) | NoGain::Unsettled(..) => {
                    unreachable!("a closed world has no ends")
                }
            })?;
        let is_certain = |&state: &usize| {
            let mut outcomes = self.outcomes_of_state(state).iter();
            outcomes.all(|outcome| outcome.probability == 1.0)
        };
        match states.iter().all(is_certain) {
            true => self.diameter_of_certain_moves(&states, starts),
            false => closed.diameter_by_sweeps(&states),
        }
    }

    /// The continuous form: from an end each action leads to the starts.
    fn closed(&self, starts: &[usize]) -> TabularMdp {
        let share = 1.0 / starts.len() as f64;
        let begin = |&start: &usize| Outcome {
            next: start as u32,
            probability: share,
            reward: 0.0,
        };
        let mut closed = TabularMdp {
            num_actions: self.num_actions,
            terminal: vec![false; self.num_states()],
            offsets: vec![0],
            outcomes: Vec::with_capacity(self.outcomes.len()),
        };
        for state in 0..self.num_states() {
            for action in self.actions() {
                match self.terminal[state] {
                    true => closed.outcomes.extend(starts.iter().map(begin)),
                    false => closed.outcomes.extend(self.outcomes(state, action)),
                }
                closed.offsets.push(closed.outcomes.len());
            }
        }
        closed
    }

    fn diameter_of_certain_moves(
        &self,
        states: &[usize],
        starts: &[usize],
    ) -> Result<f64, Unmeasured> {
        let work = states
            .len()
            .saturating_mul(self.outcomes.len() + starts.len());
        if work > MAX_WORK {
            return Err(Unmeasured::TooMuchWork);
        }
        let steps = |distance: &Option<u32>| distance.map_or(f64::INFINITY, f64::from);
        // With the step that begins anew.
        let ends = self.distances_to_terminal();
        let anew: Vec<f64> = ends.iter().map(|distance| steps(distance) + 1.0).collect();
        let predecessors = Predecessors::of(self);
        let mut diameter = 0.0_f64;
        for &target in states {
            let direct = predecessors.search(self.num_actions, [target], |_| true);
            let direct: Vec<f64> = direct.iter().map(steps).collect();
            let from_starts = mean_from_starts(starts, &direct, &anew);
            let least = |&state: &usize| direct[state].min(anew[state] + from_starts);
            diameter = states.iter().map(least).fold(diameter, f64::max);
        }
        Ok(diameter)
    }

    /// The same for a world without ends whose states communicate, whatever its moves.
    fn diameter_by_sweeps(&self, states: &[usize]) -> Result<f64, Unmeasured> {
        let predecessors = Predecessors::of(self);
        let mut work = states.len().saturating_mul(self.outcomes.len());
        let mut diameter = 0.0_f64;
        for &target in states {
            let hops = predecessors.search(self.num_actions, [target], |_| true);
            let mut order: Vec<usize> = states.to_vec();
            order.retain(|&state| state != target);
            order.sort_by_key(|&state| hops[state]);
            let mut steps: Vec<f64> = hops.iter().map(|h| f64::from(h.unwrap_or(0))).collect();
            let mut change = f64::INFINITY;
            while change > SHARE {
                work = work.saturating_add(self.outcomes.len());
                if work > MAX_WORK {
                    return Err(Unmeasured::TooMuchWork);
                }
                change = 0.0;
                for &state in &order {
                    let values = self.actions().map(|a| self.steps_by(&steps, state, a));
                    let least = values.fold(f64::INFINITY, f64::min);
                    change = change.max(least - steps[state]);
                    steps[state] = least;
                }
            }
            diameter = order
                .iter()
                .map(|&state| steps[state])
                .fold(diameter, f64::max);
        }
        Ok(diameter)
    }

    /// Steps from `state` by taking `action` until it leads elsewhere: (1 + Σ_{s′ ≠ s} P h(s′)) / (1 − P(s | s, a)).
    fn steps_by(&self, steps: &[f64], state: usize, action: Action) -> f64 {
        let (mut leaves, mut rest) = (0.0, 0.0);
        for outcome in self.outcomes(state, action) {
            if outcome.next as usize != state {
                leaves += outcome.probability;
                rest += outcome.probability * steps[outcome.next as usize];
            }
        }
        match leaves {
            0.0 => f64::INFINITY,
            leaves => (1.0 + rest) / leaves,
        }
    }

    /// Σ 1/Δ over the states where V* is a number. Gaps below a billionth of the largest value are none. Costs a
    /// value iteration.
    ///
    /// # Errors
    /// [`Unmeasured::PaysForEver`], [`Unmeasured::NeverEnds`], [`Unmeasured::TooMuchWork`].
    ///
    /// # Panics
    /// If there is no start, one is no state, or `gamma` is outside [0, 1].
    pub fn sum_of_inverse_gaps(&self, starts: &[usize], gamma: f64) -> Result<f64, Unmeasured> {
        if gamma == 1.0 && self.best_gain(starts).is_some() {
            return Err(Unmeasured::PaysForEver);
        }
        let (low, high) = self.reward_range();
        let largest_reward = low.abs().max(high.abs());
        if largest_reward == 0.0 {
            return Ok(0.0);
        }
        let sweeps = (MAX_WORK / self.outcomes.len()).max(1);
        let solved = self.value_iteration_within(gamma, TOLERANCE * largest_reward, sweeps);
        if !solved.converged {
            return Err(Unmeasured::TooMuchWork);
        }
        let values = solved.values;
        let reached = self.reachable_from(starts);
        let counts = |&s: &usize| reached[s] && !self.terminal[s] && values[s].is_finite();
        let states: Vec<usize> = (0..self.num_states()).filter(counts).collect();
        if states.is_empty() {
            return Err(Unmeasured::NeverEnds);
        }
        let sizes = states.iter().map(|&state| values[state].abs());
        let no_gap = NO_GAP * sizes.fold(largest_reward, f64::max);
        let mut sum = 0.0;
        for &state in &states {
            let value = |action| self.action_value(&values, gamma, state, action);
            let best = self.actions().map(value).fold(f64::NEG_INFINITY, f64::max);
            let gaps = self.actions().map(|action| best - value(action));
            sum += gaps
                .filter(|&gap| gap > no_gap)
                .map(f64::recip)
                .sum::<f64>();
        }
        Ok(sum)
    }
}

/// x = mean over the starts of min(d, e + 1 + x), by policy iteration: who begins anew is decided by the x of those who did so
/// before. Infinite if none of the starts leads to the target.
fn mean_from_starts(starts: &[usize], direct: &[f64], anew: &[f64]) -> f64 {
    let mut mean = f64::INFINITY;
    loop {
        let goes_directly =
            |start: usize| direct[start].is_finite() && direct[start] <= anew[start] + mean;
        let (mut steps, mut arrive) = (0.0, 0.0);
        for &start in starts {
            if goes_directly(start) {
                arrive += 1.0;
                steps += direct[start];
            } else {
                steps += anew[start];
            }
        }
        if arrive == 0.0 {
            return f64::INFINITY;
        }
        // x = (steps + (starts − arrive) x) / starts
        let next = steps / arrive;
        if next >= mean {
            return mean;
        }
        mean = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::boards;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    fn sure(next: u32, reward: f64) -> Vec<Outcome> {
        vec![Outcome {
            next,
            probability: 1.0,
            reward,
        }]
    }

    fn world(actions: &[Vec<Vec<Outcome>>]) -> TabularMdp {
        let terminal = actions.iter().map(Vec::is_empty).collect();
        TabularMdp::new(actions, terminal).unwrap()
    }

    /// `length` steps to an end; the other action stays.
    fn corridor(length: u32) -> TabularMdp {
        let mut states: Vec<_> = (0..length)
            .map(|s| vec![sure(s + 1, -1.0), sure(s, -1.0)])
            .collect();
        states.push(vec![]);
        world(&states)
    }

    /// The least expected steps from each state to each other one over all deterministic policies of a world without ends, by a linear
    /// system for each; infinite where none leads there.
    fn by_all_policies(mdp: &TabularMdp, states: &[usize]) -> f64 {
        let (n, choices) = (mdp.num_states(), mdp.num_actions());
        let mut least = DMatrix::from_element(n, n, f64::INFINITY);
        for code in 0..choices.pow(n as u32) {
            let mut p = DMatrix::<f64>::zeros(n, n);
            for state in 0..n {
                let action = Action((code / choices.pow(state as u32) % choices) as u16);
                for o in mdp.outcomes(state, action) {
                    p[(state, o.next as usize)] += o.probability;
                }
            }
            for target in 0..n {
                let mut on = p.clone();
                on.row_mut(target).fill(0.0);
                // A policy that need not arrive has a singular matrix, or nearly: of such only those states count that do.
                let mut survive = on.clone();
                for _ in 0..30 {
                    survive = &survive * &survive;
                }
                let stays: Vec<bool> = survive.row_iter().map(|row| row.sum() > 1e-6).collect();
                for (row, _) in stays.iter().enumerate().filter(|(_, stays)| **stays) {
                    on.row_mut(row).fill(0.0);
                }
                let cost = DVector::from_fn(n, |row, _| f64::from(u8::from(row != target)));
                let steps = (DMatrix::identity(n, n) - on).lu().solve(&cost).unwrap();
                for state in (0..n).filter(|&state| !stays[state]) {
                    least[(state, target)] = least[(state, target)].min(steps[state]);
                }
            }
        }
        let pairs = states
            .iter()
            .flat_map(|&s| states.iter().map(move |&t| (s, t)));
        pairs
            .filter(|(s, t)| s != t)
            .map(|pair| least[pair])
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_way_without_a_way_back_is_as_long_as_its_detour() {
        // From n − 1 to n − 2 … by the end and the start: n steps from anywhere to the state before.
        for length in [1, 2, 7] {
            assert_eq!(corridor(length).diameter(&[0]), Ok(f64::from(length)));
        }
        let ring: Vec<_> = (0..9).map(|s| vec![sure((s + 1) % 9, 0.0)]).collect();
        assert_eq!(world(&ring).diameter(&[4]), Ok(8.0));
        let chain = |s: u32| vec![sure(s.saturating_sub(1), 0.0), sure((s + 1).min(8), 0.0)];
        let chain: Vec<_> = (0..9).map(chain).collect();
        assert_eq!(world(&chain).diameter(&[4]), Ok(8.0));
        assert_eq!(world(&[vec![sure(0, 1.0)]]).diameter(&[0]), Ok(0.0));
    }

    /// Two starts, and a target that only one of them leads to: a coin for each try.
    #[test]
    fn who_begins_in_the_wrong_place_begins_again() {
        // 0 → 2 → end 3; 1 → end 3.
        let mdp = world(&[
            vec![sure(2, 0.0)],
            vec![sure(3, 0.0)],
            vec![sure(3, 0.0)],
            vec![],
        ]);
        // To 2: from 0 1 step; from 1 2 + x; x = (1 + 2 + x) / 2 = 3, from the end 4, from 1 5.
        // To 0: x = (0 + 2 + x) / 2 = 2; from 2 2 + x = 4. To 1: x = (0 + 3 + x) / 2 = 3; from 0 3 + x = 6.
        assert_eq!(mdp.diameter(&[0, 1]), Ok(6.0));
    }

    #[test]
    fn a_trap_makes_it_infinite() {
        let mdp = world(&[
            vec![sure(1, 0.0), sure(2, 0.0)],
            vec![sure(1, 0.0); 2],
            vec![],
        ]);
        let error = mdp.diameter(&[0]).unwrap_err();
        assert_eq!(error, Unmeasured::NoWay { from: 1, to: 0 });
        assert_eq!(
            error.message(|s| format!("s{s}")),
            "infinite: no way leads from s1 to s0"
        );
    }

    /// Up the river, E[i → i + 1] = (1 + down E[i − 1 → i]) / up; and by all 64 policies.
    #[test]
    fn the_diameter_of_a_river_is_the_way_against_the_current() {
        for size in [6, 20] {
            let mut on = 1.0 / 0.6;
            let mut whole = on;
            for _ in 2..size {
                on = (1.0 + 0.05 * on) / 0.35;
                whole += on;
            }
            let river = boards::river_swim(size).unwrap();
            let found = river.mdp().diameter(&[0]).unwrap();
            assert!(
                (found - whole).abs() < 2e-6 * whole,
                "{size}: {found}, not {whole}"
            );
        }
        let river = boards::river_swim(6).unwrap();
        let brute = by_all_policies(river.mdp(), &[0, 1, 2, 3, 4, 5]);
        assert!((river.mdp().diameter(&[0]).unwrap() - brute).abs() < 2e-6 * brute);
    }

    /// Staying costs a step: 1 where γ = 1, γ^d with d steps to go else.
    #[test]
    fn gaps_of_a_corridor_are_powers_of_gamma() {
        for gamma in [1.0, 0.9, 0.5] {
            let expected: f64 = (1..=7).map(|d| 1.0 / f64::powi(gamma, d)).sum();
            let found = corridor(7).sum_of_inverse_gaps(&[0], gamma).unwrap();
            assert!(
                (found - expected).abs() < 1e-9 * expected,
                "{found}, not {expected}"
            );
            // From the middle on only what is reached counts.
            let rest: f64 = (1..=3).map(|d| 1.0 / f64::powi(gamma, d)).sum();
            let found = corridor(7).sum_of_inverse_gaps(&[4], gamma).unwrap();
            assert!((found - rest).abs() < 1e-9 * rest, "{found}, not {rest}");
        }
        // A bandit: what counts is what each arm pays less than the best.
        let arms = [3.0, 3.0, 1.0, -1.0].map(|pays| sure(1, pays));
        let bandit = world(&[arms.to_vec(), vec![]]);
        let found = bandit.sum_of_inverse_gaps(&[0], 1.0).unwrap();
        assert!((found - 0.75).abs() < 1e-12);
    }

    #[test]
    fn without_values_there_are_no_gaps() {
        let pays = world(&[vec![sure(0, 1.0), sure(1, 0.0)], vec![]]);
        assert_eq!(
            pays.sum_of_inverse_gaps(&[0], 1.0),
            Err(Unmeasured::PaysForEver)
        );
        assert!(pays.sum_of_inverse_gaps(&[0], 0.5).is_ok());
        let endless = world(&[vec![sure(0, -1.0), sure(0, -2.0)]]);
        assert_eq!(
            endless.sum_of_inverse_gaps(&[0], 1.0),
            Err(Unmeasured::NeverEnds)
        );
        let found = endless.sum_of_inverse_gaps(&[0], 0.5).unwrap();
        assert!((found - 1.0).abs() < 1e-9);
        assert_eq!(
            world(&[vec![sure(0, 0.0)]]).sum_of_inverse_gaps(&[0], 1.0),
            Ok(0.0)
        );
    }

    #[test]
    fn what_is_too_large_is_left_out() {
        let state = |s: u32| vec![sure((s + 1) % 20_000, -1.0), sure(s, -1.0)];
        let ring = world(&(0..20_000).map(state).collect::<Vec<_>>());
        assert_eq!(ring.diameter(&[0]), Err(Unmeasured::TooMuchWork));
        let river = boards::river_swim(20_000).unwrap();
        assert_eq!(river.mdp().diameter(&[0]), Err(Unmeasured::TooMuchWork));
        let slow = river.mdp().sum_of_inverse_gaps(&[0], 0.999_999);
        assert_eq!(slow, Err(Unmeasured::TooMuchWork));
    }

    /// Four states and an end, two actions that lead anywhere, for certain or by the throw of a coin.
    fn small_world(certain: bool) -> impl Strategy<Value = TabularMdp> {
        let actions = prop::collection::vec((0..5_u32, 0..5_u32), 2);
        prop::collection::vec(actions, 4).prop_map(move |states| {
            let half = |next| Outcome {
                next,
                probability: 0.5,
                reward: 0.0,
            };
            let row = |&(a, b): &(u32, u32)| match certain {
                true => sure(a, 0.0),
                false => vec![half(a), half(b)],
            };
            let mut states: Vec<_> = states
                .iter()
                .map(|actions| actions.iter().map(row).collect())
                .collect();
            states.push(vec![]);
            world(&states)
        })
    }

    proptest! {
        #[test]
        fn as_trying_all_policies(
            mdp in prop_oneof![small_world(true), small_world(false)],
            starts in prop::sample::subsequence(vec![0, 1, 2, 3], 1..=4),
        ) {
            let reached = mdp.reachable_from(&starts);
            let states: Vec<_> = (0..5).filter(|&s| reached[s]).collect();
            // An end that leads to the starts, written here.
            let share = 1.0 / starts.len() as f64;
            let begin = starts.iter().map(|&start| Outcome { next: start as u32, probability: share, reward: 0.0 });
            let begin: Vec<_> = begin.collect();
            let closed = TabularMdp::from_fn(2, vec![false; 5], |state, action, outcomes| match state {
                4 => outcomes.extend(&begin),
                _ => outcomes.extend(mdp.outcomes(state, action)),
            });
            let brute = by_all_policies(&closed.unwrap(), &states);
            match mdp.diameter(&starts) {
                Ok(found) => prop_assert!((found - brute).abs() < 2e-6 * brute.max(1.0), "{} {}", found, brute),
                Err(Unmeasured::NoWay { .. }) => prop_assert_eq!(brute, f64::INFINITY),
                Err(other) => prop_assert!(false, "{:?}", other),
            }
        }

        /// Values by backward induction over many steps, written here.
        #[test]
        fn gaps_are_those_of_values(
            rewards in prop::collection::vec(-3..4_i32, 8),
            mdp in small_world(false),
            gamma in prop::sample::select(vec![0.3, 0.8]),
        ) {
            let mut paid = mdp.clone();
            for state in 0..4 {
                for action in 0..2 {
                    let pair = state * 2 + action;
                    let range = paid.offsets[pair]..paid.offsets[pair + 1];
                    paid.outcomes[range].iter_mut().for_each(|o| o.reward = f64::from(rewards[pair]));
                }
            }
            let q = |values: &[f64], state: usize, action: usize| -> f64 {
                let ahead = paid.outcomes(state, Action(action as u16)).iter();
                ahead.map(|o| o.probability * (o.reward + gamma * values[o.next as usize])).sum()
            };
            let mut values = vec![0.0; 5];
            for _ in 0..300 {
                values = (0..5).map(|s| if s == 4 { 0.0 } else { q(&values, s, 0).max(q(&values, s, 1)) }).collect();
            }
            let reached = paid.reachable_from(&[0]);
            let gaps = (0..4).filter(|&s| reached[s]).map(|s| (q(&values, s, 0) - q(&values, s, 1)).abs());
            let expected: f64 = gaps.filter(|&gap| gap > 1e-8).map(f64::recip).sum();
            let found = paid.sum_of_inverse_gaps(&[0], gamma).unwrap();
            prop_assert!((found - expected).abs() < 1e-6 * expected.max(1.0), "{} {}", found, expected);
        }
    }
}
