//! `eigentrail show --json`: a world, and what a run has learnt in it, for scripts that draw.

use super::BadInput;
use super::show::{folder_on, read, seed_folder};
use crate::cli;
use anyhow::Result;
use eigentrail::archive::RecordedSeed;
use eigentrail::env::{Model, TabularMdp};
use eigentrail::error::Error;
use eigentrail::scenario::{Actions, GoalSpec, Goals, Loaded, Names, Place, Scenario, World};
use serde::Serialize;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The document.
#[derive(Serialize)]
pub struct Sight<'a> {
    scenario: &'a str,
    /// `env.kind`.
    kind: &'static str,
    /// Of the map, if the world is drawn as one.
    rows: Option<usize>,
    cols: Option<usize>,
    /// A string for each row, as `env.map` writes it, with `X` for hazards.
    map: Option<Vec<String>>,
    /// Names of the actions by number.
    actions: Vec<&'a str>,
    states: Vec<State>,
    moved: Option<Moved>,
    #[serde(skip_serializing_if = "Option::is_none")]
    potential: Option<Vec<Potential>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    policy: Option<Vec<Greedy<'a>>>,
}

#[derive(Serialize)]
struct State {
    /// Its number here.
    state: usize,
    /// As files of runs name it: `row,col`, or a name.
    place: String,
    row: Option<usize>,
    col: Option<usize>,
    /// The chance that an episode begins here.
    start: f64,
    /// Whether episodes end here.
    end: bool,
    /// Whether they do because it is a goal.
    goal: bool,
    /// What a step that ends here pays, if that is always the same.
    reward: Option<f64>,
}

/// Goals that take the place of the first ones.
#[derive(Serialize)]
struct Moved {
    /// Episodes before the move.
    after: usize,
    /// Numbers of their states.
    goals: Vec<usize>,
}

#[derive(Serialize)]
struct Potential {
    state: usize,
    place: String,
    potential: f64,
}

#[derive(Serialize)]
struct Greedy<'a> {
    state: usize,
    place: String,
    visits: u64,
    /// None where nothing was learnt.
    action: Option<u16>,
    action_name: Option<&'a str>,
}

impl<'a> Sight<'a> {
    /// That of a scenario, with the potential and the policy of the runs that are asked for.
    pub fn of(args: &cli::Show, loaded: &'a Loaded) -> Result<Self> {
        let (scenario, world) = (&loaded.scenario, loaded.worlds.first());
        let states = states(scenario, world);
        let layout = match world {
            World::Grid(map) => Some(map.layout()),
            World::Listed(..) => None,
        };
        let moved = loaded.worlds.moved().map(|moved| Moved {
            after: moved.after,
            goals: goals(scenario.env.moved_goals.as_deref(), &moved.world),
        });
        let mut sight = Self {
            scenario: &scenario.name,
            kind: scenario.env.kind.name(),
            rows: layout.map(|layout| layout.rows()),
            cols: layout.map(|layout| layout.cols()),
            map: layout.map(|layout| layout.to_string().lines().map(str::to_owned).collect()),
            actions: world.action_names(),
            states,
            moved,
            potential: None,
            policy: None,
        };
        let folder = |run: &Path| match world {
            World::Grid(_) => folder_on(loaded, run),
            World::Listed(..) => seed_folder(run),
        };
        if let Some(run) = &args.potential {
            sight.potential = Some(sight.potential(&folder(run)?)?);
        }
        if let Some(run) = &args.policy {
            sight.policy = Some(sight.policy(&folder(run)?)?);
        }
        Ok(sight)
    }

    fn potential(&self, folder: &Path) -> Result<Vec<Potential>> {
        let number = self.numbers(folder);
        let rows = read(folder)?.into_iter().map(|(place, potential)| {
            Ok(Potential {
                state: number(&place)?,
                place,
                potential,
            })
        });
        rows.collect()
    }

