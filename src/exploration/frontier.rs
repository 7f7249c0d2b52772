//! The nearest frontier: a shortest known path to a state with something left to try (Yamauchi 1997).
//!
//! Breadth-first search from where the agent stands, over transitions it has seen, to the first state with a
//! *promising* untried action; the path is kept and followed until the agent leaves it or arrives. A search
//! visits a ball of states around the agent and pays for as many steps as the path is long.

use crate::env::Action;
use crate::graph::StateId;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Worth of an untried action to the search, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Interest {
    /// Go there.
    Promising,
    /// Go there when nothing promising is left.
    Incidental,
    /// Go there when none of these is left either.
    Doubtful,
    /// Go there when nothing else is left.
    LastResort,
    /// Never go there.
    None,
}

/// Questions of the search to the graph.
pub trait FrontierView {
    /// Number of actions of every state.
    fn num_actions(&self) -> usize;
    /// The states that `action` leads to, as far as they are known well enough to walk there.
    fn successors(&self, state: StateId, action: Action) -> impl Iterator<Item = StateId>;
    /// The worth of taking `action` in `state`: what may come of it if it was never tried.
    fn interest(&self, state: StateId, action: Action) -> Interest;
    /// The place of a state that is only expected to be on the way; none if it is known. Its number is one that no state has yet.
    fn expected_place(&self, _state: StateId) -> Option<Vec<i32>> {
        None
    }
    /// Of the promising actions of a state none of which goes straight on, those are taken that have the most of this.
    fn preference(&self, _state: StateId, _action: Action) -> u32 {
        0
    }
}

impl Interest {
    /// Kinds that are worth a way, the best first.
    const KINDS: [Self; 4] = [
        Self::Promising,
        Self::Incidental,
        Self::Doubtful,
        Self::LastResort,
    ];
}

/// The nearest action of each kind that the running search has seen and not gone for.
type Others = [Option<(StateId, Action)>; Interest::KINDS.len()];

/// A step of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct PlannedStep {
    spot: Spot,
    action: Action,
}

/// Where a step is to be taken.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Spot {
    State(StateId),
    /// The state that lies there, once it is known.
    Place(Vec<i32>),
}

/// The plan and the buffers of the search: 12 bytes a state. A search allocates only if the graph has grown or the
/// plan or the queue is longer than ever before.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct FrontierSearch {
    /// Steps still to take, last one first.
    plan: Vec<PlannedStep>,
    /// `visited[s] == epoch` if the running search has seen s. This and what follows are empty after reading, which is as good.
    #[serde(skip)]
    visited: Vec<u32>,
    #[serde(skip)]
    epoch: u32,
    #[serde(skip)]
    parent: Vec<(StateId, Action)>,
    #[serde(skip)]
    queue: VecDeque<StateId>,
    #[serde(skip)]
    candidates: Vec<Action>,
}

impl FrontierSearch {
    /// No plan.
    pub fn new() -> Self {
        Self::default()
    }

    /// The planned action in `state`, if the plan is there.
    pub fn planned(&self, state: StateId) -> Option<Action> {
        let next = self.plan.last()?;
        (next.spot == Spot::State(state)).then_some(next.action)
    }

    /// The last step of the plan: what it is made for.
    /// None if that is at a place where no state is known.
    pub fn end(&self) -> Option<(StateId, Action)> {
        match self.plan.first()? {
            PlannedStep {
                spot: Spot::State(state),
                action,
            } => Some((*state, *action)),
            _ => None,
        }
    }

    /// Whether the plan goes on at a place where no state was known.
    pub fn awaits_place(&self) -> bool {
        matches!(self.plan.last(), Some(step) if matches!(step.spot, Spot::Place(_)))
    }

    /// Tells that `state` was entered, which lies at `place`: it may be the one that the plan goes on from.
    pub fn arrive(&mut self, state: StateId, place: &[i32]) {
        if let Some(next) = self.plan.last_mut()
            && matches!(&next.spot, Spot::Place(expected) if **expected == *place)
        {
            next.spot = Spot::State(state);
        }
    }

