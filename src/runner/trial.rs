//! The loop over the episodes of one seed, for `run` and `compare` alike.

use super::build::{build_engine, move_goals, with_discovery_hook};
use super::checkpoints::Checkpoints;
use super::error::RunnerError;
use super::evaluation::GreedyReturns;
use super::observer::{Episode, Knowledge, Observers, Refresh, RunState};
use super::optimal_returns::OptimalReturns;
use super::places::{Places, knowledge};
use super::sums::Sums;
use crate::agent::{Agent, AnyAgent};
use crate::archive::{PolicyRow, SeedResult, SeedTiming};
use crate::engine::Engine;
use crate::env::{Action, GridWorld, Model, TabularEnvironment};
use crate::graph::StateId;
use crate::scenario::{MovedWorld, PotentialFile, Scenario, World, Worlds};
use crate::shaping::PotentialKind;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use tracing::{info, trace_span};

/// One seed of a scenario under way, in a world of whatever type.
pub(super) trait Trial: RunState {
    /// Plays the episode under way, or else the next one, until `pause` says so of the number of steps taken.
    ///
    /// # Errors
    /// If a part of the pipeline fails, and the first error of an observer.
    fn play_episode(
        &mut self,
        pause: &mut dyn FnMut(u64) -> bool,
        observers: &mut Observers<'_>,
    ) -> Result<Played, RunnerError>;

    /// The trial as [`resume`] reads it.
    ///
    /// # Errors
    /// If it cannot be written down.
    fn written(&self) -> Result<Vec<u8>, String>;

    /// Sums over the episodes so far.
    fn sums(&self) -> &Sums;

    /// States where φ would hold up an agent that climbs it; none without a potential.
    fn spurious_maxima(&self) -> Option<usize>;

    /// What the greedy policy earns in the true world, as it is at the end of the run.
    fn greedy_returns(&self) -> GreedyReturns;
}

/// What came of playing on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Played {
    /// An episode to its end.
    Episode,
    /// A part of one; it is under way.
    Part,
    /// Nothing: every episode had been played.
    Nothing,
}

/// The trial of `seed` in these worlds, of which `optimal` says what could be earned.
///
/// # Errors
/// If a parameter of the scenario is out of its range.
pub(super) fn begin<'a>(
    scenario: &'a Scenario,
    worlds: &Worlds,
    optimal: OptimalReturns,
    seed: u64,
) -> Result<Box<dyn Trial + 'a>, RunnerError> {
    Ok(match AnyGround::of(scenario, worlds, seed) {
        AnyGround::Grid(ground) => Box::new(TrialIn::new(ground, optimal)?),
        AnyGround::Listed(ground) => Box::new(TrialIn::new(ground, optimal)?),
    })
}

/// A trial that goes on from what [`Trial::written`] has left.
///
/// # Errors
/// If it is of another world, or damaged.
pub(super) fn resume<'a>(
    scenario: &'a Scenario,
    worlds: &Worlds,
    seed: u64,
    written: &[u8],
) -> Result<Box<dyn Trial + 'a>, String> {
    Ok(match AnyGround::of(scenario, worlds, seed) {
        AnyGround::Grid(ground) => Box::new(TrialIn::read(ground, written)?),
        AnyGround::Listed(ground) => Box::new(TrialIn::read(ground, written)?),
    })
}

/// Plays every episode that is left, or until `stop` is set, and takes checkpoints where there are to be any: those that are due,
/// and one when it is stopped.
///
/// # Errors
/// As [`Trial::play_episode`], and as [`Checkpoints::take`].
pub(super) fn play(
    trial: &mut dyn Trial,
    stop: &AtomicBool,
    observers: &mut Observers<'_>,
    mut checkpoints: Option<&mut Checkpoints<'_>>,
) -> Result<(), RunnerError> {
    loop {
        let stopped = || stop.load(Ordering::Relaxed);
        let is_due = |step| checkpoints.as_ref().is_some_and(|all| all.is_due(step));
        let played = trial.play_episode(&mut |step| stopped() || is_due(step), observers)?;
        if played == Played::Nothing {
            return Ok(());
        }
        if let Some(checkpoints) = &mut checkpoints
            && !trial.sums().is_complete()
            && (stopped() || checkpoints.is_due(trial.steps()))
        {
            checkpoints.take(trial, observers)?;
        }
        if stopped() {
            return Ok(());
        }
    }
}

