//! Spectra against independent oracles: closed forms, nalgebra's dense solver, inertia counts.
//!
//! Eigenvalues are compared as multisets, vectors through residuals and orthonormality; never one
//! vector with another, which within an eigenspace means nothing.

use crate::graphs::{self, SymmetricCsr};
use eigentrail::spectral::{
    Eigenpairs, GrowingEigensolver, Laplacian, LaplacianKind, Method, SpectralError,
    SpectralParams, SymmetricOperator, TrackParams, track,
};
use faer::Mat;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Accuracy promised of eigenvalues at tol = 1e-3, relative to λ_k.
const VALUE_TOLERANCE: f64 = 1e-6;

/// ‖VᵀV − I‖_max.
const ORTHONORMALITY: f64 = 1e-10;

const TOL: f64 = 1e-3;

fn params(k: usize, tol: f64) -> SpectralParams {
    SpectralParams {
        num_eigenpairs: k,
        tol,
        ..Default::default()
    }
}

/// All eigenvalues by nalgebra, which shares no code with the solver.
fn dense_oracle(graph: &SymmetricCsr, kind: LaplacianKind) -> Vec<f64> {
    let dense = Laplacian::new(graph, kind).to_dense();
    let matrix =
        nalgebra::DMatrix::from_fn(graph.num_nodes(), graph.num_nodes(), |i, j| dense[(i, j)]);
    let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
    if values.iter().any(|value| value.is_nan()) {
        // Of some matrices of little else than zeros nalgebra makes 0 ÷ 0.
        values = dense.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
    }
    values.sort_by(f64::total_cmp);
    values
}

/// λ_k, or the floor that stands in for it.
fn unit(values: &[f64]) -> f64 {
    let last = values.last().copied().unwrap_or(0.0);
    if last > 1e-12 { last } else { 1e-10 }
}

#[track_caller]
fn assert_values(found: &[f64], expected: &[f64], what: &str) {
    let expected = &expected[..found.len()];
    let unit = unit(expected);
    for (j, (f, e)) in found.iter().zip(expected).enumerate() {
        // A dense solver's own rounding is 1e-13 or so: it must not fail the comparison where λ_k is 0.
        let allowed = (VALUE_TOLERANCE * unit).max(1e-12);
        assert!(
            (f - e).abs() <= allowed,
            "{what}: λ_{} is {f}, should be {e} (λ_k = {unit})",
            j + 1
        );
    }
}

/// Residuals by a product with L, orthonormality, order, and the facts reported about them.
#[track_caller]
fn assert_pairs(
    graph: &SymmetricCsr,
    kind: LaplacianKind,
    pairs: &Eigenpairs,
    tol: f64,
    what: &str,
) {
    let laplacian = Laplacian::new(graph, kind);
    let (v, k) = (&pairs.vectors, pairs.values.len());
    assert_eq!((v.nrows(), v.ncols()), (graph.num_nodes(), k), "{what}");
    assert!(pairs.values.is_sorted(), "{what}");
    let gram = v.transpose() * v - Mat::<f64>::identity(k, k);
    assert!(
        gram.norm_max() <= ORTHONORMALITY,
        "{what}: VᵀV − I = {}",
        gram.norm_max()
    );
    let mut product = Mat::zeros(v.nrows(), k);
    laplacian.apply(v.as_ref(), product.as_mut());
    let unit = unit(&pairs.values);
    for j in 0..k {
        let residual = (product.col(j) - faer::Scale(pairs.values[j]) * v.col(j)).norm_l2();
        let allowed = (tol * unit).max(1e-13);
        assert!(
            residual <= allowed,
            "{what}: residual {j} is {residual}, λ_k = {unit}"
        );
        let reported = pairs.convergence.residual_norms[j];
        assert!(
            (residual - reported).abs() <= 1e-3 * allowed + 1e-13,
            "{what}: reported {reported}, is {residual}"
        );
    }
    assert_eq!(pairs.convergence.converged, k, "{what}");
}

fn solve(graph: &SymmetricCsr, params: &SpectralParams) -> Eigenpairs {
    let mut spectrum = GrowingEigensolver::new(params.clone(), 7);
    spectrum.refresh(graph).unwrap();
    spectrum.into_eigenpairs().unwrap()
}

