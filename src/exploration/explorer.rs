//! The explorer: where to look before the first goal, what is still worth a look after it.
//!
//! **Before the first goal** it advises the way to the nearest promising untried action; one whose outcome is
//! plain, because it undoes a step, is a last resort. **After it**, with d₀ the hops from the start, d* the hops to the
//! goal and L = d*(start), an untried action a of s is tried only if the best that it could lead to is an
//! improvement: d₀(s) + 1 + h < L, where h is the lower bound of dead reckoning, or 0 without it (with which this is
//! the optimism of R-max). When nothing is left to try, the advice is the rise of the potential along each action.
//!
//! **When the last goal is lost** (it was entered and the episode went on), the first quest begins again, and known
//! states that were not entered since then are as good a place to look as untried actions: the goal may have moved
//! to any of them.

use super::ExplorationParams;
use super::Optimism;
use super::displacement::{Displacements, Prediction};
use super::distances::Distances;
use super::frontier::{FrontierSearch, FrontierView, Interest};
use super::stale::StaleStates;
use crate::env::Action;
use crate::graph::connectivity::UNREACHED;
use crate::graph::{StateId, TransitionGraph};
use crate::shaping::Potential;
use rand_chacha::ChaCha8Rng;

/// A goal as the explorer sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Destination {
    /// Where it is.
    pub state: StateId,
    /// By how many steps it is worse than the best goal.
    pub handicap: u32,
}

/// Beyond this many tries an action has shown what it can do: a slip of 0.3 hides a door with probability 0.3^16.
const MAX_TRIES_WANTED: u32 = 16;

/// What the search looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quest {
    /// Any goal, when none is known.
    FirstGoal,
    /// A shorter way to the goals seen.
    ShorterPath,
    /// A goal not seen yet that is nearer than the best one seen.
    OtherGoal,
}

impl Quest {
    const COUNT: usize = 3;
}

/// Frontier exploration with all it has learnt. Memory O(n · actions).
#[derive(Clone, Debug)]
pub struct Explorer {
    params: ExplorationParams,
    search: FrontierSearch,
    displacements: Displacements,
    from_start: Distances,
    to_goal: Distances,
    destinations: Vec<Destination>,
    /// By state: episodes end there. Shorter than the graph if the last states are none of these.
    terminal: Vec<bool>,
    stale: StaleStates,
    /// A goal was lost and no other one found since.
    is_lost: bool,
    /// The action of the step before, within the episode.
    heading: Option<Action>,
    start: StateId,
    /// By quest: the state from which a search has found nothing. Searching again is no use until the graph or the
    /// start changes; until the next episode, if it was not the start, from where more may be in reach.
    exhausted: [Option<StateId>; Quest::COUNT],
    /// Steps since the first goal, and how many of them went into [`Quest::OtherGoal`].
    steps: u64,
    search_steps: u64,
    /// The plan is one of [`Quest::OtherGoal`].
    searching: bool,
    /// Some action has been seen to have two outcomes.
    stochastic: bool,
    /// An action counts as tried after this many tries.
    tries_wanted: u32,
    rng: ChaCha8Rng,
}

impl Explorer {
    /// An explorer of a world with `num_actions` actions; `rng` breaks its ties.
    pub fn new(params: ExplorationParams, num_actions: usize, rng: ChaCha8Rng) -> Self {
        Self {
            params,
            search: FrontierSearch::new(),
            displacements: Displacements::new(num_actions),
            from_start: Distances::default(),
            to_goal: Distances::default(),
            destinations: Vec::new(),
            terminal: Vec::new(),
            stale: StaleStates::default(),
            is_lost: false,
            heading: None,
            start: StateId(0),
            exhausted: [None; Quest::COUNT],
            steps: 0,
            search_steps: 0,
            searching: false,
            stochastic: false,
            tries_wanted: 1,
            rng,
        }
    }

    /// Begins an episode in `start`, a state of `graph`. O(n + m) if the start is not that of the last episode and a
    /// goal is known, else O(1).
    pub fn begin_episode(&mut self, graph: &TransitionGraph, start: StateId) {
        self.displacements.add_start(start);
        self.search.clear();
        self.stale.enter(start);
        self.heading = None;
        for exhausted in &mut self.exhausted {
            *exhausted = exhausted.filter(|from| *from == start);
        }
        if start != self.start {
            self.start = start;
            self.refresh(graph);
        }
    }

