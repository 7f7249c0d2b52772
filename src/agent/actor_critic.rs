//! Q actor-critic.
//!
//! One step (s, a, R′, s′), in the order of Sutton & Barto (2018, section 13.5), with the equations of the source report:
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
//! # Where the report's two algorithms disagree
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
//! action. Without shaping or advice, reward −1 a step, γ = 1, step sizes as above, regret over 500 episodes (median of
//! 20 seeds, quartiles in brackets; `cargo test --release --test agents -- --ignored --nocapture`):
//!
//! TABLE
//!
//! # Advice
//!
//! Advice is added to the logits and is part of π wherever π occurs: in the choice, in the expectation, and in
//! ∇ log π(a|s)_b = 1[a = b] − π(b|s), which is the gradient with respect to θ of the policy that really acts
//! (look-ahead advice, Wiewiora, Cottrell & Elkan 2003). Preferences are projected on ±`preference_clip` after each
//! step; advice is not clipped.

use super::features::LinearFeatures;
use super::greedy::{action, first_best};
use super::params::{AgentError, Bootstrap, UpdateRule, check, check_gamma, check_rate};
use super::policy::{clamp, sample, softmax};
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
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
            UpdateRule::Advantage => (0.7, 0.1, Bootstrap::Expected),
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
    pub fn validate(&self) -> Result<(), AgentError> {
        let positive = |key, value: f64| {
            check(
                key,
                value,
                value > 0.0 && value.is_finite(),
                "a finite number above 0",
            )
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

/// The policy at one state, as it was last computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Behaviour {
    /// The number of the state; `None` before the first step of an episode.
    state: Option<u32>,
    advice: Vec<f64>,
    probabilities: Vec<f64>,
    /// The action already drawn for this state.
    drawn: Option<u16>,
    /// Whether θ moved since `probabilities` were computed.
    stale: bool,
}

impl Behaviour {
    fn new(num_actions: usize) -> Self {
        let zeros = vec![0.0; num_actions];
        Behaviour {
            state: None,
            advice: zeros.clone(),
            probabilities: zeros,
            drawn: None,
            stale: true,
        }
    }

    /// Moves to `situation`, with everything about it still to be computed.
    fn enter(&mut self, situation: Situation<'_>) {
        self.state = Some(situation.state.0);
        self.advice.copy_from_slice(situation.advice);
        self.drawn = None;
        self.stale = true;
    }

    /// Whether it describes `situation`, advice included.
    fn describes(&self, situation: Situation<'_>) -> bool {
        self.state == Some(situation.state.0) && self.advice == situation.advice
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
    /// π at s, where the agent stands.
    here: Behaviour,
    /// π at s′, within an update.
    ahead: Behaviour,
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
            here: Behaviour::new(num_actions),
            ahead: Behaviour::new(num_actions),
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

    /// Step 1, for the state that `ahead` has entered: π(·|s′), and the value to bootstrap from.
    #[inline]
    fn look_ahead(&mut self, state: StateId) -> f64 {
        let preferences = self.features.values(&self.actor, state, &mut self.buffer);
        softmax(
            preferences,
            &self.ahead.advice,
            self.params.preference_clip,
            &mut self.ahead.probabilities,
        );
        self.ahead.stale = false;
        match self.params.bootstrap {
            Bootstrap::Sampled => {
                let next_action = action(sample(&self.ahead.probabilities, &mut self.rng));
                self.ahead.drawn = Some(next_action.0);
                self.features.value(&self.critic, state, next_action)
            }
            Bootstrap::Expected => expectation(
                &self.ahead.probabilities,
                self.features.values(&self.critic, state, &mut self.buffer),
            ),
        }
    }

    /// Brings `here` up to date with θ.
    #[inline]
    fn refresh_here(&mut self, state: StateId) {
        if self.here.stale {
            let preferences = self.features.values(&self.actor, state, &mut self.buffer);
            softmax(
                preferences,
                &self.here.advice,
                self.params.preference_clip,
                &mut self.here.probabilities,
            );
            self.here.stale = false;
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
        let (rate, clip) = (self.params.actor_learning_rate, self.params.preference_clip);
        for (b, &p) in self.here.probabilities.iter().enumerate() {
            let b = action(b);
            let gradient = if b == taken { 1.0 - p } else { -p };
            let preference = self.features.value(&self.actor, state, b);
            let target = clamp(preference + rate * signal * gradient, clip);
            self.features
                .step(&mut self.actor, state, b, target - preference);
        }
    }

    /// Q_w(s, a) − Σ_b π(b|s) Q_w(s, b).
    #[inline]
    fn advantage(&mut self, state: StateId, taken: Action) -> f64 {
        let values = self.features.values(&self.critic, state, &mut self.buffer);
        values[taken.index()] - expectation(&self.here.probabilities, values)
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
        if self.here.state == Some(state.0) {
            if let Some(drawn) = self.here.drawn {
                return Action(drawn); // a ← a′
            }
        }
        self.grow_to(state);
        if !self.here.describes(situation) {
            self.here.enter(situation);
        }
        self.refresh_here(state);
        let drawn = action(sample(&self.here.probabilities, &mut self.rng));
        self.here.drawn = Some(drawn.0);
        drawn
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let (s, a) = (experience.state, experience.action);
        let next = experience.next;
        self.grow_to(StateId(s.0.max(next.state.0)));
        if self.here.state != Some(s.0) {
            // A step that this agent did not choose: its policy there had no advice that we know of.
            self.here.enter(Situation {
                state: s,
                advice: next.advice,
            });
            self.here.advice.fill(0.0);
        }
        self.refresh_here(s);

        self.ahead.enter(next);
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

        self.ahead.stale |= F::GENERALISES || next.state == s;
        std::mem::swap(&mut self.here, &mut self.ahead);
        if experience.status.is_last() {
            self.here.state = None;
        }
        UpdateInfo { td_error }
    }

    fn set_features(&mut self, features: faer::MatRef<'_, f64>) {
        self.features
            .set_features(features, [&mut self.actor, &mut self.critic]);
        self.here.stale = true;
    }

    fn greedy_action(&self, state: StateId) -> Option<Action> {
        let weights = self.known(&self.actor, state)?;
        let mut buffer = vec![0.0; self.buffer.len()];
        first_best(self.features.values(weights, state, &mut buffer))
    }
}
