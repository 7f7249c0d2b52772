//! Actor-critic that replays what it has seen, shaped by the potential as it stands.
//!
//! ```text
//! Q(s, a) = Σ_s′ P̂(s′|s, a) (r̂ + F(s, s′) + g V(s′)) + b + b′,   F(s, s′) = m (g φ(s′) − φ(s)),   φ = V = 0 after the end
//! critic:   V(s) ← max_a Q(s, a)
//! actor:    θ(s, a) = C · max(−1, 2 (Q(s, a) − V(s)) / c),   π(a|s) ∝ exp(θ(s, a) + advice(a))
//! ```
//!
//! P̂ and r̂ are the frequencies and mean rewards of all that was seen, so that one backup of s replays every transition from s.
//! After each step the state just left is backed up, the one entered, too, while it has untried actions, then the states that are most out of date, with the
//! first `planning_steps` in all at most (Dyna, Sutton 1990; prioritised sweeping, Moore & Atkeson 1993). The actor is as sure as it can get at once: an action that is
//! worse by half of c, the least that a step can cost, is C = 12 logits less likely.
//!
//! **F is that of the present φ.** To store the F of the day is to replay a potential that is gone. Here the first fit of φ, and the
//! first one after an end of episodes was found or lost, is followed by one backup of every state from V = 0, those of the largest φ
//! first. Later fits leave V + mφ as it is. The fixed point is V* − mφ of the learnt model whatever φ is (Ng, Harada & Russell
//! 1999), and so are the differences of Q, all that the actor sees: φ decides where values begin (Wiewiora 2003), not where
//! they end.
//!
//! **Episodes end by themselves** in plans, after ten times the longest one seen: g = γ (1 − 1 / 10 L), L rounded up to a power of
//! two. Or else a loop that pays would be worth more than any number, and where steps are free all ways would be equally good.
//! c is the smallest reward, in size, of a step that ended nothing; where those are all 0, the largest reward's loss by g.
//!
//! **Untried actions** are worth V = 0 to begin with, like those of any learner that begins with 0. With [`Untried::Advised`] the
//! exploration says which to try; in plans one of them may lead back to where s was entered from, at half a step's doubt for the whole way,
//! and they are good for nothing else. Where no way to an end is known there is no doubt: what is known leads round in circles.
//!
//! **Tried actions** may have shown their worst side. Once any action was seen to have two outcomes, b = β r_max / (L √N(s, a)), the bonus
//! of MBIE-EB (Strehl & Littman 2008), with the largest reward seen spread over the longest episode; 0 before that. Where the same transition was seen to pay now more, now less,
//! b′ = 3 β σ̂ / √N, three β standard errors of r̂(s, a), with σ₀, the deviation typical of such transitions, where only one reward was seen.
//! r_max / L and σ₀ are reckoned anew when they have changed by half.
//!
//! **Every action is tried again and again**: after a life of 8192 steps a state known, an action with fewer than w √n tries is taken
//! where its state was left n times, the least tried first and whatever is advised; w rises from 0 to 1 while that life is lived once more. So N(s, a) → ∞ wherever s is visited for ever, P̂, r̂
//! and b go where they should, and the greedy policy becomes the best one, while the share of such steps, |A| / 2√n at most, goes to 0 (greedy in
//! the limit with infinite exploration, Singh et al. 2000). It is the whole life that must be long, not n: a state off the beaten
//! track, where one unlucky try rules an action out, sees few visits.

use super::checks::{check_bonus, check_count, check_gamma};
use super::choices::Untried;
use super::greedy::{action, advised, first_best};
use super::model::{EmpiricalModel, WayIn};
use super::policy::{sample, softmax};
use super::sweep::SweepQueue;
use super::table::largest;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::{Action, StepStatus};
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// C: the bound of preferences, in logits.
const CERTAINTY: f64 = 12.0;
/// Loss, in steps, at which an action is as unlikely as it gets.
const PLAIN_LOSS: f64 = 0.5;
/// What the first untried action of a way costs more than one that is known to lead back, in steps, and what each further one does: a known way is taken in
/// the place of an equal one, and not of a shorter one, however many such actions that has.
const DOUBT: f64 = 0.5;
const FURTHER_DOUBT: f64 = 1.0 / 64.0;
/// b′, in standard errors of the mean reward, is β times this.
const NOISE_DOUBT: f64 = 3.0;
/// Bonuses are reckoned anew, and with them all values, when they would change by this factor.
const STALE: f64 = 1.5;
/// Plans reckon with episodes so many times as long as the longest one seen.
const LONG_EPISODES: f64 = 10.0;
/// Changes that add up to less than this share of c are not passed on.
const NEGLIGIBLE: f64 = 1e-3;
/// Steps a known state before which nothing is tried for the sake of the limit alone.
const LONG_LIFE: u64 = 8192;