    /// Learns from a step that the graph has recorded; `terminal` if the episode terminated in `to`, `first_time` if
    /// this outcome was not seen before. O(1), or O(actions · degree) if it is new.
    pub fn learn(
        &mut self,
        graph: &TransitionGraph,
        from: StateId,
        action: Action,
        to: StateId,
        terminal: bool,
        first_time: bool,
    ) {
        self.search.advance(from, action);
        self.heading = Some(action);
        if !self.destinations.is_empty() {
            self.steps += 1;
            self.search_steps += u64::from(self.searching);
        }
        if terminal {
            self.terminal
                .resize(self.terminal.len().max(to.index() + 1), false);
            self.terminal[to.index()] = true;
        }
        self.stale.enter(to);
        if first_time {
            self.stochastic |= graph.tries(from, action) > 1;
            self.exhausted[Quest::FirstGoal as usize] = None;
            self.displacements.learn(graph, from, action, to);
            self.from_start.append(from, to);
            self.to_goal.append(from, to);
        }
    }

    /// Tells which goals are known, and that the graph has changed enough to reckon distances anew. O(n + m).
    pub fn set_destinations(&mut self, graph: &TransitionGraph, destinations: &[Destination]) {
        self.destinations.clear();
        self.destinations.extend_from_slice(destinations);
        if !destinations.is_empty() {
            self.is_lost = false;
            self.stale.clear();
        }
        self.search.clear();
        self.refresh(graph);
    }

    /// The agent stands in `state`, a goal until now, and the episode went on: it is none any more. If it was the last
    /// one, all other states become worth a look. O(n + m).
    pub fn forget_destination(&mut self, graph: &TransitionGraph, state: StateId) {
        if let Some(terminal) = self.terminal.get_mut(state.index()) {
            *terminal = false;
        }
        self.destinations.retain(|goal| goal.state != state);
        self.searching = false;
        self.search.clear();
        if self.destinations.is_empty() {
            self.is_lost = true;
            self.mark_stale(graph, state);
        }
        self.refresh(graph);
    }

    /// Hops from the farthest state that can reach a goal, handicaps included; 0 before the first goal.
    pub fn eccentricity(&self) -> u32 {
        self.to_goal.eccentricity()
    }

    /// All states but the one where the agent stands may have become goals.
    fn mark_stale(&mut self, graph: &TransitionGraph, here: StateId) {
        self.stale.mark_all(graph.num_states());
        self.stale.enter(here);
    }

    fn refresh(&mut self, graph: &TransitionGraph) {
        self.exhausted = [None; Quest::COUNT];
        if !self.destinations.is_empty() {
            self.from_start.search_from(graph, self.start);
            let goals: Vec<_> = self
                .destinations
                .iter()
                .map(|goal| (goal.state, goal.handicap))
                .collect();
            self.to_goal.search_to(graph, &goals);
        }
    }

    /// Writes the advice for `state` into `advice`, one logit per action: `frontier_advice` on the next step of the
    /// quest in hand, if there is one; else, once a goal is known, `potential_advice` times the expected rise of
    /// `potential` along each action, in units of `unit` > 0, the rise that one step towards the goal is worth on
    /// average. O(out-degree) on the way; a new plan costs a search of the states nearer than its end.
    ///
    /// # Panics
    /// If `state` is not in `graph`, or `advice` is shorter than the actions are many.
    pub fn advise(
        &mut self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        advice.fill(0.0);
        if let Some(action) = self.plan(graph, state) {
            advice[action.index()] = self.params.frontier_advice;
        } else if !self.destinations.is_empty() {
            self.advise_potential(graph, state, potential, unit, advice);
        }
    }

    /// The next step of the quest in hand, if there is one.
    fn plan(&mut self, graph: &TransitionGraph, state: StateId) -> Option<Action> {
        if let Some(action) = self.search.planned(state) {
            return Some(action);
        }
        if self.destinations.is_empty() {
            let found = self.look(graph, state, Quest::FirstGoal)
                || (self.stochastic && self.look_closer(graph, state))
                || (self.is_lost && self.look_again(graph, state));
            return self.search.planned(state).filter(|_| found);
        }
        for quest in [Quest::ShorterPath, Quest::OtherGoal] {
            if self.is_wanted(quest, state) && self.look(graph, state, quest) {
                self.searching = quest == Quest::OtherGoal;
                return self.search.planned(state);
            }
        }
        self.searching = false;
        None
    }

