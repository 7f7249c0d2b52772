//! Proto-value features against tables, and what happens when the basis moves.

use eigentrail::agent::{
    ActorCritic, ActorCriticParams, Agent, Bootstrap, Experience, ProtoValueFeatures, Situation,
    Tabular, UpdateRule,
};
use eigentrail::env::{Action, StepStatus};
use eigentrail::graph::StateId;
use eigentrail::seeds::{Stream, stream};
use faer::Mat;
use rand::RngExt;

const ACTIONS: usize = 3;
const ADVICE: [f64; ACTIONS] = [0.0, 0.5, -0.5];

/// n × k with entries uniform in ±1.
fn random_matrix(n: usize, k: usize, seed: u64) -> Mat<f64> {
    let mut rng = stream(seed, Stream::Spectral);
    Mat::from_fn(n, k, |_, _| rng.random_range(-1.0..1.0))
}

/// n × k, orthonormal columns.
fn orthonormal(n: usize, k: usize, seed: u64) -> Mat<f64> {
    random_matrix(n, k, seed).qr().compute_thin_Q()
}

fn pvf_agent(params: &ActorCriticParams) -> ActorCritic<ProtoValueFeatures> {
    ActorCritic::new(
        params.clone(),
        ProtoValueFeatures::new(ACTIONS),
        ACTIONS,
        1.0,
        9,
    )
}

/// `steps` steps among the states `0..n`, the same whoever learns from them.
fn learn(agent: &mut impl Agent, n: u32, steps: u32) {
    let mut rng = stream(5, Stream::Environment);
    for _ in 0..steps {
        let (state, next) = (
            StateId(rng.random_range(0..n)),
            StateId(rng.random_range(0..n)),
        );
        let action = Action(rng.random_range(0..ACTIONS as u16));
        let reward = rng.random_range(-1.0..0.5);
        let status = if rng.random_bool(0.1) {
            StepStatus::Terminated
        } else {
            StepStatus::Running
        };
        let next = Situation {
            state: next,
            advice: &ADVICE,
        };
        agent.update(&Experience {
            state,
            action,
            reward,
            shaping: 0.0,
            next,
            status,
        });
    }
}

/// Every (state, action) of the first `n` states.
fn pairs(n: u32) -> impl Iterator<Item = (StateId, Action)> {
    (0..n).flat_map(|s| (0..ACTIONS as u16).map(move |a| (StateId(s), Action(a))))
}

fn predictions(agent: &ActorCritic<ProtoValueFeatures>, n: u32) -> Vec<(f64, f64)> {
    pairs(n)
        .map(|(s, a)| (agent.action_value(s, a), agent.preference(s, a)))
        .collect()
}

#[track_caller]
fn assert_same(left: &[(f64, f64)], right: &[(f64, f64)], tolerance: f64) {
    for (i, (l, r)) in left.iter().zip(right).enumerate() {
        let off = (l.0 - r.0).abs().max((l.1 - r.1).abs());
        assert!(off < tolerance, "prediction {i}: {l:?} against {r:?}");
    }
}

/// k = n orthonormal features are a table in other coordinates, whatever their scale.
#[test]
fn a_full_basis_learns_what_a_table_learns() {
    const N: u32 = 12;
    for update in [
        UpdateRule::Advantage,
        UpdateRule::Algorithm1,
        UpdateRule::Algorithm2,
    ] {
        for (bootstrap, scale) in [
            (Bootstrap::Expected, 1.0),
            (Bootstrap::Sampled, f64::from(N).sqrt()),
        ] {
            let rates = ActorCriticParams {
                gamma: 0.9,
                bootstrap,
                ..ActorCriticParams::default()
            };
            let params = ActorCriticParams { update, ..rates };
            let mut table =
                ActorCritic::new(params.clone(), Tabular::new(ACTIONS), ACTIONS, 1.0, 9);
            let mut pvf = pvf_agent(&params);
            let features = faer::Scale(scale) * orthonormal(N as usize, N as usize, 1);
            pvf.set_features(features.as_ref());
            learn(&mut table, N, 400);
            learn(&mut pvf, N, 400);
            for (s, a) in pairs(N) {
                assert!(
                    (table.action_value(s, a) - pvf.action_value(s, a)).abs() < 1e-9,
                    "{update:?}"
                );
                assert!(
                    (table.preference(s, a) - pvf.preference(s, a)).abs() < 1e-9,
                    "{update:?}"
                );
            }
            assert!(pairs(N).any(|(s, a)| table.preference(s, a).abs() > 0.01));
        }
    }
}

