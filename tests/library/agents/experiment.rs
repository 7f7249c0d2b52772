//! Measurements rather than tests: run by `cargo test --release --test library -- --ignored --nocapture experiment`.

use super::world::{Numbering, World, play};
use eigentrail::agent::{
    ActorCritic, ActorCriticParams, Agent, AgentKind, AgentParams, AnyAgent, Bootstrap, Experience,
    Situation, Tabular, UpdateRule,
};
use eigentrail::env::StepStatus;
use eigentrail::graph::StateId;

const SEEDS: u64 = 20;
const EPISODES: usize = 500;

/// Lower quartile, median and upper quartile of the regret over seeds, and the median of the final mean length.
fn regret(side: usize, agent: impl Fn(u64) -> AnyAgent) -> ([f64; 3], f64) {
    let optimal = (2 * (side - 1)) as f64;
    let (mut regrets, mut finals): (Vec<f64>, Vec<f64>) = (0..SEEDS)
        .map(|seed| {
            let log = play(
                &mut World::grid(side, side, 0.0, seed),
                &mut agent(seed),
                &mut Numbering::default(),
                EPISODES,
            );
            (
                log.total_steps() as f64 - optimal * EPISODES as f64,
                log.final_mean(50) / optimal,
            )
        })
        .unzip();
    regrets.sort_by(f64::total_cmp);
    finals.sort_by(f64::total_cmp);
    let at = |share: f64| regrets[(share * (SEEDS - 1) as f64).round() as usize];
    ([at(0.25), at(0.5), at(0.75)], finals[finals.len() / 2])
}

#[test]
#[ignore = "prints the table in the documentation of the actor-critic"]
fn sampled_against_expected_bootstrap() {
    for side in [5, 11] {
        for update in [
            UpdateRule::Advantage,
            UpdateRule::Algorithm1,
            UpdateRule::Algorithm2,
        ] {
            for bootstrap in [Bootstrap::Sampled, Bootstrap::Expected] {
                let params = AgentParams {
                    update,
                    bootstrap: Some(bootstrap),
                    ..AgentParams::default()
                };
                let ([low, median, high], last) =
                    regret(side, |seed| AnyAgent::new(&params, 4, 1.0, seed));
                println!(
                    "{side}x{side} {update:?} {bootstrap:?}: {median:.0} [{low:.0}, {high:.0}], last {last:.3} of optimal"
                );
            }
        }
    }
}

#[test]
#[ignore = "compares the learners"]
fn learners_side_by_side() {
    use AgentKind::{ActorCritic, DynaQ, Planner, PolicyIteration, QLearning, Sarsa};
    for side in [5, 11, 25] {
        for kind in [
            ActorCritic,
            QLearning,
            Sarsa,
            DynaQ,
            Planner,
            PolicyIteration,
        ] {
            let params = AgentParams {
                kind,
                ..AgentParams::default()
            };
            let start = std::time::Instant::now();
            let ([low, median, high], last) =
                regret(side, |seed| AnyAgent::new(&params, 4, 1.0, seed));
            let seconds = start.elapsed().as_secs_f64();
            println!(
                "{side}x{side} {kind:?}: {median:.0} [{low:.0}, {high:.0}], last {last:.3} of optimal, {seconds:.2} s"
            );
        }
    }
}

#[test]
#[ignore = "measures speed"]
fn steps_per_second() {
    const STEPS: u32 = 5_000_000;
    const STATES: u32 = 10_000;
    let advice = [0.0; 4];
    for bootstrap in [Bootstrap::Sampled, Bootstrap::Expected] {
        let params = ActorCriticParams {
            bootstrap,
            ..ActorCriticParams::default()
        };
        let mut agent = ActorCritic::new(params, Tabular::new(4), 4, 1.0, 0);
        let start = std::time::Instant::now();
        let mut state = StateId(0);
        for step in 1..=STEPS {
            let action = agent.select_action(Situation {
                state,
                advice: &advice,
            });
            let next = Situation {
                state: StateId((state.0 + u32::from(action.0) + 1) % STATES),
                advice: &advice,
            };
            let status = if step % 1000 == 0 {
                StepStatus::Terminated
            } else {
                StepStatus::Running
            };
            agent.update(&Experience {
                state,
                action,
                reward: -1.0,
                shaping: 0.1,
                next,
                status,
            });
            state = next.state;
        }
        println!(
            "{bootstrap:?}: {:.1} M steps/s",
            f64::from(STEPS) / 1e6 / start.elapsed().as_secs_f64()
        );
    }
}