struct TrialIn<'a, E: Model> {
    scenario: &'a Scenario,
    seed: u64,
    engine: Engine<E, AnyAgent>,
    /// The world to go on with, and after how many episodes.
    moved: Option<(usize, E)>,
    places: Box<dyn Places<E::State>>,
    sums: Sums,
    /// Wall seconds of the episode under way until it was last paused.
    seconds: f64,
}

/// A world that can be written down with all that stands on it.
trait Plain:
    Model<State: Send + Serialize + DeserializeOwned>
    + Clone
    + Send
    + Serialize
    + DeserializeOwned
    + 'static
{
}

impl Plain for GridWorld {}
impl Plain for TabularEnvironment {}

/// What the trial of one seed stands on: its world, and what belongs to it.
struct Ground<'a, 'w, E: Plain> {
    scenario: &'a Scenario,
    seed: u64,
    first: E,
    /// The world after the goals have moved, and after how many episodes they do.
    moved: Option<(usize, E)>,
    file: Option<&'w PotentialFile>,
    places: Box<dyn Places<E::State>>,
}

#[expect(clippy::large_enum_variant, reason = "there is one, for a moment")]
enum AnyGround<'a, 'w> {
    Grid(Ground<'a, 'w, GridWorld>),
    Listed(Ground<'a, 'w, TabularEnvironment>),
}

impl<'a, 'w> AnyGround<'a, 'w> {
    fn of(scenario: &'a Scenario, worlds: &'w Worlds, seed: u64) -> Self {
        let file = scenario.shaping.file.as_deref();
        let file = file.and_then(|path| worlds.potential_of(path));
        let moved = worlds.moved_for(seed);
        match worlds.first_for(seed) {
            World::Grid(first) => Self::Grid(Ground {
                scenario,
                seed,
                places: Box::new(first.layout().clone()),
                first,
                moved: moved.and_then(|MovedWorld { after, world }| match world {
                    World::Grid(world) => Some((after, world)),
                    World::Listed(..) => None, // both are of the scenario's one kind
                }),
                file,
            }),
            World::Listed(first, names) => Self::Listed(Ground {
                scenario,
                seed,
                places: Box::new(names),
                first,
                moved: moved.and_then(|MovedWorld { after, world }| match world {
                    World::Listed(world, _) => Some((after, world)),
                    World::Grid(_) => None,
                }),
                file,
            }),
        }
    }
}

impl<'a, E: Plain> TrialIn<'a, E> {
    fn new(ground: Ground<'a, '_, E>, optimal: OptimalReturns) -> Result<Self, RunnerError> {
        let Ground { scenario, seed, .. } = ground;
        Ok(Self {
            engine: build_engine(scenario, ground.first, ground.file, seed)?,
            sums: Sums::new(optimal, scenario.run.episodes), // its clock begins now
            scenario,
            seed,
            moved: ground.moved,
            places: ground.places,
            seconds: 0.0,
        })
    }

    /// The trial that [`Trial::written`] wrote down. The clock goes on from there.
    fn read(ground: Ground<'a, '_, E>, written: &[u8]) -> Result<Self, String> {
        let read = rmp_serde::from_slice(written);
        let (engine, sums, seconds, awaits_move): (Engine<E, AnyAgent>, Sums, f64, bool) =
            read.map_err(|error| format!("the run in it is damaged: {error}"))?;
        let Ground { scenario, seed, .. } = ground;
        Ok(Self {
            engine: with_discovery_hook(scenario, engine, ground.file),
            sums,
            seconds,
            scenario,
            seed,
            moved: ground.moved.filter(|_| awaits_move),
            places: ground.places,
        })
    }

    /// Moves the goals, if `episode` is the first one after that.
    fn move_goals_before(&mut self, episode: usize) {
        if let Some((_, world)) = self.moved.take_if(|(after, _)| *after == episode) {
            info!(name: "goals_moved", episode, step = self.engine.steps(), "goals_moved");
            move_goals(self.scenario, &mut self.engine, world);
        }
    }
}

