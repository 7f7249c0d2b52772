//! One arm, one seed: the loop without files, for comparisons.
//!
//! Nothing is written and nothing logged by the step, so that the long runs of weak arms go at the speed of the loop.
//! One seed of each arm leaves, at its end, what its page needs to draw φ, the eigenvectors and the policy.

use super::build::{build_engine, move_goals};
use super::error::RunnerError;
use super::graph_files::write_graph_files;
use super::nearness::Nearness;
use super::phases::{Phases, Worlds, Yardstick};
use super::records::write_labels;
use super::snapshots::Snapshots;
use crate::agent::AnyAgent;
use crate::engine::{Engine, RefreshRecord};
use crate::env::Model;
use crate::error::Error;
use crate::graph::StateId;
use crate::report::{
    Arrival, Course, TrialResult, TrialTiming, blocks, final_mean_return, final_mean_steps,
};
use crate::scenario::Scenario;
use crate::shaping::PotentialKind;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Episodes whose mean return must be near the optimum.
const WINDOW: usize = 20;

/// Blocks of a [`Course`], about.
const BLOCKS: usize = 120;

/// What one seed came to.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialOutcome {
    /// Its results.
    pub result: TrialResult,
    /// How it went.
    pub course: Course,
    /// What the clock said.
    pub timing: TrialTiming,
}

/// Runs every episode of a scenario with this seed; none if `stop` was set before the last one ended. Snapshots, graph
/// and policy are written into the folder `keep`, if there is one.
///
/// # Errors
/// If a part of the pipeline fails, or a file cannot be written.
pub fn run_trial(
    scenario: &Scenario,
    seed: u64,
    keep: Option<&Path>,
    stop: &AtomicBool,
) -> Result<Option<TrialOutcome>, Error> {
    match Worlds::of(scenario, seed) {
        Worlds::Grid(worlds) => {
            let layout = worlds.first.layout().clone();
            run_in(scenario, worlds, seed, stop, keep, &|cell| {
                let (row, col) = layout.position(*cell);
                vec![row.to_string(), col.to_string()]
            })
        }
        Worlds::Listed(worlds, names) => run_in(scenario, worlds, seed, stop, keep, &|state| {
            vec![names[state.index()].clone()]
        }),
    }
}

/// The fields of a state in `states.csv`: its row and column, or its name.
type Label<'a, S> = &'a dyn Fn(&S) -> Vec<String>;

fn run_in<E>(
    scenario: &Scenario,
    mut worlds: Phases<E>,
    seed: u64,
    stop: &AtomicBool,
    keep: Option<&Path>,
    label: Label<'_, E::State>,
) -> Result<Option<TrialOutcome>, Error>
where
    E: Model + Clone + Send + 'static,
    E::State: Send,
{
    let episodes = scenario.run.episodes;
    let yardstick = worlds.yardstick();
    let mut engine = build_engine(scenario, worlds.first.clone(), seed)?;
    let begun = Instant::now();
    let mut tally = Tally::new(yardstick, episodes);
    let mut snapshots = keep.map(|_| Snapshots::default());
    let mut timing = TrialTiming::default();
    for episode in 0..episodes {
        if let Some(world) = worlds.take_moved(episode) {
            move_goals(scenario, &mut engine, world);
        }
        let record = engine.run_episode_unless(stop, |refresh, pipeline| {
            tally.count_refresh(refresh, &mut timing);
            if let Some(snapshots) = &mut snapshots {
                snapshots.refreshed(refresh.step, pipeline);
            }
        })?;
        let Some(record) = record else {
            return Ok(None);
        };
        tally.count_episode(record.length, record.plain_return, record.step);
    }
    timing.finish(begun.elapsed().as_secs_f64(), engine.steps());
    if let (Some(folder), Some(snapshots)) = (keep, snapshots) {
        write_sights(folder, snapshots, &engine, label)?;
    }
    let pipeline = engine.pipeline();
    let spurious_maxima = match scenario.shaping.potential {
        PotentialKind::None => None,
        _ => Some(pipeline.spurious_maxima()?.len()),
    };
    let graph = pipeline.transitions();
    let best = yardstick.last(episodes);
    let final_steps = final_mean_steps(yardstick.since_move(&tally.lengths));
    let final_return = final_mean_return(yardstick.since_move(&tally.returns));
    let result = TrialResult {
        seed,
        episodes,
        steps: engine.steps(),
        regret: tally.regret(),
        optimal_steps: best.optimum.expected_steps,
        final_mean_steps: final_steps,
        optimal_return: best.optimum.expected_return,
        final_return,
        final_ratio: best.ratio(final_return, final_steps),
        goals_moved_after: yardstick.moved_after(episodes),
        first_goal_step: engine.first_goal_step(),
        within_1_5x: tally.within_1_5x.arrival,
        within_1_1x: tally.within_1_1x.arrival,
        nodes: graph.num_states(),
        edges: graph.adjacency().num_edges(),
        spectrum_refreshes: tally.spectrum_refreshes,
        gcn_fits: tally.gcn_fits,
        spurious_maxima,
    };
    let course = tally.course();
    Ok(Some(TrialOutcome {
        result,
        course,
        timing,
    }))
}

