use super::*;
use crate::graph::SymmetricCsr;
use crate::shaping::fixtures::{
    Alternative, any_graph, any_process, far_reaching_graphs, graph, grid, path, process,
    value_iteration, walks, worths,
};
use faer::Mat;
use faer::prelude::Solve;
use proptest::prelude::*;

const TOL: f64 = 1e-10;

/// The process of walks that pay `reward` from everywhere on.
fn uniform(adjacency: &SymmetricCsr, reward: f64) -> DecisionProcess {
    process(&walks(adjacency, |_| reward), reward.abs())
}

fn cold(process: &DecisionProcess, tau: f64) -> (Vec<f64>, SolveStatistics) {
    let tau = vec![tau; process.len()];
    SoftBellman::new(process).solve_cold(&tau, TOL)
}

/// By position.
fn gathered(process: &DecisionProcess, by_state: &[f64]) -> Vec<f64> {
    process
        .order()
        .iter()
        .map(|&s| by_state[s as usize])
        .collect()
}

/// V by state of walks at one temperature: u = e^{V/τ} obeys u_i = e^{r_i/τ} Σ_j P_ij u_j with u_0 = 1. By dense LU, 0 where there are no edges.
fn dense_walks(adjacency: &SymmetricCsr, reward: impl Fn(usize) -> f64, tau: f64) -> Vec<f64> {
    let n = adjacency.num_nodes();
    let mut matrix = Mat::<f64>::identity(n, n);
    for i in 1..n {
        let (columns, weights) = adjacency.row(i);
        let edges = || {
            columns
                .iter()
                .zip(weights)
                .filter(|(j, _)| **j as usize != i)
        };
        let total: f64 = edges().map(|(_, weight)| weight).sum();
        for (&j, weight) in edges() {
            matrix[(i, j as usize)] -= (reward(i) / tau).exp() * weight / total;
        }
    }
    let ends = Mat::from_fn(n, 1, |i, _| f64::from(i == 0));
    let u = matrix.partial_piv_lu().solve(&ends);
    (0..n).map(|i| tau * u[(i, 0)].ln()).collect()
}

fn assert_close(found: &[f64], expected: &[f64], tol: f64) {
    assert_eq!(found.len(), expected.len());
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tol, "{i}: {a} against {b}");
    }
}

// ---- the equation -----------------------------------------------------------------------------------------------

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn any_process_agrees_with_value_iteration(
        states in any_process(0.1),
        tau in prop::collection::vec(prop_oneof![Just(0.0), 1e-3_f64..0.1, 0.1_f64..6.0], 12),
        step_reward in 0.2_f64..3.0,
    ) {
        let tau = &tau[..states.len()];
        let process = process(&states, step_reward);
        let by_position = gathered(&process, tau);
        let (v, statistics) = SoftBellman::new(&process).solve_cold(&by_position, TOL);
        prop_assert!(statistics.converged && statistics.residual <= TOL, "{:?}", statistics);
        let expected = gathered(&process, &value_iteration(&states, tau));
        for (a, b) in v.iter().zip(&expected) {
            prop_assert!((a - b).abs() < 1e-7, "{} against {}", a, b);
        }
    }

    /// V lies between the mean of the choices and the best of them.
    #[test]
    fn no_temperature_makes_a_false_maximum(
        states in any_process(0.1),
        tau in prop::collection::vec(prop_oneof![Just(0.0), 1e-3_f64..100.0], 12),
    ) {
        let process = process(&states, 1.0);
        let by_position = gathered(&process, &tau);
        let (v, _) = SoftBellman::new(&process).solve_cold(&by_position, TOL);
        let v = process.scatter(&v);
        for (choices, value) in states.iter().zip(&v).filter(|(choices, _)| !choices.is_empty()) {
            let worths = worths(choices, &v);
            let best = worths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let total: f64 = choices.iter().map(|a| a.weight).sum();
            let mean: f64 = worths.iter().zip(choices).map(|(q, a)| q * a.weight / total).sum();
            prop_assert!(mean - 1e-9 <= *value && *value <= best + 1e-9, "{} ≤ {} ≤ {}", mean, value, best);
        }
    }

    #[test]
    fn any_graph_agrees_with_a_dense_solve(
        adjacency in any_graph(),
        costs in prop::collection::vec(0.02_f64..4.0, 24),
        tau in 0.5_f64..3.0,
    ) {
        // Connected, since what reaches no end goes on for ever.
        let n = adjacency.num_nodes();
        let edges = (0..n).flat_map(|i| adjacency.row(i).0.iter().map(move |&j| (i, j as usize)));
        let all: Vec<_> = edges.chain((1..n).map(|i| (i - 1, i))).collect();
        let adjacency = graph(n, &all);
        let reward = |i: usize| -costs[i];
        let process = process(&walks(&adjacency, reward), 1.0);
        let (v, statistics) = cold(&process, tau);
        prop_assert!(statistics.converged, "{:?}", statistics);
        let expected = gathered(&process, &dense_walks(&adjacency, reward, tau));
        for (a, b) in v.iter().zip(&expected) {
            prop_assert!((a - b).abs() < 1e-6, "{} against {}", a, b);
        }
    }
}