    /// Forgets the plan.
    pub fn clear(&mut self) {
        self.plan.clear();
    }

    /// Tells what the agent did: the plan goes on if it was the planned step, else it is forgotten.
    pub fn advance(&mut self, state: StateId, action: Action) {
        if self.planned(state) == Some(action) {
            self.plan.pop();
        } else {
            self.plan.clear();
        }
    }

    /// Plans a path from `from` to the nearest action of the best kind, and returns the kind; `None` if there is nothing. `known_best` says that nothing better than that is
    /// left: with what is as good the search ends at once. Ties at the frontier go to the action that continues the path (`heading` at the
    /// start), then to the preferred one, then to chance. O(states and transitions nearer than the frontier), of all in reach if only worse is left than `known_best`.
    pub fn search(
        &mut self,
        view: &impl FrontierView,
        from: StateId,
        heading: Option<Action>,
        known_best: Interest,
        rng: &mut ChaCha8Rng,
    ) -> Option<Interest> {
        self.plan.clear();
        self.begin_epoch();
        self.queue.clear();
        self.visit(from, (from, Action(0)));
        let mut others = Others::default();
        while let Some(state) = self.queue.pop_front() {
            let arriving = if state == from {
                heading
            } else {
                Some(self.parent[state.index()].1)
            };
            let kind = self.collect(view, state, known_best, &mut others);
            if let Some(action) = self.choose(view, state, arriving, rng) {
                self.trace(view, from, state, action);
                return Some(kind);
            }
            self.expand(view, state, rng);
        }
        let mut nearest = Interest::KINDS.into_iter().zip(others);
        let (kind, (state, action)) = nearest.find_map(|(kind, found)| Some((kind, found?)))?;
        self.trace(view, from, state, action);
        Some(kind)
    }

    /// Makes the best actions of `state` the candidates, if they are as good as `known_best`; remembers the others. The kind of the candidates.
    fn collect(
        &mut self,
        view: &impl FrontierView,
        state: StateId,
        known_best: Interest,
        others: &mut Others,
    ) -> Interest {
        let mut best = known_best;
        self.candidates.clear();
        for action in (0..view.num_actions() as u16).map(Action) {
            let interest = view.interest(state, action);
            if interest < best {
                best = interest;
                self.candidates.clear();
            }
            if interest == best {
                self.candidates.push(action);
            } else if let Some(other) = others.get_mut(interest as usize) {
                other.get_or_insert((state, action));
            }
        }
        best
    }

    /// The candidate of `state` to try, if there is one.
    fn choose(
        &mut self,
        view: &impl FrontierView,
        state: StateId,
        arriving: Option<Action>,
        rng: &mut ChaCha8Rng,
    ) -> Option<Action> {
        if let Some(ahead) = arriving.filter(|ahead| self.candidates.contains(ahead)) {
            return Some(ahead);
        }
        self.keep_preferred(view, state);
        match self.candidates.len() {
            0 => None,
            several => Some(self.candidates[rng.random_range(0..several)]),
        }
    }

    /// Strikes out the candidates that are not the most preferred ones.
    fn keep_preferred(&mut self, view: &impl FrontierView, state: StateId) {
        let mut best = 0;
        let mut kept = 0;
        for i in 0..self.candidates.len() {
            let preference = view.preference(state, self.candidates[i]);
            if preference > best {
                best = preference;
                kept = 0;
            }
            if preference == best {
                self.candidates[kept] = self.candidates[i];
                kept += 1;
            }
        }
        self.candidates.truncate(kept);
    }

    /// Enqueues the unvisited successors of `state`, from a random action on.
    fn expand(&mut self, view: &impl FrontierView, state: StateId, rng: &mut ChaCha8Rng) {
        let num_actions = view.num_actions();
        let offset = rng.random_range(0..num_actions);
        for i in 0..num_actions {
            let action = Action(((i + offset) % num_actions) as u16);
            for next in view.successors(state, action) {
                let seen = self
                    .visited
                    .get(next.index())
                    .is_some_and(|epoch| *epoch == self.epoch);
                if !seen {
                    self.visit(next, (state, action));
                }
            }
        }
    }