/// What a page draws on the map.
fn write_sights<E: Model>(
    folder: &Path,
    snapshots: Snapshots,
    engine: &Engine<E, AnyAgent>,
    label: Label<'_, E::State>,
) -> Result<(), RunnerError> {
    std::fs::create_dir_all(folder).map_err(RunnerError::write(folder))?;
    let graph = engine.pipeline().graph();
    let states = (0..graph.transitions().num_states()).map(|s| StateId(s as u32));
    write_labels(folder, states.map(|state| label(graph.state(state))))?;
    snapshots.finish(engine.steps(), engine.pipeline(), folder)?;
    let advice = engine.pipeline().look_ahead();
    write_graph_files(folder, graph.transitions(), engine.agent(), &advice)
}

/// The sums over episodes.
struct Tally {
    yardstick: Yardstick,
    lengths: Vec<u32>,
    returns: Vec<f64>,
    /// Σ of returns up to each episode.
    totals: Vec<f64>,
    /// Episodes before the goals moved to where they are at the end of the run, and the steps they took.
    before_last_goals: usize,
    moved_at: u64,
    within_1_5x: Approach,
    within_1_1x: Approach,
    spectrum_refreshes: usize,
    gcn_fits: usize,
}

impl Tally {
    /// Of a run of `episodes`.
    fn new(yardstick: Yardstick, episodes: usize) -> Self {
        let best = yardstick.last(episodes);
        Self {
            yardstick,
            lengths: Vec::new(),
            returns: Vec::new(),
            totals: Vec::new(),
            before_last_goals: yardstick.moved_after(episodes).unwrap_or(0),
            moved_at: 0,
            within_1_5x: Approach::to(best, 1.5),
            within_1_1x: Approach::to(best, 1.1),
            spectrum_refreshes: 0,
            gcn_fits: 0,
        }
    }

    fn count_refresh(&mut self, refresh: &RefreshRecord, timing: &mut TrialTiming) {
        self.spectrum_refreshes += usize::from(refresh.spectrum.is_some());
        let fit = refresh.fit.as_ref().and_then(|fit| fit.fit.as_ref());
        self.gcn_fits += usize::from(fit.is_some());
        timing.spectrum_seconds += refresh.spectrum_seconds;
        timing.fit_seconds += refresh.fit_seconds;
    }

    /// An episode of this length has ended after `step` steps of the run.
    fn count_episode(&mut self, length: u64, plain_return: f64, step: u64) {
        self.lengths.push(u32::try_from(length).unwrap_or(u32::MAX));
        self.returns.push(plain_return);
        self.totals.push(self.total() + plain_return);
        self.look(step);
    }

    /// Whether the episodes under the goals that the run ends with have come near the optimum.
    fn look(&mut self, step: u64) {
        if self.returns.len() <= self.before_last_goals {
            self.moved_at = step;
            return;
        }
        let returns = &self.returns[self.before_last_goals..];
        self.within_1_5x.look(returns, step - self.moved_at);
        self.within_1_1x.look(returns, step - self.moved_at);
    }

    /// ρ(T) = Σ R* − Σ R_t (eq. 15).
    fn regret(&self) -> f64 {
        self.yardstick.expected_return(self.lengths.len()) - self.total()
    }

    fn total(&self) -> f64 {
        self.totals.last().copied().unwrap_or(0.0)
    }

    fn course(&self) -> Course {
        let mut course = Course::default();
        for block in blocks(self.lengths.len(), BLOCKS) {
            let lengths = self.lengths[block.clone()].iter();
            let steps: u64 = lengths.map(|&length| u64::from(length)).sum();
            let best = self.yardstick.expected_return(block.end);
            course.episodes.push(block.end);
            course.length.push(steps as f64 / block.len() as f64);
            course.regret.push(best - self.totals[block.end - 1]);
        }
        course
    }
}

/// Waits for the trailing mean of returns to come near the optimum.
struct Approach {
    best: Nearness,
    times: f64,
    arrival: Option<Arrival>,
}

impl Approach {
    /// To within `times` times the optimum.
    fn to(best: Nearness, times: f64) -> Self {
        Self {
            best,
            times,
            arrival: None,
        }
    }