impl<E: Plain> Trial for TrialIn<'_, E> {
    fn play_episode(
        &mut self,
        pause: &mut dyn FnMut(u64) -> bool,
        observers: &mut Observers<'_>,
    ) -> Result<Played, RunnerError> {
        if self.sums.is_complete() {
            return Ok(Played::Nothing);
        }
        let number = self.sums.lengths().len();
        if !self.engine.pipeline().walker().is_in_episode() {
            self.move_goals_before(number);
        }
        // Trials that nobody observes are spared the clock, a fiftieth of a short episode.
        let begun = (!observers.is_empty()).then(Instant::now);
        let _in_episode = trace_span!("episode", episode = number).entered();
        let (sums, places) = (&mut self.sums, self.places.as_ref());
        let mut told = Ok(());
        let record = self.engine.run_episode_until(pause, |record, pipeline| {
            sums.refreshed(record);
            let refresh = Refresh {
                record,
                knowledge: knowledge(pipeline, places),
            };
            if told.is_ok() {
                told = observers.iter_mut().try_for_each(|o| o.refreshed(&refresh));
            }
        })?;
        told?;
        self.seconds += begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64());
        let Some(record) = record else {
            return Ok(Played::Part);
        };
        self.sums.episode_ended(&record);
        let episode = Episode {
            record: &record,
            regret: self.sums.regret(),
            seconds: std::mem::take(&mut self.seconds),
        };
        for observer in observers {
            observer.episode_ended(&episode, self)?;
        }
        Ok(Played::Episode)
    }

    fn written(&self) -> Result<Vec<u8>, String> {
        let run = (&self.engine, &self.sums, self.seconds, self.moved.is_some());
        rmp_serde::to_vec(&run).map_err(|error| error.to_string())
    }

    fn sums(&self) -> &Sums {
        &self.sums
    }

    fn spurious_maxima(&self) -> Option<usize> {
        let has_potential = self.scenario.shaping.potential != PotentialKind::None;
        has_potential.then(|| self.engine.pipeline().spurious_maxima().len())
    }

    fn greedy_returns(&self) -> GreedyReturns {
        GreedyReturns::of(&self.engine)
    }
}

impl<E: Model> RunState for TrialIn<'_, E> {
    fn steps(&self) -> u64 {
        self.engine.steps()
    }

    fn knowledge(&self) -> Knowledge<'_> {
        knowledge(self.engine.pipeline(), self.places.as_ref())
    }

    fn policy(&self) -> Vec<PolicyRow> {
        let graph = self.engine.pipeline().transitions();
        let advice = self.engine.pipeline().look_ahead();
        let advice = advice.chunks_exact(graph.num_actions());
        let states = (0..graph.num_states() as u32).map(StateId).zip(advice);
        states
            .map(|(state, advice)| {
                let actions = (0..graph.num_actions()).map(|a| Action(a as u16));
                let tries = actions.map(|action| u64::from(graph.tries(state, action)));
                let greedy = self.engine.agent().greedy_action(state, advice);
                PolicyRow {
                    state: state.0,
                    visits: tries.sum(),
                    greedy: greedy.map(|action| action.0),
                }
            })
            .collect()
    }

    fn result(&self) -> SeedResult {
        let sums = &self.sums;
        let graph = self.engine.pipeline().transitions();
        let optimum = sums.best().optimum;
        SeedResult {
            seed: self.seed,
            finished: sums.is_complete(),
            episodes: sums.lengths().len(),
            steps: self.engine.steps(),
            regret: sums.regret(),
            optimal_steps: optimum.expected_steps,
            final_mean_steps: sums.final_steps(),
            optimal_return: Some(optimum.expected_return),
            final_return: Some(sums.final_return()),
            goals_moved_after: sums.moved_after(),
            first_goal_step: self.engine.first_goal_step(),
            nodes: graph.num_states(),
            edges: graph.adjacency().num_edges(),
            spectrum_refreshes: sums.spectrum_refreshes(),
            gcn_fits: sums.gcn_fits(),
        }
    }

    fn timing(&self) -> SeedTiming {
        SeedTiming::new(self.seed, self.sums.timing(self.engine.steps()))
    }
}
