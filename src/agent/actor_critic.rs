//! Q actor-critic.
//!
//! One step (s, a, R′, s′), in the order of Sutton & Barto (2018, section 13.5), with the equations of the source paper:
//!
//! 1. a′ ~ π_θ(·|s′), the policy of [`policy`](super::policy) (eq. 7);
//! 2. δ = R′ + γ Q_w(s′, a′) − Q_w(s, a), R′ = r + m·F (eqs. 3 and 11); without the Q_w(s′, a′) if the task is over;
//! 3. w ← w + α_critic δ φ(s, a), since ∇_w Q_w(s, a) = φ(s, a) (eq. 13);
//! 4. θ ← θ + α_actor ∇_θ log π_θ(a|s) · signal (eq. 12);
//! 5. s ← s′, a ← a′.
//!
//! | `update` | signal | step sizes by default (critic, actor) |
//! |---|---|---|
//! | `advantage` | Q_w(s, a) − Σ_b π(b\|s) Q_w(s, b), with the w of step 3 | 0.7, 0.1 |
//! | `algorithm-1` | δ | 0.01, 0.005 |
//! | `algorithm-2` | Q_w(s, a), with the w before step 3 | 0.005, 0.01 |
//!
//! # Where the paper's two algorithms disagree
//!
//! - **α and β change places.** Algorithm 1 moves w by α (line 12) and θ by β (line 13); Algorithm 2 moves θ by α (line 8)
//!   and w by β (line 9). Here the step sizes are called what they belong to, `critic_learning_rate` and
//!   `actor_learning_rate`; their defaults are α = 0.01 and β = 0.005 of section 4.3, each where its algorithm puts it.
//! - **Line 8 of Algorithm 2** reads θ ← α ∇ log π · Q. That would forget θ at each step; eq. 9 has θ = θ + …, and so
//!   has this module.
//! - **The actor's signal** is δ in Algorithm 1 and in eqs. 10 and 12, the raw Q in Algorithm 2. Both are offered. With
//!   an action-value critic δ says how surprising the step was, not how good the action is against the others; raw Q
//!   lacks a baseline. The advantage is Q with the baseline that leaves the gradient's expectation unchanged, hence the
//!   default.
//! - **γ** is left out in lines 10 and 11 of Algorithm 1, where it is 1. Here it is always written.
//! - **Order.** Algorithm 1 moves w before θ, Algorithm 2 θ before w. As δ is fixed before either, this matters only
//!   where the signal reads w: `algorithm-2` takes the old w as printed, `advantage` the new.
//! - **The goal.** Both loops end at the goal without saying what Q(s_goal, ·) is. It is 0 on termination; a truncated
//!   episode bootstraps from the state it was cut off in.
//!
//! # Sampled or expected
//!
//! `bootstrap = "expected"` puts Σ_b π(b|s′) Q_w(s′, b) in the place of Q_w(s′, a′) and draws a′ when it is asked for an
//! action. Open grids from corner to corner, no shaping, no advice, reward −1 a step, γ = 1, step sizes as above, regret
//! over 500 episodes: median of 20 seeds, quartiles in brackets, and the mean length of the last 50 episodes against the
//! shortest path (`cargo test --release --test library -- --ignored --nocapture sampled`):
//!
//! | `update` | `bootstrap` | 5×5 | 11×11 |
//! |---|---|---|---|
//! | `advantage` | sampled | 1 398 [1 366, 1 405], 1.03 | 10 196 [10 040, 10 401], 1.04 |
//! | `advantage` | expected | 1 391 [1 369, 1 416], 1.03 | 10 516 [10 323, 10 924], 1.05 |
//! | `algorithm-1` | sampled | 28 367 [28 133, 28 665], 4.9 | 183 039 [181 820, 185 557], 10.9 |
//! | `algorithm-1` | expected | 28 388 [28 101, 28 600], 5.0 | 184 274 [183 410, 185 491], 11.1 |
//! | `algorithm-2` | sampled | 34 672 [34 148, 34 740], 6.3 | 219 805 [213 914, 221 460], 12.9 |
//! | `algorithm-2` | expected | 34 388 [34 052, 34 885], 6.6 | 217 652 [215 146, 220 765], 12.9 |
//!
//! The two are close; sampled is what the paper prints and no worse, hence the default. (Taking the advantage from the w
//! *before* step 3 costs more: 1 469 and 11 579 in the first row.)
//!
//! # Advice
//!
//! Advice is added to the logits and is part of π wherever π occurs: in the choice, in the expectation, and in
//! ∇ log π(a|s)_b = 1[a = b] − π(b|s), which is the gradient with respect to θ of the policy that really acts
//! (look-ahead advice, Wiewiora, Cottrell & Elkan 2003). Preferences are projected on ±`preference_clip` after each
//! step; advice is not clipped.

