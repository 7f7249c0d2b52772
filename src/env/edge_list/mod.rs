//! Any finite MDP or graph from a CSV file.
//!
//! ```text
//! from,action,to,probability,reward
//! hall,north,kitchen,0.9,-1
//! hall,north,hall,0.1,-1
//! kitchen,south,hall,1,-2
//! ```
//!
//! - States and actions are any names; both are numbered in order of appearance.
//! - The column `action` may be left out, with `probability`: then each line is an action of its own, which is called by its
//!   number among the lines of its state, from 0 in the order of the file, and is sure to lead where the line says.
//! - `probability` may be left out, for the whole file or for all lines of one (from, action): these then share equally. Given
//!   ones must sum to 1.
//! - `reward` may be left out, for the whole file or on a line: the step then pays what the [`RewardScheme`] says, with
//!   the bonus on entering a goal. A number in the file is the whole reward of that line, so that a goal with a
//!   [`reward`](EdgeListGoal::reward) of its own needs lines without one.
//! - An action that a state has no line for leaves the agent where it is, at the reward of a step.
//! - Episodes end at goals, so lines that leave a goal have no effect. A continuing task has no goals.

mod parse;
mod quotes;

use super::error::nearest;
use super::grid_world::{RewardScheme, require_finite, require_weight};
use super::tabular::{Outcome, TabularEnvironment, TabularMdp};
use super::{Action, EnvError, Starts};
use indexmap::IndexSet;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A goal by the name of its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeListGoal {
    /// Name of the state.
    pub at: String,
    /// Added to the reward of a step that enters it. The file must not say itself what such steps pay. Default: what the
    /// reward scheme gives every goal, on lines without a reward.
    #[serde(default)]
    pub reward: Option<f64>,
}

/// One of several starts, by the name of its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EdgeListStart {
    /// Name of the state.
    pub at: String,
    /// How often episodes begin there, beside the weights of the others; finite and above 0.
    pub weight: f64,
}

/// Parameters that make a world of an [`EdgeList`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EdgeListParams {
    /// Name of the start; `None`: anywhere from where a goal can be reached, or anywhere at all if `continuing`.
    pub start: Option<String>,
    /// Without `start`: states of which one is drawn for each episode; none for those of `None` above.
    pub drawn_starts: Vec<EdgeListStart>,
    /// Where episodes end; none if `continuing`.
    pub goals: Vec<EdgeListGoal>,
    /// Whether nothing ever ends or begins anew; see [`TabularEnvironment::continuing`].
    pub continuing: bool,
    /// What a line without a reward pays.
    pub rewards: RewardScheme,
    /// After how many steps an episode is truncated; `None`: ten times the number of states.
    pub max_steps: Option<usize>,
}

/// The contents of an edge list.
#[derive(Clone, Debug)]
pub struct EdgeList {
    /// The file's name, for messages.
    file: String,
    states: IndexSet<String>,
    actions: IndexSet<String>,
    /// Sorted by (from, action), in the order of the file within each.
    edges: Vec<Edge>,
    /// Line and reward of the largest size, and of the smallest but 0, if a line gives one.
    largest: Option<(u64, f64)>,
    smallest: Option<(u64, f64)>,
}

/// One line, with its probability filled in.
#[derive(Clone, Debug)]
struct Edge {
    from: u32,
    action: u16,
    to: u32,
    probability: f64,
    reward: Option<f64>,
}

