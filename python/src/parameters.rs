//! Parameters as Python hands them over: JSON objects with the names that a scenario has.

use eigentrail::PipelineParams;
use eigentrail::agent::AgentParams;
use eigentrail::engine::ScheduleParams;
use eigentrail::exploration::ExplorationParams;
use eigentrail::features::DeepWalkParams;
use eigentrail::gcn::GcnParams;
use eigentrail::shaping::{PotentialKind, ShapingParams};
use eigentrail::spectral::SpectralParams;
use pyo3::PyResult;
use pyo3::exceptions::PyValueError;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// The sections of a scenario that a pipeline needs.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Sections {
    spectral: SpectralParams,
    deepwalk: DeepWalkParams,
    gcn: GcnParams,
    shaping: ShapingParams,
    exploration: ExplorationParams,
    schedule: ScheduleParams,
}

/// Parameters of a pipeline with discount `gamma`; those that know the true world are refused, for here nobody does.
pub fn pipeline(json: &str, gamma: f64) -> PyResult<PipelineParams> {
    let Sections {
        spectral,
        deepwalk,
        gcn,
        shaping,
        exploration,
        schedule,
    } = parsed(json)?;
    let needs_world = matches!(
        shaping.potential,
        PotentialKind::Oracle | PotentialKind::NegatedOracle | PotentialKind::File
    );
    if needs_world {
        return Err(PyValueError::new_err(format!(
            "shaping.potential = \"{}\": needs a world that is known in full; choose one that is learnt, such as \"gcn\"",
            shaping.potential
        )));
    }
    Ok(PipelineParams {
        spectral,
        deepwalk,
        gcn,
        shaping,
        exploration,
        schedule,
        gamma,
    })
}

/// Parameters of a learner with discount `gamma`.
pub fn agent(json: &str, gamma: f64) -> PyResult<AgentParams> {
    let params: AgentParams = parsed(json)?;
    Ok(AgentParams { gamma, ..params })
}

fn parsed<T: DeserializeOwned>(json: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| {
        // The place in the JSON text says nothing to somebody who wrote Python.
        let text = error.to_string();
        let text = text.split(" at line ").next().unwrap_or(&text);
        PyValueError::new_err(format!("parameters: {text}"))
    })
}
