//! From a scenario to an engine: the one place that knows every concrete type.

use crate::agent::{AgentKind, AnyAgent, FeatureKind, build_agent};
use crate::engine::{DiscoveryHook, Engine, PipelineParams, ShapingPipeline};
use crate::env::Model;
use crate::features::FeatureSource;
use crate::parameter::ParameterError;
use crate::scenario::{PotentialFile, Scenario, Worlds};
use crate::shaping::PotentialKind;
use std::collections::BTreeSet;
use std::path::PathBuf;
use tracing::warn;

/// The engine of one seed in `world`; `file` says what φ is if the potential is one of a file
/// ([`Worlds::potential_of`](crate::scenario::Worlds::potential_of)), else it is 0 there.
///
/// # Errors
/// The first parameter of the scenario that breaks its rule.
///
/// # Panics
/// If `file` is about another world, with fewer states.
pub fn build_engine<E>(
    scenario: &Scenario,
    world: E,
    file: Option<&PotentialFile>,
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
    let engine = Engine::new(world, pipeline, agent);
    Ok(with_discovery_hook(scenario, engine, file))
}

/// The same engine, whose potential will be told about states as they are discovered, if it is of a kind that listens: true
/// distances, or the φ of a file. [`build_engine`] has done so; an engine that was read back needs it again, because the hook is
/// no part of its state.
pub fn with_discovery_hook<E>(
    scenario: &Scenario,
    engine: Engine<E, AnyAgent>,
    file: Option<&PotentialFile>,
) -> Engine<E, AnyAgent>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let numbers = match (scenario.shaping.potential, file) {
        (kind, _) if knows_distances(kind) => true_distances(engine.env()),
        (PotentialKind::File, Some(file)) => {
            let values = file.values().iter();
            values.map(|value| value.unwrap_or(0.0)).collect()
        }
        _ => return engine,
    };
    let hook = by_state(engine.env(), numbers);
    engine.with_discovery_hook(hook)
}

/// Puts `world`, the same with other goals, in the place of the present one between two episodes. The agent is not
/// told; only the potentials that know true distances are.
pub fn move_goals<E>(scenario: &Scenario, engine: &mut Engine<E, AnyAgent>, world: E)
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    if knows_distances(scenario.shaping.potential) {
        engine.set_discovery_hook(by_state(&world, true_distances(&world)));
    }
    *engine.env_mut() = world;
}

fn knows_distances(kind: PotentialKind) -> bool {
    matches!(kind, PotentialKind::Oracle | PotentialKind::NegatedOracle)
}

/// Numbers by state of the MDP, as a function of states.
fn by_state<E>(world: &E, numbers: Vec<f64>) -> DiscoveryHook<E::State>
where
    E: Model + Clone + Send + 'static,
{
    let map = world.clone();
    Box::new(move |state| numbers[map.mdp_index(state)])
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

/// Says which files of φ leave states out, each once.
pub(super) fn warn_of_file<'a>(worlds: &Worlds, scenarios: impl IntoIterator<Item = &'a Scenario>) {
    let paths = scenarios.into_iter().flat_map(|s| &s.shaping.file);
    let paths: BTreeSet<&PathBuf> = paths.collect();
    let files = paths
        .into_iter()
        .filter_map(|path| worlds.potential_of(path));
    for caution in files.filter_map(PotentialFile::caution) {
        warn!("{caution}");
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