/// On the half-line u_k = x^k with x = e^{r/τ} (1 + x²) / 2: V falls by τ arcosh e^{−r/τ} a step, however far.
#[test]
fn a_long_path_falls_as_the_closed_form_says() {
    for (tau, most_sweeps) in [(1.0 / 0.7, 24), (10.0, 60)] {
        let process = uniform(&path(20_000), -1.0);
        let (v, statistics) = cold(&process, tau);
        assert!(
            statistics.converged && statistics.sweeps <= most_sweeps,
            "{statistics:?}"
        );
        for hops in [1, 10, 700, 15_000] {
            let expected = -tau * (1.0 / tau).exp().acosh() * hops as f64;
            let found = v[hops - 1];
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{found} against {expected}"
            );
        }
    }
}

#[test]
fn without_temperature_a_long_path_counts_steps() {
    let process = uniform(&path(20_000), -0.5);
    let (v, statistics) = cold(&process, 0.0);
    assert_eq!(
        (statistics.steps, statistics.sweeps),
        (0, 0),
        "the first guess is the answer"
    );
    for (hops, v) in (1..).zip(&v) {
        assert_eq!(*v, -0.5 * f64::from(hops));
    }
}

#[test]
fn grids_agree_with_a_dense_solve() {
    for (cells, tau) in [(grid(8, 7, &[]), 1.0), (grid(6, 6, &[]), 4.0)] {
        let reward = |i: usize| -0.1 - 0.3 * (i % 5) as f64;
        let process = process(&walks(&cells, reward), 0.7);
        let (v, statistics) = cold(&process, tau);
        assert!(statistics.converged);
        assert_close(
            &v,
            &gathered(&process, &dense_walks(&cells, reward, tau)),
            1e-9,
        );
    }
}

/// Where nearly all neighbours are far, carrying everything along would overshoot without end.
#[test]
fn complete_and_bipartite_graphs_and_stars_converge_at_high_temperature() {
    for adjacency in far_reaching_graphs() {
        let process = uniform(&adjacency, -1.0);
        for tau in [1000.0, 10.0, 0.3] {
            let (v, statistics) = cold(&process, tau);
            assert!(statistics.converged, "τ = {tau}: {statistics:?}");
            let expected = gathered(&process, &dense_walks(&adjacency, |_| -1.0, tau));
            assert_close(&v, &expected, 1e-6 * tau.max(1.0));
        }
    }
}

/// A tolerance below what rounding leaves is no reason to go on for ever.
#[test]
fn huge_returns_are_solved_as_far_as_numbers_go() {
    let process = uniform(&grid(12, 12, &[]), -1e15);
    let tau = vec![0.5e15; process.len()];
    let (v, statistics) = SoftBellman::new(&process).solve_cold(&tau, 1e-5);
    assert!(
        statistics.converged && statistics.sweeps < 200,
        "{statistics:?}"
    );
    let (small, _) = cold(&uniform(&grid(12, 12, &[]), -1.0), 0.5);
    for (large, small) in v.iter().zip(small) {
        assert!((large / 1e15 - small).abs() < 1e-9 * (1.0 + small.abs()));
    }
}

/// The number of sweeps grows with the temperature, but hardly with the size.
#[test]
fn large_grids_take_few_sweeps() {
    for side in [40, 160] {
        let process = uniform(&grid(side, side, &[]), -1.0);
        for (tau, most) in [(0.0, 0), (0.5, 20), (2.0, 60), (10.0, 400)] {
            let tau = vec![tau; process.len()];
            let (_, statistics) = SoftBellman::new(&process).solve_cold(&tau, 1e-5);
            assert!(
                statistics.converged && statistics.sweeps <= most,
                "{side}: {statistics:?}"
            );
        }
    }
}

