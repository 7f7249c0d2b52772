//! A learner that plans for an episode ahead, on what it believes of the world.
//!
//! The three learners of this kind differ in what they believe ([`Belief`]): the model as seen with a bonus on its rewards
//! ([`MbieEbParams`](super::MbieEbParams)), with a confidence bound ([`UcbviParams`](super::UcbviParams)), or a model drawn
//! at random from those that the world may be ([`PsrlParams`](super::PsrlParams)). They share what the originals leave open
//! for a world of which nothing is known:
//!
//! - **When it plans:** at the beginning of each episode, and whenever some action has been tried 1, 2, 4, 8, … times in a
//!   state (the doubling of Jaksch, Ortner & Auer 2010; for posterior sampling Ouyang, Gagrani, Nayyar & Jain 2017). So there
//!   are no more than pairs · log₂(tries) plans besides one an episode. Without those within an episode, an agent would
//!   have no plan for states that it meets in it for the first time.
//! - **What it plans:** it is told of no time step, so it takes the policy that is best in the first of `horizon` steps for
//!   all of them ([`horizon_plan`](super::horizon_plan)), where the originals have a policy for each step. Value iteration ends
//!   sooner if nothing changes any more by more than a millionth of the range of rewards R.
//! - **The unknown:** what was never tried is worth the best return in the steps that are left that the rewards seen so far
//!   let one hope for, those that pay fourfold ([`reward_range`](super::reward_range)), or `optimistic_value`.
//! - **The range of rewards:** in theory rewards lie in [0, 1], and returns of H steps in [0, H]. Here returns are seen to lie
//!   between that of the worst episode so far and the best that may be hoped for, and R, by which bonuses are
//!   multiplied, is the H-th part of that distance: a dear mishap does not make every step a reason to explore.
//!
//! A plan costs O(transitions) a sweep and as many sweeps as the longest way has steps, `horizon` at most: in a world of 225 states
//! 0.1 ms, of 588 states half a millisecond, so that a run takes seconds in hundreds of states and minutes in thousands.
//!
//! They are yardsticks: they heed neither shaping nor advice.

use super::checks::{check_count, check_gamma, check_return};
use super::greedy::{action, choose, first_best};
use super::horizon_plan::{Believed, HorizonPlan};
use super::model::{EmpiricalModel, Outcome};
use super::reward_range::RewardRange;
use super::table::largest;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Sweeps end when they change less than this share of the range of rewards.
const NEGLIGIBLE: f64 = 1e-6;

/// Parameters of plans, common to all beliefs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodePlanParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// Steps to plan ahead, 1 to 1 000 000.
    pub horizon: usize,
    /// Return expected where something unknown happens; `None`: from the largest rewards seen.
    pub optimistic_value: Option<f64>,
}

impl Default for EpisodePlanParams {
    fn default() -> Self {
        EpisodePlanParams {
            gamma: 1.0,
            horizon: 1000,
            optimistic_value: None,
        }
    }
}

impl EpisodePlanParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_gamma(self.gamma)?;
        check_count("horizon", self.horizon)?;
        check_return("optimistic_value", self.optimistic_value.unwrap_or(0.0))
    }
}

/// What beliefs may depend on besides what was seen to follow from an action.
#[derive(Clone, Copy, Debug)]
pub struct Outlook {
    /// R: how far the returns of episodes may be apart, by what was seen, divided by the horizon; above 0.
    pub range: f64,
    /// (state, action) pairs of the states known so far.
    pub pairs: usize,
    /// Steps taken so far.
    pub steps: u64,
}

/// What a learner believes of a world that it has seen a part of.
pub trait Belief {
    /// Whether no action is believed to be worth more than the unknown.
    const CLIPS: bool;

    /// How it plans.
    fn plan(&self) -> &EpisodePlanParams;

    /// What it adds to each reward of the best return that the unknown may be worth.
    fn hope(&self, outlook: &Outlook) -> f64;

    /// Believes something of a pair of which `outcomes` were seen, none if it was never tried: appends the states to `next`
    /// that it leads to, with their chances, and returns its reward and the chance of something unknown.
    fn believe(
        &self,
        outcomes: &[Outcome],
        outlook: &Outlook,
        rng: &mut ChaCha8Rng,
        next: &mut Vec<(u32, f64)>,
    ) -> Believed;
}

