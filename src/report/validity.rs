//! Is the shaping of a run valid? A few questions, answered from what the run recorded and from the true model.
//!
//! Shaping by F = γφ(s′) − φ(s), φ = 0 after termination, must leave the optimal actions as they are
//! (Ng, Harada & Russell 1999): Q*_shaped(s, a) = Q*(s, a) − φ(s).

use super::terminal::amount;
use crate::archive::RecordedSeed;
use crate::env::layouts::Layout;
use crate::env::{Action, Model, Outcome, TabularMdp};
use crate::exploration::ExplorationKind;
use crate::scenario::{Scenario, World};
use crate::shaping::PotentialKind;
use serde::Serialize;

/// Largest world of which the values are computed.
const MAX_STATES: usize = 5_000;

/// To what the two sides of an identity may differ: sums of thousands of terms of size 1 to 1000, and φ kept to four
/// digits.
const TOLERANCE: f64 = 1e-6;

/// The question that shaping by a potential always answers with yes.
const PROMISE: &str = "The optimal policy stays (value iteration on the true model)";

/// Share of the best return by which a policy may fall short of it.
const FAILURE: f64 = 0.05;

/// Answer to one question about a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The question.
    pub name: &'static str,
    /// Yes, no, or nothing to say.
    pub holds: Option<bool>,
    /// The numbers.
    pub detail: String,
}

/// The answers for one seed of a scenario.
pub fn validity(scenario: &Scenario, seed: &RecordedSeed) -> Vec<Check> {
    let mut checks = match unshaped(scenario) {
        Some(why) => vec![Check {
            name: PROMISE,
            holds: None,
            detail: format!("not applicable: {why}"),
        }],
        None => vec![telescopes(scenario, seed)],
    };
    // After a move of the goals it is the last ones that value and policy are for.
    let episodes = match seed.num_episodes() {
        0 => scenario.run.episodes, // not on record, but comparisons run them all
        known => known,
    };
    let last = episodes.saturating_sub(1);
    match scenario.world_in(seed.seed, last) {
        Ok(World::Grid(world)) => {
            let layout = world.layout();
            let index = |label: &str| Some(world.mdp_index(&cell(layout, label)?));
            checks.extend(on_the_model(scenario, seed, &world, index));
        }
        Ok(World::Listed(world, names)) => {
            let index = |label: &str| names.states.iter().position(|name| name == label);
            checks.extend(on_the_model(scenario, seed, &world, index));
        }
        Err(error) => checks.push(Check {
            name: PROMISE,
            holds: None,
            detail: format!("the world cannot be built here: {}", error.message),
        }),
    }
    // Where nothing is shaped, no more is to be said about it.
    checks.dedup_by_key(|check| check.name);
    checks
}

/// Why there is nothing to be valid, if the reward that the agent learns from is the plain one.
fn unshaped(scenario: &Scenario) -> Option<&'static str> {
    if scenario.shaping.potential == PotentialKind::None {
        return Some("no potential, so the reward is the plain one");
    }
    (scenario.shaping.mix == 0.0)
        .then_some("shaping.mix = 0, so what is learnt is the plain reward")
}

/// The cell that a label `row,col` names.
pub(super) fn cell(layout: &Layout, label: &str) -> Option<crate::env::layouts::Cell> {
    let (row, col) = label.split_once(',')?;
    layout.cell(row.parse().ok()?, col.parse().ok()?)
}