/// Parameters of [`ReplayActorCritic`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReplayActorCriticParams {
    /// Discount factor γ, 0..=1.
    pub gamma: f64,
    /// States backed up after each step, the one just left included; at least 1.
    pub planning_steps: usize,
    /// What untried actions are worth.
    pub untried: Untried,
    /// β, at least 0.
    pub bonus: f64,
}

impl Default for ReplayActorCriticParams {
    fn default() -> Self {
        Self {
            gamma: 1.0,
            planning_steps: 3,
            untried: Untried::Advised,
            bonus: 0.6,
        }
    }
}

impl ReplayActorCriticParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_gamma(self.gamma)?;
        check_count("planning_steps", self.planning_steps)?;
        check_bonus("bonus", self.bonus)
    }
}

/// What is known of where a way leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Way {
    /// To no end of episodes.
    Unknown,
    /// To an end, if untried actions lead back.
    Guessed,
    /// To an end.
    Known,
}

/// Lengths of episodes and sizes of rewards, as far as they were seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Scale {
    /// Steps of the episode so far.
    so_far: u32,
    /// L.
    longest: u32,
    largest_reward: f64,
    /// The smallest size of a reward that is not 0, of steps that ended nothing.
    cheapest_step: Option<f64>,
}

impl Scale {
    fn new() -> Self {
        Self {
            so_far: 0,
            longest: 1,
            largest_reward: 0.0,
            cheapest_step: None,
        }
    }

    /// Takes a step in; whether L has grown or c fallen: changes that were nothing may be something now.
    fn note(&mut self, reward: f64, status: StepStatus) -> bool {
        let (size, before) = (reward.abs(), (self.longest, self.step_cost()));
        self.largest_reward = self.largest_reward.max(size);
        if status != StepStatus::Terminated && size > 0.0 {
            self.cheapest_step = Some(self.cheapest_step.map_or(size, |least| least.min(size)));
        }
        self.so_far = self.so_far.saturating_add(1);
        if self.so_far > self.longest {
            self.longest = self.longest.saturating_mul(2);
        }
        if status.is_last() {
            self.so_far = 0;
        }
        self.longest != before.0 || self.step_cost() < before.1
    }

    /// Chance that an episode ends by itself after a step.
    fn end_of_time(&self) -> f64 {
        1.0 / (LONG_EPISODES * f64::from(self.longest))
    }

    /// c; above 0.
    fn step_cost(&self) -> f64 {
        let by_time = self.largest_reward * self.end_of_time();
        self.cheapest_step.unwrap_or(by_time).max(f64::MIN_POSITIVE)
    }
}

/// Tabular actor-critic with replay. Memory O(states · actions + different transitions). A step costs at most `planning_steps` + 1 backups, each
/// O(outcomes of the state's actions + ways into the state); a fit of φ costs one a state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReplayActorCritic {
    params: ReplayActorCriticParams,
    /// m.
    mix: f64,
    model: EmpiricalModel,
    scale: Scale,
    /// Steps of its life so far.
    steps: u64,
    /// Whether an action was seen to have two outcomes.
    stochastic: bool,
    /// b(1) and σ₀ that values are reckoned with: those of the day would put every value out of date at every step.
    bonus_heeded: f64,
    noise_heeded: f64,
    /// φ by state, as of the last fit; of a state found since, that of the state it was entered from.
    potential: Vec<f64>,
    /// V by state.
    values: Vec<f64>,
    /// V + mφ by state, as of when it was last passed on.
    passed_on: Vec<f64>,
    /// By state: where the best action leads.
    ways: Vec<Way>,
    /// Whether values have begun at φ since the last change of where episodes end.
    begun: bool,
    /// States whose value may be out of date.
    queue: SweepQueue,
    /// Room for one number per action.
    preferences: Vec<f64>,
    probabilities: Vec<f64>,
    rng: ChaCha8Rng,
}