#[test]
fn a_process_without_states_is_solved() {
    let process = process(&[vec![], vec![]], 1.0);
    let (v, statistics) = cold(&process, 1.0);
    assert!(v.is_empty() && statistics.converged);
}

// ---- the way there ----------------------------------------------------------------------------------------------

/// A guess is a matter of time, never of the result.
#[test]
fn any_guess_ends_at_the_same_place() {
    let process = uniform(&grid(30, 30, &[]), -0.2);
    for tau in [vec![1.0; 899], vec![0.0; 899]] {
        let (exact, _) = SoftBellman::new(&process).solve_cold(&tau, TOL);
        let misleading: [&dyn Fn(usize) -> f64; 6] = [
            &|_| 0.0,
            &|i| -1e9 * (i % 2) as f64,
            &|i| 1e3 - i as f64,
            &|i| match i % 7 {
                0 => f64::NAN,
                _ => (i as f64 * 0.9).sin() * 50.0,
            },
            &|i| if i % 3 == 0 { f64::MAX } else { -1e300 },
            &|_| f64::INFINITY,
        ];
        for (number, guess) in misleading.into_iter().enumerate() {
            let guess: Vec<f64> = (0..process.len()).map(guess).collect();
            let (v, statistics) = SoftBellman::new(&process).solve_near(&guess, &tau, TOL);
            assert!(statistics.converged, "{number}: {statistics:?}");
            assert_close(&v, &exact, 1e-6);
        }
    }
}

#[test]
fn a_warm_start_ends_at_the_same_place_sooner() {
    let process = uniform(&grid(40, 40, &[]), -0.7);
    let mut solver = SoftBellman::new(&process);
    let tau = vec![1.0; process.len()];
    let (before, cold) = solver.solve_cold(&tau, TOL);
    let nearby: Vec<f64> = (0..process.len())
        .map(|i| 1.0 + 1e-4 * (i % 3) as f64)
        .collect();
    let (fresh, _) = solver.solve_cold(&nearby, TOL);
    let (v, warm) = solver.solve_near(&before, &nearby, TOL);
    assert!(
        warm.converged && warm.sweeps < cold.sweeps,
        "{warm:?} after {cold:?}"
    );
    assert_close(&v, &fresh, 1e-7);
    let (_, again) = solver.solve_near(&v, &nearby, TOL);
    assert_eq!((again.steps, again.sweeps), (0, 0));
    // Following costs what it is told to, and comes as near.
    let mut followed = before;
    (0..6).for_each(|_| solver.follow(&nearby, &mut followed, 10));
    assert_close(&followed, &fresh, 1e-7);
}

/// With exact steps V only rises from the second iterate on, whatever the start.
#[test]
fn newton_is_monotone() {
    let process = uniform(&grid(12, 12, &[]), -0.3);
    for temperature in [0.0, 0.2, 1.0] {
        let tau = vec![temperature; process.len()];
        let mut solver = SoftBellman::new(&process);
        // Not too high, or the policy walks in circles where it pays.
        let mut v: Vec<f64> = (0..process.len())
            .map(|i| -10.0 + 0.1 * (i as f64).sin() - i as f64)
            .collect();
        let mut exact_step = |v: &mut Vec<f64>| {
            solver.update(&tau, v);
            let residual = solver.set_residual(v);
            let right = solver.residual.clone();
            let mut step = vec![0.0; right.len()];
            solver.solve_linear(&right, &mut step, 1e-14, 100_000);
            v.iter_mut().zip(&step).for_each(|(v, step)| *v += step);
            residual
        };
        exact_step(&mut v);
        for _ in 0..25 {
            let before = v.clone();
            exact_step(&mut v);
            let rounding = 1e-9 * before.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
            assert!(
                v.iter()
                    .zip(&before)
                    .all(|(new, old)| *new >= old - rounding)
            );
        }
        assert!(exact_step(&mut v) < TOL, "{temperature}");
    }
}

#[test]
fn nan_is_a_result_that_has_not_converged() {
    let reward = |i: usize| if i == 2 { f64::NAN } else { -1.0 };
    let process = process(&walks(&path(5), reward), 1.0);
    for tau in [0.0, 0.5] {
        let (v, statistics) = cold(&process, tau);
        assert!(!statistics.converged, "{statistics:?}");
        assert!(!statistics.residual.is_finite(), "{statistics:?}");
        assert!(v.iter().any(|v| !v.is_finite()), "{v:?}");
    }
    let (v, statistics) =
        SoftBellman::new(&uniform(&path(3), -1.0)).solve_cold(&[f64::NAN; 2], TOL);
    assert!(
        !statistics.converged && v.iter().any(|v| v.is_nan()),
        "{statistics:?} {v:?}"
    );
}

