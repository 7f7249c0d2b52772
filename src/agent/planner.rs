//! R-max: optimal plans on the learnt model, optimistic about what was never tried (Brafman & Tennenholtz 2002).
//!
//! V(s) = max_a U if N(s, a) < m, else Σ_s′ P̂(s′|s, a) (r̂ − κ + γ V(s′)), with V = 0 at terminal states.
//!
//! U is what an unknown action might be worth: the largest reward seen so far and then the end of the task, or that
//! reward for ever, r_max / (1 − γ), where γ < 1 and r_max > 0. An agent that follows such plans goes wherever an untried
//! action could still beat the best known path, also after the first goal, and stops exploring when none can. m is
//! `known_after`. κ = 1e-6 settles ties between free paths in favour of the shorter.
//!
//! Plans are kept exact by prioritised sweeping (Moore & Atkeson 1993) from the values before: a step that teaches
//! nothing costs one backup, one that does costs as many as there are states whose value depends on it. Values start
//! optimistic and come down, so with γ = 1 a region without any way out would sink for ever; values end at a floor of
//! ten times the longest simple path at the largest cost seen.
//!
//! Where steps cost next to nothing and chance has a part, that is slow, and values that should come down hold each other
//! up, sinking by the cost of a round at a time. Four things bound it:
//!
//! - A step has a budget of a few backups a state, and what earlier ones saved; states that are left over wait for the next.
//! - In a world of few states a step that used up its budget is followed by policy iteration with policies evaluated exactly.
//! - In a larger one the plan is then made anew from the floor, for from below values have nothing to hold on to (from above
//!   and from below they enclose what is right: Haddad & Monmege 2014); but only so often that this at most doubles
//!   the work, and more seldom while it turns out to change nothing.
//! - With γ = 1 a loop that pays is worth more than any number. Once a value exceeds ten times what the longest simple path
//!   could earn there must be one, and from then on plans discount, as if an episode went on for about so many steps.
//!
//! The planner is the yardstick for what knowing the graph can give: it heeds no shaping, and no advice either, unless it is
//! told to leave untried actions to it ([`Untried::Advised`]). Then of the most advised actions the best one is taken, whatever
//! the others may be worth: the exploration says where to look for as long as it looks for something, and the plan does the
//! rest. Plans then count, as that search does, an untried action of s as one that may lead back to any s′ from where s was
//! entered, at little less reward; and hope for nothing else from it.

use super::checks::{check_count, check_gamma, check_return};
use super::greedy::{action, choose, first_best};
use super::model::{EmpiricalModel, WayIn};
use super::small_mdp::{Row, SmallMdp, Solution};
use super::sweep::SweepQueue;
use super::table::largest;
use super::{Agent, Experience, Situation, Untried, UpdateInfo};
use crate::env::{Action, StepStatus};
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// κ: cost of a step in plans besides its reward.
const STEP_COST: f64 = 1e-6;
/// Changes below this share of the cheapest step's cost are not passed on. Where nothing is left to chance, changes are
/// whole steps and plans exact; under slip values are good to about this share of their size.
const NEGLIGIBLE: f64 = 1e-3;
/// Floor and ceiling, in longest simple paths: room for slip to make a path ten times as long.
const LONG_PATHS: f64 = 10.0;
/// The budget of a step, in backups a state; in small worlds at least so many.
const BACKUPS_PER_STATE: usize = 8;
const MIN_BACKUPS: usize = 200;
/// Up to so many states, policies are evaluated exactly: a third of their cube is a few hundred microseconds.
const FEW_STATES: usize = 64;
/// A plan is close to done when what waits could change no value by more than this share of the largest reward.
const ALMOST_DONE: f64 = 1e-5;
/// A plan from the floor changed nothing where no value differs by more than this share of the largest.
const MATERIAL: f64 = 1e-2;
/// Steps between two plans from the floor that changed nothing, at most.
const MAX_REST: u64 = 1 << 20;

/// Parameters of [`Planner`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannerParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// m: tries after which an action counts as known; at least 1.
    pub known_after: u32,
    /// What leads to unknown actions.
    pub untried: Untried,
    /// U; `None`: from the largest reward seen.
    pub optimistic_value: Option<f64>,
    /// At most so many backups after one step, at least 1, be it for what the step taught or for a plan from the floor; what
    /// is left waits for the next.
    pub max_backups: usize,
}

impl Default for PlannerParams {
    fn default() -> Self {
        PlannerParams {
            gamma: 1.0,
            known_after: 1,
            untried: Untried::Optimistic,
            optimistic_value: None,
            max_backups: 100_000,
        }
    }
}

impl PlannerParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_gamma(self.gamma)?;
        check_count("known_after", self.known_after as usize)?;
        check_return("optimistic_value", self.optimistic_value.unwrap_or(0.0))?;
        check_count("max_backups", self.max_backups)
    }
}