    /// Forgets what was visited; O(1) but once in 2³² times.
    fn begin_epoch(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        if self.epoch == 0 {
            self.visited.fill(0);
            self.epoch = 1;
        }
    }

    fn visit(&mut self, state: StateId, parent: (StateId, Action)) {
        if state.index() >= self.visited.len() {
            self.visited.resize(state.index() + 1, 0);
            self.parent
                .resize(state.index() + 1, (StateId(0), Action(0)));
        }
        self.visited[state.index()] = self.epoch;
        self.parent[state.index()] = parent;
        self.queue.push_back(state);
    }

    /// Writes the path from `from` to `state`, then `action`, into the plan.
    fn trace(&mut self, view: &impl FrontierView, from: StateId, state: StateId, action: Action) {
        let mut step = (state, action);
        loop {
            let (at, action) = step;
            let place = view.expected_place(at);
            let spot = place.map_or(Spot::State(at), Spot::Place);
            self.plan.push(PlannedStep { spot, action });
            if at == from {
                break;
            }
            step = self.parent[at.index()];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exploration::fixtures::{World, walled_grids};
    use proptest::prelude::*;
    use rand::SeedableRng;

    /// A world of which everything is known, with a list of what is interesting.
    struct Known {
        world: World,
        interests: Vec<(usize, u16, Interest)>,
    }

    impl FrontierView for Known {
        fn num_actions(&self) -> usize {
            self.world.num_actions()
        }

        fn successors(&self, state: StateId, action: Action) -> impl Iterator<Item = StateId> {
            let next = self.world.moves[state.index()][action.index()];
            std::iter::once(StateId(next as u32))
        }

        fn interest(&self, state: StateId, action: Action) -> Interest {
            let place = (state.index(), action.0);
            let found = self.interests.iter().find(|(s, a, _)| (*s, *a) == place);
            found.map_or(Interest::None, |found| found.2)
        }
    }

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    /// Follows the plan to its end: where it goes, action by action.
    fn follow(search: &mut FrontierSearch, world: &World, from: usize) -> Vec<(usize, u16)> {
        let mut here = StateId(from as u32);
        let mut path = Vec::new();
        while let Some(action) = search.planned(here) {
            path.push((here.index(), action.0));
            search.advance(here, action);
            here = StateId(world.moves[here.index()][action.index()] as u32);
        }
        path
    }

    proptest! {
        #[test]
        fn the_plan_is_a_shortest_path_to_the_nearest_promising_action(
            world in walled_grids(),
            interests in prop::collection::vec((0usize..36, 0u16..4, 0usize..4), 0..5),
            from in 0usize..36,
            seed in any::<u64>(),
        ) {
            let n = world.num_states();
            let from = from % n;
            let kinds = Interest::KINDS;
            let interests: Vec<_> = interests
                .into_iter()
                .map(|(s, a, kind)| (s % n, a, kinds[kind]))
                .collect();
            let known = Known { world, interests };
            let mut search = FrontierSearch::new();
            let found = search.search(&known, StateId(from as u32), None, Interest::Promising, &mut rng(seed));
            let hops = known.world.hops_from(from);
            let places: Vec<_> = (0..n).flat_map(|s| (0..4).map(move |a| (s, a))).collect();
            let nearest = |wanted| {
                let wanted: Vec<_> = places
                    .iter()
                    .filter(|&&(s, a)| known.interest(StateId(s as u32), Action(a)) == wanted)
                    .collect();
                wanted.into_iter().filter_map(|&(s, _)| hops[s]).min()
            };
            let best = kinds.into_iter().find(|&kind| nearest(kind).is_some());
            let wanted = best.unwrap_or(Interest::None);
            let expected = best.and_then(nearest);
            prop_assert_eq!(found, best);
            let path = follow(&mut search, &known.world, from);
            prop_assert_eq!(path.len() as u32, expected.map_or(0, |hops| hops + 1));
            if let Some(&(state, action)) = path.last() {
                prop_assert_eq!(known.interest(StateId(state as u32), Action(action)), wanted);
            }
        }
    }

    #[test]
    fn of_equals_the_one_straight_ahead_is_taken_else_any() {
        let world = World::grid(1, 5, |_, _| false);
        let interests = (0..4).map(|a| (4, a, Interest::Promising)).collect();
        let known = Known { world, interests };
        let mut search = FrontierSearch::new();
        let mut first_choices = [0; 4];
        for seed in 0..100 {
            assert!(
                search
                    .search(
                        &known,
                        StateId(0),
                        None,
                        Interest::Promising,
                        &mut rng(seed)
                    )
                    .is_some()
            );
            let path = follow(&mut search, &known.world, 0);
            assert!(
                path.iter().all(|step| step.1 == 1),
                "to the right and on: {path:?}"
            );
            search.search(
                &known,
                StateId(4),
                Some(Action(2)),
                Interest::Promising,
                &mut rng(seed),
            );
            assert_eq!(search.planned(StateId(4)), Some(Action(2)));
            search.search(
                &known,
                StateId(4),
                None,
                Interest::Promising,
                &mut rng(seed),
            );
            first_choices[search.planned(StateId(4)).expect("there are four").index()] += 1;
        }
        assert!(first_choices.iter().all(|&n| n > 10), "{first_choices:?}");
    }

    /// A state where everything is promising, and larger actions are preferred.
    struct Choosy;

    impl FrontierView for Choosy {
        fn num_actions(&self) -> usize {
            4
        }

        fn successors(&self, _: StateId, _: Action) -> impl Iterator<Item = StateId> {
            std::iter::empty()
        }

        fn interest(&self, _: StateId, _: Action) -> Interest {
            Interest::Promising
        }

        fn preference(&self, _: StateId, action: Action) -> u32 {
            u32::from(action.0 / 2)
        }
    }

    #[test]
    fn preference_decides_where_no_action_goes_straight_on() {
        let mut search = FrontierSearch::new();
        let mut taken = [0; 4];
        for seed in 0..100 {
            search.search(
                &Choosy,
                StateId(0),
                None,
                Interest::Promising,
                &mut rng(seed),
            );
            taken[search.planned(StateId(0)).expect("all promise").index()] += 1;
            search.search(
                &Choosy,
                StateId(0),
                Some(Action(1)),
                Interest::Promising,
                &mut rng(seed),
            );
            assert_eq!(search.planned(StateId(0)), Some(Action(1)));
        }
        assert!(
            taken[0] + taken[1] == 0 && taken[2] > 20 && taken[3] > 20,
            "{taken:?}"
        );
    }

    #[test]
    fn a_plan_is_forgotten_when_the_agent_leaves_it() {
        let world = World::grid(1, 5, |_, _| false);
        let known = Known {
            world,
            interests: vec![(4, 1, Interest::Promising)],
        };
        let mut search = FrontierSearch::new();
        assert!(
            search
                .search(&known, StateId(0), None, Interest::Promising, &mut rng(0))
                .is_some()
        );
        search.advance(StateId(0), Action(1));
        assert_eq!(search.planned(StateId(1)), Some(Action(1)));
        assert_eq!(
            search.planned(StateId(2)),
            None,
            "the plan is for another place"
        );
        search.advance(StateId(1), Action(0));
        assert_eq!(search.planned(StateId(1)), None);
        assert!(
            search
                .search(&known, StateId(1), None, Interest::Promising, &mut rng(0))
                .is_some()
        );
        search.clear();
        assert_eq!(search.planned(StateId(1)), None);
    }

    #[test]
    fn the_number_of_searches_may_wrap() {
        let world = World::grid(1, 3, |_, _| false);
        let known = Known {
            world,
            interests: vec![(2, 1, Interest::Promising)],
        };
        let mut search = FrontierSearch::new();
        search.epoch = u32::MAX - 1;
        for _ in 0..4 {
            assert!(
                search
                    .search(&known, StateId(0), None, Interest::Promising, &mut rng(0))
                    .is_some()
            );
            assert_eq!(follow(&mut search, &known.world, 0).len(), 3);
        }
    }
}