    /// Everything was tried often enough, but where actions slip a door may have been missed: asks for one more try.
    fn look_closer(&mut self, graph: &TransitionGraph, state: StateId) -> bool {
        if self.tries_wanted == MAX_TRIES_WANTED {
            return false;
        }
        self.tries_wanted += 1;
        self.exhausted[Quest::FirstGoal as usize] = None;
        self.look(graph, state, Quest::FirstGoal)
    }

    /// Everything in reach was entered since the goal was lost, and it is nowhere: it may have moved meanwhile. Stale
    /// states that are out of reach here may not be so from the start.
    fn look_again(&mut self, graph: &TransitionGraph, state: StateId) -> bool {
        if !self.stale.is_empty() && state != self.start {
            return false;
        }
        self.mark_stale(graph, state);
        self.exhausted[Quest::FirstGoal as usize] = None;
        self.look(graph, state, Quest::FirstGoal)
    }

    /// Looking for other goals may cost one best path, and `search_share` of the steps on top. It begins at the start
    /// of an episode, so that near goals are found first, once there is enough for a trip as long as the best path.
    fn is_wanted(&self, quest: Quest, state: StateId) -> bool {
        match (quest, self.params.optimism) {
            (_, Optimism::None) => false,
            (Quest::OtherGoal, Optimism::SeenGoals) => {
                let trip = f64::from(self.to_goal.get(self.start));
                let left =
                    trip + self.params.search_share * self.steps as f64 - self.search_steps as f64;
                if self.searching {
                    left > 0.0
                } else {
                    state == self.start && left >= trip
                }
            }
            _ => true,
        }
    }

    /// Plans a step of `quest` from `state`; whether there is one.
    fn look(&mut self, graph: &TransitionGraph, state: StateId, quest: Quest) -> bool {
        if self.exhausted[quest as usize].is_some() {
            return false;
        }
        let mut view = QuestView {
            graph,
            displacements: &mut self.displacements,
            from_start: &self.from_start,
            destinations: &self.destinations,
            terminal: &self.terminal,
            tries_wanted: if quest == Quest::FirstGoal {
                self.tries_wanted
            } else {
                1
            },
            stale: &self.stale,
            quest,
            best: self.to_goal.get(self.start),
        };
        let found = self
            .search
            .search(&mut view, state, self.heading, &mut self.rng);
        if !found {
            self.exhausted[quest as usize] = Some(state);
        }
        found
    }

    /// Look-ahead advice: the expected rise of the potential along each action whose outcome is known.
    fn advise_potential(
        &mut self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        unit: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        let weight = self.params.potential_advice / unit;
        for (i, logit) in advice.iter_mut().enumerate() {
            let action = Action(i as u16);
            if graph.tries(state, action) == 0
                && let Prediction::Undo(next) = self.displacements.predict(graph, state, action)
            {
                *logit = weight * (potential.value(next) - here);
            }
        }
        for outcome in graph.outcomes(state) {
            let tries = f64::from(graph.tries(state, outcome.action)) + self.doubt();
            let share = f64::from(outcome.count) / tries;
            advice[outcome.action.index()] +=
                weight * share * (potential.value(outcome.next) - here);
        }
        if self.stochastic {
            self.add_doubt(graph, state, potential, weight, advice);
        }
        self.advise_untried(graph, state, advice);
    }

    /// Where no known action leads uphill, the way up must be one that was never tried.
    fn advise_untried(&self, graph: &TransitionGraph, state: StateId, advice: &mut [f64]) {
        if advice.iter().all(|&logit| logit <= 0.0) {
            for (i, logit) in advice.iter_mut().enumerate() {
                if graph.tries(state, Action(i as u16)) == 0 {
                    *logit = self.params.frontier_advice;
                }
            }
        }
    }

    /// Outcomes not seen that count beside those seen: where actions slip, one bad try must not rule an action out.
    fn doubt(&self) -> f64 {
        if self.stochastic { 1.0 } else { 0.0 }
    }

