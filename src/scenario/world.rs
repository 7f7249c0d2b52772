//! From the section `[env]` to a world one can act in.

use super::Scenario;
use super::env::{Actions, EnvKind, EnvParams, GoalList};
use super::error::BrokenRule;
use super::magnitude::Extent;
use super::place::{MoveAfter, Place};
use super::start::Start;
use crate::env::{
    Board, Caution, EdgeList, EdgeListGoal, EdgeListParams, EdgeListStart, GridWorld, Model,
    Optimum, Starts, TabularEnvironment, TabularMdp, Unmeasured, boards,
};
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;

/// Any world that a scenario can describe.
#[derive(Clone, Debug)]
pub enum World {
    /// A map.
    Grid(GridWorld),
    /// An edge list, a board of the field, or a map for a walker that turns, with the names of what is in it.
    Listed(TabularEnvironment, Names),
}

/// Names of a world's states and actions, by their numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Names {
    /// Those of the states.
    pub states: Vec<String>,
    /// Those of the actions.
    pub actions: Vec<String>,
}

impl Names {
    fn new(states: Vec<String>, actions: &[&str]) -> Self {
        let actions = actions.iter().map(|&name| name.to_owned()).collect();
        Self { states, actions }
    }
}

/// A world whose goals have moved.
#[derive(Clone, Debug)]
pub struct MovedWorld {
    /// After how many episodes they do.
    pub after: usize,
    /// The world from then on.
    pub world: World,
}

impl Scenario {
    /// The world, with the goals that a run begins with; `seed` is the run's and draws slips, random starts and a random
    /// goal. O(states).
    ///
    /// # Errors
    /// If the section `[env]` does not describe one, with the key to blame.
    pub fn world(&self, seed: u64) -> Result<World, BrokenRule> {
        let list = self.env.edge_list()?;
        self.first_world(list.as_ref(), seed)
    }

    /// The same with the edge list read already, if there is one.
    pub(super) fn first_world(
        &self,
        list: Option<&EdgeList>,
        seed: u64,
    ) -> Result<World, BrokenRule> {
        let episodes = self.run.episodes;
        self.env.world(list, GoalList::First, seed, episodes)
    }

    /// The same world with the goals that a run ends with; none if they do not move. Its states are those of
    /// [`Self::world`], with the same numbers.
    ///
    /// # Errors
    /// As [`Self::world`], and if the goals move nowhere or never.
    pub fn moved_world(&self, seed: u64) -> Result<Option<MovedWorld>, BrokenRule> {
        if self.goals_move_after().is_none() {
            return Ok(None);
        }
        let list = self.env.edge_list()?;
        self.world_after_move(list.as_ref(), seed)
    }

    /// The same with the edge list read already, if there is one.
    pub(super) fn world_after_move(
        &self,
        list: Option<&EdgeList>,
        seed: u64,
    ) -> Result<Option<MovedWorld>, BrokenRule> {
        let Some(after) = self.goals_move_after() else {
            return Ok(None);
        };
        if GoalList::First.of(&self.env) == self.env.moved_goals.as_deref() {
            return Err(BrokenRule::new(
                GoalList::Moved.key(),
                "env.moved_goals = env.goals: the goals would not move",
            )
            .beside(&[GoalList::First.key()]));
        }
        if after >= self.run.episodes && self.env.goals_move_after != Some(MoveAfter::Half) {
            return Err(BrokenRule::new(
                "env.goals_move_after",
                format!(
                    "env.goals_move_after = {after}, but the run has {} episodes: the goals would never move",
                    self.run.episodes
                ),
            )
            .beside(&["run.episodes", GoalList::Moved.key()]));
        }
        let episodes = self.run.episodes;
        let world = self.env.world(list, GoalList::Moved, seed, episodes)?;
        Ok(Some(MovedWorld { after, world }))
    }

    /// The world in which episode number `episode`, from 0, is played.
    ///
    /// # Errors
    /// As [`Self::moved_world`].
    pub fn world_in(&self, seed: u64, episode: usize) -> Result<World, BrokenRule> {
        match self.moved_world(seed)? {
            Some(moved) if moved.after <= episode => Ok(moved.world),
            _ => self.world(seed),
        }
    }

    /// The number of episodes before the goals move; none if they do not.
    pub fn goals_move_after(&self) -> Option<usize> {
        let after = self.env.goals_move_after.unwrap_or_default();
        let moves = self.env.moved_goals.is_some();
        moves.then(|| after.resolved(self.run.episodes))
    }
}