use super::behaviour::Behaviour;
use super::checks::{AGENT, check_gamma, check_rate};
use super::choices::{Bootstrap, UpdateRule};
use super::features::LinearFeatures;
use super::greedy::{action, advised, first_best};
use super::policy::{clamp, sample, softmax};
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::{Action, LARGEST_RETURN};
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Parameters of [`ActorCritic`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActorCriticParams {
    /// Which signal moves the actor.
    pub update: UpdateRule,
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// Step size of θ, above 0.
    pub actor_learning_rate: f64,
    /// Step size of w, in (0, 1].
    pub critic_learning_rate: f64,
    /// Bound of a preference's absolute value, above 0.
    pub preference_clip: f64,
    /// How the value of s′ is estimated.
    pub bootstrap: Bootstrap,
}

impl ActorCriticParams {
    /// The defaults that go with `update`.
    pub fn of(update: UpdateRule) -> Self {
        let (critic_learning_rate, actor_learning_rate, bootstrap) = match update {
            UpdateRule::Advantage => (0.7, 0.1, Bootstrap::Sampled),
            UpdateRule::Algorithm1 => (0.01, 0.005, Bootstrap::Sampled),
            UpdateRule::Algorithm2 => (0.005, 0.01, Bootstrap::Sampled),
        };
        let (gamma, preference_clip) = (1.0, 3.0);
        ActorCriticParams {
            update,
            gamma,
            actor_learning_rate,
            critic_learning_rate,
            preference_clip,
            bootstrap,
        }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let positive = |key, value: f64| {
            let holds = value > 0.0 && value <= LARGEST_RETURN;
            AGENT.number(key, value, holds, "above 0 and at most 1e27")
        };
        check_gamma(self.gamma)?;
        positive("actor_learning_rate", self.actor_learning_rate)?;
        check_rate(self.critic_learning_rate)?;
        positive("preference_clip", self.preference_clip)
    }
}

impl Default for ActorCriticParams {
    fn default() -> Self {
        ActorCriticParams::of(UpdateRule::default())
    }
}

/// Actor-critic, linear in the features `F`: preferences θᵀφ(s, a) and action values wᵀφ(s, a).
///
/// Memory: two numbers per (state, action) with [`Tabular`](super::Tabular) features; a step takes O(actions)
/// time there and O(features · actions) with proto-value functions, and allocates only when a new state arrives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActorCritic<F> {
    params: ActorCriticParams,
    /// Weight m of the shaping.
    mix: f64,
    features: F,
    /// θ.
    actor: Vec<f64>,
    /// w.
    critic: Vec<f64>,
    /// π at s, where the agent stands, and, within an update, at s′; which is which changes with each step.
    behaviours: [Behaviour; 2],
    /// Which of the two is the one at s.
    here: usize,
    /// Room for one number per action.
    buffer: Vec<f64>,
    rng: ChaCha8Rng,
}