impl EdgeList {
    /// Names of the states, in the order of their numbers.
    pub fn state_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.states.iter().map(String::as_str)
    }

    /// Names of the actions, in the order of their numbers.
    pub fn action_names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.actions.iter().map(String::as_str)
    }

    /// The file's name.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The reward of the largest size and that of the smallest but 0, each with its first line, if the file gives any.
    pub fn extreme_rewards(&self) -> impl Iterator<Item = (u64, f64)> {
        self.largest.into_iter().chain(self.smallest)
    }

    /// The number of the state called `name`.
    ///
    /// # Errors
    /// [`EnvError::UnknownState`], which names the closest one there is.
    pub fn state(&self, name: &str) -> Result<usize, EnvError> {
        self.states
            .get_index_of(name)
            .ok_or_else(|| EnvError::UnknownState {
                file: self.file.clone(),
                name: name.to_owned(),
                nearest: nearest(name, self.state_names()),
            })
    }

    /// The world with these goals; its state numbers are the order of [`state_names`](Self::state_names). O(lines).
    ///
    /// # Errors
    /// Unknown names, no goal, what is wrong with a continuing task, a goal twice or out of reach, start and goal the same, rewards that are not finite, pay for
    /// staying away or are for no line of the file, no steps.
    pub fn environment(
        &self,
        params: &EdgeListParams,
        rng: ChaCha8Rng,
    ) -> Result<TabularEnvironment, EnvError> {
        params.rewards.validate()?;
        let goals = self.goals(params)?;
        self.require_use(params, &goals)?;
        let mdp = self.mdp(params, &goals)?;
        let starts = self.starts(params, &goals, &mdp)?;
        let max_steps = params
            .max_steps
            .unwrap_or_else(|| self.states.len().saturating_mul(10));
        let world = TabularEnvironment::new(mdp, starts, max_steps, rng)?;
        match params.continuing {
            true => world.continuing(|state| self.states[state].clone()),
            false => Ok(world),
        }
    }

    /// The goals' state numbers, in the order given.
    fn goals(&self, params: &EdgeListParams) -> Result<Vec<usize>, EnvError> {
        if params.goals.is_empty() && !params.continuing {
            return Err(EnvError::NoGoal);
        }
        let mut goals = Vec::with_capacity(params.goals.len());
        for goal in &params.goals {
            let state = self.state(&goal.at)?;
            require_finite(
                &format!("the goal {:?}", goal.at),
                goal.reward.unwrap_or(0.0),
            )?;
            if goals.contains(&state) {
                return Err(EnvError::DuplicateGoal {
                    place: format!("{:?}", goal.at),
                });
            }
            goals.push(state);
        }
        Ok(goals)
    }

    fn mdp(&self, params: &EdgeListParams, goals: &[usize]) -> Result<TabularMdp, EnvError> {
        let step = params.rewards.step();
        let mut terminal = vec![false; self.states.len()];
        let mut on_entering = vec![step; self.states.len()];
        for (goal, &state) in params.goals.iter().zip(goals) {
            terminal[state] = true;
            on_entering[state] = step + goal.reward.unwrap_or(params.rewards.goal());
        }
        // Edges and calls come in the same order, so one pass over the edges is enough.
        let mut rest = self.edges.as_slice();
        TabularMdp::from_fn(self.actions.len(), terminal, |state, action, outcomes| {
            let key = (state as u32, action);
            rest = &rest[rest.partition_point(|edge| edge.pair() < key)..];
            let (these, others) = rest.split_at(rest.partition_point(|edge| edge.pair() == key));
            rest = others;
            outcomes.extend(these.iter().map(|edge| edge.outcome(&on_entering)));
            if these.is_empty() {
                outcomes.push(Outcome {
                    next: state as u32,
                    probability: 1.0,
                    reward: step,
                });
            }
        })
    }

    /// Refuses rewards that the file leaves no room for: of a goal, where the file says otherwise of any step into it; of
    /// the reward scheme, where it says otherwise of all steps. Numbers that change nothing, those of the default scheme
    /// included, are never held against anyone.
    fn require_use(&self, params: &EdgeListParams, goals: &[usize]) -> Result<(), EnvError> {
        let leaves_a_goal = |edge: &&Edge| goals.contains(&(edge.from as usize));
        let played: Vec<&Edge> = self.edges.iter().filter(|e| !leaves_a_goal(e)).collect();
        let steps_into = |state: usize| played.iter().filter(move |e| e.to as usize == state);
        for (goal, (spec, &state)) in params.goals.iter().zip(goals).enumerate() {
            let own = spec.reward.unwrap_or(0.0);
            let said = steps_into(state).find(|edge| own != 0.0 && edge.reward.is_some());
            if let Some(edge) = said {
                return Err(EnvError::GoalRewardUnused {
                    file: self.file.clone(),
                    goal,
                    name: spec.at.clone(),
                    reward: own,
                    from: self.states[edge.from as usize].clone(),
                    action: self.actions[usize::from(edge.action)].clone(),
                });
            }
        }
        let (scheme, default) = (params.rewards, RewardScheme::default());
        let unused = |what: String| {
            Err(EnvError::RewardUnused {
                file: self.file.clone(),
                what,
            })
        };
        let mut pairs: Vec<_> = played.iter().map(|edge| edge.pair()).collect();
        pairs.dedup();
        let all_listed = pairs.len() == (self.states.len() - goals.len()) * self.actions.len();
        let all_said = played.iter().all(|edge| edge.reward.is_some());
        if scheme.step() != default.step() && all_listed && all_said {
            return unused(format!("step = {}", scheme.step()));
        }
        let of_the_scheme = params.goals.iter().zip(goals);
        let mut of_the_scheme = of_the_scheme
            .filter(|(goal, _)| goal.reward.is_none())
            .peekable();
        let given = scheme.goal() != default.goal() && of_the_scheme.peek().is_some();
        let pays_it = |(_, &state): (_, &usize)| steps_into(state).any(|e| e.reward.is_none());
        if given && !of_the_scheme.any(pays_it) {
            return unused(format!("the bonus of a goal, {},", scheme.goal()));
        }
        Ok(())
    }

    fn starts(
        &self,
        params: &EdgeListParams,
        goals: &[usize],
        mdp: &TabularMdp,
    ) -> Result<Starts, EnvError> {
        let starts = match &params.start {
            Some(name) => {
                let start = self.state(name)?;
                if goals.contains(&start) {
                    return Err(EnvError::StartIsGoal {
                        place: format!("{name:?}"),
                    });
                }
                Starts::from(&[start])
            }
            None if !params.drawn_starts.is_empty() => self.drawn_starts(params, goals, mdp)?,
            None if params.continuing => Starts::equally_likely((0..mdp.num_states()).collect()),
            None => {
                let distances = mdp.distances_to_terminal();
                let leads_to_goal =
                    |&state: &usize| distances[state].is_some_and(|transitions| transitions > 0);
                Starts::equally_likely((0..mdp.num_states()).filter(leads_to_goal).collect())
            }
        };
        let reached = mdp.reachable_from(starts.places());
        let unreached = params
            .goals
            .iter()
            .zip(goals)
            .find(|&(_, &state)| !reached[state]);
        match unreached {
            None => Ok(starts),
            Some((goal, _)) => Err(EnvError::GoalUnreachable {
                goal: format!("{:?}", goal.at),
                start: params
                    .start
                    .as_ref()
                    .map_or("any start".to_owned(), |name| format!("the start {name:?}")),
            }),
        }
    }
}

