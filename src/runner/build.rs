//! From a scenario to an engine: the one place that knows every concrete type.

use crate::agent::{AgentKind, AnyAgent, FeatureKind, build_agent};
use crate::engine::{DiscoveryHook, Engine, PipelineParams, ShapingPipeline};
use crate::env::Model;
use crate::features::FeatureSource;
use crate::parameter::ParameterError;
use crate::scenario::Scenario;
use crate::shaping::PotentialKind;

/// The engine of one seed in `world`.
///
/// # Errors
/// The first parameter of the scenario that breaks its rule.
pub fn build_engine<E>(
    scenario: &Scenario,
    world: E,
    seed: u64,
) -> Result<Engine<E, AnyAgent>, ParameterError>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let num_actions = world.num_actions();
    let params = scenario.agent.with_step_limit(world.max_steps());
    let agent = build_agent(&params, num_actions, scenario.shaping.mix, seed);
    let agent_features = match (params.kind, params.features) {
        (AgentKind::ActorCritic, FeatureKind::Pvf) => Some(FeatureSource::Pvf),
        (AgentKind::ActorCritic, FeatureKind::Deepwalk) => Some(FeatureSource::Deepwalk),
        _ => None,
    };
    let pipeline = ShapingPipeline::new(
        &pipeline_params(scenario),
        num_actions,
        agent_features,
        seed,
    )?;
    Ok(with_true_distances(
        scenario,
        Engine::new(world, pipeline, agent),
    ))
}

/// The same engine, whose oracle potential, if it is one, will be told the true distances of states as they are discovered.
/// [`build_engine`] has done so; an engine that was read back needs it again, because the hook is no part of its state.
pub fn with_true_distances<E>(
    scenario: &Scenario,
    engine: Engine<E, AnyAgent>,
) -> Engine<E, AnyAgent>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    if scenario.shaping.potential != PotentialKind::Oracle {
        return engine;
    }
    let oracle = oracle(engine.env());
    engine.with_true_distances(oracle)
}

/// Puts `world`, the same with other goals, in the place of the present one between two episodes. The agent is not
/// told; only the oracle knows.
pub fn move_goals<E>(scenario: &Scenario, engine: &mut Engine<E, AnyAgent>, world: E)
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    if scenario.shaping.potential == PotentialKind::Oracle {
        engine.set_true_distances(oracle(&world));
    }
    *engine.env_mut() = world;
}

fn oracle<E>(world: &E) -> DiscoveryHook<E::State>
where
    E: Model + Clone + Send + 'static,
{
    let steps = true_distances(world);
    let map = world.clone();
    Box::new(move |state| steps[map.mdp_index(state)])
}

/// The sections of a scenario that the pipeline needs.
pub fn pipeline_params(scenario: &Scenario) -> PipelineParams {
    PipelineParams {
        spectral: scenario.spectral.clone(),
        deepwalk: scenario.deepwalk.clone(),
        gcn: scenario.gcn.clone(),
        shaping: scenario.shaping.clone(),
        exploration: scenario.exploration.clone(),
        schedule: scenario.schedule.clone(),
        gamma: scenario.agent.gamma,
    }
}

/// Steps to the nearest goal by state of the MDP; from where there is no way, one more than from anywhere else.
fn true_distances(world: &impl Model) -> Vec<f64> {
    let distances = world.to_mdp().distances_to_terminal();
    let farthest = distances.iter().flatten().max().map_or(0, |&d| d);
    distances
        .iter()
        .map(|distance| f64::from(distance.unwrap_or(farthest + 1)))
        .collect()
}