    fn policy(&self, folder: &Path) -> Result<Vec<Greedy<'a>>> {
        let seed = RecordedSeed::read_sights(folder, 0).map_err(Error::from)?;
        let number = self.numbers(folder);
        let name = |action: u16| self.actions.get(usize::from(action)).copied();
        let rows = seed.labels.iter().zip(&seed.policy).map(|(place, row)| {
            let action = row.greedy.filter(|_| row.visits > 0);
            Ok(Greedy {
                state: number(place)?,
                place: place.clone(),
                visits: row.visits,
                action,
                action_name: action.and_then(name),
            })
        });
        rows.collect()
    }

    /// The number of a state by its place; refused if a run is of another world.
    fn numbers(&self, folder: &Path) -> impl Fn(&str) -> Result<usize> + use<'_, 'a> {
        let states = self.states.iter();
        let numbers: HashMap<&str, usize> = states.map(|s| (s.place.as_str(), s.state)).collect();
        let folder: PathBuf = folder.to_owned();
        move |place| match numbers.get(place) {
            Some(&number) => Ok(number),
            None => Err(BadInput(format!(
                "{}: the run is of another world: it has no state {place}",
                folder.display()
            ))
            .into()),
        }
    }
}

/// Every state of the world, by number.
fn states(scenario: &Scenario, world: &World) -> Vec<State> {
    let mdp = mdp(world);
    let mut start = vec![0.0; mdp.num_states()];
    for (&state, chance) in world.start_distribution().chances() {
        start[state] += chance;
    }
    let rewards = rewards_at_ends(&mdp);
    let listed = match &scenario.env.goals {
        Some(Goals::Listed(goals)) => Some(goals.as_slice()),
        _ => None,
    };
    let mut is_goal = vec![false; mdp.num_states()];
    for goal in goals(listed, world) {
        is_goal[goal] = true;
    }
    let places = places(world);
    let turns = scenario.env.actions == Some(Actions::Turns);
    let has_position = turns || matches!(world, World::Grid(_));
    let states = places.into_iter().enumerate().map(|(state, place)| {
        let mut position = place.split(',').map_while(|number| number.parse().ok());
        let (row, col) = match has_position {
            true => (position.next(), position.next()),
            false => (None, None),
        };
        State {
            state,
            row,
            col,
            start: start[state],
            end: mdp.is_terminal(state),
            goal: is_goal[state],
            reward: rewards[state],
            place,
        }
    });
    states.collect()
}

/// Names of the states as files of runs have them.
fn places(world: &World) -> Vec<String> {
    match world {
        World::Grid(map) => {
            let positions = map.mdp_cells().map(|cell| map.layout().position(cell));
            positions.map(|(row, col)| format!("{row},{col}")).collect()
        }
        World::Listed(_, names) => names.states.clone(),
    }
}

fn mdp(world: &World) -> Cow<'_, TabularMdp> {
    match world {
        World::Grid(map) => Cow::Owned(map.to_mdp()),
        World::Listed(world, _) => Cow::Borrowed(world.mdp()),
    }
}

/// Numbers of the goals: those of a map, those of an edge list that are `listed`, and elsewhere every end.
fn goals(listed: Option<&[GoalSpec]>, world: &World) -> Vec<usize> {
    let names_goal = |name: &str| {
        let goals = listed.into_iter().flatten();
        let places = goals.map(|goal| &goal.at);
        let named = places.filter(|at| matches!(at, Place::Named(goal) if goal.trim() == name));
        named.count() > 0
    };
    match world {
        World::Grid(map) => {
            let cells = map.mdp_cells().enumerate();
            let goals = cells.filter(|&(_, cell)| map.layout().is_goal(cell));
            goals.map(|(state, _)| state).collect()
        }
        World::Listed(world, Names { states: names, .. }) => {
            let are_named = names.iter().any(|name| names_goal(name));
            let states = (0..names.len()).filter(|&state| match are_named {
                true => names_goal(&names[state]),
                false => world.mdp().is_terminal(state),
            });
            states.collect()
        }
    }
}

/// What a step into each end pays; none where that differs, or where nothing ends.
fn rewards_at_ends(mdp: &TabularMdp) -> Vec<Option<f64>> {
    let mut rewards: Vec<Option<f64>> = vec![None; mdp.num_states()];
    let mut differs = vec![false; mdp.num_states()];
    for state in 0..mdp.num_states() {
        for action in mdp.actions() {
            for outcome in mdp.outcomes(state, action) {
                let end = outcome.next as usize;
                let reward = *rewards[end].get_or_insert(outcome.reward);
                differs[end] |= reward != outcome.reward;
            }
        }
    }
    let is_told = |state: usize| mdp.is_terminal(state) && !differs[state];
    let rewards = rewards.into_iter().enumerate();
    rewards
        .map(|(state, reward)| reward.filter(|_| is_told(state)))
        .collect()
}