/// Σ F over an episode must be −φ(s₀) if it terminated and γ = 1. φ(s₀) is known for the episodes after the last fit.
fn telescopes(scenario: &Scenario, seed: &RecordedSeed) -> Check {
    let name = "Σ F = −φ(start) over a terminated episode: φ counts as 0 at its end";
    let unknown = |why: &str| Check {
        name,
        holds: None,
        detail: format!("not measured: {why}"),
    };
    if scenario.agent.gamma != 1.0 {
        return unknown("the discounted sum is not on record (γ < 1)");
    }
    if seed.episodes.is_empty() {
        return unknown("comparisons keep no returns of single episodes");
    }
    if scenario.exploration.kind == ExplorationKind::CountBonus {
        return unknown("the bonus for novelty is part of the shaped return");
    }
    let fits = seed.refreshes.iter().filter(|row| row.fitted);
    let last_fit = fits.map(|row| row.step).max().unwrap_or(0);
    let shapings = (seed.episodes.iter())
        .filter(|row| row.episodes == 1 && row.status == "terminated")
        .filter(|row| row.step.saturating_sub(row.length) >= last_fit)
        .map(|row| row.shaped_return - row.plain_return);
    let (mut low, mut high, mut count) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for shaping in shapings {
        (low, high, count) = (low.min(shaping), high.max(shaping), count + 1);
    }
    if count < 2 {
        return unknown("fewer than two episodes ended after the last fit");
    }
    let starts = scenario
        .world(seed.seed)
        .map(|world| world.start_distribution());
    if starts.is_ok_and(|starts| starts.places().len() > 1) {
        return unknown("episodes begin in different states");
    }
    let error = high - low;
    Check {
        name,
        holds: Some(error < TOLERANCE),
        detail: format!(
            "Σ F = {high:.4} in each of {count} episodes, whatever way they went; largest difference {error:.1e}"
        ),
    }
}

/// Value iteration with and without φ.
fn on_the_model(
    scenario: &Scenario,
    seed: &RecordedSeed,
    world: &impl Model,
    index: impl Fn(&str) -> Option<usize>,
) -> Vec<Check> {
    let mdp = &world.to_mdp();
    let name = PROMISE;
    let states = mdp.num_states();
    if states > MAX_STATES {
        let detail = format!("not computed: {states} states, more than {MAX_STATES}");
        return vec![Check {
            name,
            holds: None,
            detail,
        }];
    }
    let places: Vec<Option<usize>> = seed.labels.iter().map(|label| index(label)).collect();
    let phi = potential_by_place(seed, &places, states);
    let gamma = scenario.agent.gamma;
    let Some(shaped) = shaped_model(mdp, &phi, gamma) else {
        let detail = "not computed: φ is not finite".to_owned();
        return vec![Check {
            name,
            holds: Some(false),
            detail,
        }];
    };
    let plain_values = mdp.value_iteration(gamma, 1e-10).values;
    let shaped_values = shaped.value_iteration(gamma, 1e-10).values;
    let best = |model: &TabularMdp, values: &[f64], state| {
        model.greedy_actions(values, gamma, state, TOLERANCE)
    };
    let (mut changed, mut compared, mut error) = (0, 0, 0.0_f64);
    let known = || places.iter().flatten().copied();
    for state in known().filter(|&s| !mdp.is_terminal(s) && plain_values[s].is_finite()) {
        compared += 1;
        let differ = best(mdp, &plain_values, state) != best(&shaped, &shaped_values, state);
        changed += usize::from(differ);
        error = error.max((shaped_values[state] + phi[state] - plain_values[state]).abs());
    }
    let mut right = 0;
    let mut held = 0;
    for (row, place) in seed.policy.iter().zip(&places) {
        if let (Some(action), Some(state)) = (row.greedy, place)
            && row.visits > 0
            && !mdp.is_terminal(*state)
        {
            held += 1;
            let optimal = best(mdp, &plain_values, *state);
            right += usize::from(optimal.contains(&Action(action)));
        }
    }
    let mut checks = Vec::new();
    if unshaped(scenario).is_none() {
        checks.push(Check {
            name,
            holds: Some(changed == 0),
            detail: format!(
                "optimal actions differ in {changed} of {compared} states; largest |V_shaped + φ − V| = {error:.1e}. This is about the \
                 shaped reward, and no other part of the agent"
            ),
        });
    }
    checks.extend(advice(scenario, world, mdp, &phi));
    checks.push(
        Check {
            name: "What was learnt (for information)",
            holds: None,
            detail: format!(
                "the action held best is optimal in {right} of {held} visited states; rarely visited ones need not be learnt"
            ),
        },
    );
    checks
}