/// Every prefix of `graph` in turn, `check` after each refresh.
fn grow(
    graph: &SymmetricCsr,
    sizes: &[usize],
    params: &SpectralParams,
    mut check: impl FnMut(&SymmetricCsr, &Eigenpairs, &str),
) {
    let mut spectrum = GrowingEigensolver::new(params.clone(), 7);
    for &m in sizes {
        let prefix = graphs::prefix(graph, m);
        spectrum.refresh(&prefix).unwrap();
        let what = format!("{m} of {} nodes", graph.num_nodes());
        check(&prefix, spectrum.eigenpairs().unwrap(), &what);
    }
}

mod closed_forms {
    //! Chung, *Spectral Graph Theory* (1997), section 1.2: below and above the size from which the
    //! sparse route takes over.
    use super::*;

    #[track_caller]
    fn check(graph: &SymmetricCsr, mut expected: Vec<f64>, what: &str) {
        expected.sort_by(f64::total_cmp);
        for k in [1, 2, 7, 16] {
            let pairs = solve(graph, &params(k, TOL));
            assert_values(&pairs.values, &expected, what);
            assert_pairs(graph, LaplacianKind::Normalized, &pairs, TOL, what);
        }
    }

    #[test]
    fn path() {
        for n in [2, 50, 301, 3000] {
            let value = |j: usize| 1.0 - (PI * j as f64 / (n - 1) as f64).cos();
            check(
                &graphs::path(n),
                (0..n).map(value).collect(),
                &format!("path of {n}"),
            );
        }
    }

    #[test]
    fn cycle() {
        for n in [3, 50, 301, 3000] {
            let value = |j: usize| 1.0 - (2.0 * PI * j as f64 / n as f64).cos();
            check(
                &graphs::cycle(n),
                (0..n).map(value).collect(),
                &format!("cycle of {n}"),
            );
        }
    }

    #[test]
    fn complete() {
        for n in [2, 50, 400] {
            let mut expected = vec![n as f64 / (n - 1) as f64; n];
            expected[0] = 0.0;
            check(
                &graphs::complete(n),
                expected,
                &format!("complete graph of {n}"),
            );
        }
    }

    #[test]
    fn star() {
        for n in [3, 50, 5000] {
            let mut expected = vec![1.0; n];
            (expected[0], expected[n - 1]) = (0.0, 2.0);
            check(&graphs::star(n), expected, &format!("star of {n}"));
        }
    }

    #[test]
    fn hypercube() {
        for d in [1, 5, 9, 11] {
            let expected = (0..1usize << d)
                .map(|i| 2.0 * f64::from(i.count_ones()) / d as f64)
                .collect();
            check(&graphs::hypercube(d), expected, &format!("{d}-cube"));
        }
    }

    #[test]
    fn combinatorial_path_and_star() {
        let n = 2000;
        let mut combinatorial = params(10, TOL);
        combinatorial.laplacian = LaplacianKind::Combinatorial;
        let path: Vec<f64> = (0..n)
            .map(|j| 2.0 - 2.0 * (PI * j as f64 / n as f64).cos())
            .collect();
        let pairs = solve(&graphs::path(n), &combinatorial);
        assert_values(&pairs.values, &path, "path");
        assert_pairs(
            &graphs::path(n),
            LaplacianKind::Combinatorial,
            &pairs,
            TOL,
            "path",
        );
        let mut star = vec![1.0; n];
        (star[0], star[n - 1]) = (0.0, n as f64);
        let pairs = solve(&graphs::star(n), &combinatorial);
        assert_values(&pairs.values, &star, "star");
        assert_pairs(
            &graphs::star(n),
            LaplacianKind::Combinatorial,
            &pairs,
            TOL,
            "star",
        );
    }
}

mod edge_cases {
    use super::*;

    #[test]
    fn no_nodes_one_node_and_fewer_nodes_than_pairs() {
        for n in [0, 1, 5] {
            let pairs = solve(&graphs::path(n), &params(16, TOL));
            assert_eq!(pairs.values.len(), n);
            assert_eq!(pairs.vectors.nrows(), n);
            assert_eq!(pairs.convergence.converged, n);
        }
    }

