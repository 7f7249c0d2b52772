//! A world model and the walkers on it, for agents outside.

use crate::aliases::Aliases;
use crate::arrays::{self, Matrix, Vector};
use crate::calls::{interruptible, unlocked};
use crate::container::{Kind, packed, unpacked};
use crate::errors::raised;
use crate::parameters;
use crate::seen::{self, Key, Seen};
use eigentrail::engine::{PipelineError, RefreshRecord, events};
use eigentrail::graph::StateId;
use eigentrail::{Potential, Walker, WorldModel};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};

const KIND: Kind = Kind {
    letters: b"ENGN",
    version: 2,
};

/// Source, action, target, count, sum of rewards and end of transitions.
type Transitions<'py> = (
    Vector<'py, i64>,
    Vector<'py, i64>,
    Vector<'py, i64>,
    Vector<'py, i64>,
    Vector<'py, f64>,
    Vector<'py, bool>,
);

/// What brings a world up to date.
type Renewal = fn(&mut WorldModel<Key>) -> Result<Option<Box<RefreshRecord>>, PipelineError>;

/// The world model, the walkers, and what is watched on the way.
#[pyclass(module = "eigentrail._eigentrail")]
pub struct Engine {
    state: State,
    aliases: Aliases,
    /// Of each walker, the step before the last.
    before: Vec<Option<(u32, i64)>>,
}

/// All of it that is written down.
#[derive(Serialize, Deserialize)]
struct State {
    world: WorldModel<Key>,
    walkers: Vec<Walker>,
}

impl Engine {
    fn walker(&self, walker: usize) -> PyResult<&Walker> {
        let walkers = self.state.walkers.len();
        self.state.walkers.get(walker).ok_or_else(|| {
            PyIndexError::new_err(format!("walker {walker} of an engine with {walkers}"))
        })
    }

    /// Brings the world up to date. After an interruption it is as it was before.
    fn renew(&mut self, py: Python<'_>, work: Renewal) -> PyResult<()> {
        let mut world = self.state.world.clone();
        let (world, outcome) = interruptible(py, move || {
            let outcome = work(&mut world);
            (world, outcome)
        })?;
        self.state.world = world;
        if let Some(refresh) = outcome.map_err(raised)? {
            unlocked(py, || events::refreshed(&refresh))?;
        }
        Ok(())
    }

    fn of(state: State) -> Self {
        Self {
            before: vec![None; state.walkers.len()],
            state,
            aliases: Aliases::default(),
        }
    }
}

#[pymethods]
impl Engine {
    #[new]
    fn new(
        num_actions: usize,
        gamma: f64,
        seed: u64,
        walkers: u32,
        params: &str,
    ) -> PyResult<Self> {
        if walkers == 0 {
            return Err(PyValueError::new_err("walkers = 0: must be at least 1"));
        }
        let params = parameters::pipeline(params, gamma)?;
        let world = WorldModel::new(&params, num_actions, None, seed).map_err(raised)?;
        let walkers = (0..walkers).map(|i| Walker::new(&world, i)).collect();
        Ok(Self::of(State { world, walkers }))
    }

    fn begin_episode(&mut self, py: Python<'_>, key: &[u8], walker: usize) -> PyResult<u32> {
        self.walker(walker)?;
        let State { world, walkers } = &mut self.state;
        self.before[walker] = None;
        let place = &mut walkers[walker];
        let node = unlocked(py, || place.begin_episode(world, &key.to_vec()))?;
        Ok(node.0)
    }

    /// The fields of `Observed`, and where the key was found out to be ambiguous.
    #[allow(clippy::too_many_arguments)] // a step, as Gymnasium tells of it
    fn observe(
        &mut self,
        py: Python<'_>,
        action: i64,
        key: &[u8],
        reward: f64,
        terminated: bool,
        truncated: bool,
        walker: usize,
    ) -> PyResult<(Seen, Option<(u32, i64)>)> {
        let from = self.walker(walker)?.state().0;
        let State { world, walkers } = &mut self.state;
        let place = &mut walkers[walker];
        let taken = seen::action(action, world.transitions().num_actions())?;
        let step = seen::step(key, reward, terminated, truncated);
        let observed = unlocked(py, || {
            let observed = place.observe(world, taken, &step);
            observed.inspect(|observed| seen::log(world, observed))
        })?
        .map_err(raised)?;
        let outcome = (observed.state.0, terminated);
        let doubt = self
            .aliases
            .observe(self.before[walker], from, action, outcome);
        self.before[walker] = Some((from, action));
        Ok((seen::told(world, &observed, step.status), doubt))
    }

