//! φ as a table: frozen between two fits, O(1) a look-up, growing with the states found meanwhile.

use super::{Potential, PotentialFit, ShapingError};
use crate::graph::{StateId, SymmetricCsr};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// φ of every known state. Plain values: cloning or serialising it is a checkpoint.
///
/// A state found after the last fit has no φ of its own yet. The rule that costs nothing and pays nothing is
/// φ(new) = φ(the state it was entered from): at γ = 1 the step into the unknown is then neither rewarded nor
/// punished. A caller that knows better, for instance that the new state is one step farther, passes that instead.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PotentialTable {
    values: Vec<f64>,
    /// φ of a state that nobody extended the table to: the lowest of the last fit.
    unknown: f64,
}

impl PotentialTable {
    /// A table of no states, 0 everywhere.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of states with a value of their own.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether no state has a value of its own.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// φ by state number.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Takes over the result of a fit; states it does not cover keep what they had.
    ///
    /// # Errors
    /// [`ShapingError::NotFinite`] on a NaN or infinite value; the table is then unchanged.
    pub fn replace(&mut self, fit: &PotentialFit) -> Result<(), ShapingError> {
        check_finite(&fit.values)?;
        let covered = fit.values.len().min(self.values.len());
        self.values[..covered].copy_from_slice(&fit.values[..covered]);
        self.values.extend_from_slice(&fit.values[covered..]);
        self.unknown = fit.values.iter().copied().fold(f64::INFINITY, f64::min);
        if fit.values.is_empty() {
            self.unknown = 0.0;
        }
        Ok(())
    }

    /// Back to φ = 0 for all states, known and unknown: there is nothing to climb any more. O(n).
    pub fn flatten(&mut self) {
        self.values.fill(0.0);
        self.unknown = 0.0;
    }

    /// Gives `state` a value until the next fit. States in between that have none get the same. Amortised O(1).
    ///
    /// # Panics
    /// If `value` is not finite.
    pub fn extend(&mut self, state: StateId, value: f64) {
        assert!(
            value.is_finite(),
            "the potential of {state:?} would be {value}"
        );
        if self.values.len() <= state.index() {
            self.values.resize(state.index() + 1, value);
        }
        self.values[state.index()] = value;
    }

    /// [`extend`](Self::extend) by the rule φ(new) = φ(entry); leaves a state that has a value alone.
    pub fn inherit(&mut self, new: StateId, entry: StateId) {
        if new.index() >= self.values.len() {
            self.extend(new, self.value(entry));
        }
    }
}

impl Potential for PotentialTable {
    /// φ(state); a state beyond the table has the lowest value of the last fit (0 before the first).
    fn value(&self, state: StateId) -> f64 {
        self.values
            .get(state.index())
            .copied()
            .unwrap_or(self.unknown)
    }
}

/// The first value that is not finite, as an error.
pub(crate) fn check_finite(values: &[f64]) -> Result<(), ShapingError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(state) => Err(ShapingError::NotFinite {
            state,
            value: values[state],
        }),
        None => Ok(()),
    }
}

/// Where φ lies to an agent that climbs it: non-goal nodes, reachable from a goal, none of whose neighbours has a
/// larger φ. A node is no neighbour of itself. Ascending; O(n + edges).
///
/// On an explored world use [`false_maxima`](super::false_maxima()), which looks at the
/// moves there are instead of at the symmetrised graph.
///
/// # Panics
/// If `values` has not one entry per node, or a goal is out of range.
pub fn spurious_maxima(
    values: &[f64],
    adjacency: &SymmetricCsr,
    goals: &[StateId],
) -> Vec<StateId> {
    assert_eq!(values.len(), adjacency.num_nodes(), "one value per node");
    let neighbors = |i: usize| adjacency.row(i).0;
    let reached = reachable(adjacency.num_nodes(), goals, &neighbors);
    let is_goal = |i: usize| goals.iter().any(|g| g.index() == i);
    (0..values.len())
        .filter(|&i| reached[i] && !neighbors(i).iter().any(|&j| values[j as usize] > values[i]))
        .filter(|&i| !is_goal(i))
        .map(|i| StateId(i as u32))
        .collect()
}