    /// The unseen outcome of every tried action might be the best neighbour of `state`.
    fn add_doubt(
        &self,
        graph: &TransitionGraph,
        state: StateId,
        potential: &impl Potential,
        weight: f64,
        advice: &mut [f64],
    ) {
        let here = potential.value(state);
        let neighbors = graph.adjacency().neighbors(state.0).iter();
        let best = neighbors
            .map(|&next| potential.value(StateId(next)) - here)
            .fold(0.0, f64::max);
        for (i, logit) in advice.iter_mut().enumerate() {
            let tries = graph.tries(state, Action(i as u16));
            if tries > 0 {
                *logit += weight * best * self.doubt() / (f64::from(tries) + self.doubt());
            }
        }
    }
}

/// The graph through the eyes of a quest.
struct QuestView<'a> {
    graph: &'a TransitionGraph,
    displacements: &'a mut Displacements,
    from_start: &'a Distances,
    destinations: &'a [Destination],
    terminal: &'a [bool],
    tries_wanted: u32,
    stale: &'a StaleStates,
    quest: Quest,
    /// L, the steps of the best path known from the start to a goal.
    best: u32,
}

impl QuestView<'_> {
    fn is_terminal(&self, state: StateId) -> bool {
        self.terminal.get(state.index()).copied().unwrap_or(false)
    }

    /// Whether as many neighbours of `state` are known as it has actions, so that trying one again shows nothing new.
    fn is_complete(&self, state: StateId) -> bool {
        self.graph.adjacency().neighbors(state.0).len() >= self.graph.num_actions()
    }

    /// Whether `action` is known to lead from `state` to one that was not entered since the goal was lost.
    fn leads_to_stale(&mut self, state: StateId, action: Action) -> bool {
        !self.stale.is_empty()
            && self
                .successor(state, action)
                .is_some_and(|next| self.stale.contains(next))
    }

    /// The fewest steps to a goal that trying `action` in `state` could turn out to leave, that step included.
    fn optimistic_steps(&mut self, state: StateId, action: Action, prediction: Prediction) -> u32 {
        match (self.quest, prediction) {
            (_, Prediction::Undo(_)) => UNREACHED,
            // A goal not seen yet is no state that is known.
            (Quest::OtherGoal, Prediction::Known(_)) => UNREACHED,
            (Quest::OtherGoal, _) => 1,
            _ => {
                let bounds = self.destinations.iter().map(|goal| {
                    goal.handicap
                        .saturating_add(self.displacements.lower_bound(state, action, goal.state))
                });
                bounds.min().unwrap_or(0).saturating_add(1)
            }
        }
    }
}