impl ReplayActorCritic {
    /// An agent that knows nothing, draws from the agent's stream of `seed` and learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: ReplayActorCriticParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        Self {
            params,
            mix,
            model: EmpiricalModel::new(num_actions, 0.0),
            scale: Scale::new(),
            steps: 0,
            stochastic: false,
            bonus_heeded: 0.0,
            noise_heeded: 0.0,
            potential: Vec::new(),
            values: Vec::new(),
            passed_on: Vec::new(),
            ways: Vec::new(),
            begun: false,
            queue: SweepQueue::default(),
            preferences: vec![0.0; num_actions],
            probabilities: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
        }
    }

    /// V(state) + mφ(state), in units of return: what V would be without the shaping; `None` for states it has not heard of. O(1).
    pub fn unshaped_value(&self, state: StateId) -> Option<f64> {
        let value = self.values.get(state.index())?;
        Some(value + self.shaping_of(state))
    }

    /// g.
    fn gamma(&self) -> f64 {
        self.params.gamma * (1.0 - self.scale.end_of_time())
    }

    /// mφ(state).
    fn shaping_of(&self, state: StateId) -> f64 {
        self.mix * self.potential[state.index()]
    }

    /// V(state) + mφ(state).
    fn worth(&self, state: StateId) -> f64 {
        self.values[state.index()] + self.shaping_of(state)
    }

    /// b(1), of the day.
    fn bonus_of_one(&self) -> f64 {
        match self.stochastic {
            true => self.params.bonus * self.scale.largest_reward / f64::from(self.scale.longest),
            false => 0.0,
        }
    }

    /// b + b′ of a tried action.
    fn bonus(&self, state: StateId, action: Action) -> f64 {
        let tries = f64::from(self.model.tries(state, action));
        let typical = self.noise_heeded;
        let error = self.model.standard_error_of_reward(state, action, typical);
        self.bonus_heeded / tries.sqrt() + self.params.bonus * NOISE_DOUBT * error
    }

    /// Q(state, action), `untried` for what was never tried.
    fn action_value(&self, state: StateId, action: Action, untried: Option<f64>) -> Option<f64> {
        let seen = self
            .model
            .action_value(state, action, self.gamma(), |next| self.worth(next));
        let of_tried = |value| value - self.shaping_of(state) + self.bonus(state, action);
        seen.map(of_tried).or(untried)
    }

    /// Q(state, ·) of the untried actions; none if there are none, or if nothing is to be hoped for from them.
    fn untried_value(&self, state: StateId) -> Option<f64> {
        if !self.model.has_untried(state) {
            return None;
        }
        match self.params.untried {
            Untried::Optimistic => Some(0.0),
            Untried::Advised => {
                let back = self.ways_back(state).map(|way| {
                    let doubt = match self.ways[way.state.index()] {
                        Way::Known => DOUBT,
                        Way::Guessed => FURTHER_DOUBT,
                        Way::Unknown => 0.0,
                    };
                    way.reward + self.gamma() * self.worth(way.state)
                        - doubt * self.scale.step_cost()
                });
                Some(back.reduce(f64::max)? - self.shaping_of(state))
            }
        }
    }

    /// The steps by which `state` was entered from elsewhere, but for states that end episodes now.
    fn ways_back(&self, state: StateId) -> impl Iterator<Item = WayIn> + '_ {
        let ways = self.model.ways_into(state);
        ways.filter(move |way| way.state != state && !self.model.is_terminal(way.state))
    }

    /// Q(state, ·) where it is known.
    fn action_values(&self, state: StateId) -> impl Iterator<Item = Option<f64>> + '_ {
        let untried = self.untried_value(state);
        (0..self.model.num_actions()).map(move |a| self.action_value(state, action(a), untried))
    }

    /// Computes V(state) anew and passes a change on; returns it.
    fn back_up(&mut self, state: StateId) -> f64 {
        let (value, way) = self.best_action_value(state);
        let change = value - std::mem::replace(&mut self.values[state.index()], value);
        let flipped = std::mem::replace(&mut self.ways[state.index()], way) != way;
        let worth = self.worth(state);
        let news = (worth - self.passed_on[state.index()]).abs();
        let matters = news > NEGLIGIBLE * self.scale.step_cost() || flipped;
        if matters && !self.model.is_terminal(state) {
            self.passed_on[state.index()] = worth;
            self.pass_on(state, news.max(f64::MIN_POSITIVE));
        }
        change
    }

    /// max_a Q(state, a), 0 if nothing is known, and where that action leads.
    fn best_action_value(&self, state: StateId) -> (f64, Way) {
        let untried = self.untried_value(state);
        let mut best: Option<(Action, f64)> = None;
        for a in (0..self.model.num_actions()).map(action) {
            if let Some(value) = self.action_value(state, a, None)
                && best.is_none_or(|(_, most)| value > most)
            {
                best = Some((a, value));
            }
        }
        match (best, untried) {
            (Some((a, tried)), _) if untried.is_none_or(|untried| tried >= untried) => {
                (tried, self.way_of(state, a))
            }
            _ => (untried.unwrap_or(0.0), self.way_of_untried(state)),
        }
    }

    /// Where a tried action mostly leads.
    fn way_of(&self, state: StateId, action: Action) -> Way {
        let outcomes = self.model.outcomes(state, action);
        let mostly = outcomes.max_by_key(|outcome| (outcome.count, Reverse(outcome.to)));
        mostly.map_or(Way::Unknown, |outcome| match outcome.ends {
            true => Way::Known,
            false => self.ways[outcome.to.index()],
        })
    }

    /// Where the untried actions lead, if one leads back.
    fn way_of_untried(&self, state: StateId) -> Way {
        let mut back = self.ways_back(state);
        match back.any(|way| self.ways[way.state.index()] != Way::Unknown) {
            true => Way::Guessed,
            false => Way::Unknown,
        }
    }

    /// Queues every state whose value rests on that of `state`.
    fn pass_on(&mut self, state: StateId, change: f64) {
        for way in self.model.ways_into(state) {
            self.queue.push(way.state.index(), way.probability * change);
        }
        if self.params.untried == Untried::Advised {
            let actions = (0..self.model.num_actions()).map(action);
            let next = actions.flat_map(|a| self.model.ways_out(state, a));
            for (next, _) in next.filter(|&(next, _)| self.model.has_untried(next)) {
                self.queue.push(next.index(), change);
            }
        }
    }

    /// Backs up every state once from V = 0, in the order of φ.
    fn begin_at_potential(&mut self) {
        self.begun = true;
        self.values.fill(0.0);
        self.passed_on = self.potential.iter().map(|phi| self.mix * phi).collect();
        let mut order: Vec<u32> = (0..self.values.len() as u32).collect();
        let phi = |state: u32| self.potential[state as usize];
        order.sort_by(|&a, &b| phi(b).total_cmp(&phi(a)));
        for state in order {
            self.back_up(StateId(state));
        }
    }

    /// Makes room for `state`, which has `potential` if it is new.
    fn grow_to(&mut self, state: StateId, potential: f64) {
        self.model.grow_to(state);
        if state.index() >= self.values.len() {
            self.values.resize(state.index() + 1, 0.0);
            self.passed_on
                .resize(state.index() + 1, self.mix * potential);
            self.ways.resize(state.index() + 1, Way::Unknown);
            self.potential.resize(state.index() + 1, potential);
        }
    }

    /// Takes a step into the model, and queues what it puts out of date besides the state just left.
    fn record(&mut self, experience: &Experience<'_>) {
        let (state, next) = (experience.state, experience.next.state);
        self.steps += 1;
        let scale_changed = self.scale.note(experience.reward, experience.status);
        let ends_changed = self.model.record(experience);
        self.stochastic |= self
            .model
            .outcomes(state, experience.action)
            .nth(1)
            .is_some();
        if ends_changed {
            // The task ends here now, or no longer does: everything that leads here is worth something else.
            let change = self.worth(next).abs().max(self.scale.step_cost());
            self.pass_on(next, change);
            self.begun = false;
        }
        let end_is_lost = ends_changed && !self.model.is_terminal(next);
        if end_is_lost {
            self.ways.fill(Way::Unknown); // in a circle each state would go on to vouch for the next
        }
        let bonus = self.bonus_of_one();
        let bonus_is_stale = is_stale(self.bonus_heeded, bonus);
        if bonus_is_stale {
            self.bonus_heeded = bonus;
        }
        if scale_changed || end_is_lost || bonus_is_stale {
            self.queue_all(f64::MIN_POSITIVE);
        }
        let noise = self.model.reward_noise();
        if is_stale(self.noise_heeded, noise) {
            let change = (noise - self.noise_heeded).abs();
            self.noise_heeded = noise;
            self.queue_all(self.params.bonus * NOISE_DOUBT * change);
        }
    }

    fn queue_all(&mut self, priority: f64) {
        (0..self.values.len()).for_each(|state| self.queue.push(state, priority));
    }

    /// The action of `state` that was tried least, if that is too seldom. O(actions), and O(1) in a short life.
    fn neglected(&self, state: StateId) -> Option<Action> {
        let long_life = LONG_LIFE * self.values.len() as u64;
        if self.steps < long_life {
            return None;
        }
        let ripeness = (self.steps as f64 / long_life as f64 - 1.0).min(1.0);
        let (action, tries) = self.model.least_tried(state);
        let wanted = ripeness * f64::from(self.model.tries_in(state)).sqrt();
        (f64::from(tries) < wanted).then_some(action)
    }

    /// Writes θ(state, ·).
    fn write_preferences(&self, state: StateId, preferences: &mut [f64]) {
        for (preference, value) in preferences.iter_mut().zip(self.action_values(state)) {
            *preference = value.unwrap_or(f64::NEG_INFINITY);
        }
        let best = largest(preferences);
        if best == f64::NEG_INFINITY || self.scale.largest_reward == 0.0 {
            return preferences.fill(0.0); // nothing is known of any action, or nothing but that it paid nothing
        }
        let steepness = CERTAINTY / (PLAIN_LOSS * self.scale.step_cost());
        for preference in preferences.iter_mut() {
            *preference = (steepness * (*preference - best)).max(-CERTAINTY);
        }
    }
}