    #[test]
    fn isolated_nodes_loops_and_components_have_exact_zeros() {
        let looped = graphs::from_weighted_edges(1, &[(0, 0, 2.5)]);
        for side in [10, 40] {
            let graph = graphs::disjoint(&[
                graphs::grid(side, side),
                graphs::path(1),
                looped.clone(),
                graphs::star(2 * side),
            ]);
            let pairs = solve(&graph, &params(12, TOL));
            assert_eq!(pairs.values[..4], [0.0; 4]);
            assert!(pairs.values[4] > 0.0);
            assert_values(
                &pairs.values,
                &dense_oracle(&graph, LaplacianKind::Normalized),
                "parts",
            );
            assert_pairs(&graph, LaplacianKind::Normalized, &pairs, TOL, "parts");
        }
    }

    #[test]
    fn more_components_than_pairs_is_a_cut_cluster_of_zeros() {
        let parts: Vec<SymmetricCsr> = (0..200).map(|i| graphs::path(2 + i % 3)).collect();
        let graph = graphs::disjoint(&parts);
        let pairs = solve(&graph, &params(16, TOL));
        assert_eq!(pairs.values, [0.0; 16]);
        assert!(pairs.convergence.cluster_cut);
        assert_pairs(
            &graph,
            LaplacianKind::Normalized,
            &pairs,
            TOL,
            "200 components",
        );
    }

    #[test]
    fn pairs_close_to_n() {
        let graph = graphs::random(400, 5.0, 3);
        for k in [390, 400, 500] {
            let pairs = solve(&graph, &params(k, TOL));
            assert_eq!(pairs.values.len(), k.min(400));
            assert_values(
                &pairs.values,
                &dense_oracle(&graph, LaplacianKind::Normalized),
                "k near n",
            );
        }
    }

    #[test]
    fn weights_of_many_magnitudes() {
        // D − W keeps the magnitudes, and the dense oracle's rounding with them.
        for (kind, decades) in [
            (LaplacianKind::Normalized, 13),
            (LaplacianKind::Combinatorial, 3),
        ] {
            let weight = |i: usize| 10f64.powi((i % decades) as i32 - decades as i32 / 2);
            let edges: Vec<_> = (0..899).map(|i| (i, i + 1, weight(i))).collect();
            let graph = graphs::from_weighted_edges(900, &edges);
            let mut p = params(8, TOL);
            p.laplacian = kind;
            let pairs = solve(&graph, &p);
            assert_values(
                &pairs.values,
                &dense_oracle(&graph, kind),
                &format!("{kind:?}"),
            );
        }
    }

    #[test]
    fn a_cluster_cut_by_k_is_reported() {
        // The second and third value of a square grid are equal.
        let cut = |side, k| {
            solve(&graphs::grid(side, side), &params(k, TOL))
                .convergence
                .cluster_cut
        };
        for side in [12, 40] {
            assert!(cut(side, 2), "{side}");
            assert!(!cut(side, 3), "{side}");
        }
    }

    #[test]
    fn bad_weights_are_errors_and_leave_the_last_pairs() {
        let mut spectrum = GrowingEigensolver::new(params(3, TOL), 0);
        spectrum.refresh(&graphs::path(10)).unwrap();
        for weight in [f64::NAN, -1.0, f64::INFINITY] {
            let edges = [(0, 1, 1.0), (1, 2, weight)];
            let bad = eigentrail_testing::graphs::from_weighted_edges(11, &edges);
            assert!(matches!(
                SymmetricCsr::new(bad).and_then(|bad| spectrum.refresh(&bad)),
                Err(SpectralError::Weight {
                    row: 1,
                    column: 2,
                    ..
                })
            ));
            assert_eq!(spectrum.eigenpairs().unwrap().vectors.nrows(), 10);
        }
    }

    #[test]
    fn running_out_of_restarts_is_a_fact_not_an_error() {
        let mut hopeless = params(16, 1e-9);
        hopeless.max_restarts = 1;
        let pairs = solve(&graphs::grid(60, 60), &hopeless);
        assert_eq!(pairs.values.len(), 16);
        assert!(pairs.convergence.converged < 16);
        assert!(pairs.convergence.max_relative_residual.is_finite());
    }

    #[test]
    fn a_smaller_graph_is_taken_for_another_one() {
        let mut spectrum = GrowingEigensolver::new(params(8, TOL), 0);
        spectrum.refresh(&graphs::grid(30, 30)).unwrap();
        let small = graphs::path(500);
        let refresh = spectrum.refresh(&small).unwrap();
        assert!(refresh.cold_start);
        assert_values(
            &refresh.eigenvalues,
            &dense_oracle(&small, LaplacianKind::Normalized),
            "path",
        );
    }
}