    fn advice<'py>(&self, py: Python<'py>, walker: usize) -> PyResult<Vector<'py, f64>> {
        Ok(arrays::vector(py, self.walker(walker)?.advice().to_vec()))
    }

    fn look_ahead<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py, f64>> {
        let world = &self.state.world;
        let advice = unlocked(py, || world.look_ahead())?;
        arrays::rows(py, advice, world.transitions().num_actions())
    }

    fn node_of(&self, key: &[u8]) -> Option<u32> {
        Some(self.state.world.graph().id(&key.to_vec())?.0)
    }

    fn key_of<'py>(&self, py: Python<'py>, node: usize) -> PyResult<Bound<'py, PyBytes>> {
        let graph = self.state.world.graph();
        match node < graph.num_states() {
            true => Ok(PyBytes::new(py, graph.state(StateId(node as u32)))),
            false => Err(PyIndexError::new_err(format!(
                "node {node} of a graph of {}",
                graph.num_states()
            ))),
        }
    }

    fn keys<'py>(&self, py: Python<'py>) -> Vec<Bound<'py, PyBytes>> {
        let states = self.state.world.graph().states();
        states.map(|key| PyBytes::new(py, key)).collect()
    }

    fn walker_node(&self, walker: usize) -> PyResult<Option<u32>> {
        let nowhere = self.state.world.graph().num_states() == 0;
        let node = self.walker(walker)?.state().0;
        Ok((!nowhere).then_some(node))
    }

    fn in_episode(&self, walker: usize) -> PyResult<bool> {
        Ok(self.walker(walker)?.is_in_episode())
    }

    fn phi(&self, node: u32) -> f64 {
        self.state.world.potential().value(StateId(node))
    }

    fn potential<'py>(&self, py: Python<'py>) -> Vector<'py, f64> {
        arrays::vector(py, seen::potential(&self.state.world))
    }

    fn eigenvalues<'py>(&self, py: Python<'py>) -> Vector<'py, f64> {
        let pairs = self.state.world.spectrum().eigenpairs();
        let values = pairs.map_or_else(Vec::new, |pairs| pairs.values.clone());
        arrays::vector(py, values)
    }

    fn eigenvectors<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py, f64>> {
        match self.state.world.spectrum().eigenpairs() {
            Some(pairs) => arrays::matrix(py, pairs.vectors.as_ref()),
            None => arrays::rows(py, Vec::new(), 0),
        }
    }

    fn refresh(&mut self, py: Python<'_>) -> PyResult<()> {
        self.renew(py, WorldModel::refresh_features)
    }

    fn refit(&mut self, py: Python<'_>) -> PyResult<()> {
        self.renew(py, WorldModel::refit)
    }

    /// Offsets, columns and weights of the symmetric adjacency.
    fn adjacency<'py>(
        &self,
        py: Python<'py>,
    ) -> (Vector<'py, i64>, Vector<'py, i64>, Vector<'py, f64>) {
        let adjacency = self.state.world.transitions().adjacency();
        let (mut offsets, mut columns, mut weights) = (vec![0], Vec::new(), Vec::new());
        for node in 0..adjacency.num_nodes() as u32 {
            columns.extend(adjacency.neighbors(node).iter().map(|&j| i64::from(j)));
            weights.extend_from_slice(adjacency.weights(node));
            offsets.push(columns.len() as i64);
        }
        (
            arrays::vector(py, offsets),
            arrays::vector(py, columns),
            arrays::vector(py, weights),
        )
    }

    /// Source, action, target, count, sum of rewards and whether it ever ended an episode, of every transition seen.
    fn transitions<'py>(&self, py: Python<'py>) -> Transitions<'py> {
        let graph = self.state.world.transitions();
        let (mut from, mut action, mut to) = (Vec::new(), Vec::new(), Vec::new());
        let (mut count, mut reward, mut terminal) = (Vec::new(), Vec::new(), Vec::new());
        for state in 0..graph.num_states() as u32 {
            let begin = from.len();
            for seen in graph.outcomes(StateId(state)) {
                from.push(i64::from(state));
                action.push(i64::from(seen.action.0));
                to.push(i64::from(seen.next.0));
                count.push(i64::from(seen.count));
                reward.push(seen.reward_sum);
                terminal.push(seen.terminal);
            }
            // Most recent first; in order of discovery they read better.
            action[begin..].reverse();
            to[begin..].reverse();
            count[begin..].reverse();
            reward[begin..].reverse();
            terminal[begin..].reverse();
        }
        (
            arrays::vector(py, from),
            arrays::vector(py, action),
            arrays::vector(py, to),
            arrays::vector(py, count),
            arrays::vector(py, reward),
            arrays::vector(py, terminal),
        )
    }

    fn goals(&self) -> Vec<u32> {
        let goals = self.state.world.goals();
        goals.iter().map(|goal| goal.state.0).collect()
    }

    fn spurious_maxima(&self) -> Vec<u32> {
        let found = self.state.world.spurious_maxima();
        found.into_iter().map(|state| state.0).collect()
    }

    #[getter]
    fn num_nodes(&self) -> usize {
        self.state.world.graph().num_states()
    }

    #[getter]
    fn num_edges(&self) -> usize {
        self.state.world.transitions().adjacency().num_edges()
    }

    #[getter]
    fn num_actions(&self) -> usize {
        self.state.world.transitions().num_actions()
    }

    #[getter]
    fn num_walkers(&self) -> usize {
        self.state.walkers.len()
    }

    #[getter]
    fn steps(&self) -> u64 {
        self.state.world.steps()
    }

    #[getter]
    fn gamma(&self) -> f64 {
        self.state.world.gamma()
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &packed(KIND, &self.state)?))
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let state: State = unpacked(KIND, bytes)?;
        Ok(Self::of(state))
    }
}
