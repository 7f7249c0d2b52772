//! Single updates against numbers worked out by hand.

use eigentrail::agent::{
    ActorCritic, ActorCriticParams, Agent, AgentKind, AgentParams, AnyAgent, Bootstrap, Experience,
    Planner, PlannerParams, PolicyIteration, PolicyIterationParams, Sarsa, SarsaParams, Situation,
    Tabular, UpdateRule,
};
use eigentrail::env::{Action, StepStatus};
use eigentrail::graph::StateId;

const ROUNDING: f64 = 1e-14;
const NO_ADVICE: [f64; 2] = [0.0, 0.0];

fn experience(
    state: u32,
    action: u16,
    reward: f64,
    next: u32,
    status: StepStatus,
) -> Experience<'static> {
    let next = Situation {
        state: StateId(next),
        advice: &NO_ADVICE,
    };
    Experience {
        state: StateId(state),
        action: Action(action),
        reward,
        shaping: 0.0,
        next,
        status,
    }
}

#[track_caller]
fn assert_close(actual: f64, expected: f64) {
    assert!(
        (actual - expected).abs() < ROUNDING,
        "{actual} instead of {expected}"
    );
}

/// γ = 0.5, critic 0.5, actor 0.1.
fn actor_critic(update: UpdateRule) -> ActorCritic<Tabular> {
    let params = ActorCriticParams {
        update,
        gamma: 0.5,
        actor_learning_rate: 0.1,
        critic_learning_rate: 0.5,
        preference_clip: 3.0,
        bootstrap: Bootstrap::Expected,
    };
    ActorCritic::new(params, Tabular::new(2), 2, 1.0, 0)
}

/// Two steps: (1, 0) → end with reward 8, and (0, 1) → 1 with reward −2.
///
/// First: δ = 8, Q(1, 0) = 4. Second: V(1) = ½·4 + ½·0 where π(·|1) is still uniform.
fn after_two_steps(update: UpdateRule) -> (ActorCritic<Tabular>, f64, f64) {
    let mut agent = actor_critic(update);
    let first = agent.update(&experience(1, 0, 8.0, 2, StepStatus::Terminated));
    assert_close(first.td_error, 8.0);
    assert_close(agent.action_value(StateId(1), Action(0)), 4.0);
    let preference = agent.preference(StateId(1), Action(0));
    let chance = 1.0 / (1.0 + (-2.0 * preference).exp()); // the other preference is its negative
    let second = agent.update(&experience(0, 1, -2.0, 1, StepStatus::Running));
    let td_error = -2.0 + 0.5 * chance * 4.0;
    assert_close(second.td_error, td_error);
    assert_close(agent.action_value(StateId(0), Action(1)), 0.5 * td_error);
    (agent, preference, td_error)
}

#[test]
fn advantage_moves_the_actor_by_the_new_q_less_its_mean() {
    let (agent, preference, td_error) = after_two_steps(UpdateRule::Advantage);
    // Q(1, 0) = 4 after the critic's step, mean ½·4, ∇ = (½, −½): 0.1 · 2 · ½
    assert_close(preference, 0.1);
    // Q(0, 1) = δ/2, mean δ/4; 0.1 · δ/4 · ½ for the action taken
    assert_close(
        agent.preference(StateId(0), Action(1)),
        0.1 * td_error / 4.0 * 0.5,
    );
    assert_close(
        agent.preference(StateId(0), Action(0)),
        -0.1 * td_error / 4.0 * 0.5,
    );
}

#[test]
fn algorithm_1_moves_the_actor_by_the_td_error() {
    let (agent, preference, td_error) = after_two_steps(UpdateRule::Algorithm1);
    assert_close(preference, 0.1 * 8.0 * 0.5);
    assert_close(
        agent.preference(StateId(0), Action(1)),
        0.1 * td_error * 0.5,
    );
}