impl Agent for ReplayActorCritic {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.grow_to(situation.state, 0.0);
        if let Some(action) = self.neglected(situation.state) {
            return action;
        }
        let mut preferences = std::mem::take(&mut self.preferences);
        self.write_preferences(situation.state, &mut preferences);
        let probabilities = &mut self.probabilities;
        softmax(&preferences, situation.advice, CERTAINTY, probabilities);
        self.preferences = preferences;
        action(sample(&self.probabilities, &mut self.rng))
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let (state, next) = (experience.state, experience.next.state);
        self.grow_to(state, 0.0);
        self.grow_to(next, self.potential[state.index()]);
        self.record(experience);
        let td_error = self.back_up(state);
        let may_lead_back = self.params.untried == Untried::Advised && self.model.has_untried(next);
        if may_lead_back && !self.model.is_terminal(next) {
            self.back_up(next); // it may have been entered from a better place than ever before
        }
        for _ in 1..self.params.planning_steps {
            let Some(waiting) = self.queue.pop() else {
                break;
            };
            self.back_up(StateId(waiting as u32));
        }
        UpdateInfo { td_error }
    }

    fn set_potential(&mut self, potential: &[f64]) {
        let states = (0..self.values.len() as u32).map(StateId);
        let worth: Vec<f64> = states.map(|state| self.worth(state)).collect();
        for (phi, &fitted) in self.potential.iter_mut().zip(potential) {
            *phi = fitted;
        }
        if self.begun || self.mix == 0.0 {
            for (s, worth) in worth.into_iter().enumerate() {
                self.values[s] = worth - self.shaping_of(StateId(s as u32));
            }
        } else {
            self.begin_at_potential();
        }
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        if state.index() >= self.values.len() {
            return None;
        }
        let mut preferences = vec![0.0; advice.len()];
        self.write_preferences(state, &mut preferences);
        first_best(&advised(&preferences, advice))
    }
}

