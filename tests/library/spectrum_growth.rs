//! Five hundred growing graphs against nalgebra's dense solver, at every update; twenty larger ones against faer's.
//!
//! Twenty families of 25 cases each: number of pairs, tolerance, Laplacian, sizes and growth are drawn per case. Most
//! graphs grow beyond 300 nodes, where the sparse route begins. Eigenvalues are compared as lists with
//! repetitions, vectors through residuals and orthonormality.

use crate::graphs::{self, SymmetricCsr};
use eigentrail::spectral::{
    Eigenpairs, GrowingEigensolver, Laplacian, LaplacianKind, SpectralParams, SymmetricOperator,
};
use eigentrail_testing::families::{FAMILIES, rng_of};
use faer::Mat;
use rand::RngExt;
use rayon::prelude::*;

const CASES: u64 = 25;

/// Accuracy of a dense solver's eigenvalues, relative to ‖L‖.
const ROUNDING: f64 = 1e-13;

/// The same for residuals of its vectors, which weights twelve powers of ten apart push to 1e-12.
const RESIDUAL_ROUNDING: f64 = 3e-12;

/// ‖VᵀV − I‖_max.
const ORTHONORMALITY: f64 = 1e-10;

/// All eigenvalues of a dense symmetric matrix, ascending.
type Oracle = fn(&Mat<f64>) -> Vec<f64>;

/// One growing graph and what is asked of its spectrum.
#[derive(Debug)]
struct Case {
    family: &'static str,
    number: u64,
    graph: SymmetricCsr,
    sizes: Vec<usize>,
    params: SpectralParams,
    /// How many of the last updates to check.
    checked: usize,
}

impl Case {
    fn new(family: usize, number: u64, most: usize) -> Self {
        let rng = &mut rng_of(family, number);
        let about = rng.random_range(most * 3 / 4..=most);
        let graph = graphs::checked((FAMILIES[family].make)(about, rng));
        let n = graph.num_nodes();
        let start = rng.random_range(n / 2..=n * 9 / 10);
        let growth = [0.01, 0.05, 0.2, 0.5][rng.random_range(0..4)];
        let mut sizes = graphs::sizes(start.max(1), growth, n);
        // The last updates say the most: that is where the sparse route is.
        sizes.drain(..sizes.len().saturating_sub(4));
        let num_eigenpairs = match rng.random_range(0..8) {
            0 => 1,
            1 => 2,
            2 => 7,
            3 => 24,
            4 => 40,
            5 => n - n / 20 - 1,
            _ => 16,
        };
        let params = SpectralParams {
            num_eigenpairs,
            tol: [1e-2, 1e-3, 1e-6][rng.random_range(0..3)],
            laplacian: if rng.random_bool(0.25) {
                LaplacianKind::Combinatorial
            } else {
                LaplacianKind::Normalized
            },
            certify: rng.random_bool(0.2),
            ..Default::default()
        };
        let family = FAMILIES[family].name;
        Self {
            family,
            number,
            graph,
            sizes,
            params,
            checked: usize::MAX,
        }
    }

    /// What is wrong, update by update; nothing if all is well.
    fn faults(&self, oracle: Oracle) -> Vec<String> {
        let mut spectrum = GrowingEigensolver::new(self.params.clone(), self.number);
        let mut faults = Vec::new();
        for (i, &nodes) in self.sizes.iter().enumerate() {
            let prefix = graphs::prefix(&self.graph, nodes);
            spectrum.refresh(&prefix).unwrap();
            if self.sizes.len() - i > self.checked {
                continue;
            }
            let pairs = spectrum.eigenpairs().unwrap();
            if let Err(fault) = check(&prefix, &self.params, pairs, oracle) {
                let (family, number, params) = (self.family, self.number, &self.params);
                faults.push(format!(
                    "{family} {number}, {nodes} of {:?} nodes: {fault}; {params:?}",
                    self.sizes
                ));
            }
        }
        faults
    }
}