#[test]
fn algorithm_2_moves_the_actor_by_the_q_before_the_critic_step_and_keeps_theta() {
    let (mut agent, preference, _) = after_two_steps(UpdateRule::Algorithm2);
    // Q was 0 before either step
    assert_close(preference, 0.0);
    assert_close(agent.preference(StateId(0), Action(1)), 0.0);
    // again: now Q(1, 0) = 4 comes first, then δ = 8 − 4
    agent.update(&experience(1, 0, 8.0, 2, StepStatus::Terminated));
    assert_close(agent.preference(StateId(1), Action(0)), 0.1 * 4.0 * 0.5);
    assert_close(agent.action_value(StateId(1), Action(0)), 6.0);
    // and again: θ is added to, not replaced
    let chance = 1.0 / (1.0 + (-0.4f64).exp());
    agent.update(&experience(1, 0, 8.0, 2, StepStatus::Terminated));
    assert_close(
        agent.preference(StateId(1), Action(0)),
        0.2 + 0.1 * 6.0 * (1.0 - chance),
    );
}

#[test]
fn advice_is_part_of_the_gradient_but_not_of_the_preferences() {
    let mut agent = actor_critic(UpdateRule::Algorithm1);
    let advice = [0.0, 3f64.ln()]; // π = (¼, ¾)
    let mut probabilities = [0.0; 2];
    agent.probabilities(
        Situation {
            state: StateId(0),
            advice: &advice,
        },
        &mut probabilities,
    );
    assert_close(probabilities[1], 0.75);
    agent.select_action(Situation {
        state: StateId(0),
        advice: &advice,
    });
    agent.update(&experience(0, 1, -2.0, 1, StepStatus::Terminated));
    assert_close(
        agent.preference(StateId(0), Action(1)),
        0.1 * -2.0 * (1.0 - 0.75),
    );
    assert_close(
        agent.preference(StateId(0), Action(0)),
        0.1 * -2.0 * (0.0 - 0.25),
    );
}

#[test]
fn preferences_stop_at_the_clip() {
    let mut agent = actor_critic(UpdateRule::Algorithm1);
    for _ in 0..1000 {
        agent.update(&experience(0, 1, 100.0, 1, StepStatus::Terminated));
        agent.update(&experience(1, 1, 1e6, 2, StepStatus::Terminated));
    }
    assert_eq!(agent.preference(StateId(1), Action(1)), 3.0);
    assert_eq!(agent.preference(StateId(1), Action(0)), -3.0);
    assert!(agent.preference(StateId(0), Action(1)) <= 3.0);
}

#[test]
fn the_sampled_next_action_is_the_one_taken() {
    let params = ActorCriticParams {
        bootstrap: Bootstrap::Sampled,
        ..ActorCriticParams::default()
    };
    let mut agent = ActorCritic::new(params, Tabular::new(2), 2, 1.0, 5);
    // the two actions of state 1 are worth 0.7 · 10 and 0, so that δ tells which was drawn
    agent.update(&experience(1, 0, 10.0, 9, StepStatus::Terminated));
    let mut seen = [false; 2];
    for state in 10..60 {
        let info = agent.update(&experience(state, 0, 0.0, 1, StepStatus::Running));
        let drawn = agent.select_action(Situation {
            state: StateId(1),
            advice: &NO_ADVICE,
        });
        assert_close(info.td_error, if drawn == Action(0) { 7.0 } else { 0.0 });
        seen[drawn.index()] = true;
    }
    assert_eq!(seen, [true; 2], "both actions are drawn now and then");
}

/// After a step into a state that is worth 4 by its best action, and 2 to a policy that is still uniform.
#[test]
fn truncation_bootstraps_and_termination_does_not() {
    use Bootstrap::{Expected, Sampled};
    for (kind, bootstrap, ahead) in [
        (AgentKind::QLearning, Sampled, 4.0),
        (AgentKind::Sarsa, Sampled, 4.0),
        (AgentKind::Sarsa, Expected, 4.0),
        (AgentKind::DynaQ, Sampled, 4.0),
        (AgentKind::ActorCritic, Expected, 2.0),
    ] {
        let params = AgentParams {
            kind,
            update: UpdateRule::Algorithm2, // its actor does not move in the first step
            bootstrap: Some(bootstrap),
            critic_learning_rate: Some(0.5),
            planning_steps: Some(1),
            epsilon: Some(0.0),
            ..AgentParams::default()
        };
        for (status, ahead) in [
            (StepStatus::Running, ahead),
            (StepStatus::Truncated, ahead),
            (StepStatus::Terminated, 0.0),
        ] {
            let mut agent = AnyAgent::new(&params, 2, 1.0, 0);
            agent.update(&experience(1, 0, 8.0, 2, StepStatus::Terminated));
            let info = agent.update(&experience(0, 0, -1.0, 1, status));
            assert_eq!(
                info.td_error,
                ahead - 1.0,
                "{kind:?} {bootstrap:?} {status:?}"
            );
        }
    }
}