impl EnvParams {
    /// The world with these goals, for a run of `episodes` with this seed, on an edge list or, without one, on a map.
    fn world(
        &self,
        list: Option<&EdgeList>,
        goals: GoalList,
        seed: u64,
        episodes: usize,
    ) -> Result<World, BrokenRule> {
        self.check_rewards(goals)?;
        let rng = match goals {
            GoalList::First => stream(seed, Stream::Environment),
            GoalList::Moved => stream(seed, Stream::MovedEnvironment),
        };
        let world = match (list, self.board(goals)?) {
            (Some(list), _) => self.listed(list, goals, rng)?,
            (None, Some(board)) => {
                let max_steps = self.max_steps.given();
                let world = match self.continuing {
                    true => board.continuing(max_steps, rng),
                    false => board.environment(max_steps, rng),
                };
                let world = world.map_err(|e| self.blame(e, goals))?;
                let names = Names::new(board.state_names().to_vec(), board.action_names());
                World::Listed(world, names)
            }
            (None, None) => {
                let layout = self.layout(goals, seed)?;
                let map = GridWorld::new(layout, self.grid_world_params(), rng);
                let map = map.map_err(|e| self.blame(e, goals))?;
                match self.actions.unwrap_or_default() {
                    Actions::Moves => World::Grid(map),
                    Actions::Turns => {
                        let world = map.turning().map_err(|e| self.blame(e, goals))?;
                        let actions = &GridWorld::TURNING_ACTION_NAMES;
                        World::Listed(world, Names::new(map.turning_names(), actions))
                    }
                }
            }
        };
        let extent = Extent {
            episodes,
            max_steps: world.max_steps(),
        };
        self.check_reward_sizes(goals, list, extent)?;
        Ok(world)
    }

    /// Reads the edge list of a world that is one.
    pub(super) fn edge_list(&self) -> Result<Option<EdgeList>, BrokenRule> {
        if self.kind != EnvKind::EdgeList {
            return Ok(None);
        }
        let path = self.file.as_deref().unwrap_or("".as_ref());
        let list = EdgeList::read(path).map_err(|e| self.blame(e, GoalList::First))?;
        Ok(Some(list))
    }

    /// The board of the field, of a world that is one.
    fn board(&self, goals: GoalList) -> Result<Option<Board>, BrokenRule> {
        let size = self.size.unwrap_or_default();
        let board = match self.kind {
            EnvKind::DeepSea => {
                let rng = &mut stream(self.seed.unwrap_or_default(), Stream::Layout);
                match self.stochastic.unwrap_or_default() {
                    true => boards::stochastic_deep_sea(size, rng),
                    false => boards::deep_sea(size, rng),
                }
            }
            EnvKind::RiverSwim => boards::river_swim(size),
            EnvKind::Cliff => boards::cliff_walking(),
            EnvKind::FrozenLake => boards::frozen_lake(size),
            EnvKind::Taxi => boards::taxi(),
            EnvKind::Bridge => boards::bridge(self.fall.unwrap_or_default()),
            _ => return Ok(None),
        };
        board.map(Some).map_err(|e| self.blame(e, goals))
    }

    fn listed(
        &self,
        list: &EdgeList,
        goals: GoalList,
        rng: ChaCha8Rng,
    ) -> Result<World, BrokenRule> {
        let names = Names {
            states: list.state_names().map(str::to_owned).collect(),
            actions: list.action_names().map(str::to_owned).collect(),
        };
        let params = self.edge_list_params(list, &names.states[0], goals)?;
        let world = list.environment(&params, rng);
        let world = world.map_err(|e| self.blame(e, goals))?;
        Ok(World::Listed(world, names))
    }

    /// The numbers that an edge list needs to become a world; it starts in `first` unless told otherwise. A state that is
    /// called "random" is a state: only where there is none does the word mean random starts.
    fn edge_list_params(
        &self,
        list: &EdgeList,
        first: &str,
        which: GoalList,
    ) -> Result<EdgeListParams, BrokenRule> {
        let mut drawn_starts = Vec::new();
        let start = match &self.start {
            None => Some(first.to_owned()),
            Some(Start::At(place)) => match state_name("env.start", place, list) {
                Err(_) if self.starts_anywhere() => None,
                named => Some(named?),
            },
            Some(Start::Drawn(starts)) => {
                for (i, start) in starts.iter().enumerate() {
                    drawn_starts.push(EdgeListStart {
                        at: state_name(&format!("env.start[{i}].at"), &start.at, list)?,
                        weight: start.weight,
                    });
                }
                None
            }
        };
        let goals = which.of(self).into_iter().flatten().enumerate();
        let goals = goals.map(|(i, goal)| {
            Ok(EdgeListGoal {
                at: state_name(&format!("{}[{i}].at", which.key()), &goal.at, list)?,
                reward: goal.reward,
            })
        });
        Ok(EdgeListParams {
            start,
            drawn_starts,
            goals: goals.collect::<Result<_, BrokenRule>>()?,
            continuing: self.continuing,
            rewards: self.reward,
            max_steps: self.max_steps.given(),
        })
    }
}

