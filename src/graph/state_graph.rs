//! State ↔ number, on top of the transition graph. (interface sketch)

use super::{StateId, TransitionGraph};
use std::hash::Hash;

#[derive(Clone, Debug)]
pub struct StateGraph<S> {
    pub(crate) marker: std::marker::PhantomData<S>,
}

#[allow(unused_variables)]
impl<S: Clone + Eq + Hash> StateGraph<S> {
    pub fn new(num_actions: usize) -> Self {
        todo!()
    }
    /// The number of `state`, and whether it is new. Amortised O(1).
    pub fn intern(&mut self, state: &S) -> (StateId, bool) {
        todo!()
    }
    pub fn id(&self, state: &S) -> Option<StateId> {
        todo!()
    }
    pub fn state(&self, id: StateId) -> &S {
        todo!()
    }
    pub fn transitions(&self) -> &TransitionGraph {
        todo!()
    }
    /// see [`TransitionGraph::record`]
    pub fn record(
        &mut self,
        from: StateId,
        action: crate::env::Action,
        reward: f64,
        to: StateId,
        terminal: bool,
    ) -> bool {
        todo!()
    }
}