mod growth {
    use super::*;

    fn check_growing(graph: &SymmetricCsr, k: usize, growth: f64) {
        let sizes = graphs::sizes(64, growth, graph.num_nodes());
        grow(graph, &sizes, &params(k, TOL), |prefix, pairs, what| {
            let oracle = dense_oracle(prefix, LaplacianKind::Normalized);
            assert_values(&pairs.values, &oracle, what);
            assert_pairs(prefix, LaplacianKind::Normalized, pairs, TOL, what);
        });
    }

    #[test]
    fn small_worlds_by_five_per_cent() {
        let worlds = [
            graphs::grid(15, 15),
            graphs::rooms(3, 3, 5),
            graphs::maze(15, 15, 0.05, 1),
        ];
        for world in worlds {
            for k in [16, 32] {
                check_growing(&graphs::discovered(&world, 2), k, 0.05);
            }
        }
    }

    #[test]
    fn worlds_of_900_by_five_per_cent() {
        let worlds = [
            graphs::grid(30, 30),
            graphs::rooms(5, 5, 6),
            graphs::maze(30, 30, 0.05, 1),
        ];
        for world in worlds {
            for k in [16, 32] {
                check_growing(&graphs::discovered(&world, 3), k, 0.05);
            }
        }
    }

    /// Where a dense oracle would take minutes: a cold solve to 1e-7 and an inertia count.
    fn check_against_tight(graph: &SymmetricCsr, k: usize) {
        let sizes = graphs::sizes(64, 0.05, graph.num_nodes());
        grow(graph, &sizes, &params(k, TOL), |prefix, pairs, what| {
            let mut tight = params(k, 1e-7);
            tight.method = Method::Cold;
            tight.certify = true;
            let mut independent = GrowingEigensolver::new(tight, 99);
            let facts = independent.refresh(prefix).unwrap().convergence;
            assert_ne!(facts.certified, Some(false), "{what}");
            let oracle = independent.into_eigenpairs().unwrap();
            assert_eq!(oracle.convergence.converged, oracle.values.len(), "{what}");
            assert_values(&pairs.values, &oracle.values, what);
            assert_pairs(prefix, LaplacianKind::Normalized, pairs, TOL, what);
        });
    }

    #[test]
    fn worlds_of_2500_by_five_per_cent() {
        let worlds = [
            graphs::grid(50, 50),
            graphs::rooms(7, 7, 7),
            graphs::maze(50, 50, 0.05, 1),
        ];
        for world in worlds {
            for k in [16, 32] {
                check_against_tight(&graphs::discovered(&world, 4), k);
            }
        }
    }

    /// `cargo test --release --test library -- --ignored worlds_of_10000`
    #[test]
    #[ignore = "takes a minute"]
    fn worlds_of_10000_by_five_per_cent() {
        let worlds = [
            graphs::grid(100, 100),
            graphs::rooms(10, 10, 9),
            graphs::maze(100, 100, 0.05, 1),
        ];
        for world in worlds {
            for k in [16, 32] {
                check_against_tight(&graphs::discovered(&world, 5), k);
            }
        }
    }

    #[test]
    fn hypercubes_whose_eigenspaces_are_wider_than_the_block() {
        // λ = 2j / d has C(d, j) copies: k = 16 cuts the 36 of λ = 4 / 9.
        check_growing(&graphs::hypercube(9), 16, 0.05);
        let cube = graphs::hypercube(10);
        let sizes = graphs::sizes(64, 0.05, cube.num_nodes());
        let mut expected = vec![0.0];
        expected.extend([0.2; 10]);
        expected.extend([0.4; 45]);
        grow(&cube, &sizes, &params(32, TOL), |prefix, pairs, what| {
            assert_pairs(prefix, LaplacianKind::Normalized, pairs, TOL, what);
            if prefix.num_nodes() == cube.num_nodes() {
                assert_values(&pairs.values, &expected, what);
            }
        });
    }