/// A state of an edge list; spaces around names do not count, as in the file.
fn state_name(key: &str, place: &Place, list: &EdgeList) -> Result<String, BrokenRule> {
    match place {
        Place::Named(name) => match list.state(name.trim()) {
            Ok(_) => Ok(name.trim().to_owned()),
            Err(unknown) => {
                let broken = BrokenRule::new(key, unknown.to_string());
                Err(broken.beside(&["env.kind", "env.file"]))
            }
        },
        Place::Cell(_) => Err(BrokenRule::new(
            key,
            format!("{place} is a place on a map; an edge list has names"),
        )
        .beside(&["env.kind"])),
    }
}

impl World {
    /// Draws slips and random starts from `rng` from now on.
    pub(super) fn reseed(&mut self, rng: ChaCha8Rng) {
        match self {
            World::Grid(world) => world.reseed(rng),
            World::Listed(world, _) => world.reseed(rng),
        }
    }

    /// Number of actions in every state.
    pub fn num_actions(&self) -> usize {
        use crate::env::Environment;
        match self {
            World::Grid(world) => world.num_actions(),
            World::Listed(world, _) => world.num_actions(),
        }
    }

    /// Names of the actions, in the order of their numbers.
    pub fn action_names(&self) -> Vec<&str> {
        match self {
            World::Grid(_) => GridWorld::ACTION_NAMES.to_vec(),
            World::Listed(_, names) => names.actions.iter().map(String::as_str).collect(),
        }
    }

    /// States there are, and states that can be reached from where episodes begin. O(states × actions).
    pub fn num_states(&self) -> (usize, usize) {
        let starts = self.start_distribution();
        let mdp = match self {
            World::Grid(world) => world.to_mdp(),
            World::Listed(world, _) => world.to_mdp(),
        };
        let reached = mdp.reachable_from(starts.places());
        (mdp.num_states(), reached.iter().filter(|&&r| r).count())
    }

    /// Where episodes may begin, by the numbers of the states, with the chance of each.
    pub fn start_distribution(&self) -> Starts {
        match self {
            World::Grid(world) => world.start_distribution(),
            World::Listed(world, _) => world.start_distribution(),
        }
    }

    /// After how many steps an episode is cut off.
    pub fn max_steps(&self) -> usize {
        match self {
            World::Grid(world) => Model::max_steps(world),
            World::Listed(world, _) => Model::max_steps(world),
        }
    }

    /// What the best policy earns in an episode and how long it takes.
    pub fn optimum(&self) -> Optimum {
        match self {
            World::Grid(world) => world.optimum(),
            World::Listed(world, _) => world.optimum(),
        }
    }

    /// Of a continuing task, what the best policy earns a step.
    pub fn optimal_gain(&self) -> Option<f64> {
        match self {
            World::Grid(world) => world.optimal_gain(),
            World::Listed(world, _) => world.optimal_gain(),
        }
    }

    /// Steps between the two states that are farthest from each other, or in words why there is no number; see
    /// [`TabularMdp::diameter`](crate::env::TabularMdp::diameter).
    pub fn diameter(&self) -> Result<f64, String> {
        self.measure(|mdp, starts| mdp.diameter(starts))
    }

    /// Σ 1 / (V* − Q*) with this discount, or in words why there is no number; see
    /// [`TabularMdp::sum_of_inverse_gaps`](crate::env::TabularMdp::sum_of_inverse_gaps).
    pub fn sum_of_inverse_gaps(&self, gamma: f64) -> Result<f64, String> {
        self.measure(|mdp, starts| mdp.sum_of_inverse_gaps(starts.places(), gamma))
    }

    fn measure(
        &self,
        measure: impl Fn(&TabularMdp, &Starts) -> Result<f64, Unmeasured>,
    ) -> Result<f64, String> {
        let starts = self.start_distribution();
        let measured = match self {
            World::Grid(world) => measure(&world.to_mdp(), &starts),
            World::Listed(world, _) => measure(world.mdp(), &starts),
        };
        measured.map_err(|why| why.message(|state| self.state_name(state)))
    }

    /// The name of a state, by its number in the MDP.
    fn state_name(&self, state: usize) -> String {
        match self {
            World::Grid(world) => {
                let cell = world.mdp_cells().nth(state).expect("a state of this world");
                let (row, col) = world.layout().position(cell);
                format!("[{row}, {col}]")
            }
            World::Listed(_, names) => format!("{:?}", names.states[state]),
        }
    }

    /// What its author may not have meant, in words; see [`TabularMdp::cautions`](crate::env::TabularMdp::cautions) for the
    /// cost. Nothing of a continuing task: it has no ends to miss, and is meant to pay for ever.
    pub fn cautions(&self) -> Vec<String> {
        fn of<E: Model>(world: &E) -> Vec<Caution> {
            if world.optimal_gain().is_some() {
                return Vec::new();
            }
            let mdp = world.to_mdp();
            mdp.cautions(world.start_distribution(), world.max_steps())
        }
        let cautions = match self {
            World::Grid(world) => of(world),
            World::Listed(world, _) => of(world),
        };
        let name = |state| self.state_name(state);
        cautions.iter().map(|c| c.message(name)).collect()
    }
}
