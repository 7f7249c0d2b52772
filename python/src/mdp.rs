//! Exact values of a finite MDP given by its transitions.

use crate::arrays::{self, Matrix, Vector};
use crate::calls::unlocked;
use eigentrail::Action;
use eigentrail::env::{Outcome, TabularMdp};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Transitions by (state, action): pair p owns `order[offsets[p]..offsets[p + 1]]`.
struct Table<'a> {
    num_states: usize,
    num_actions: usize,
    pair: &'a [i64],
    next: &'a [i64],
    probability: &'a [f64],
    reward: &'a [f64],
    ends: &'a [bool],
}

impl Table<'_> {
    /// The MDP, with one state more, in which all that ends comes to an end. States without transitions are ends as well.
    fn to_mdp(&self) -> Result<TabularMdp, String> {
        let by_pair = self.by_pair()?;
        let of_state = |state: usize| {
            let pairs = state * self.num_actions..(state + 1) * self.num_actions;
            &by_pair[pairs]
        };
        let mut terminal: Vec<bool> = (0..self.num_states)
            .map(|state| of_state(state).iter().all(Vec::is_empty))
            .collect();
        terminal.push(true);
        TabularMdp::from_fn(self.num_actions, terminal, |state, action: Action, row| {
            row.extend_from_slice(&of_state(state)[action.index()]);
        })
        .map_err(|error| error.to_string())
    }

    fn by_pair(&self) -> Result<Vec<Vec<Outcome>>, String> {
        let pairs = self.num_states * self.num_actions;
        let mut rows = vec![Vec::new(); pairs];
        for i in 0..self.pair.len() {
            let pair = usize::try_from(self.pair[i]).ok().filter(|&p| p < pairs);
            let next = u32::try_from(self.next[i]).ok();
            let next = next.filter(|&next| (next as usize) < self.num_states);
            let (Some(pair), Some(next)) = (pair, next) else {
                return Err(format!(
                    "transition {i} is between states or of an action that do not exist"
                ));
            };
            rows[pair].push(Outcome {
                next: if self.ends[i] {
                    self.num_states as u32
                } else {
                    next
                },
                probability: self.probability[i],
                reward: self.reward[i],
            });
        }
        Ok(rows)
    }
}

/// Optimal values, n, and action values, n × |A|.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // an MDP, as five arrays and two numbers
pub fn solve<'py>(
    py: Python<'py>,
    num_states: usize,
    num_actions: usize,
    pair: PyReadonlyArray1<'py, i64>,
    next: PyReadonlyArray1<'py, i64>,
    probability: PyReadonlyArray1<'py, f64>,
    reward: PyReadonlyArray1<'py, f64>,
    ends: PyReadonlyArray1<'py, bool>,
    gamma: f64,
    tol: f64,
) -> PyResult<(Vector<'py, f64>, Matrix<'py, f64>)> {
    if !(0.0..=1.0).contains(&gamma) {
        return Err(PyValueError::new_err(format!(
            "gamma = {gamma}: must be within 0 and 1"
        )));
    }
    if !(tol > 0.0 && tol.is_finite()) {
        return Err(PyValueError::new_err(format!(
            "tol = {tol}: must be above 0"
        )));
    }
    let table = Table {
        num_states,
        num_actions,
        pair: pair.as_slice()?,
        next: next.as_slice()?,
        probability: probability.as_slice()?,
        reward: reward.as_slice()?,
        ends: ends.as_slice()?,
    };
    let count = table.pair.len();
    if [
        table.next.len(),
        table.probability.len(),
        table.reward.len(),
        table.ends.len(),
    ] != [count; 4]
    {
        return Err(PyValueError::new_err(
            "the arrays of transitions differ in length",
        ));
    }
    let solved = unlocked(py, || solved(&table, gamma, tol))?;
    let (values, action_values) = solved.map_err(PyValueError::new_err)?;
    Ok((
        arrays::vector(py, values),
        arrays::rows(py, action_values, num_actions)?,
    ))
}

fn solved(table: &Table<'_>, gamma: f64, tol: f64) -> Result<(Vec<f64>, Vec<f64>), String> {
    let mdp = table.to_mdp()?;
    let found = mdp.value_iteration(gamma, tol);
    if !found.converged {
        return Err(format!(
            "with gamma = {gamma} the values grow without end: some loop pays for ever; choose a smaller gamma"
        ));
    }
    let states = 0..table.num_states;
    let action_values = states
        .flat_map(|state| mdp.actions().map(move |action| (state, action)))
        .map(|(state, action)| mdp.action_value(&found.values, gamma, state, action));
    let action_values = action_values.collect();
    let mut values = found.values;
    values.truncate(table.num_states);
    Ok((values, action_values))
}