/// Plans, acts, and re-plans after each step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Planner {
    params: PlannerParams,
    model: EmpiricalModel,
    /// V.
    values: Vec<f64>,
    /// States whose value may be out of date.
    queue: SweepQueue,
    /// Whether a loop was found that pays.
    loop_pays: bool,
    /// Backups of earlier budgets that were not needed.
    saved: usize,
    /// Steps until a plan may be made from the floor again, and how many there were to be after the last one.
    rest: u64,
    last_rest: u64,
    /// Backups so far.
    backups: u64,
    /// Largest and smallest reward seen.
    rewards: Option<(f64, f64)>,
    /// Smallest |reward| of a step that did not end the task.
    cheapest_step: Option<f64>,
    /// Room for one number per action.
    buffer: Vec<f64>,
    /// As many zeros.
    no_advice: Vec<f64>,
    rng: ChaCha8Rng,
}

impl Planner {
    /// An agent that knows nothing, and draws from the agent's stream of `seed` where actions are equally good.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: PlannerParams, num_actions: usize, seed: u64) -> Self {
        Planner {
            params,
            model: EmpiricalModel::new(num_actions, 0.0),
            values: Vec::new(),
            queue: SweepQueue::default(),
            loop_pays: false,
            saved: 0,
            rest: 0,
            last_rest: 0,
            backups: 0,
            rewards: None,
            cheapest_step: None,
            buffer: vec![0.0; num_actions],
            no_advice: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
        }
    }

    /// V(state) of the present plan; `None` for states it has not heard of.
    pub fn value(&self, state: StateId) -> Option<f64> {
        self.values.get(state.index()).copied()
    }

    /// Backups so far: the work that plans have cost.
    pub fn backups(&self) -> u64 {
        self.backups
    }

    /// γ of plans; less than 1 where a loop pays.
    fn gamma(&self) -> f64 {
        if self.loop_pays {
            // Of a number of states that seldom changes, for values depend on it everywhere.
            1.0 - 1.0 / (LONG_PATHS * (self.values.len() + 1).next_power_of_two() as f64)
        } else {
            self.params.gamma
        }
    }

    /// U.
    fn optimistic_value(&self) -> f64 {
        let gamma = self.params.gamma;
        let from_rewards = match self.rewards {
            None => 0.0,
            Some((largest, _)) if largest > 0.0 && gamma < 1.0 => largest / (1.0 - gamma),
            Some((largest, _)) => largest,
        };
        self.params.optimistic_value.unwrap_or(from_rewards)
    }

    /// What an unknown action of `state` counts for in plans.
    fn unknown_value(&self, state: StateId) -> f64 {
        match self.params.untried {
            Untried::Optimistic => self.optimistic_value(),
            Untried::Advised => {
                let back = |way: WayIn| {
                    way.reward - self.doubt() + self.gamma() * self.values[way.state.index()]
                };
                let ways = self.ways_back(state).map(back);
                ways.fold(self.floor(), f64::max)
            }
        }
    }

    /// What a way that may not exist costs more than one that does: half a step, so that of two ways of the same length the
    /// known one is taken.
    fn doubt(&self) -> f64 {
        0.5 * self.cheapest_step.unwrap_or(0.0) + 2.0 * STEP_COST
    }

    /// The ways into `state` from elsewhere, which an unknown action may undo.
    fn ways_back(&self, state: StateId) -> impl Iterator<Item = WayIn> + '_ {
        let ways = self.model.ways_into(state);
        ways.filter(move |way| way.state != state)
    }

    /// Below this no value falls.
    fn floor(&self) -> f64 {
        let cost = self
            .rewards
            .map_or(0.0, |(_, smallest)| (-smallest).max(0.0))
            + STEP_COST;
        let states = self.values.len() + 1;
        let states = match self.params.untried {
            Untried::Optimistic => states,
            // Values begin there, so that it had better seldom change.
            Untried::Advised => states.next_power_of_two(),
        };
        -LONG_PATHS * cost * states as f64
    }

    /// Moves values that lay on the floor, and what rests on them, when it has sunk from `before`.
    fn follow_floor(&mut self, before: f64) {
        let floor = self.floor();
        if self.params.untried == Untried::Advised && floor != before {
            for value in self.values.iter_mut().filter(|value| **value == before) {
                *value = floor;
            }
            self.queue_all(before - floor);
        }
    }

    /// Above this no value rises with γ = 1 unless there is a loop that pays.
    fn ceiling(&self) -> f64 {
        let largest = self.rewards.map_or(0.0, |(largest, _)| largest.max(0.0));
        let ends = self.optimistic_value().max(0.0);
        ends + LONG_PATHS * largest * (self.values.len() + 1) as f64
    }

    /// Changes up to this are not passed on, and values this close count as equal.
    fn tolerance(&self) -> f64 {
        NEGLIGIBLE * (self.cheapest_step.unwrap_or(0.0) + STEP_COST)
    }

    fn grow_to(&mut self, state: StateId) {
        self.model.grow_to(state);
        if state.index() >= self.values.len() {
            let (floor, gamma) = (self.floor(), self.gamma());
            let unknown = match self.params.untried {
                Untried::Optimistic => self.optimistic_value(),
                Untried::Advised => floor,
            };
            self.values.resize(state.index() + 1, unknown);
            self.follow_floor(floor);
            if self.gamma() != gamma {
                self.queue_all(1.0);
            }
        }
    }

    /// What `action` is worth by the present values.
    fn action_value(&self, state: StateId, action: Action) -> f64 {
        if self.model.tries(state, action) < self.params.known_after {
            return self.unknown_value(state);
        }
        let known = self
            .model
            .action_value(state, action, self.gamma(), |s| self.values[s.index()]);
        known.expect("the action was tried") - STEP_COST
    }

    /// Computes V(state) anew and passes on a change; returns it.
    fn back_up(&mut self, state: StateId) -> f64 {
        self.backups += 1;
        let actions = 0..self.model.num_actions();
        let value = actions
            .map(|a| self.action_value(state, action(a)))
            .fold(f64::NEG_INFINITY, f64::max);
        let value = value.max(self.floor());
        if self.gamma() == 1.0 && value > self.ceiling() {
            self.loop_pays = true;
            self.queue_all(value);
        }
        let change = value - std::mem::replace(&mut self.values[state.index()], value);
        if change.abs() > self.tolerance() && !self.model.is_terminal(state) {
            self.pass_on(state, change.abs());
        }
        change
    }

    /// Queues every state that has a way into `state`, or may have one.
    fn pass_on(&mut self, state: StateId, change: f64) {
        for way in self.model.ways_into(state) {
            self.queue
                .push(way.state.index(), self.gamma() * way.probability * change);
        }
        if self.params.untried == Untried::Advised {
            let actions = 0..self.model.num_actions();
            let next = actions.flat_map(|a| self.model.ways_out(state, action(a)));
            for (next, _) in next {
                self.queue.push(next.index(), self.gamma() * change);
            }
        }
    }

    /// Queues every state.
    fn queue_all(&mut self, priority: f64) {
        (0..self.values.len()).for_each(|s| self.queue.push(s, priority));
    }

    /// Backs up what waits, most urgent first, at most so many.
    fn sweep(&mut self, backups: usize) {
        for _ in 0..backups {
            let Some(state) = self.queue.pop() else { break };
            self.back_up(StateId(state as u32));
        }
    }

    /// Solves the model, unless a loop turns out to pay: then sweeps go on with what that changes.
    fn plan_exactly(&mut self) {
        let problem = SmallMdp {
            rows: (0..self.values.len()).map(|s| self.rows(s)).collect(),
            gamma: self.gamma(),
            floor: self.floor(),
            ceiling: self.ceiling(),
            tolerance: self.tolerance(),
        };
        match problem.solve(&self.values) {
            Solution::Values(values, policies) => {
                self.backups += (policies * values.len()) as u64;
                self.values = values;
                self.queue = SweepQueue::default();
            }
            Solution::Unbounded => {
                self.loop_pays = true;
                self.queue_all(1.0);
            }
        }
    }

    /// The actions of a state by the model.
    fn rows(&self, state: usize) -> Vec<Row> {
        let state = StateId(state as u32);
        let actions = (0..self.model.num_actions()).map(action);
        actions
            .flat_map(
                |action| match self.model.tries(state, action) < self.params.known_after {
                    true => self.unknown_rows(state),
                    false => vec![self.known_row(state, action)],
                },
            )
            .collect()
    }

    fn known_row(&self, state: StateId, action: Action) -> Row {
        let reward = self.model.action_value(state, action, 1.0, |_| 0.0);
        let ways = self.model.ways_out(state, action);
        Row {
            reward: reward.expect("the action was tried") - STEP_COST,
            next: ways
                .filter(|&(to, _)| !self.model.is_terminal(to))
                .map(|(to, probability)| (to.index(), probability))
                .collect(),
        }
    }

    /// An unknown action is worth U or the floor, and then the task ends; or else it leads back.
    fn unknown_rows(&self, state: StateId) -> Vec<Row> {
        let end = |reward| Row {
            reward,
            next: Vec::new(),
        };
        match self.params.untried {
            Untried::Optimistic => vec![end(self.optimistic_value())],
            Untried::Advised => {
                let back = self.ways_back(state).map(|way| Row {
                    reward: way.reward - self.doubt(),
                    next: vec![(way.state.index(), 1.0)],
                });
                std::iter::once(end(self.floor())).chain(back).collect()
            }
        }
    }

    /// Plans anew from the floor up, and rests as long as earns the backups of it; twice as long as last time if nothing
    /// came of it. A plan that is far from done when its backups are used up is dropped.
    fn plan_from_the_floor(&mut self, earned: usize, backups: usize) {
        let (values, queue) = (self.values.clone(), std::mem::take(&mut self.queue));
        let before = self.backups;
        let floor = self.floor();
        self.values.fill(floor);
        self.queue_all(f64::INFINITY);
        self.sweep(backups);
        let largest = |(l, s): (f64, f64)| l.abs().max(s.abs());
        let worth = self.rewards.map_or(0.0, largest) + STEP_COST;
        let close = self.queue.most_urgent() <= self.tolerance().max(ALMOST_DONE * worth);
        let scale = values.iter().fold(worth, |scale, v| scale.max(v.abs()));
        let differs = |(a, b): (&f64, &f64)| (a - b).abs() > MATERIAL * scale;
        let changed = close && self.values.iter().zip(&values).any(differs);
        if !close {
            (self.values, self.queue) = (values, queue);
        }
        let steps = (self.backups - before) / earned as u64;
        self.last_rest = if changed {
            steps
        } else {
            (2 * self.last_rest).clamp(steps, MAX_REST.max(steps))
        };
        self.rest = self.last_rest;
    }

    /// Notes the range of rewards; every value may depend on U, which goes by it.
    fn note_reward(&mut self, reward: f64, status: StepStatus) {
        if status != StepStatus::Terminated {
            let cheapest = self
                .cheapest_step
                .unwrap_or(f64::INFINITY)
                .min(reward.abs());
            self.cheapest_step = cheapest.is_finite().then_some(cheapest);
        }
        let (largest, smallest) = self.rewards.unwrap_or((reward, reward));
        let before = self.rewards.map(|_| self.optimistic_value());
        let floor = self.floor();
        self.rewards = Some((largest.max(reward), smallest.min(reward)));
        self.follow_floor(floor);
        let after = self.optimistic_value();
        if before != Some(after) {
            self.queue_all(after.abs().max(1.0));
        }
    }
}