/// Mean reward of what was seen, and the states that it leads to, with the chances that were seen: the belief that the world
/// is what it was so far.
pub(super) fn as_seen(outcomes: &[Outcome], next: &mut Vec<(u32, f64)>) -> f64 {
    let tries = f64::from(tries(outcomes));
    let share = |outcome: &Outcome| f64::from(outcome.count) / tries;
    let goes_on = outcomes.iter().filter(|outcome| !outcome.ends);
    next.extend(goes_on.map(|outcome| (outcome.to.0, share(outcome))));
    outcomes.iter().map(|o| share(o) * o.reward).sum()
}

/// N(s, a).
pub(super) fn tries(outcomes: &[Outcome]) -> u32 {
    outcomes.iter().map(|outcome| outcome.count).sum()
}

/// Plans on what it believes, and follows the plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodePlanner<B> {
    belief: B,
    model: EmpiricalModel,
    rewards: RewardRange,
    /// Q of the plan in force, row by row.
    action_values: Vec<f64>,
    steps: u64,
    plans: u64,
    no_advice: Vec<f64>,
    rng: ChaCha8Rng,
}

impl<B: Belief> EpisodePlanner<B> {
    /// An agent that has seen nothing, and draws from the agent's stream of `seed`.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(belief: B, num_actions: usize, seed: u64) -> Self {
        EpisodePlanner {
            belief,
            model: EmpiricalModel::new(num_actions, 0.0),
            rewards: RewardRange::default(),
            action_values: Vec::new(),
            steps: 0,
            plans: 0,
            no_advice: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
        }
    }

    /// Plans so far: the work that it has cost.
    pub fn plans(&self) -> u64 {
        self.plans
    }

    /// Q(state, ·) of the plan in force; `None` for states that it does not cover.
    pub fn action_values(&self, state: StateId) -> Option<&[f64]> {
        let width = self.model.num_actions();
        self.action_values.chunks_exact(width).nth(state.index())
    }

    fn plan(&mut self) {
        self.plans += 1;
        let params = self.belief.plan();
        let outlook = Outlook {
            range: self.rewards.per_step(params.horizon, params.gamma),
            pairs: self.model.num_states() * self.model.num_actions(),
            steps: self.steps,
        };
        let mut plan = HorizonPlan::new(self.model.num_actions());
        let mut outcomes = Vec::new();
        for state in 0..self.model.num_states() {
            for a in 0..self.model.num_actions() {
                outcomes.clear();
                outcomes.extend(self.model.outcomes(StateId(state as u32), action(a)));
                let rng = &mut self.rng;
                plan.push(|next| self.belief.believe(&outcomes, &outlook, rng, next));
            }
        }
        let hope = self.belief.hope(&outlook);
        let best = |steps| {
            let by_rewards = || self.rewards.best_return(steps, params.gamma, hope);
            params.optimistic_value.unwrap_or_else(by_rewards)
        };
        let tolerance = NEGLIGIBLE * outlook.range;
        self.action_values = plan.solve(params.gamma, params.horizon, tolerance, B::CLIPS, best);
    }
}

impl<B: Belief> Agent for EpisodePlanner<B> {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        if self.action_values(situation.state).is_none() {
            self.model.grow_to(situation.state);
            self.plan();
        }
        let values = &self.action_values[situation.state.index() * self.model.num_actions()..];
        choose(
            &values[..self.no_advice.len()],
            &self.no_advice,
            0.0,
            &mut self.rng,
        )
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let (state, next) = (experience.state, experience.next.state);
        self.steps += 1;
        self.rewards.note(experience.reward, experience.status);
        let changed = self.model.record(experience);
        let tries = self.model.tries(state, experience.action);
        if changed || tries.is_power_of_two() || experience.status.is_last() {
            self.plan();
        }
        let value_of = |state| self.action_values(state).map_or(0.0, largest);
        let ahead = experience.continuation() * self.belief.plan().gamma * value_of(next);
        let own = self.action_values(state);
        let own = own.map_or(0.0, |values| values[experience.action.index()]);
        UpdateInfo {
            td_error: experience.reward + ahead - own,
        }
    }

    fn greedy_action(&self, state: StateId, _advice: &[f64]) -> Option<Action> {
        first_best(self.action_values(state)?)
    }
}