impl FrontierView for QuestView<'_> {
    fn num_actions(&self) -> usize {
        self.graph.num_actions()
    }

    fn successor(&mut self, state: StateId, action: Action) -> Option<StateId> {
        self.graph.likely_successor(state, action).or_else(|| {
            match self.displacements.predict(self.graph, state, action) {
                Prediction::Undo(next) if !self.is_terminal(state) => Some(next),
                _ => None,
            }
        })
    }

    fn interest(&mut self, state: StateId, action: Action) -> Interest {
        if self.is_terminal(state) {
            return Interest::None;
        }
        if self.leads_to_stale(state, action) {
            return Interest::Promising;
        }
        let tries = self.graph.tries(state, action);
        if tries >= self.tries_wanted || (tries > 0 && self.is_complete(state)) {
            return Interest::None;
        }
        let prediction = self.displacements.predict(self.graph, state, action);
        if self.quest == Quest::FirstGoal {
            return match prediction {
                Prediction::Undo(_) => Interest::LastResort,
                _ => Interest::Promising,
            };
        }
        let through = self
            .from_start
            .get(state)
            .saturating_add(self.optimistic_steps(state, action, prediction));
        if through < self.best {
            Interest::Promising
        } else {
            Interest::None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exploration::Optimism;
    use crate::exploration::fixtures::{World, walled_grids};
    use crate::shaping::PotentialTable;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};

    /// An agent that does as it is advised, in a world that starts in state 0.
    struct Follower {
        world: World,
        /// State and handicap.
        goals: Vec<(usize, u32)>,
        graph: TransitionGraph,
        explorer: Explorer,
        potential: PotentialTable,
        /// The world's names of the states, in order of discovery.
        names: Vec<usize>,
        rng: ChaCha8Rng,
    }

    impl Follower {
        fn new(world: World, goals: &[(usize, u32)], optimism: Optimism, seed: u64) -> Self {
            let params = ExplorationParams {
                optimism,
                search_share: 0.0,
                ..Default::default()
            };
            let rng = ChaCha8Rng::seed_from_u64(seed);
            let mut graph = TransitionGraph::new(world.num_actions());
            graph.add_state();
            Self {
                explorer: Explorer::new(params, world.num_actions(), rng.clone()),
                world,
                goals: goals.to_vec(),
                graph,
                potential: PotentialTable::new(),
                names: vec![0],
                rng,
            }
        }

        /// Steps of an episode; `None` if it was cut off after `limit`.
        fn episode(&mut self, limit: usize) -> Option<usize> {
            let mut here = StateId(0);
            self.explorer.begin_episode(&self.graph, here);
            for steps in 1..=limit {
                let action = self.advised(here);
                here = self.step(here, action);
                if self.goal(here).is_some() {
                    self.take_stock();
                    return Some(steps);
                }
                if self
                    .explorer
                    .destinations
                    .iter()
                    .any(|goal| goal.state == here)
                {
                    self.explorer.forget_destination(&self.graph, here);
                    self.potential.flatten();
                }
            }
            self.take_stock();
            None
        }

        /// The best advice, at random among equals.
        fn advised(&mut self, state: StateId) -> Action {
            let mut advice = vec![0.0; self.world.num_actions()];
            let (graph, table) = (&self.graph, &self.potential);
            self.explorer.advise(graph, state, table, 1.0, &mut advice);
            let best = advice.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let equals: Vec<_> = (0..advice.len()).filter(|&a| advice[a] == best).collect();
            Action(equals[self.rng.random_range(0..equals.len())] as u16)
        }

        fn step(&mut self, from: StateId, action: Action) -> StateId {
            let name = self.world.moves[self.names[from.index()]][action.index()];
            let known = self.names.iter().position(|&n| n == name);
            let to = match known {
                Some(place) => StateId(place as u32),
                None => {
                    self.names.push(name);
                    self.graph.add_state()
                }
            };
            let first_time = self.graph.tries(from, action) == 0;
            let terminal = self.goal(to).is_some();
            self.graph.record(from, action, -1.0, to, terminal);
            self.explorer
                .learn(&self.graph, from, action, to, terminal, first_time);
            to
        }

        fn goal(&self, state: StateId) -> Option<Destination> {
            let name = self.names[state.index()];
            let &(_, handicap) = self.goals.iter().find(|goal| goal.0 == name)?;
            Some(Destination { state, handicap })
        }

        /// At the end of an episode: goals seen, distances anew, φ = −hops.
        fn take_stock(&mut self) {
            let states = (0..self.names.len()).map(|s| StateId(s as u32));
            let seen: Vec<_> = states
                .clone()
                .filter_map(|state| self.goal(state))
                .collect();
            if seen.is_empty() {
                return;
            }
            self.explorer.set_destinations(&self.graph, &seen);
            for state in states {
                let hops = self.explorer.to_goal.get(state).min(1000);
                self.potential.extend(state, -f64::from(hops));
            }
        }

        /// The fewest steps plus handicap from the start, by the world itself.
        fn optimum(&self) -> Option<u32> {
            let mut ending = self.world.clone();
            for &(goal, _) in &self.goals {
                ending.moves[goal].fill(goal);
            }
            let hops = ending.hops_from(0);
            let costs = self.goals.iter().filter_map(|&(g, h)| Some(hops[g]? + h));
            costs.min()
        }
    }

    fn open(side: usize) -> World {
        World::grid(side, side, |_, _| false)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// Every plan of at most n steps tries something new, and there are 4n things to try.
        #[test]
        fn before_the_first_goal_every_state_in_reach_is_visited(
            world in walled_grids(),
            seed in any::<u64>(),
        ) {
            let n = world.num_states();
            let hops = world.hops_from(0);
            let mut follower = Follower::new(world, &[], Optimism::SeenGoals, seed);
            for _ in 0..4 * n {
                follower.episode(2 * n);
            }
            let reachable = (0..n).filter(|&name| hops[name].is_some());
            let mut found = follower.names.clone();
            found.sort_unstable();
            prop_assert_eq!(found, reachable.collect::<Vec<_>>());
        }

        #[test]
        fn after_the_first_goal_episodes_become_shortest_paths(
            world in walled_grids(),
            goal in 1usize..36,
            seed in any::<u64>(),
        ) {
            let goal = 1 + goal % (world.num_states() - 1);
            let n = world.num_states();
            let mut follower = Follower::new(world, &[(goal, 0)], Optimism::SeenGoals, seed);
            if let Some(optimum) = follower.optimum() {
                let lengths: Vec<_> = (0..6 * n).map(|_| follower.episode(6 * n)).collect();
                prop_assert_eq!(lengths.last(), Some(&Some(optimum as usize)), "{:?}", lengths);
            }
        }

        #[test]
        fn optimism_about_any_goal_finds_the_best_of_two(
            world in walled_grids(),
            near in 1usize..36,
            far in 1usize..36,
            handicap in 0u32..4,
            seed in any::<u64>(),
        ) {
            let n = world.num_states();
            let goals = [(1 + near % (n - 1), handicap), (1 + far % (n - 1), 0)];
            prop_assume!(goals[0].0 != goals[1].0);
            let mut follower = Follower::new(world, &goals, Optimism::AnyGoal, seed);
            if let Some(optimum) = follower.optimum() {
                let lengths: Vec<_> = (0..6 * n).map(|_| follower.episode(6 * n)).collect();
                let last = lengths.last().copied().flatten().map(|steps| steps as u32);
                // A shorter episode ends at the goal that costs the difference.
                prop_assert!(
                    last == Some(optimum) || last == Some(optimum.saturating_sub(handicap)),
                    "optimum {} of {:?}", optimum, lengths
                );
            }
        }
    }

    #[test]
    fn a_goal_that_moved_is_found_again() {
        for seed in 0..10 {
            let mut follower = Follower::new(open(6), &[(35, 0)], Optimism::SeenGoals, seed);
            let lengths: Vec<_> = (0..40).map(|_| follower.episode(400)).collect();
            assert_eq!(lengths[39], Some(10), "{lengths:?}");
            for goal in [30, 5] {
                follower.goals = vec![(goal, 0)];
                let lengths: Vec<_> = (0..40).map(|_| follower.episode(400)).collect();
                assert!(lengths[0].is_some_and(|steps| steps < 150), "{lengths:?}");
                assert_eq!(lengths[39], Some(5), "goal {goal}: {lengths:?}");
            }
        }
    }

    #[test]
    fn what_moves_while_it_is_looked_for_is_looked_for_again() {
        let mut follower = Follower::new(open(4), &[(15, 0)], Optimism::SeenGoals, 3);
        while follower.episode(200) != Some(6) {}
        follower.goals.clear();
        assert_eq!(follower.episode(200), None, "there is no goal any more");
        assert!(follower.explorer.is_lost);
        follower.goals = vec![(10, 0)];
        assert!(follower.episode(200).is_some(), "a second round finds it");
        assert!(!follower.explorer.is_lost && follower.explorer.stale.is_empty());
    }

    /// 0 → 1 → 2 (goal) is known; at 0 a door into a dead end from which nothing can be reached. What a search from there
    /// does not find must not be given up for the episodes to come.
    #[test]
    fn what_is_out_of_reach_here_is_not_given_up_elsewhere() {
        let moves = vec![
            vec![1, 4, 0],
            vec![3, 1, 1],
            vec![2, 2, 2],
            vec![2, 3, 3],
            vec![4, 4, 4],
        ];
        let mut follower = Follower::new(World { moves }, &[(2, 0)], Optimism::AnyGoal, 0);
        let path = |follower: &mut Follower, actions: &[u16]| {
            let mut here = StateId(0);
            follower.explorer.begin_episode(&follower.graph, here);
            for &action in actions {
                here = follower.step(here, Action(action));
            }
            here
        };
        path(&mut follower, &[0, 0, 0]);
        follower.take_stock();
        // Into the dead end, until everything in it has been tried.
        let dead_end = path(&mut follower, &[2, 1, 0, 1, 2]);
        follower.take_stock();
        let plan = follower.explorer.plan(&follower.graph, dead_end);
        assert_eq!(plan, None);
        follower.explorer.begin_episode(&follower.graph, StateId(0));
        let plan = follower.explorer.plan(&follower.graph, StateId(0));
        assert!(plan.is_some(), "state 1 has untried actions");
    }
}