    #[test]
    fn a_large_cube_whose_eigenspace_is_wider_than_the_block() {
        // 4096 nodes: too many to decompose whole. λ = 2 / 12 has 12 copies, λ = 4 / 12 has 66.
        let cube = graphs::hypercube(12);
        let mut expected = vec![0.0];
        expected.extend([1.0 / 6.0; 12]);
        expected.extend([1.0 / 3.0; 3]);
        let sizes = [3900, cube.num_nodes()];
        grow(&cube, &sizes, &params(16, TOL), |prefix, pairs, what| {
            assert_pairs(prefix, LaplacianKind::Normalized, pairs, TOL, what);
            if prefix.num_nodes() == cube.num_nodes() {
                assert_values(&pairs.values, &expected, what);
            }
        });
    }

    #[test]
    fn many_equal_parts_have_more_equal_eigenvalues_than_the_block_has_columns() {
        // 40 equal grids: 40 null vectors, then 80 copies of the next value (two per square grid).
        let parts: Vec<SymmetricCsr> = (0..40).map(|_| graphs::grid(8, 8)).collect();
        let graph = graphs::disjoint(&parts);
        let one = dense_oracle(&parts[0], LaplacianKind::Normalized);
        let mut expected = vec![0.0; 40];
        expected.extend([one[1]; 10]);
        let pairs = solve(&graph, &params(50, TOL));
        assert_values(&pairs.values, &expected, "40 grids");
        assert_pairs(&graph, LaplacianKind::Normalized, &pairs, TOL, "40 grids");
    }

    #[test]
    fn components_that_follow_one_another() {
        // Several low modes of a component are new at once: nothing of them is in the warm start.
        let parts: Vec<SymmetricCsr> = [1, 15, 7, 20, 1]
            .map(|side| graphs::grid(side, side))
            .into();
        let graph = graphs::discovered(&graphs::disjoint(&parts), 6);
        check_growing(&graph, 32, 0.05);
    }

    #[test]
    fn components_that_join_later() {
        // In shuffled order prefixes are mostly isolated nodes and small trees.
        for seed in 0..3 {
            let graph = graphs::shuffled(&graphs::grid(25, 26), seed);
            check_growing(&graph, 16, 0.08);
        }
        // Two large parts, bridged by the very last node.
        let parts = graphs::disjoint(&[graphs::grid(20, 20), graphs::rooms(3, 4, 5)]);
        let n = parts.num_nodes();
        let mut edges: Vec<(usize, usize, f64)> = vec![(5, n, 1.0), (n - 1, n, 1.0)];
        for (i, row) in parts.as_csr().outer_iterator().enumerate() {
            edges.extend(row.iter().filter(|&(j, _)| j < i).map(|(j, &w)| (i, j, w)));
        }
        check_growing(&graphs::from_weighted_edges(n + 1, &edges), 16, 0.1);
    }

    #[test]
    fn edges_between_old_nodes_and_nothing_new() {
        // The same number of nodes, ever more edges: from a tree to the whole grid.
        let whole = graphs::grid(25, 25);
        let tree = graphs::maze(25, 25, 0.0, 3);
        let mut spectrum = GrowingEigensolver::new(params(16, TOL), 0);
        for share in [0, 1, 2, 5, 10] {
            let mut edges = Vec::new();
            for (graph, kept) in [(&tree, 10), (&whole, share)] {
                for (i, row) in graph.as_csr().outer_iterator().enumerate() {
                    for (j, _) in row.iter().filter(|&(j, _)| j < i) {
                        if (i * 7 + j) % 10 < kept {
                            edges.push((i, j));
                        }
                    }
                }
            }
            edges.sort_unstable();
            edges.dedup();
            let graph = graphs::from_edges(625, &edges);
            let refresh = spectrum.refresh(&graph).unwrap();
            let oracle = dense_oracle(&graph, LaplacianKind::Normalized);
            assert_values(&refresh.eigenvalues, &oracle, &format!("share {share}"));
        }
    }

    #[test]
    fn warm_starts_cost_less_than_cold_ones() {
        let graph = graphs::discovered(&graphs::grid(50, 50), 1);
        // Below 300 nodes a cold update decomposes the whole matrix, without a solve.
        let solves = |method| {
            let params = TrackParams {
                tol: TOL,
                method,
                start_nodes: 320,
                ..Default::default()
            };
            let statistics = track(&graph, &params, |_| ()).unwrap().statistics;
            assert!(statistics.updates.iter().all(|u| u.converged));
            statistics.updates.iter().map(|u| u.solves).sum::<usize>()
        };
        assert!(solves(Method::Warm) < solves(Method::Cold));
    }