/// What look-ahead advice does to the promise, if it is given: it bends what the agent does until it has seen enough, and no theorem says
/// that a step of look-ahead is the best one. So the policy that does nothing else is evaluated.
fn advice(scenario: &Scenario, world: &impl Model, mdp: &TabularMdp, phi: &[f64]) -> Option<Check> {
    let weight = scenario.exploration.potential_advice;
    let advises = scenario.exploration.kind == ExplorationKind::Frontier
        && scenario.shaping.potential != PotentialKind::None;
    if !advises || weight == 0.0 || world.optimal_gain().is_some() {
        return None;
    }
    let gamma = scenario.agent.gamma;
    let climb = |state| climbing_action(mdp, phi, gamma, state);
    let policy: Vec<Action> = (0..mdp.num_states()).map(climb).collect();
    let earned = mdp.policy_return(world.start_distribution(), world.max_steps(), &policy);
    let best = world.optimum().expected_return;
    let (lowest, highest) = mdp.reward_range();
    let scale = match best == 0.0 {
        true => highest.max(-lowest),
        false => best.abs(),
    };
    Some(Check {
        name: "Following φ, as look-ahead advice says, earns what the best policy earns (the promise covers the limit alone)",
        holds: Some(earned >= best - FAILURE * scale),
        detail: format!(
            "{} in place of {} an episode, exactly; {weight} logits of advice a step of φ bend what the agent does in states \
             that it has seldom seen",
            amount(earned),
            amount(best)
        ),
    })
}

/// The first of the actions with the largest r + γφ(s′), as expected in the true world; φ = 0 where episodes end.
fn climbing_action(mdp: &TabularMdp, phi: &[f64], gamma: f64, state: usize) -> Action {
    let worth = |outcome: &Outcome| match mdp.is_terminal(outcome.next as usize) {
        true => outcome.reward,
        false => outcome.reward + gamma * phi[outcome.next as usize],
    };
    let expected = |action: Action| -> f64 {
        let outcomes = mdp.outcomes(state, action).iter();
        outcomes
            .map(|outcome| outcome.probability * worth(outcome))
            .sum()
    };
    let best = |best: Action, action: Action| match expected(action) > expected(best) {
        true => action,
        false => best,
    };
    mdp.actions().fold(Action(0), best)
}

/// φ by state of the model; where the run never was, the lowest.
fn potential_by_place(seed: &RecordedSeed, places: &[Option<usize>], states: usize) -> Vec<f64> {
    let last = seed.snapshots.last();
    let values = last.map_or(&[][..], |snapshot| &snapshot.potential);
    let lowest = values.iter().copied().fold(0.0_f32, f32::min);
    let mut phi = vec![f64::from(lowest); states];
    for (place, &value) in places.iter().zip(values) {
        if let Some(place) = place {
            phi[*place] = f64::from(value);
        }
    }
    phi
}

/// The same world paying r + γφ(s′) − φ(s), φ = 0 where episodes end.
fn shaped_model(mdp: &TabularMdp, phi: &[f64], gamma: f64) -> Option<TabularMdp> {
    let terminal: Vec<bool> = (0..mdp.num_states()).map(|s| mdp.is_terminal(s)).collect();
    let ends = terminal.clone();
    let shaped = TabularMdp::from_fn(mdp.num_actions(), terminal, |state, action, outcomes| {
        outcomes.extend(mdp.outcomes(state, action).iter().map(|outcome| {
            let next = outcome.next as usize;
            let entered = if ends[next] { 0.0 } else { phi[next] };
            Outcome {
                reward: outcome.reward + gamma * entered - phi[state],
                ..*outcome
            }
        }));
    });
    shaped.ok()
}