    fn look(&mut self, returns: &[f64], step: u64) {
        let Some(from) = returns.len().checked_sub(WINDOW) else {
            return;
        };
        if self.arrival.is_none() && self.best.holds(&returns[from..], self.times) {
            self.arrival = Some(Arrival {
                episodes: returns.len() as u64,
                steps: step,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Optimum;
    use std::path::Path;

    #[test]
    fn arrival_needs_a_full_window_at_the_limit() {
        let optimum = Optimum {
            expected_return: -8.0,
            expected_steps: 8.0,
        };
        let mut approach = Approach::to(Nearness::new(optimum, (-1.0, -1.0)), 1.1);
        let mut returns = vec![-8.0; 19];
        approach.look(&returns, 152);
        assert_eq!(approach.arrival, None);
        returns[0] = -8.0 - 17.0; // the sum of 20 is then −177, one too many
        returns.push(-8.0);
        approach.look(&returns, 177);
        assert_eq!(approach.arrival, None);
        returns[0] += 1.0;
        approach.look(&returns, 176);
        returns.push(-1000.0);
        approach.look(&returns, 1176);
        let arrival = approach.arrival.unwrap();
        assert_eq!((arrival.episodes, arrival.steps), (20, 176));
    }

    #[test]
    fn a_trial_agrees_with_the_world_and_stops_when_told() {
        let text = "[env]\nrows = 4\ncols = 4\n[run]\nepisodes = 40\n";
        let scenario = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        let scenario = scenario.unwrap().scenario;
        let go_on = AtomicBool::new(false);
        let folder = tempfile::tempdir().unwrap();
        let outcome = run_trial(&scenario, 5, None, &go_on).unwrap().unwrap();
        let TrialOutcome {
            result,
            course,
            timing,
        } = outcome;
        assert_eq!(course.episodes.last(), Some(&40));
        assert_eq!(course.regret.last(), Some(&result.regret));
        assert_eq!(course.length.iter().sum::<f64>(), result.steps as f64);
        assert_eq!(result.optimal_steps, 6.0);
        // −1 a step, 0 for the one that enters the goal: regret is exactly the steps beyond the shortest path.
        assert_eq!(result.regret, result.steps as f64 - 40.0 * 6.0);
        assert_eq!(result.spurious_maxima, Some(0));
        assert!(result.first_goal_step.unwrap() >= 6);
        assert!(timing.wall_seconds >= timing.spectrum_seconds + timing.fit_seconds);
        let kept = run_trial(&scenario, 5, Some(folder.path()), &go_on);
        assert_eq!(kept.unwrap().unwrap().result, result);
        assert!(folder.path().join("snapshots.json").is_file());
        let stop = AtomicBool::new(true);
        assert!(run_trial(&scenario, 5, None, &stop).unwrap().is_none());
    }

    #[test]
    fn a_richer_goal_is_found_behind_the_nearest() {
        let trial = |seed: u64, more: &str| {
            let sets = ["run.episodes=200", "shaping.potential=heat", more].map(str::to_owned);
            let loaded = Scenario::load(Path::new("rewarded_goals"), &sets).unwrap();
            let trial = run_trial(&loaded.scenario, seed, None, &AtomicBool::new(false));
            trial.unwrap().unwrap().result
        };
        for seed in 0..3 {
            let settled = trial(seed, "exploration.reward_search_share=0");
            let found = trial(seed, "run.seed=0");
            assert!(found.regret < 0.5 * settled.regret, "{found:?} {settled:?}");
            let length = found.final_mean_steps;
            assert!(length > 1.5 * settled.final_mean_steps, "{found:?}");
        }
    }

    #[test]
    fn a_goal_that_moves_is_measured_by_its_present_place() {
        let text = "[env]\nrows = 4\ncols = 5\nmoved_goals = [{ at = \"top-right\" }]\ngoals_move_after = 60\n[run]\nepisodes = 100\n";
        let scenario = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        let scenario = scenario.unwrap().scenario;
        let go_on = AtomicBool::new(false);
        let outcome = run_trial(&scenario, 5, None, &go_on).unwrap().unwrap();
        let result = outcome.result;
        assert_eq!(result.goals_moved_after, Some(60));
        assert_eq!(result.optimal_steps, 4.0);
        assert_eq!(
            result.regret,
            result.steps as f64 - (60.0 * 7.0 + 40.0 * 4.0)
        );
        let arrival = result
            .within_1_5x
            .expect("a field of 20 cells is soon known");
        assert!(
            arrival.episodes >= 20 && arrival.episodes <= 40,
            "{arrival:?}"
        );
        assert!(arrival.steps < result.steps - 60 * 7, "{arrival:?}");
        assert!(result.final_mean_steps < 1.5 * 4.0, "{result:?}");
    }
}
