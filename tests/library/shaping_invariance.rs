//! Shaping leaves the optimal policies as they are, and why φ must be 0 after termination: value iteration on small
//! MDPs, with every F taken from `RewardShaper`. The solver here is the tests' own, so that it can judge the library.

use eigentrail::env::StepStatus;
use eigentrail::gcn::GcnParams;
use eigentrail::graph::{StateId, SymmetricCsr};
use eigentrail::shaping::{PotentialKind, RewardShaper, ShapingParams, potential_on_graph};
use faer::Mat;
use proptest::prelude::*;

/// Actions whose values differ by less are both optimal. Value iteration stops at 1e-11.
const TIE: f64 = 1e-7;

/// One possible outcome of an action.
#[derive(Clone, Copy, Debug)]
struct Outcome {
    probability: f64,
    next: usize,
    reward: f64,
    terminal: bool,
}

/// `outcomes[s][a]`; a terminal outcome's `next` only names the state for φ.
#[derive(Clone, Debug)]
struct Mdp {
    outcomes: Vec<Vec<Vec<Outcome>>>,
}

/// F of one step that enters `next` from a state entered with φ_s.
fn shaping(gamma: f64, phi: &[f64], state: usize, outcome: &Outcome) -> f64 {
    let status = if outcome.terminal {
        StepStatus::Terminated
    } else {
        StepStatus::Running
    };
    let mut shaper = RewardShaper::new(gamma);
    shaper.begin_episode(phi[state]);
    shaper.shape(phi[outcome.next], status)
}

impl Mdp {
    /// The same MDP with R + F.
    fn shaped(&self, f: impl Fn(usize, &Outcome) -> f64) -> Mdp {
        let mut shaped = self.clone();
        for (state, actions) in shaped.outcomes.iter_mut().enumerate() {
            for outcome in actions.iter_mut().flatten() {
                outcome.reward += f(state, outcome);
            }
        }
        shaped
    }

    /// Q* by value iteration.
    fn optimal_q(&self, gamma: f64) -> Vec<Vec<f64>> {
        let mut v = vec![0.0; self.outcomes.len()];
        loop {
            let q = self.backup(gamma, &v);
            let new: Vec<f64> = q
                .iter()
                .map(|q| q.iter().copied().fold(f64::NEG_INFINITY, f64::max))
                .collect();
            let change = v
                .iter()
                .zip(&new)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            v = new;
            if change < 1e-11 {
                return q;
            }
        }
    }

    fn backup(&self, gamma: f64, v: &[f64]) -> Vec<Vec<f64>> {
        let value = |o: &Outcome| {
            o.probability * (o.reward + if o.terminal { 0.0 } else { gamma * v[o.next] })
        };
        let action = |outcomes: &Vec<Outcome>| outcomes.iter().map(value).sum();
        self.outcomes
            .iter()
            .map(|actions| actions.iter().map(action).collect())
            .collect()
    }
}

/// The optimal actions of each state.
fn greedy(q: &[Vec<f64>]) -> Vec<Vec<usize>> {
    q.iter()
        .map(|q| {
            let best = q.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (0..q.len()).filter(|&a| q[a] > best - TIE).collect()
        })
        .collect()
}

/// MDPs of 2 to 6 states and 2 or 3 actions; each action has two ordinary outcomes and one that ends the episode with
/// probability at least 0.1, so that γ = 1 is well-defined.
fn any_mdp() -> impl Strategy<Value = Mdp> {
    (2_usize..=6, 2_usize..=3).prop_flat_map(|(states, actions)| {
        let outcome = (0..states, -5.0_f64..5.0);
        let action = (
            outcome.clone(),
            outcome.clone(),
            outcome,
            0.1_f64..0.5,
            0.0_f64..1.0,
        );
        let action = action.prop_map(|(first, second, last, end, split)| {
            let rest = 1.0 - end;
            [
                (first, rest * split, false),
                (second, rest * (1.0 - split), false),
                (last, end, true),
            ]
            .map(|((next, reward), probability, terminal)| Outcome {
                probability,
                next,
                reward,
                terminal,
            })
            .to_vec()
        });
        prop::collection::vec(prop::collection::vec(action, actions), states)
            .prop_map(|outcomes| Mdp { outcomes })
    })
}