    #[test]
    fn all_methods_agree() {
        let graph = graphs::discovered(&graphs::rooms(4, 4, 5), 1);
        let values = [Method::Warm, Method::Cold, Method::Full].map(|method| {
            let params = TrackParams {
                tol: TOL,
                method,
                growth: 0.3,
                ..Default::default()
            };
            track(&graph, &params, |_| ())
                .unwrap()
                .statistics
                .eigenvalues
        });
        assert_values(&values[0], &values[2], "warm and full");
        assert_values(&values[1], &values[2], "cold and full");
    }
}

mod determinism {
    use super::*;

    #[test]
    fn results_are_the_same_bits_at_any_thread_count() {
        let graph = graphs::discovered(&graphs::grid(70, 70), 1);
        let run = |threads| {
            let params = TrackParams {
                threads,
                growth: 0.3,
                ..Default::default()
            };
            let tracked = track(&graph, &params, |_| ()).unwrap();
            let bits: Vec<u64> = tracked
                .statistics
                .updates
                .iter()
                .flat_map(|u| u.eigenvalues.iter().map(|v| v.to_bits()))
                .collect();
            (bits, tracked.eigenpairs.vectors)
        };
        let (one, four) = (run(1), run(4));
        assert_eq!(one.0, four.0);
        assert_eq!(one.1, four.1);
        assert_eq!(one.0, run(1).0);
    }
}

mod certification {
    use super::*;

    #[test]
    fn repeated_eigenvalues_are_proved_complete() {
        for (graph, what) in [
            (graphs::grid(40, 40), "grid"),
            (graphs::cycle(900), "cycle"),
            (
                graphs::disjoint(&[
                    graphs::grid(20, 20),
                    graphs::grid(20, 20),
                    graphs::grid(20, 20),
                ]),
                "three grids",
            ),
        ] {
            for k in [5, 16] {
                let mut p = params(k, TOL);
                p.certify = true;
                let facts = solve(&graph, &p).convergence;
                assert_eq!(facts.certified, Some(true), "{what}, k = {k}");
                assert_eq!(facts.repaired, 0, "{what}, k = {k}");
            }
        }
    }

    #[test]
    fn every_update_of_a_growing_world_is_proved_complete() {
        for world in [
            graphs::grid(40, 40),
            graphs::rooms(6, 6, 6),
            graphs::maze(40, 40, 0.05, 2),
        ] {
            let params = TrackParams {
                certify: true,
                ..Default::default()
            };
            let statistics = track(&graphs::discovered(&world, 6), &params, |_| ())
                .unwrap()
                .statistics;
            for update in statistics.updates {
                assert!(update.certified, "{} nodes", update.nodes);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Small graphs grown in three steps, either Laplacian, against the dense oracle.
    #[test]
    fn random_graphs_agree_with_the_dense_oracle(
        n in 1usize..60,
        mean_degree in 0.0f64..6.0,
        k in 1usize..20,
        seed in 0u64..1000,
        normalized: bool,
    ) {
        let kind = if normalized { LaplacianKind::Normalized } else { LaplacianKind::Combinatorial };
        let graph = graphs::random(n, mean_degree, seed);
        let mut p = params(k, TOL);
        p.laplacian = kind;
        grow(&graph, &[n.div_ceil(3), n.div_ceil(2), n], &p, |prefix, pairs, what| {
            assert_values(&pairs.values, &dense_oracle(prefix, kind), what);
            assert_pairs(prefix, kind, pairs, TOL, what);
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The same on graphs large enough for the sparse route.
    #[test]
    fn larger_random_graphs_agree_with_the_dense_oracle(
        n in 310usize..500,
        mean_degree in 1.5f64..4.0,
        k in 1usize..40,
        seed in 0u64..1000,
        normalized: bool,
    ) {
        let kind = if normalized { LaplacianKind::Normalized } else { LaplacianKind::Combinatorial };
        let graph = graphs::random(n, mean_degree, seed);
        let mut p = params(k, TOL);
        p.laplacian = kind;
        grow(&graph, &[n - n / 10, n - n / 50, n], &p, |prefix, pairs, what| {
            assert_values(&pairs.values, &dense_oracle(prefix, kind), what);
            assert_pairs(prefix, kind, pairs, TOL, what);
        });
    }
}