impl EdgeList {
    /// The starts that are listed. Each must lead to a goal, if there are any.
    fn drawn_starts(
        &self,
        params: &EdgeListParams,
        goals: &[usize],
        mdp: &TabularMdp,
    ) -> Result<Starts, EnvError> {
        let distances = mdp.distances_to_terminal();
        let mut drawn: Vec<(usize, f64)> = Vec::with_capacity(params.drawn_starts.len());
        for start in &params.drawn_starts {
            let (state, place) = (self.state(&start.at)?, format!("{:?}", start.at));
            require_weight(&place, start.weight)?;
            if goals.contains(&state) {
                return Err(EnvError::StartIsGoal { place });
            }
            if drawn.iter().any(|(earlier, _)| *earlier == state) {
                return Err(EnvError::DuplicateStart { place });
            }
            if distances[state].is_none() && !params.continuing {
                return Err(EnvError::StartLeadsNowhere { place });
            }
            drawn.push((state, start.weight));
        }
        Ok(Starts::weighted(drawn))
    }
}

impl Edge {
    fn pair(&self) -> (u32, Action) {
        (self.from, Action(self.action))
    }

    /// `on_entering` is what a step to each state pays by the scheme.
    fn outcome(&self, on_entering: &[f64]) -> Outcome {
        let reward = self.reward.unwrap_or(on_entering[self.to as usize]);
        Outcome {
            next: self.to,
            probability: self.probability,
            reward,
        }
    }
}