proptest! {
    /// Q′* = Q* − φ, hence the same optimal actions, for any φ and any γ.
    #[test]
    fn any_potential_keeps_the_optimal_actions(
        mdp in any_mdp(),
        phi in prop::collection::vec(-20.0_f64..20.0, 6),
        gamma in prop::sample::select(vec![0.0, 0.5, 0.9, 0.99, 1.0]),
    ) {
        let plain = mdp.optimal_q(gamma);
        let shaped = mdp.shaped(|s, o| shaping(gamma, &phi, s, o)).optimal_q(gamma);
        for (s, (plain, shaped)) in plain.iter().zip(&shaped).enumerate() {
            for (a, b) in plain.iter().zip(shaped) {
                prop_assert!((a - phi[s] - b).abs() < 1e-8, "{} − {} against {}", a, phi[s], b);
            }
        }
        prop_assert_eq!(greedy(&plain), greedy(&shaped));
    }
}

/// From state 0: exit at once for −2, or walk to state 1 and exit there for −1 − 0.5.
fn two_exits() -> Mdp {
    let sure = |next, reward, terminal| {
        vec![Outcome {
            probability: 1.0,
            next,
            reward,
            terminal,
        }]
    };
    Mdp {
        outcomes: vec![
            vec![sure(2, -2.0, true), sure(1, -1.0, false)],
            vec![sure(3, -0.5, true), sure(3, -0.5, true)],
            vec![],
            vec![],
        ],
    }
}

/// Grześ (2017): with φ(terminal) ≠ 0 the better exit changes. The same potential with the shaper's rule is harmless.
#[test]
fn a_potential_that_survives_termination_changes_the_policy() {
    let mdp = two_exits();
    let phi = [-2.0, -1.0, 3.0, 0.0];
    for gamma in [0.5, 0.9, 1.0] {
        let naive = mdp.shaped(|s, o| gamma * phi[o.next] - phi[s]);
        let proper = mdp.shaped(|s, o| shaping(gamma, &phi, s, o));
        let first = |mdp: &Mdp| greedy_of_start(mdp, gamma);
        assert_eq!(first(&proper), first(&mdp), "γ = {gamma}");
        assert_ne!(first(&naive), first(&mdp), "γ = {gamma}");
    }
}

fn greedy_of_start(mdp: &Mdp, gamma: f64) -> Vec<usize> {
    // States 2 and 3 are only names of exits: they have no actions.
    let reachable = Mdp {
        outcomes: mdp.outcomes[..2].to_vec(),
    };
    greedy(&reachable.optimal_q(gamma))[0].clone()
}