impl Agent for Planner {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.grow_to(situation.state);
        let mut buffer = std::mem::take(&mut self.buffer);
        for (a, value) in buffer.iter_mut().enumerate() {
            *value = self.action_value(situation.state, action(a));
        }
        let best = largest(&buffer);
        let tolerance = self.tolerance();
        for value in buffer
            .iter_mut()
            .filter(|value| **value >= best - tolerance)
        {
            *value = best;
        }
        if self.params.untried == Untried::Advised {
            keep_most_advised(&mut buffer, situation.advice);
        }
        self.buffer = buffer;
        choose(&self.buffer, &self.no_advice, 0.0, &mut self.rng)
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let (state, next) = (experience.state, experience.next.state);
        self.grow_to(StateId(state.0.max(next.0)));
        self.note_reward(experience.reward, experience.status);
        if self.model.record(experience) {
            self.pass_on(next, self.values[next.index()].abs().max(1.0));
        }
        if self.params.untried == Untried::Advised {
            self.queue.push(next.index(), 1.0); // where there may be a new way back
        }
        let td_error = self.back_up(state);
        let earned = (BACKUPS_PER_STATE * self.values.len()).max(MIN_BACKUPS);
        let few_states = self.values.len() <= FEW_STATES;
        let saved = if few_states { 0 } else { self.saved };
        let budget = (saved + earned).min(self.params.max_backups);
        let before = self.backups;
        self.sweep(budget - 1);
        self.saved = budget - 1 - (self.backups - before) as usize;
        self.rest = self.rest.saturating_sub(1);
        let done = self.queue.most_urgent() == 0.0;
        if !done && few_states && earned < self.params.max_backups {
            self.plan_exactly();
        } else if !done && self.rest == 0 && budget < self.params.max_backups {
            self.plan_from_the_floor(earned, self.params.max_backups - budget);
        }
        UpdateInfo { td_error }
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        self.value(state)?;
        let mut values: Vec<f64> = (0..self.model.num_actions())
            .map(|a| self.action_value(state, action(a)))
            .collect();
        if self.params.untried == Untried::Advised {
            keep_most_advised(&mut values, advice);
        }
        first_best(&values)
    }
}

/// Makes actions worthless that are advised less than others.
///
/// # Panics
/// If there is not one number of advice per action.
fn keep_most_advised(values: &mut [f64], advice: &[f64]) {
    assert_eq!(
        values.len(),
        advice.len(),
        "one number of advice per action"
    );
    let most = largest(advice);
    for (value, &advice) in values.iter_mut().zip(advice) {
        if advice < most {
            *value = f64::NEG_INFINITY;
        }
    }
}
