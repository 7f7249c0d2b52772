//! Steps as Python tells of them, and what they were worth.

use eigentrail::engine::events;
use eigentrail::graph::StateId;
use eigentrail::{Action, Observed, Potential, Step, StepStatus, WorldModel};
use pyo3::PyResult;
use pyo3::exceptions::PyValueError;

/// Name of a state: whatever bytes the key gave it.
pub type Key = Vec<u8>;

/// Node, shaping, φ, new node, first goal, lost goal, bonus, refreshed: the fields of `Observed` in Python.
pub type Seen = (u32, f64, f64, bool, bool, bool, f64, bool);

/// The number as an action, `0..num_actions`.
pub fn action(number: i64, num_actions: usize) -> PyResult<Action> {
    match u16::try_from(number) {
        Ok(action) if usize::from(action) < num_actions => Ok(Action(action)),
        _ => Err(PyValueError::new_err(format!(
            "action {number} of a world whose actions are 0..{num_actions}"
        ))),
    }
}

/// What the environment answered. An episode that is both terminated and truncated is over for good.
pub fn step(key: &[u8], reward: f64, terminated: bool, truncated: bool) -> Step<Key> {
    Step {
        state: key.to_vec(),
        reward,
        status: match (terminated, truncated) {
            (true, _) => StepStatus::Terminated,
            (false, true) => StepStatus::Truncated,
            (false, false) => StepStatus::Running,
        },
    }
}

/// The facts of a step for Python; φ is 0 where the task is over.
pub fn told(world: &WorldModel<Key>, observed: &Observed, status: StepStatus) -> Seen {
    let phi = match status {
        StepStatus::Terminated => 0.0,
        _ => world.potential().value(observed.state),
    };
    (
        observed.state.0,
        observed.shaping,
        phi,
        observed.new_state,
        observed.first_goal,
        observed.lost_goal,
        observed.bonus,
        observed.refresh.is_some(),
    )
}

/// Tells whoever keeps a log of what is rare.
pub fn log(world: &WorldModel<Key>, observed: &Observed) {
    events::observed(observed, world.steps(), world.graph().num_states());
    if let Some(refresh) = &observed.refresh {
        events::refreshed(refresh);
    }
}

/// φ of every state.
pub fn potential(world: &WorldModel<Key>) -> Vec<f64> {
    let states = 0..world.graph().num_states() as u32;
    states
        .map(|state| world.potential().value(StateId(state)))
        .collect()
}
