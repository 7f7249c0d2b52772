//! For the tests: an agent that does as the explorer says.

use super::{Destination, ExplorationModel, Explorer, RecordedStep};
use crate::env::Action;
use crate::exploration::fixtures::World;
use crate::exploration::{ExplorationParams, Optimism};
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::PotentialTable;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An agent that does as it is advised, in a world that starts in state 0.
pub(super) struct Follower {
    pub world: World,
    /// State and handicap.
    pub goals: Vec<(usize, u32)>,
    pub graph: TransitionGraph,
    pub model: ExplorationModel,
    pub explorer: Explorer,
    pub potential: PotentialTable,
    /// The world's names of the states, in order of discovery.
    pub names: Vec<usize>,
    /// Three moves in ten go astray.
    pub on_ice: bool,
    pub rng: ChaCha8Rng,
}

impl Follower {
    pub(super) fn new(world: World, goals: &[(usize, u32)], optimism: Optimism, seed: u64) -> Self {
        let params = ExplorationParams {
            optimism,
            search_share: 0.0,
            potential_advice: 20.0,
            ..Default::default()
        };
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let mut graph = TransitionGraph::new(world.num_actions());
        graph.add_state();
        Self {
            model: ExplorationModel::new(params, world.num_actions()),
            explorer: Explorer::new(rng.clone()),
            world,
            goals: goals.to_vec(),
            graph,
            potential: PotentialTable::new(),
            names: vec![0],
            on_ice: false,
            rng,
        }
    }

    /// Steps of an episode; `None` if it was cut off after `limit`.
    pub(super) fn episode(&mut self, limit: usize) -> Option<usize> {
        let mut here = StateId(0);
        self.explorer
            .begin_episode(&mut self.model, &self.graph, here);
        for steps in 1..=limit {
            let action = self.advised(here);
            here = self.step(here, action);
            if self.goal(here).is_some() {
                self.take_stock();
                return Some(steps);
            }
            if self
                .model
                .destinations
                .iter()
                .any(|goal| goal.state == here)
            {
                self.model.forget_destination(&self.graph, here);
                self.explorer.lose_goal();
                self.potential.flatten();
            }
        }
        self.take_stock();
        None
    }

    /// The best advice, at random among equals.
    pub(super) fn advised(&mut self, state: StateId) -> Action {
        let mut advice = vec![0.0; self.world.num_actions()];
        let (graph, table) = (&self.graph, &self.potential);
        self.explorer
            .advise(&mut self.model, graph, state, table, 1.0, &mut advice);
        let best = advice.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let equals: Vec<_> = (0..advice.len()).filter(|&a| advice[a] == best).collect();
        Action(equals[self.rng.random_range(0..equals.len())] as u16)
    }

    pub(super) fn step(&mut self, from: StateId, action: Action) -> StateId {
        let draw = match self.on_ice {
            true => self.rng.random(),
            false => 1.0,
        };
        let here = self.names[from.index()];
        let name = self.world.slipped(here, action.index(), draw);
        let known = self.names.iter().position(|&n| n == name);
        let to = match known {
            Some(place) => StateId(place as u32),
            None => {
                self.names.push(name);
                self.graph.add_state()
            }
        };
        let terminal = self.goal(to).is_some();
        let before = self.graph.num_transitions();
        let untried = self.graph.tries(from, action) == 0;
        let new_edge = self.graph.record(from, action, -1.0, to, terminal);
        let first_time = self.graph.num_transitions() > before;
        let step = RecordedStep {
            from,
            action,
            to,
            terminated: terminal,
            first_time,
            new_way: untried || new_edge || known.is_none(),
        };
        self.explorer.learn(&mut self.model, &self.graph, step);
        to
    }

    pub(super) fn goal(&self, state: StateId) -> Option<Destination> {
        let name = self.names[state.index()];
        let &(_, handicap) = self.goals.iter().find(|goal| goal.0 == name)?;
        Some(Destination { state, handicap })
    }

    /// At the end of an episode: goals seen, distances anew, φ = −hops.
    pub(super) fn take_stock(&mut self) {
        let states = (0..self.names.len()).map(|s| StateId(s as u32));
        let seen: Vec<_> = states
            .clone()
            .filter_map(|state| self.goal(state))
            .collect();
        if seen.is_empty() {
            return;
        }
        self.model.set_destinations(&self.graph, &seen);
        for state in states {
            let hops = self.model.to_goal.get(state).min(1000);
            self.potential.extend(state, -f64::from(hops));
        }
    }

    /// The fewest steps plus handicap from the start, by the world itself.
    pub(super) fn optimum(&self) -> Option<u32> {
        let mut ending = self.world.clone();
        for &(goal, _) in &self.goals {
            ending.moves[goal].fill(goal);
        }
        let hops = ending.hops_from(0);
        let costs = self.goals.iter().filter_map(|&(g, h)| Some(hops[g]? + h));
        costs.min()
    }
}