fn reachable<'a>(
    nodes: usize,
    from: &[StateId],
    neighbors: &dyn Fn(usize) -> &'a [u32],
) -> Vec<bool> {
    let mut reached = vec![false; nodes];
    let mut queue: VecDeque<usize> = from.iter().map(|g| g.index()).collect();
    queue.iter().for_each(|&g| reached[g] = true);
    while let Some(i) = queue.pop_front() {
        for &j in neighbors(i) {
            if !std::mem::replace(&mut reached[j as usize], true) {
                queue.push_back(j as usize);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{graph, path};

    fn ids(states: &[u32]) -> Vec<StateId> {
        states.iter().map(|&s| StateId(s)).collect()
    }

    #[test]
    fn a_hill_away_from_the_goal_is_found() {
        let phi = [0.0, -1.0, -2.0, -1.5, -3.0];
        assert_eq!(spurious_maxima(&phi, &path(5), &ids(&[0])), ids(&[3]));
        assert_eq!(spurious_maxima(&phi, &path(5), &ids(&[0, 3])), []);
    }

    #[test]
    fn a_plateau_counts_and_so_does_a_flat_potential() {
        assert_eq!(
            spurious_maxima(&[0.0, -1.0, -1.0, -1.0], &path(4), &ids(&[0])),
            ids(&[2, 3])
        );
        assert_eq!(
            spurious_maxima(&[0.0; 3], &path(3), &ids(&[1])),
            ids(&[0, 2])
        );
    }

    #[test]
    fn what_no_goal_reaches_does_not_count() {
        let two_components = graph(4, &[(0, 1), (2, 3), (3, 3)]);
        let phi = [0.0, -1.0, -5.0, -4.0];
        assert_eq!(spurious_maxima(&phi, &two_components, &ids(&[0])), []);
        assert_eq!(
            spurious_maxima(&phi, &two_components, &ids(&[2])),
            ids(&[3])
        );
        assert_eq!(spurious_maxima(&phi, &two_components, &[]), []);
    }

    #[test]
    fn a_table_grows_inherits_and_takes_fits_over() {
        let mut table = PotentialTable::new();
        assert_eq!(table.value(StateId(9)), 0.0);
        assert_eq!((table.is_empty(), table.len()), (true, 0));
        let fit = |values: &[f64]| PotentialFit {
            values: values.to_vec(),
            ..Default::default()
        };
        table.replace(&fit(&[0.0, -1.0, -4.0])).unwrap();
        assert_eq!(table.value(StateId(1)), -1.0);
        assert_eq!(
            table.value(StateId(7)),
            -4.0,
            "unknown states have the lowest value"
        );
        table.inherit(StateId(3), StateId(1));
        assert_eq!(table.value(StateId(3)), -1.0);
        table.inherit(StateId(3), StateId(2));
        assert_eq!(
            table.value(StateId(3)),
            -1.0,
            "a known state keeps its value"
        );
        table.extend(StateId(4), -2.5);
        table.replace(&fit(&[0.0, -2.0])).unwrap();
        assert_eq!(table.values(), [0.0, -2.0, -4.0, -1.0, -2.5]);
        assert_eq!((table.is_empty(), table.len()), (false, 5));
        table.flatten();
        assert_eq!(
            (table.values(), table.value(StateId(9))),
            (&[0.0; 5][..], 0.0)
        );
    }

    #[test]
    fn a_fit_with_nan_is_refused_and_changes_nothing() {
        let mut table = PotentialTable::new();
        table.extend(StateId(0), -1.0);
        let before = table.clone();
        let bad = PotentialFit {
            values: vec![0.0, f64::NAN],
            ..Default::default()
        };
        let error = table.replace(&bad).unwrap_err();
        assert_eq!(error.to_string(), "the potential of state 1 is NaN");
        assert_eq!(table, before);
    }
}
