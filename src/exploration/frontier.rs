//! The nearest frontier: a shortest known path to a state with something left to try (Yamauchi 1997).
//!
//! Breadth-first search from where the agent stands, over transitions it has seen, to the first state with a
//! *promising* untried action; the path is kept and followed until the agent leaves it or arrives. A search
//! visits a ball of states around the agent and pays for as many steps as the path is long.

use crate::env::Action;
use crate::graph::StateId;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// What an untried action is worth to the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interest {
    /// Go there.
    Promising,
    /// Go there when nothing promising is left.
    LastResort,
    /// Never go there.
    None,
}

/// What the search asks of the graph.
pub trait FrontierView {
    /// Number of actions of every state.
    fn num_actions(&self) -> usize;
    /// The state that `action` leads to, if that is known well enough to walk there.
    fn successor(&mut self, state: StateId, action: Action) -> Option<StateId>;
    /// The worth of trying `action` in `state`; [`Interest::None`] if it was tried.
    fn interest(&mut self, state: StateId, action: Action) -> Interest;
}

/// The plan and the buffers of the search.
#[derive(Clone, Debug)]
pub struct FrontierSearch {
    /// Steps still to take, last one first.
    plan: Vec<(StateId, Action)>,
    /// `visited[s] == epoch` if the running search has seen s.
    visited: Vec<u32>,
    epoch: u32,
    parent: Vec<(StateId, Action)>,
    queue: VecDeque<StateId>,
    candidates: Vec<Action>,
}

impl Default for FrontierSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl FrontierSearch {
    /// No plan.
    pub fn new() -> Self {
        Self {
            plan: Vec::new(),
            visited: Vec::new(),
            epoch: 0,
            parent: Vec::new(),
            queue: VecDeque::new(),
            candidates: Vec::new(),
        }
    }

    /// The planned action in `state`, if the plan is there.
    pub fn planned(&self, state: StateId) -> Option<Action> {
        self.plan
            .last()
            .filter(|step| step.0 == state)
            .map(|step| step.1)
    }

    /// Whether no step is planned.
    pub fn is_idle(&self) -> bool {
        self.plan.is_empty()
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

    /// Plans a path from `from` to the nearest promising action (a last resort if there is none) and says
    /// whether there is one. Ties at the frontier go to the action that continues the path (`heading` at the
    /// start), then to chance. O(states and transitions nearer than the frontier).
    pub fn search(
        &mut self,
        view: &mut impl FrontierView,
        from: StateId,
        heading: Option<Action>,
        rng: &mut ChaCha8Rng,
    ) -> bool {
        self.plan.clear();
        self.epoch += 1;
        self.queue.clear();
        self.visit(from, (from, Action(0)));
        let mut last_resort = None;
        while let Some(state) = self.queue.pop_front() {
            let arriving = if state == from {
                heading
            } else {
                Some(self.parent[state.index()].1)
            };
            if let Some(action) = self.choose(view, state, arriving, &mut last_resort, rng) {
                self.trace(from, state, action);
                return true;
            }
            self.expand(view, state, rng);
        }
        if let Some((state, action)) = last_resort {
            self.trace(from, state, action);
        }
        last_resort.is_some()
    }

    /// The promising action of `state` to try, if any; remembers the first last resort on the way.
    fn choose(
        &mut self,
        view: &mut impl FrontierView,
        state: StateId,
        arriving: Option<Action>,
        last_resort: &mut Option<(StateId, Action)>,
        rng: &mut ChaCha8Rng,
    ) -> Option<Action> {
        self.candidates.clear();
        for action in (0..view.num_actions() as u16).map(Action) {
            match view.interest(state, action) {
                Interest::Promising => self.candidates.push(action),
                Interest::LastResort => {
                    last_resort.get_or_insert((state, action));
                }
                Interest::None => {}
            }
        }
        match arriving {
            Some(action) if self.candidates.contains(&action) => Some(action),
            _ if self.candidates.is_empty() => None,
            _ => Some(self.candidates[rng.random_range(0..self.candidates.len())]),
        }
    }

    /// Enqueues the unvisited successors of `state`, from a random action on.
    fn expand(&mut self, view: &mut impl FrontierView, state: StateId, rng: &mut ChaCha8Rng) {
        let num_actions = view.num_actions();
        let offset = rng.random_range(0..num_actions);
        for i in 0..num_actions {
            let action = Action(((i + offset) % num_actions) as u16);
            if let Some(next) = view.successor(state, action) {
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
    fn trace(&mut self, from: StateId, state: StateId, action: Action) {
        self.plan.push((state, action));
        let mut at = state;
        while at != from {
            let (previous, action) = self.parent[at.index()];
            self.plan.push((previous, action));
            at = previous;
        }
    }
}