/// Expected discounted return from state 0 of a deterministic policy, by carrying the distribution over states
/// forward; F from `f(t, state, outcome)`.
fn expected_return(
    mdp: &Mdp,
    policy: &[usize],
    gamma: f64,
    f: impl Fn(usize, usize, &Outcome) -> f64,
) -> f64 {
    let mut distribution = vec![0.0; mdp.outcomes.len()];
    distribution[0] = 1.0;
    let (mut total, mut discount) = (0.0, 1.0);
    // At least a tenth of the mass ends in each step: 0.9^400 < 1e-18.
    for t in 0..400 {
        let mut next = vec![0.0; distribution.len()];
        for (state, mass) in distribution.iter().enumerate() {
            for outcome in &mdp.outcomes[state][policy[state]] {
                let mass = mass * outcome.probability;
                total += discount * mass * (outcome.reward + f(t, state, outcome));
                if !outcome.terminal {
                    next[outcome.next] += mass;
                }
            }
        }
        distribution = next;
        discount *= gamma;
    }
    total
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Devlin & Kudenko (2012): φ is another one at every step, and each policy's return still moves by −φ_0(s_0) only.
    #[test]
    fn a_potential_that_changes_moves_all_policies_alike(
        mdp in any_mdp(),
        phis in prop::collection::vec(prop::collection::vec(-9.0_f64..9.0, 6), 3..8),
        gamma in prop::sample::select(vec![0.5, 0.95, 1.0]),
        choices in prop::collection::vec(prop::collection::vec(0_usize..2, 6), 4),
    ) {
        let phi = |t: usize| &phis[t % phis.len()];
        for policy in choices {
            let plain = expected_return(&mdp, &policy, gamma, |_, _, _| 0.0);
            let shaped = expected_return(&mdp, &policy, gamma, |t, state, outcome| {
                let mut shaper = RewardShaper::new(gamma);
                shaper.begin_episode(phi(t)[state]);
                let ended = outcome.terminal;
                let status = if ended { StepStatus::Terminated } else { StepStatus::Running };
                shaper.shape(phi(t + 1)[outcome.next], status)
            });
            let expected = plain - phi(0)[0];
            prop_assert!((shaped - expected).abs() < 1e-9, "{} against {}", shaped, expected);
        }
    }
}

/// A 5 × 6 grid with slip 0.2, reward −1 a step, goal in the corner 29.
fn slippery_grid() -> (Mdp, SymmetricCsr) {
    let (rows, columns, goal) = (5_i32, 6_i32, 29_usize);
    let directions = [(-1, 0), (0, 1), (1, 0), (0, -1)];
    let mut triplets = sprs::TriMatI::<f64, u32>::new((30, 30));
    let target = |s: usize, (dr, dc): (i32, i32)| {
        let (r, c) = (s as i32 / columns + dr, s as i32 % columns + dc);
        let inside = (0..rows).contains(&r) && (0..columns).contains(&c);
        if inside {
            (r * columns + c) as usize
        } else {
            s
        }
    };
    let outcomes = (0..30)
        .map(|s| {
            for direction in directions.into_iter().filter(|&d| target(s, d) != s) {
                triplets.add_triplet(s, target(s, direction), 1.0);
            }
            let outcome = |probability, direction| {
                let next = target(s, direction);
                Outcome {
                    probability,
                    next,
                    reward: -1.0,
                    terminal: next == goal,
                }
            };
            let action = |a: usize| {
                let sideways = [directions[(a + 1) % 4], directions[(a + 3) % 4]];
                let mut outcomes = vec![outcome(0.8, directions[a])];
                outcomes.extend(sideways.map(|d| outcome(0.1, d)));
                outcomes
            };
            (0..4).map(action).collect()
        })
        .collect();
    (
        Mdp { outcomes },
        SymmetricCsr::new(triplets.to_csr()).unwrap(),
    )
}

#[test]
fn every_kind_of_potential_keeps_the_optimal_actions() {
    let (mdp, adjacency) = slippery_grid();
    let plain = greedy(&mdp.optimal_q(1.0));
    let features = Mat::from_fn(30, 4, |i, c| ((i + 1) as f64 * (c + 1) as f64 * 0.7).cos());
    for kind in [
        PotentialKind::Gcn,
        PotentialKind::Report,
        PotentialKind::Heat,
        PotentialKind::Dr,
        PotentialKind::Sr,
        PotentialKind::Hops,
        PotentialKind::Random,
    ] {
        let fit = potential_on_graph(
            &adjacency,
            &[StateId(29)],
            kind,
            features.as_ref(),
            &ShapingParams::default(),
            &GcnParams::default(),
            1,
        )
        .unwrap();
        let shaped = mdp.shaped(|s, o| shaping(1.0, &fit.values, s, o));
        // The goal itself is never acted in.
        assert_eq!(greedy(&shaped.optimal_q(1.0))[..29], plain[..29], "{kind}");
    }
}