#[test]
fn a_new_basis_that_spans_the_old_keeps_every_prediction() {
    const N: u32 = 30;
    let old = orthonormal(30, 6, 1);
    let mut agent = pvf_agent(&ActorCriticParams {
        gamma: 0.9,
        ..ActorCriticParams::default()
    });
    agent.set_features(old.as_ref());
    learn(&mut agent, N, 300);
    let before = predictions(&agent, N);

    let turned = &old * orthonormal(6, 6, 2);
    let mut wider = random_matrix(30, 9, 3);
    wider.as_mut().subcols_mut(2, 6).copy_from(&turned);
    agent.set_features(wider.as_ref());
    assert_same(&predictions(&agent, N), &before, 1e-8);

    // Five new states, and room in the basis for what they say.
    let mut taller = random_matrix(35, 16, 4);
    taller.as_mut().submatrix_mut(0, 0, 30, 9).copy_from(&wider);
    agent.set_features(taller.as_ref());
    assert_same(&predictions(&agent, N), &before, 1e-4);
}

/// Where the new basis cannot say it all, no other weights come closer.
#[test]
fn a_narrower_basis_keeps_the_least_squares_fit() {
    const N: u32 = 30;
    let mut agent = pvf_agent(&ActorCriticParams {
        gamma: 0.9,
        ..ActorCriticParams::default()
    });
    agent.set_features(orthonormal(30, 8, 1).as_ref());
    learn(&mut agent, N, 300);
    let before = predictions(&agent, N);
    let narrow = orthonormal(30, 4, 7);
    agent.set_features(narrow.as_ref());
    let after = predictions(&agent, N);
    for feature in 0..4 {
        for a in 0..ACTIONS {
            let residual: f64 = (0..30)
                .map(|s| {
                    narrow[(s, feature)] * (after[s * ACTIONS + a].0 - before[s * ACTIONS + a].0)
                })
                .sum();
            assert!(
                residual.abs() < 1e-9,
                "the residual is orthogonal to the basis: {residual}"
            );
        }
    }
    assert!(
        before
            .iter()
            .zip(&after)
            .any(|(b, a)| (b.0 - a.0).abs() > 1e-3),
        "something was lost"
    );
}

#[test]
fn states_beyond_the_basis_share_what_is_learnt_and_disturb_nothing() {
    let mut agent = pvf_agent(&ActorCriticParams::default());
    agent.set_features(orthonormal(5, 3, 1).as_ref());
    learn(&mut agent, 5, 50);
    let before = predictions(&agent, 5);
    let next = Situation {
        state: StateId(77),
        advice: &ADVICE,
    };
    let beyond = Experience {
        state: StateId(60),
        action: Action(1),
        reward: -3.0,
        shaping: 0.0,
        next,
        status: StepStatus::Terminated,
    };
    agent.update(&beyond);
    assert_eq!(predictions(&agent, 5), before);
    assert!((agent.action_value(StateId(60), Action(1)) - 0.7 * -3.0).abs() < 1e-12);
    assert_eq!(
        agent.action_value(StateId(61), Action(1)),
        agent.action_value(StateId(60), Action(1))
    );
}

#[test]
fn features_that_are_no_numbers_are_left_out() {
    let mut agent = pvf_agent(&ActorCriticParams {
        gamma: 0.9,
        ..ActorCriticParams::default()
    });
    agent.set_features(orthonormal(8, 4, 1).as_ref());
    learn(&mut agent, 8, 50);
    let before = predictions(&agent, 8);
    let mut broken = orthonormal(8, 4, 2);
    broken[(3, 2)] = f64::NAN;
    for features in [broken, Mat::zeros(8, 4), Mat::zeros(0, 0)] {
        agent.set_features(features.as_ref());
        assert_eq!(predictions(&agent, 8), before);
    }
}

/// A row far longer than the average would make a critic step of 0.7 overshoot, and diverge.
#[test]
fn long_rows_do_not_diverge() {
    let mut features = orthonormal(40, 3, 1);
    for j in 0..3 {
        features[(0, j)] = 5.0;
    }
    let mut agent = pvf_agent(&ActorCriticParams {
        gamma: 0.9,
        ..ActorCriticParams::default()
    });
    agent.set_features(features.as_ref());
    for _ in 0..200 {
        learn(&mut agent, 1, 50);
    }
    for (value, preference) in predictions(&agent, 40) {
        assert!(value.abs() < 100.0 && preference.abs() <= 3.0, "{value}");
    }
}