/// The list against the oracle's, residuals by a product with L, orthonormality, and what is reported.
fn check(
    graph: &SymmetricCsr,
    params: &SpectralParams,
    pairs: &Eigenpairs,
    oracle: Oracle,
) -> Result<(), String> {
    let laplacian = Laplacian::new(graph, params.laplacian);
    let dense = laplacian.to_dense();
    let n = graph.num_nodes();
    let k = params.num_eigenpairs.min(n);
    let exact = oracle(&dense);
    let norm = exact[n - 1];
    let unit = exact[k - 1].max(ROUNDING * norm);
    require(
        (
            pairs.values.len(),
            pairs.vectors.ncols(),
            pairs.vectors.nrows(),
        ) == (k, k, n),
        || "shape".into(),
    )?;
    require(pairs.convergence.converged == k, || {
        format!("{} of {k} converged", pairs.convergence.converged)
    })?;
    let allowed = params.tol * params.tol * unit + ROUNDING * norm;
    for (j, (found, right)) in pairs.values.iter().zip(&exact).enumerate() {
        require((found - right).abs() <= allowed, || {
            format!(
                "λ_{} is {found:e}, should be {right:e}, λ_k = {unit:e}",
                j + 1
            )
        })?;
    }
    let v = &pairs.vectors;
    let gram = (v.transpose() * v - Mat::<f64>::identity(k, k)).norm_max();
    require(gram <= ORTHONORMALITY, || format!("VᵀV − I = {gram:e}"))?;
    let mut product = Mat::zeros(n, k);
    laplacian.apply(v.as_ref(), product.as_mut());
    let allowed = params.tol * unit + RESIDUAL_ROUNDING * norm;
    for (j, &value) in pairs.values.iter().enumerate() {
        let residual = (product.col(j) - faer::Scale(value) * v.col(j)).norm_l2();
        require(residual <= allowed, || {
            format!(
                "residual {} is {residual:e}, λ_k = {unit:e}, ‖L‖ = {norm:e}",
                j + 1
            )
        })?;
    }
    Ok(())
}

fn require(holds: bool, fault: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(fault()) }
}

/// All eigenvalues, ascending, by a solver that shares no code with ours.
fn nalgebra_values(dense: &Mat<f64>) -> Vec<f64> {
    let n = dense.nrows();
    let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| dense[(i, j)]);
    let mut values = matrix.symmetric_eigenvalues().as_slice().to_vec();
    values.sort_by(f64::total_cmp);
    values
}

/// 125 sequences a test, so that the harness spreads them; the cases of one test run on rayon's threads.
#[track_caller]
fn assert_families(families: std::ops::Range<usize>) {
    let cases: Vec<_> = families
        .flat_map(|f| (0..CASES).map(move |c| (f, c)))
        .collect();
    let faults: Vec<String> = cases
        .par_iter()
        .flat_map_iter(|&(family, number)| {
            let most = if number % 5 == 0 { 120 } else { 400 };
            Case::new(family, number, most).faults(nalgebra_values)
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{} updates wrong:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

/// Values only, which faer finds fast enough for graphs too large to be proved or rescued by a dense solver.
fn faer_values(dense: &Mat<f64>) -> Vec<f64> {
    dense.self_adjoint_eigenvalues(faer::Side::Lower).unwrap()
}

#[test]
fn graphs_beyond_the_reach_of_the_dense_route() {
    let faults: Vec<String> = (0..FAMILIES.len())
        .into_par_iter()
        .flat_map_iter(|family| {
            let mut case = Case::new(family, 1000, 1800);
            let n = case.graph.num_nodes();
            (case.sizes, case.checked) = (vec![n - n / 20, n], 1);
            case.params.num_eigenpairs = case.params.num_eigenpairs.min(24);
            case.params.tol = case.params.tol.max(1e-3);
            case.faults(faer_values)
        })
        .collect();
    assert!(
        faults.is_empty(),
        "{} updates wrong:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

#[test]
fn trees_hubs_and_complete_graphs() {
    assert_families(0..5);
}

#[test]
fn symmetric_graphs_and_grids() {
    assert_families(5..10);
}

#[test]
fn mazes_power_laws_and_random_graphs() {
    assert_families(10..15);
}

#[test]
fn parts_joins_and_wide_weights() {
    assert_families(15..20);
}
