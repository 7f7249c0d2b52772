//! One explorer on a [`WorldModel`]: where it stands, what it is paid, what it is advised.
//!
//! ```text
//! R′ = R + F,    F_t = γ φ_{t+1}(s_{t+1}) − φ_t(s_t)                      (eq. 3 and 4 of the source paper)
//! ```
//!
//! Several walkers may stand on one model: what one of them finds, all of them know.

use super::error::PipelineError;
use super::record::RefreshRecord;
use super::returns::Trajectory;
use super::world_model::WorldModel;
use crate::env::{Action, Step};
use crate::exploration::Explorer;
use crate::graph::StateId;
use crate::shaping::{Potential, RewardShaper};
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// State of one explorer: its place, the potential it entered with, its plan and its random stream.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Walker {
    state: StateId,
    start: StateId,
    /// Steps of the episode so far.
    age: u32,
    in_episode: bool,
    shaper: RewardShaper,
    trajectory: Trajectory,
    explorer: Explorer,
    /// For `state`.
    advice: Vec<f64>,
}

/// Meaning of one step.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The number of the state that was reached.
    pub state: StateId,
    /// F = γ φ(s′) − φ(s), to be added to the reward; 0 without shaping.
    pub shaping: f64,
    /// Reward for novelty under `count-bonus`, else 0. Not potential-based.
    pub bonus: f64,
    /// The state was not known before.
    pub new_state: bool,
    /// A goal was entered while none was known: the first one, or the first after the last one was lost.
    pub first_goal: bool,
    /// The state was a goal until now, and the episode went on: the goal is forgotten.
    pub lost_goal: bool,
    /// The spectrum or the potential was brought up to date.
    pub refresh: Option<Box<RefreshRecord>>,
}

impl Walker {
    /// A walker on `world` that stands nowhere yet. Walkers of different numbers draw from different random streams.
    pub fn new<S: Clone + Eq + Hash>(world: &WorldModel<S>, number: u32) -> Self {
        let num_actions = world.transitions().num_actions();
        Self {
            state: StateId(0),
            start: StateId(0),
            age: 0,
            in_episode: false,
            shaper: RewardShaper::new(world.gamma()),
            trajectory: Trajectory::default(),
            explorer: Explorer::new(world.exploration_stream(number)),
            advice: vec![0.0; num_actions],
        }
    }

    /// Begins an episode in `start`, returns its number. An episode under way is abandoned.
    ///
    /// O(1), but O(states + transitions) with the `frontier` exploration if the start is another one than last time.
    pub fn begin_episode<S: Clone + Eq + Hash>(
        &mut self,
        world: &mut WorldModel<S>,
        start: &S,
    ) -> StateId {
        let state = world.intern(start);
        self.start = state;
        self.state = state;
        self.age = 0;
        world.meet(state, 0);
        self.in_episode = true;
        self.trajectory.begin();
        self.shaper.begin_episode(world.potential().value(state));
        if let Some((exploration, graph)) = world.exploration() {
            self.explorer.begin_episode(exploration, graph, state);
        }
        self.update_advice(world);
        state
    }

    /// Takes in one step from the present state and returns what it was worth.
    ///
    /// O(1) among known states, plus the refreshes that the schedule asks for. Without them, and with no state or
    /// transition that is new, it allocates nothing; but where moves slip, the frontier exploration looks over all
    /// transitions each time that the steps have grown by a sixteenth.
    ///
    /// # Errors
    /// If the reward is not finite, the action does not exist or no episode is under way, and then nothing has changed.
    /// If the spectrum or the potential cannot be computed: the transition is then known, φ is as it was, and the episode
    /// is closed, so that nothing can be learnt from a place where the walker does not stand.
    #[inline]
    pub fn observe<S: Clone + Eq + Hash>(
        &mut self,
        world: &mut WorldModel<S>,
        action: Action,
        step: &Step<S>,
    ) -> Result<Observed, PipelineError> {
        if !self.in_episode {
            return Err(PipelineError::NoEpisode {
                step: world.steps(),
            });
        }
        let recorded = world.record(self.state, action, step)?;
        let next = recorded.step.to;
        let terminated = recorded.step.terminated;
        if let Some((exploration, graph)) = world.exploration() {
            self.explorer.learn(exploration, graph, recorded.step);
        }
        let none_known = world.goals().is_empty();
        let lost_goal = !terminated && world.forget_goal(next, step.reward);
        if lost_goal {
            self.explorer.lose_goal();
        }
        self.age = self.age.saturating_add(1);
        world.meet(next, self.age);
        world.count(self.start, next, step);
        world.count_returns(&mut self.trajectory, self.state, step);
        let first_goal = none_known && !world.goals().is_empty();
        let refresh = match world.refresh_if_due(step.status.is_last()) {
            Ok(refresh) => refresh,
            Err(error) => {
                self.close_episode(next);
                return Err(error);
            }
        };
        let shaping = self
            .shaper
            .shape(world.potential().value(next), step.status);
        let bonus = world.count_bonus(next);
        self.state = next;
        self.in_episode = !step.status.is_last();
        if terminated {
            self.advice.fill(0.0);
        } else {
            self.update_advice(world);
        }
        Ok(Observed {
            state: next,
            shaping,
            bonus,
            new_state: recorded.new_state,
            first_goal,
            lost_goal,
            refresh,
        })
    }

    /// The number of the state where it stands; 0 before the first episode.
    pub fn state(&self) -> StateId {
        self.state
    }

    /// Whether an episode is under way.
    pub fn is_in_episode(&self) -> bool {
        self.in_episode
    }

    /// Advice for the present state, one logit per action; all 0 without the `frontier` exploration, and after
    /// termination. After truncation it is that of the last state, whose value still counts.
    pub fn advice(&self) -> &[f64] {
        &self.advice
    }

    fn close_episode(&mut self, state: StateId) {
        self.state = state;
        self.in_episode = false;
        self.advice.fill(0.0);
    }

    fn update_advice<S: Clone + Eq + Hash>(&mut self, world: &mut WorldModel<S>) {
        world.advise(&mut self.explorer, self.state, &mut self.advice);
    }
}
