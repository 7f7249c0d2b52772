//! A solver read back: what was written down must hang together before anything is computed from it.

use super::growing_eigensolver::{GrowingEigensolver, Tracked};
use crate::{SpectralError, SpectralParams};

/// The fields of a solver as they were written.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Checkpoint {
    params: SpectralParams,
    seed: u64,
    refreshes: u64,
    tracked: Option<Tracked>,
}

impl TryFrom<Checkpoint> for GrowingEigensolver {
    type Error = SpectralError;

    fn try_from(read: Checkpoint) -> Result<Self, SpectralError> {
        if let Some(tracked) = &read.tracked {
            tracked.check()?;
        }
        Ok(Self {
            refreshes: read.refreshes,
            tracked: read.tracked,
            ..Self::new(read.params, read.seed)
        })
    }
}

impl Tracked {
    fn check(&self) -> Result<(), SpectralError> {
        let (nodes, pairs) = (self.order.node.len(), self.solved.values.len());
        let warm_start = self.warm_start.as_ref();
        let has_vectors = match &self.solved.vectors {
            Some(vectors) => vectors.shape() == (nodes, pairs),
            None => warm_start.is_some_and(|w| w.can_give(pairs)),
        };
        let is_whole = self.order.is_consistent()
            && warm_start.is_none_or(|w| w.is_consistent(&self.order))
            && self.solved.convergence.residual_norms.len() == pairs
            && has_vectors;
        is_whole.then_some(()).ok_or(SpectralError::Checkpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LaplacianKind, Method, Route, SymmetricCsr, testing};
    use serde_json::{Value, json};

    fn solver(k: usize, method: Method) -> GrowingEigensolver {
        let params = SpectralParams {
            num_eigenpairs: k,
            tol: 1e-3,
            method,
            ..Default::default()
        };
        GrowingEigensolver::new(params, 3)
    }

    fn through_json(solver: &GrowingEigensolver) -> GrowingEigensolver {
        serde_json::from_str(&serde_json::to_string(solver).unwrap()).unwrap()
    }

    /// Values, vectors and facts, by their bits.
    fn result(
        solver: &mut GrowingEigensolver,
        graph: &SymmetricCsr,
    ) -> (Vec<u64>, Vec<u64>, String) {
        let refresh = solver.refresh(graph).unwrap();
        let vectors = &solver.eigenpairs().unwrap().vectors;
        let entries = vectors
            .col_iter()
            .flat_map(|c| c.iter().map(|v| v.to_bits()));
        (
            refresh.eigenvalues.iter().map(|v| v.to_bits()).collect(),
            entries.collect(),
            format!("{refresh:?}"),
        )
    }

    #[test]
    fn a_solver_read_back_goes_on_to_the_same_bits() {
        let parts = [testing::grid(20, 25), testing::cycle(90), testing::path(3)];
        let graphs = [
            testing::discovered(&testing::maze(30, 30, 0.05, 1), 2),
            testing::shuffled(&testing::disjoint(&parts), 4),
            testing::discovered(&testing::random(1700, 16.0, 1), 2),
        ];
        let mut routes = Vec::new();
        for whole in &graphs {
            for method in [Method::Warm, Method::Cold] {
                let mut kept = solver(10, method);
                let mut read = through_json(&kept);
                for nodes in testing::sizes(40, 0.3, whole.num_nodes()) {
                    let graph = whole.leading_block(nodes);
                    let expected = result(&mut kept, &graph);
                    assert_eq!(result(&mut read, &graph), expected, "{nodes} nodes");
                    routes.extend(kept.tracked.as_ref().map(|t| t.solved.route));
                    read = through_json(&read);
                    let pairs = |s: &GrowingEigensolver| s.eigenpairs().unwrap().vectors.clone();
                    assert_eq!(pairs(&read), pairs(&kept), "before the next refresh, too");
                }
            }
        }
        for route in [
            Route::Small,
            Route::NullSpace,
            Route::ShiftInvert,
            Route::Products,
        ] {
            assert!(routes.contains(&route), "{route:?} is not tried");
        }
    }

    #[test]
    fn infinite_numbers_come_back() {
        let mut solver = solver(4, Method::Warm);
        solver.refresh(&testing::grid(20, 20)).unwrap();
        let tracked = solver.tracked.as_mut().unwrap();
        tracked.solved.convergence.max_relative_residual = f64::INFINITY;
        let gains = &mut tracked.warm_start.as_mut().unwrap().gains;
        *gains = gains.clone().and(f64::INFINITY);
        let expected = gains.clone();
        let tracked = through_json(&solver).tracked.unwrap();
        assert_eq!(
            tracked.solved.convergence.max_relative_residual,
            f64::INFINITY
        );
        assert_eq!(tracked.warm_start.unwrap().gains, expected);
    }

    /// Whether a checkpoint is refused after `damage`.
    fn is_refused(damage: impl Fn(&mut Value)) -> bool {
        let mut solver = solver(4, Method::Warm);
        solver.refresh(&testing::grid(18, 20)).unwrap();
        let mut value = serde_json::to_value(&solver).unwrap();
        damage(&mut value);
        serde_json::from_value::<GrowingEigensolver>(value).is_err()
    }

    #[test]
    fn what_does_not_hang_together_is_refused() {
        assert!(!is_refused(|_| ()));
        let tracked: [fn(&mut Value); 12] = [
            |t| t["order"]["node"][0] = t["order"]["node"][1].clone(),
            |t| t["order"]["position"][0] = json!(400),
            |t| t["order"]["parent"][5] = json!(4),
            |t| t["order"]["parent"] = json!([]),
            |t| t["order"]["fingerprint"] = json!([1]),
            |t| t["order"]["components"][0]["end"] = json!(7),
            |t| t["warm_start"]["block"]["rows"] = json!(359),
            |t| t["warm_start"]["values"] = json!(vec![0; 100]),
            |t| t["warm_start"]["null_space"]["norms"] = json!([]),
            |t| t["warm_start"]["position"][0] = t["warm_start"]["position"][1].clone(),
            |t| t["warm_start"] = Value::Null,
            |t| t["solved"]["values"] = json!(vec![0; 80]),
        ];
        for (i, damage) in tracked.iter().enumerate() {
            assert!(is_refused(|v| damage(&mut v["tracked"])), "damage {i}");
        }
        assert!(is_refused(|v| v["params"]["tol"] = json!("small")));
    }

    #[test]
    fn other_settings_come_back_too() {
        let params = SpectralParams {
            num_eigenpairs: 3,
            tol: 0.1 + 0.2,
            laplacian: LaplacianKind::Combinatorial,
            method: Method::Full,
            certify: true,
            ..Default::default()
        };
        let solver = GrowingEigensolver::new(params.clone(), u64::MAX);
        let read = through_json(&solver);
        assert_eq!((read.params(), read.seed), (&params, u64::MAX));
        assert!(read.eigenpairs().is_none());
    }
}