/// Three states that lead to each other for ever, beside a long way to an end: V is the discounted return of going round.
#[test]
fn a_ring_without_an_end_has_its_discounted_return() {
    let len = 3_u32;
    let g = 1.0 - 1.0 / (10.0 * f64::from(len));
    let mut states: Vec<Vec<Alternative>> = vec![vec![]];
    for i in 1..len {
        let before = Alternative::new(-1.0, i == 1, &[(i - 1, g)]);
        states.push(vec![before]);
    }
    let rewards = [-1.0, -7.0, -3.0];
    for (k, reward) in rewards.into_iter().enumerate() {
        states.push(vec![Alternative::new(
            reward,
            false,
            &[(len + (k as u32 + 1) % 3, g)],
        )]);
    }
    let process = process(&states, 1.0);
    assert_eq!(process.len() - process.num_reached(), 3);
    for tau in [0.0, 2.0] {
        let (v, statistics) = cold(&process, tau);
        assert!(statistics.converged, "{statistics:?}");
        let v = process.scatter(&v);
        let round = |k: usize| rewards[k % 3];
        for k in 0..3 {
            let once = round(k) + g * round(k + 1) + g * g * round(k + 2);
            let expected = once / (1.0 - g.powi(3));
            let found = v[len as usize + k];
            assert!(
                (found / expected - 1.0).abs() < 1e-6,
                "{found} against {expected}"
            );
        }
    }
}

// ---- derivatives ------------------------------------------------------------------------------------------------

/// x of (I − W) x = b or (I − Wᵀ) x = b by dense LU.
fn dense(solver: &SoftBellman<'_>, b: &[f64], transposed: bool) -> Vec<f64> {
    let n = b.len();
    let mut matrix = Mat::<f64>::identity(n, n);
    for i in 0..n {
        for e in solver.process.range(i) {
            let j = solver.process.columns()[e] as usize;
            let place = if transposed { (j, i) } else { (i, j) };
            matrix[place] -= solver.weights[e];
        }
    }
    let right = Mat::from_fn(n, 1, |i, _| b[i]);
    let x = matrix.partial_piv_lu().solve(&right);
    (0..n).map(|i| x[(i, 0)]).collect()
}

fn assert_solves(solver: &mut SoftBellman<'_>, b: &[f64]) {
    for transposed in [false, true] {
        let mut x = vec![0.0; b.len()];
        if transposed {
            solver.solve_transposed(b, &mut x, 1e-14, 10_000);
        } else {
            solver.solve_linear(b, &mut x, 1e-14, 10_000);
        }
        let expected = dense(solver, b, transposed);
        let largest = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        assert_close(&x, &expected, 1e-9 * largest);
    }
}

fn solved<'p>(process: &'p DecisionProcess, tau: &[f64]) -> (SoftBellman<'p>, Vec<f64>) {
    let mut solver = SoftBellman::new(process);
    let (v, statistics) = solver.solve_cold(tau, 1e-12);
    assert!(statistics.residual < 1e-10, "{statistics:?}");
    (solver, v)
}

/// Of walks on this graph, with costs and temperatures that differ from place to place.
fn uneven(adjacency: &SymmetricCsr) -> (DecisionProcess, Vec<f64>) {
    let process = process(&walks(adjacency, |i| -0.2 - 0.2 * (i % 4) as f64), 0.5);
    let tau = (0..process.len())
        .map(|i| 0.6 + 0.4 * (i % 3) as f64)
        .collect();
    (process, tau)
}

#[test]
fn both_systems_agree_with_a_dense_solve() {
    let spider = graph(8, &[(0, 1), (1, 2), (1, 3), (1, 4), (1, 5), (1, 6), (6, 7)]);
    for adjacency in [grid(7, 6, &[]), path(40), spider] {
        let (process, tau) = uneven(&adjacency);
        let b: Vec<f64> = (0..process.len()).map(|i| (i % 3) as f64 - 0.7).collect();
        assert_solves(&mut solved(&process, &tau).0, &b);
    }
}