/// The same for learners that plan: the value of state 0 after both its actions were tried.
#[test]
fn plans_end_where_the_task_ends_and_not_where_the_clock_runs_out() {
    for (status, expected) in [(StepStatus::Truncated, 7.0), (StepStatus::Terminated, -1.0)] {
        let steps = [
            experience(1, 0, 8.0, 2, StepStatus::Terminated),
            experience(1, 1, 8.0, 2, StepStatus::Terminated),
            experience(0, 0, -1.0, 1, status),
            experience(0, 1, -1.0, 1, status),
        ];
        let mut planner = Planner::new(PlannerParams::default(), 2, 0);
        let mut policy_iteration =
            PolicyIteration::new(PolicyIterationParams::default(), 2, 1.0, 0);
        for step in &steps {
            planner.update(step);
            policy_iteration.update(step);
        }
        assert_eq!(
            policy_iteration.value(StateId(0)),
            Some(expected),
            "{status:?}"
        );
        let planned = planner.value(StateId(0)).unwrap();
        assert!((planned - expected).abs() < 1e-5, "{status:?}: {planned}");
    }
}

/// Every learner that takes shaping sees r + mix · F.
#[test]
fn shaping_counts_by_its_mix() {
    use AgentKind::{ActorCritic, DynaQ, PolicyIteration, QLearning, Sarsa};
    for kind in [ActorCritic, QLearning, Sarsa, DynaQ, PolicyIteration] {
        for (mix, expected) in [(1.0, 3.0), (0.25, 0.0), (0.0, -1.0)] {
            let params = AgentParams {
                kind,
                initial_value: -9.0,
                ..AgentParams::default()
            };
            let mut agent = AnyAgent::new(&params, 2, mix, 0);
            let shaped = Experience {
                shaping: 4.0,
                ..experience(0, 0, -1.0, 1, StepStatus::Terminated)
            };
            let td_error = agent.update(&shaped).td_error;
            let initial = if kind == ActorCritic { 0.0 } else { -9.0 };
            assert!(
                (td_error - (expected - initial)).abs() < ROUNDING,
                "{kind:?} at mix {mix}: {td_error}"
            );
        }
    }
}

/// Klissarov & Precup's two critics, blended, are the one critic that learns from r + mix · F.
#[test]
fn blending_two_critics_is_learning_from_the_blended_reward() {
    let (mix, gamma, rate) = (0.3, 0.9, 0.7);
    let params = SarsaParams {
        gamma,
        learning_rate: rate,
        epsilon: 1.0, // the path does not depend on the values
        initial_value: 0.0,
        bootstrap: Bootstrap::Sampled,
    };
    let critic = |mix| Sarsa::new(params.clone(), 2, mix, 11);
    let (mut shaped, mut plain, mut blended) = (critic(1.0), critic(0.0), critic(mix));
    let potential = |s: u32| -f64::from(s * s);
    for step in 0..200u32 {
        let (from, to) = (step * 7 % 5, (step + 1) * 7 % 5);
        let situation = Situation {
            state: StateId(from),
            advice: &NO_ADVICE,
        };
        let action = blended.select_action(situation);
        for agent in [&mut shaped, &mut plain] {
            assert_eq!(agent.select_action(situation), action);
        }
        let shaping = gamma * potential(to) - potential(from);
        let step = Experience {
            shaping,
            ..experience(from, action.0, -1.0, to, StepStatus::Running)
        };
        for agent in [&mut shaped, &mut plain, &mut blended] {
            agent.update(&step);
        }
    }
    for (state, action) in (0..5).flat_map(|s| [(StateId(s), Action(0)), (StateId(s), Action(1))]) {
        let blend = mix * shaped.action_value(state, action)
            + (1.0 - mix) * plain.action_value(state, action);
        assert!((blended.action_value(state, action) - blend).abs() < 1e-12);
        assert!(blend.abs() > 0.1, "something was learnt");
    }
}
