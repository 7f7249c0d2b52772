//! The rules that tie a world to its model.

use super::episodes::{Episode, Panicked, SEEDS, play_all};
use super::{Coverage, Expectations, Rule, Violations, check_environment};
use crate::env::{Action, Model, Step, StepStatus, TabularMdp};

/// How far a reward may be from the model's, relative to its size.
const REWARD_TOLERANCE: f64 = 1e-9;

/// Checks the contract of [`Environment`](crate::env::Environment) and that what is seen agrees with [`Model`]. The
/// step limit is the model's; `random` is as in [`Expectations::random`].
///
/// # Errors
/// Every rule that was seen broken.
pub fn check_model<E: Model>(
    make: impl Fn(u64) -> E,
    random: bool,
) -> Result<Coverage, Violations> {
    let expectations = Expectations {
        max_steps: Some(make(SEEDS.start).max_steps()),
        random,
    };
    let contract = check_environment(&make, &expectations);
    let mut violations = contract
        .as_ref()
        .err()
        .cloned()
        .unwrap_or(Violations(Vec::new()));
    for seed in SEEDS {
        // A panic has been reported by the contract's check, which plays the same episodes.
        let _: Result<(), Panicked> = check_seed(&mut make(seed), &mut violations);
    }
    if violations.0.is_empty() {
        contract
    } else {
        Err(violations)
    }
}

fn check_seed<E: Model>(world: &mut E, violations: &mut Violations) -> Result<(), Panicked> {
    let mdp = world.to_mdp();
    if mdp.num_actions() != world.num_actions() {
        let seen = format!(
            "{} actions in the model, {} in the world",
            mdp.num_actions(),
            world.num_actions()
        );
        violations.note(Rule::ModelHasTheSameShape, seen);
        return Ok(());
    }
    let starts = world.start_states();
    if starts.is_empty()
        || starts
            .iter()
            .any(|&start| start >= mdp.num_states() || mdp.is_terminal(start))
    {
        violations.note(Rule::StartsAreStarts, format!("starts {starts:?}"));
        return Ok(());
    }
    let max_steps = world.max_steps();
    for episode in play_all(world, Some(max_steps))? {
        check_episode(world, &mdp, &starts, &episode, violations);
    }
    Ok(())
}

fn check_episode<E: Model>(
    world: &E,
    mdp: &TabularMdp,
    starts: &[usize],
    episode: &Episode<E::State>,
    violations: &mut Violations,
) {
    let mut from = world.mdp_index(&episode.start);
    if !starts.contains(&from) {
        violations.note(
            Rule::StartsAreStarts,
            format!("an episode began in {:?}", episode.start),
        );
    }
    for (action, step) in &episode.steps {
        let to = world.mdp_index(&step.state);
        if !is_possible(mdp, from, *action, to, step) {
            let seen = format!("state {from}, action {}: {step:?}, state {to}", action.0);
            violations.note(Rule::TransitionsAreInTheModel, seen);
        }
        if mdp.is_terminal(to) != (step.status == StepStatus::Terminated) {
            let seen = format!("{:?} on entering {:?}", step.status, step.state);
            violations.note(Rule::TerminatedExactlyAtTerminalStates, seen);
        }
        from = to;
    }
}

fn is_possible<S>(
    mdp: &TabularMdp,
    from: usize,
    action: Action,
    to: usize,
    step: &Step<S>,
) -> bool {
    mdp.outcomes(from, action).iter().any(|outcome| {
        let close = REWARD_TOLERANCE * outcome.reward.abs().max(1.0);
        outcome.next as usize == to && (outcome.reward - step.reward).abs() <= close
    })
}