/// What flows in at the far end must flow out at the goal; and the number of sweeps does not grow with the length.
#[test]
fn a_long_path_takes_few_sweeps() {
    let process = uniform(&path(5_000), -0.7);
    let (mut solver, _) = solved(&process, &vec![1.0; process.len()]);
    let n = process.len();
    let (mut b, mut x) = (vec![0.0; n], vec![0.0; n]);
    b[n - 1] = 1.0;
    let sweeps = solver.solve_transposed(&b, &mut x, 1e-12, 100);
    assert!(sweeps < 30, "{sweeps} sweeps");
    // All but what goes on to the second position ends.
    let into_goal = 1.0 - solver.weights[process.range(0)].iter().sum::<f64>();
    assert!(
        (x[0] * into_goal - 1.0).abs() < 1e-9,
        "{} · {into_goal}",
        x[0]
    );
    x.fill(0.0);
    assert!(solver.solve_linear(&vec![1.0; n], &mut x, 1e-12, 100) < 30);
    let again = solver.solve_linear(&vec![1.0; n], &mut x, 1e-8, 100);
    assert_eq!(again, 1, "a solution is kept");
}

/// −KL(π‖w) is how V̂ changes with the temperature while Q stays as it is.
#[test]
fn the_divergence_is_the_derivative_by_the_temperature() {
    let (process, tau) = uneven(&grid(5, 4, &[]));
    let (mut solver, v) = solved(&process, &tau);
    let divergence = solver.divergence().to_vec();
    let mut at = |shift: f64| {
        let tau: Vec<f64> = tau.iter().map(|tau| tau + shift).collect();
        solver.update(&tau, &v);
        solver.backed_up.clone()
    };
    let (above, below) = (at(1e-5), at(-1e-5));
    for (i, divergence) in divergence.iter().enumerate() {
        let expected = (below[i] - above[i]) / 2e-5;
        assert!(
            (divergence - expected).abs() < 1e-8,
            "{i}: {divergence} against {expected}"
        );
    }
    assert!(divergence.iter().any(|&kl| kl > 0.1));
    let (solver, _) = solved(&process, &vec![0.0; tau.len()]);
    assert!(solver.divergence().iter().all(|&kl| kl == 0.0));
}

/// dℓ/dτ_i = −μ_i KL_i for ℓ = Σ g_i V_i, against central differences of whole solves.
fn assert_gradient_is_right(process: &DecisionProcess, tau: &[f64], g: &[f64]) {
    let mut mu = vec![0.0; tau.len()];
    let (mut solver, _) = solved(process, tau);
    solver.solve_transposed(g, &mut mu, 1e-14, 10_000);
    let gradient: Vec<f64> = mu
        .iter()
        .zip(solver.divergence())
        .map(|(mu, kl)| -mu * kl)
        .collect();
    let largest = gradient.iter().fold(1e-2_f64, |m, x| m.max(x.abs()));
    for (i, found) in gradient.iter().enumerate() {
        let loss = |step: f64| -> f64 {
            let mut tau = tau.to_vec();
            tau[i] += step;
            solved(process, &tau)
                .1
                .iter()
                .zip(g)
                .map(|(v, g)| v * g)
                .sum()
        };
        let expected = (loss(1e-5) - loss(-1e-5)) / 2e-5;
        let error = (found - expected).abs() / largest;
        assert!(error < 1e-5, "position {i}: {found} against {expected}");
    }
}

#[test]
fn gradients_agree_with_finite_differences() {
    for adjacency in [grid(6, 5, &[]), path(30)] {
        let (process, tau) = uneven(&adjacency);
        let g: Vec<f64> = (0..tau.len()).map(|i| (i % 3) as f64 - 0.7).collect();
        assert_gradient_is_right(&process, &tau, &g);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_process_agrees_with_a_dense_solve(
        states in any_process(0.1),
        tau in prop::collection::vec(0.0_f64..2.0, 12),
        b in prop::collection::vec(-1.0_f64..1.0, 12),
    ) {
        let process = process(&states, 1.0);
        let n = process.len();
        assert_solves(&mut solved(&process, &tau[..n]).0, &b[..n]);
    }

    #[test]
    fn any_process_has_the_right_gradient(
        states in any_process(0.1),
        tau in prop::collection::vec(0.2_f64..3.0, 12),
        g in prop::collection::vec(-1.0_f64..1.0, 12),
    ) {
        let process = process(&states, 1.0);
        let n = process.len();
        assert_gradient_is_right(&process, &tau[..n], &g[..n]);
    }
}