/// Whether `now` is too far from the number that is reckoned with.
fn is_stale(heeded: f64, now: f64) -> bool {
    now > STALE * heeded || heeded > STALE * now
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    const NO_ADVICE: [f64; 2] = [0.0; 2];

    /// A step: from, action, reward, to, whether the episode ends there.
    type Seen = (u32, u16, f64, u32, StepStatus);

    fn agent(params: ReplayActorCriticParams, mix: f64) -> ReplayActorCritic {
        ReplayActorCritic::new(params, 2, mix, 0)
    }

    /// An agent that replays until nothing waits, and adds no bonus.
    fn thorough() -> ReplayActorCriticParams {
        ReplayActorCriticParams {
            gamma: 0.9,
            planning_steps: 1_000_000,
            bonus: 0.0,
            ..Default::default()
        }
    }

    fn live(agent: &mut ReplayActorCritic, steps: &[Seen]) {
        for &(state, action, reward, next, status) in steps {
            agent.update(&Experience {
                state: StateId(state),
                action: Action(action),
                reward,
                shaping: 0.0,
                next: Situation {
                    state: StateId(next),
                    advice: &NO_ADVICE,
                },
                status,
            });
        }
    }

    fn on(from: u32, action: u16, reward: f64, to: u32) -> Seen {
        (from, action, reward, to, StepStatus::Running)
    }

    /// V* of what was seen, by plain value iteration over counts of its own. State 4 ends episodes.
    fn optimal_values(steps: &[Seen], gamma: f64) -> [f64; 5] {
        let mut seen: BTreeMap<(u32, u16), Vec<(f64, u32)>> = BTreeMap::new();
        for &(from, action, reward, to, _) in steps {
            seen.entry((from, action)).or_default().push((reward, to));
        }
        let mut values = [0.0; 5];
        for _ in 0..2000 {
            let mut next = [f64::NEG_INFINITY; 5];
            next[4] = 0.0;
            for (&(from, _), outcomes) in &seen {
                let sum: f64 = outcomes
                    .iter()
                    .map(|&(reward, to)| reward + gamma * values[to as usize])
                    .sum();
                let best = &mut next[from as usize];
                *best = best.max(sum / outcomes.len() as f64);
            }
            values = next;
        }
        values
    }

    /// Every action of the states 0 to 3 once, then anything.
    fn experience() -> impl Strategy<Value = Vec<Seen>> {
        let outcome = (-3.0..3.0_f64, 0..5_u32);
        let firsts = prop::collection::vec(outcome.clone(), 8);
        let more = prop::collection::vec((0..8_usize, outcome), 0..60);
        (firsts, more).prop_map(|(firsts, more)| {
            let firsts = firsts.into_iter().enumerate();
            firsts
                .chain(more)
                .map(|(pair, (reward, to))| {
                    let status = match to {
                        4 => StepStatus::Terminated,
                        _ => StepStatus::Running,
                    };
                    (pair as u32 / 2, pair as u16 % 2, reward, to, status)
                })
                .collect()
        })
    }

    proptest! {
        /// The potential that comes in the middle of it, or at the end, does not show: V + mφ is V* of what was seen, and the greedy
        /// actions are those of V*, as far as they differ.
        #[test]
        fn replay_ends_at_the_optimum_of_what_was_seen_whatever_the_potential(
            steps in experience(),
            potential in prop::collection::vec(-50.0..50.0_f64, 5),
            last in prop::collection::vec(-50.0..50.0_f64, 5),
            middle in 0..60_usize,
        ) {
            let middle = middle.min(steps.len());
            let mut agent = agent(thorough(), 0.7);
            live(&mut agent, &steps[..middle]);
            agent.set_potential(&potential);
            live(&mut agent, &steps[middle..]);
            agent.set_potential(&last);
            // One step more, which changes nothing but lets the agent replay.
            let again = steps[steps.len() - 1];
            live(&mut agent, &[again]);
            let mut all = steps.clone();
            all.push(again);

            let gamma = agent.gamma();
            let expected = optimal_values(&all, gamma);
            let tolerance = 20.0 * NEGLIGIBLE * agent.scale.step_cost().max(1e-3);
            for state in 0..4 {
                let found = agent.unshaped_value(StateId(state)).unwrap();
                prop_assert!((found - expected[state as usize]).abs() < tolerance, "{} {} {:?}", state, found, expected);
                let worth = |action| agent.model.action_value(StateId(state), Action(action), gamma, |s| expected[s.index()]).unwrap();
                let (first, second) = (worth(0), worth(1));
                if (first - second).abs() > 2.0 * tolerance {
                    let best = Action(u16::from(second > first));
                    prop_assert_eq!(agent.greedy_action(StateId(state), &NO_ADVICE), Some(best));
                }
            }
        }
    }

    proptest! {
        /// The defining equation, bonus included, whatever has changed the scale on the way.
        #[test]
        fn when_nothing_waits_every_value_is_that_of_its_best_action(
            steps in experience(),
            potential in prop::collection::vec(-50.0..50.0_f64, 5),
            windfall in 1.0..200.0_f64,
        ) {
            let params = ReplayActorCriticParams { bonus: 0.6, ..thorough() };
            let mut agent = agent(params, 0.7);
            live(&mut agent, &steps);
            agent.set_potential(&potential);
            live(&mut agent, &[on(6, 0, windfall, 6), on(6, 1, -1.0, 6)]);
            for state in 0..4 {
                let (best, _) = agent.best_action_value(StateId(state));
                let residual = (agent.values[state as usize] - best).abs();
                let tolerance = 20.0 * NEGLIGIBLE * agent.scale.step_cost().max(1e-3);
                prop_assert!(residual < tolerance, "{}: {}", state, residual);
            }
        }
    }

    #[test]
    fn once_the_end_is_lost_no_circle_vouches_for_a_way_to_it() {
        let mut agent = agent(thorough(), 1.0);
        let round = [on(0, 0, -1.0, 1), on(1, 0, -1.0, 0)];
        live(&mut agent, &round);
        live(&mut agent, &[(1, 1, -1.0, 2, StepStatus::Terminated)]);
        live(&mut agent, &round);
        assert_eq!(agent.ways[..2], [Way::Known; 2]);
        live(
            &mut agent,
            &[on(1, 1, -1.0, 2), on(2, 0, -1.0, 0), on(2, 1, -1.0, 1)],
        );
        live(&mut agent, &[on(0, 1, -1.0, 0)]);
        live(&mut agent, &round);
        assert_eq!(agent.ways[..3], [Way::Unknown; 3]);
    }

    /// A corridor of 20 in which action 0 stays, walked once, two tries a place.
    fn corridor() -> Vec<Seen> {
        let places = (0..20).flat_map(|s| [on(s, 0, -1.0, s), on(s, 1, -1.0, s + 1)]);
        let mut steps: Vec<_> = places.collect();
        steps[39].4 = StepStatus::Terminated;
        steps
    }

    #[test]
    fn with_the_right_potential_one_backup_a_state_is_enough() {
        let frugal = ReplayActorCriticParams {
            planning_steps: 1,
            ..Default::default()
        };
        let goes_on = |agent: &ReplayActorCritic| {
            let greedy = |s| agent.greedy_action(StateId(s), &NO_ADVICE);
            (0..20).filter(|&s| greedy(s) == Some(Action(1))).count()
        };
        let mut agent = agent(frugal, 1.0);
        live(&mut agent, &corridor());
        assert!(goes_on(&agent) < 5, "the way back to the start is long");
        let hops: Vec<f64> = (0..=20).map(|s| f64::from(s) - 20.0).collect();
        agent.set_potential(&hops);
        assert_eq!(goes_on(&agent), 20);
        let value = agent.value_of(0);
        assert!(
            value.abs() < 0.5,
            "V is next to nothing where φ says it all: {value}"
        );
    }

    #[test]
    fn a_later_fit_changes_no_preference_unless_an_end_has_come_or_gone() {
        let frugal = ReplayActorCriticParams {
            planning_steps: 1,
            ..thorough()
        };
        let mut agent = agent(frugal, 1.0);
        live(&mut agent, &corridor());
        agent.set_potential(&[0.0; 21]);
        let preferences = |agent: &ReplayActorCritic| {
            let mut written = [[0.0; 2]; 20];
            for (state, row) in written.iter_mut().enumerate() {
                agent.write_preferences(StateId(state as u32), row);
            }
            written
        };
        let before = preferences(&agent);
        let hostile: Vec<f64> = (0..=20).map(|s| -f64::from(s)).collect();
        agent.set_potential(&hostile);
        for (before, after) in before.iter().zip(preferences(&agent)) {
            assert!((before[0] - after[0]).abs() < 1e-9 && (before[1] - after[1]).abs() < 1e-9);
        }
        // The end is none any more.
        live(&mut agent, &[on(19, 1, -1.0, 20)]);
        agent.set_potential(&hostile);
        assert_ne!(preferences(&agent), before);
    }

    #[test]
    fn without_a_mix_the_potential_is_not_heeded() {
        let mut agent = agent(thorough(), 0.0);
        live(&mut agent, &corridor());
        let before = agent.values.clone();
        agent.set_potential(&[100.0; 21]);
        assert_eq!(agent.values, before);
        assert_eq!(agent.unshaped_value(StateId(3)), Some(before[3]));
    }

    #[test]
    fn an_untried_action_is_advised_or_may_lead_back() {
        let params = ReplayActorCriticParams {
            untried: Untried::Advised,
            gamma: 1.0,
            ..thorough()
        };
        let mut agent = agent(params, 1.0);
        // 0 –0→ 1 –0→ 2, and 0 –1→ 3, an end.
        live(&mut agent, &[on(0, 0, -1.0, 1), on(1, 0, -1.0, 2)]);
        live(&mut agent, &[(0, 1, -1.0, 3, StepStatus::Terminated)]);
        let g = agent.gamma();
        // Half a step of doubt for the way, and next to nothing for each further action of it.
        let back = |value: f64, doubt: f64| -1.0 - doubt + g * value;
        let first = back(-1.0, DOUBT);
        let expected = [-1.0, first, back(first, FURTHER_DOUBT)];
        for (state, expected) in expected.into_iter().enumerate() {
            let found = agent.value_of(state);
            assert!((found - expected).abs() < 1e-9, "{state}: {found}");
        }
        assert_eq!(
            agent.greedy_action(StateId(1), &NO_ADVICE),
            Some(Action(1)),
            "back, which was not tried yet"
        );
        assert_eq!(
            agent.greedy_action(StateId(1), &[30.0, 0.0]),
            Some(Action(0)),
            "advice outvotes that"
        );
    }

    #[test]
    fn a_known_way_is_taken_before_an_equal_one_that_leads_back_and_not_before_a_shorter_one() {
        // From 4 action 0 leads to 3, from which the steps back to 0 were never tried; from 0 it is a step to the end, 9.
        // Action 1 leads from 4 over 5, 6, … to the end, in as many steps or in one more.
        for (length, best) in [(4, 1), (5, 0)] {
            let params = ReplayActorCriticParams {
                untried: Untried::Advised,
                gamma: 1.0,
                ..thorough()
            };
            let mut agent = agent(params, 1.0);
            live(&mut agent, &[(0, 1, -1.0, 9, StepStatus::Terminated)]);
            live(&mut agent, &[on(0, 0, -1.0, 2), on(2, 0, -1.0, 3)]);
            live(&mut agent, &[on(4, 0, -1.0, 3)]);
            let mut steps = vec![on(4, 1, -1.0, 20)];
            steps.extend((20..19 + length).map(|s| on(s, 0, -1.0, s + 1)));
            steps.last_mut().unwrap().3 = 9;
            steps.last_mut().unwrap().4 = StepStatus::Terminated;
            live(&mut agent, &steps);
            let greedy = agent.greedy_action(StateId(4), &NO_ADVICE);
            assert_eq!(greedy, Some(Action(best)), "{length} steps");
        }
    }

    #[test]
    fn where_no_way_to_an_end_is_known_what_is_untried_is_as_good_as_what_leads_round() {
        let params = ReplayActorCriticParams {
            untried: Untried::Advised,
            gamma: 1.0,
            ..thorough()
        };
        let mut agent = agent(params, 1.0);
        live(&mut agent, &[on(0, 0, -1.0, 1), on(0, 1, -1.0, 0)]);
        live(&mut agent, &[on(1, 0, -1.0, 0); 20]);
        let mut preferences = [0.0; 2];
        agent.write_preferences(StateId(1), &mut preferences);
        let loss = preferences[0] - preferences[1];
        assert!(loss.abs() < 1e-6, "{preferences:?}");
    }

    #[test]
    fn once_chance_has_a_part_what_was_seldom_tried_is_worth_a_bonus() {
        let params = ReplayActorCriticParams {
            gamma: 0.0,
            bonus: 2.0,
            ..thorough()
        };
        let mut agent = agent(params, 1.0);
        live(&mut agent, &[on(0, 0, 1.0, 1), on(0, 0, 1.0, 1)]);
        assert_eq!(agent.value_of(0), 1.0, "no two outcomes so far");
        live(&mut agent, &[on(0, 0, 4.0, 2), on(0, 1, 1.0, 2)]);
        // L = 4, r_max = 4: b = 2 · 4 / 4 / √N.
        let (seldom, often) = (1.0 + 2.0, 2.0 + 2.0 / 3.0_f64.sqrt());
        let found = agent.value_of(0);
        assert!((found - often.max(seldom)).abs() < 1e-12, "{found}");
        let best = u16::from(seldom > often);
        let greedy = agent.greedy_action(StateId(0), &NO_ADVICE);
        assert_eq!(greedy, Some(Action(best)));
    }

    #[test]
    fn where_rewards_are_noisy_a_mean_is_worth_its_standard_error() {
        let params = ReplayActorCriticParams {
            gamma: 0.0,
            bonus: 0.5,
            ..thorough()
        };
        let mut agent = agent(params, 1.0);
        live(&mut agent, &[on(0, 0, 2.0, 1), on(0, 0, 2.0, 1)]);
        live(&mut agent, &[on(1, 0, -1.0, 0), on(1, 1, -1.0, 0)]);
        assert_eq!(agent.value_of(0), 2.0, "the same each time");
        assert_eq!(
            agent.value_of(1),
            -1.0,
            "one reward, and none has been noisy"
        );
        live(&mut agent, &[on(0, 0, 5.0, 1)]);
        // Σ (r − r̂)² = 6 over 3 rewards: σ₀² = 3; of the pair (6 + 3) / 3, of the single reward σ₀².
        let expected = [
            3.0 + 1.5 * (3.0_f64 / 3.0).sqrt(),
            -1.0 + 1.5 * 3.0_f64.sqrt(),
        ];
        for (state, expected) in expected.into_iter().enumerate() {
            let found = agent.value_of(state);
            assert!(
                (found - expected).abs() < 1e-12,
                "{state}: {found} {expected}"
            );
        }
    }

    #[test]
    fn in_a_long_life_no_action_is_neglected_whatever_is_advised() {
        let mut agent = agent(thorough(), 1.0);
        let advice = [0.0, 1e6];
        let mut seldom = 0;
        for n in 0..3 * LONG_LIFE {
            let taken = agent.select_action(Situation {
                state: StateId(0),
                advice: &advice,
            });
            seldom += u32::from(taken == Action(0));
            let ripe = (n as f64 / LONG_LIFE as f64 - 1.0).clamp(0.0, 1.0);
            let rule = f64::from(seldom) - ripe * (n as f64).sqrt();
            assert!((-1.0..=1.0).contains(&rule), "{seldom} of {n}");
            live(&mut agent, &[on(0, taken.0, -1.0, 0)]);
        }
        assert!(seldom > 150, "{seldom}");
    }

    #[test]
    fn a_loop_that_pays_is_worth_a_number() {
        let params = ReplayActorCriticParams {
            gamma: 1.0,
            ..thorough()
        };
        let mut agent = agent(params, 1.0);
        for _ in 0..50 {
            live(&mut agent, &[on(0, 0, 1.0, 0), on(0, 1, -1.0, 0)]);
        }
        // L is 128 after 100 steps: 1 + g + g² + … = 10 L.
        let found = agent.value_of(0);
        assert!((found - 1280.0).abs() < 13.0, "{found}");
    }

    #[test]
    fn episodes_without_end_or_reward_keep_the_scale_in_bounds() {
        let mut scale = Scale::new();
        assert!(scale.step_cost() > 0.0, "nothing seen yet");
        scale.so_far = u32::MAX - 1;
        scale.longest = 1 << 31;
        assert!(scale.note(0.0, StepStatus::Running));
        assert!(!scale.note(0.0, StepStatus::Running));
        assert!(scale.end_of_time() > 0.0 && scale.step_cost() > 0.0);
        scale.note(-7.0, StepStatus::Terminated);
        assert!(scale.step_cost() < 1e-6, "ends are no steps");
        scale.note(-0.5, StepStatus::Running);
        scale.note(2.0, StepStatus::Truncated);
        assert_eq!(scale.step_cost(), 0.5);
    }

    impl ReplayActorCritic {
        fn value_of(&self, state: usize) -> f64 {
            self.values[state]
        }
    }
}