impl<F: LinearFeatures> ActorCritic<F> {
    /// An agent that knows nothing: every preference and value 0. It draws from the agent's stream of `seed` and
    /// learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(
        params: ActorCriticParams,
        features: F,
        num_actions: usize,
        mix: f64,
        seed: u64,
    ) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        ActorCritic {
            params,
            mix,
            features,
            actor: Vec::new(),
            critic: Vec::new(),
            behaviours: [Behaviour::new(num_actions), Behaviour::new(num_actions)],
            here: 0,
            buffer: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
        }
    }

    /// Q_w(state, action); 0 where nothing is known. O(features).
    pub fn action_value(&self, state: StateId, action: Action) -> f64 {
        self.known(&self.critic, state)
            .map_or(0.0, |w| self.features.value(w, state, action))
    }

    /// h_θ(state, action), within ±`preference_clip`; 0 where nothing is known. O(features).
    pub fn preference(&self, state: StateId, action: Action) -> f64 {
        let preference = self
            .known(&self.actor, state)
            .map_or(0.0, |w| self.features.value(w, state, action));
        clamp(preference, self.params.preference_clip)
    }

    /// Writes π(·|situation) into `probabilities`. O(features · actions), allocates a preference per action.
    ///
    /// # Panics
    /// If advice or `probabilities` do not have one number per action.
    pub fn probabilities(&self, situation: Situation<'_>, probabilities: &mut [f64]) {
        let preferences: Vec<f64> = (0..probabilities.len())
            .map(|a| self.preference(situation.state, action(a)))
            .collect();
        softmax(
            &preferences,
            situation.advice,
            self.params.preference_clip,
            probabilities,
        );
    }

    fn known<'a>(&self, weights: &'a [f64], state: StateId) -> Option<&'a [f64]> {
        self.features.knows(weights, state).then_some(weights)
    }

    #[inline]
    fn grow_to(&mut self, state: StateId) {
        self.features.grow_to(&mut self.actor, state);
        self.features.grow_to(&mut self.critic, state);
    }

    #[inline]
    fn here(&mut self) -> &mut Behaviour {
        &mut self.behaviours[self.here]
    }

    #[inline]
    fn ahead(&mut self) -> &mut Behaviour {
        &mut self.behaviours[1 - self.here]
    }

    /// Brings the policy of one of the two behaviours up to date with θ.
    #[inline]
    fn refresh(&mut self, which: usize, state: StateId) {
        if self.behaviours[which].stale {
            let preferences = self.features.values(&self.actor, state, &mut self.buffer);
            self.behaviours[which].compute(preferences, self.params.preference_clip);
        }
    }

    /// Step 1: π(·|s′), and the value to bootstrap from.
    #[inline]
    fn look_ahead(&mut self, state: StateId) -> f64 {
        let which = 1 - self.here;
        self.refresh(which, state);
        let ahead = &mut self.behaviours[which];
        match self.params.bootstrap {
            Bootstrap::Sampled => {
                let next_action = action(sample(&ahead.probabilities, &mut self.rng));
                ahead.drawn = Some(next_action.0);
                self.features.value(&self.critic, state, next_action)
            }
            Bootstrap::Expected => {
                let values = self.features.values(&self.critic, state, &mut self.buffer);
                expectation(&ahead.probabilities, values)
            }
        }
    }

    /// Step 3.
    #[inline]
    fn move_critic(&mut self, state: StateId, action: Action, td_error: f64) {
        self.features.step(
            &mut self.critic,
            state,
            action,
            self.params.critic_learning_rate * td_error,
        );
    }

    /// Step 4, preferences projected on ±clip.
    #[inline]
    fn move_actor(&mut self, state: StateId, taken: Action, signal: f64) {
        let rate = self.params.actor_learning_rate * signal;
        let probabilities = &self.behaviours[self.here].probabilities;
        self.features
            .step_within(&mut self.actor, state, self.params.preference_clip, |b| {
                let indicator = if b == taken.index() { 1.0 } else { 0.0 };
                rate * (indicator - probabilities[b])
            });
    }

    /// Q_w(s, a) − Σ_b π(b|s) Q_w(s, b).
    #[inline]
    fn advantage(&mut self, state: StateId, taken: Action) -> f64 {
        let values = self.features.values(&self.critic, state, &mut self.buffer);
        values[taken.index()] - expectation(&self.behaviours[self.here].probabilities, values)
    }
}

/// Σ_b p_b v_b.
#[inline]
fn expectation(probabilities: &[f64], values: &[f64]) -> f64 {
    probabilities.iter().zip(values).map(|(p, v)| p * v).sum()
}

impl<F: LinearFeatures> Agent for ActorCritic<F> {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        let state = situation.state;
        let here = self.here();
        if let (true, Some(drawn)) = (here.state == Some(state.0), here.drawn) {
            return Action(drawn); // a ← a′
        }
        if !here.describes(situation) {
            here.enter(situation);
        }
        self.grow_to(state);
        self.refresh(self.here, state);
        let drawn = action(sample(
            &self.behaviours[self.here].probabilities,
            &mut self.rng,
        ));
        self.here().drawn = Some(drawn.0);
        drawn
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let (s, a) = (experience.state, experience.action);
        let next = experience.next;
        self.grow_to(StateId(s.0.max(next.state.0)));
        if self.here().state != Some(s.0) {
            // A step that this agent did not choose: its policy there had no advice that we know of.
            self.here().enter(Situation {
                state: s,
                advice: next.advice,
            });
            self.here().advice.fill(0.0);
        }
        self.refresh(self.here, s);

        self.ahead().enter(next);
        let continuation = experience.continuation();
        let bootstrap = if continuation > 0.0 {
            self.look_ahead(next.state)
        } else {
            0.0
        };

        let before = self.features.value(&self.critic, s, a);
        let target = experience.shaped_reward(self.mix) + self.params.gamma * bootstrap;
        let td_error = target - before;
        self.move_critic(s, a, td_error);
        let signal = match self.params.update {
            UpdateRule::Advantage => self.advantage(s, a),
            UpdateRule::Algorithm1 => td_error,
            UpdateRule::Algorithm2 => before,
        };
        self.move_actor(s, a, signal);

        self.ahead().stale |= F::GENERALISES || next.state == s;
        self.here = 1 - self.here;
        if experience.status.is_last() {
            self.here().state = None;
        }
        UpdateInfo { td_error }
    }

    fn set_features(&mut self, features: faer::MatRef<'_, f64>) {
        self.features
            .set_features(features, [&mut self.actor, &mut self.critic]);
        self.here().stale = true;
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        let weights = self.known(&self.actor, state)?;
        let mut buffer = vec![0.0; self.buffer.len()];
        let preferences = self.features.values(weights, state, &mut buffer);
        first_best(&advised(preferences, advice))
    }
}
