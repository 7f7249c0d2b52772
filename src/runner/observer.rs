//! Whoever watches a run: what is told, and what may be asked.
//!
//! A run hands each of its observers every refresh and every episode as it happens, then its end. An observer that fails
//! ends the run with its error; rows that others have not written by then are written first.

use crate::archive::{
    ArchiveError, Checkpoint, EpisodeRow, GraphRow, PolicyRow, RefreshRow, SeedResult, SeedTiming,
};
use crate::engine::{EpisodeRecord, RefreshRecord};
use crate::env::layouts::{Cell, Layout};
use crate::env::{Action, StepStatus};
use crate::graph::{StateId, TransitionGraph};
use crate::scenario::Scenario;
use crate::shaping::PotentialTable;
use crate::spectral::Eigenpairs;
use petgraph::visit::EdgeRef;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Observer of one seed. Nothing here should wait. `Err` of any method ends the run.
pub trait RunObserver {
    /// The spectrum, the potential, or both were brought up to date.
    ///
    /// # Errors
    /// What ends the run.
    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        let _ = refresh;
        Ok(())
    }

    /// An episode has ended.
    ///
    /// # Errors
    /// What ends the run.
    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        run: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        let _ = (episode, run);
        Ok(())
    }

    /// No episode will come any more, whether or not there is an error to tell: what waits in memory belongs on disk.
    ///
    /// # Errors
    /// Why it cannot be brought there.
    fn flush(&mut self) -> Result<(), ArchiveError> {
        Ok(())
    }

    /// A checkpoint is taken. What was noted so far has to be on the disk at the end of this; the result is what the observer of
    /// the same name needs to go on from here ([`RunStart::saved`]), if it has a name.
    ///
    /// # Errors
    /// Why that cannot be.
    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        self.flush().map(|()| None)
    }

    /// The run has ended without an error, after its last episode or because it was told to stop.
    ///
    /// # Errors
    /// What to tell in the place of its results.
    fn ended(&mut self, run: &dyn RunState) -> Result<(), ArchiveError> {
        let _ = run;
        Ok(())
    }
}

/// Name of an observer, and what it goes on from.
pub type SavedObserver = (&'static str, Vec<u8>);

/// Observers of one seed, told one after the other.
pub type Observers<'a> = Vec<Box<dyn RunObserver + 'a>>;

/// Beginning of a seed: what an observer is made for.
#[derive(Clone, Copy, Debug)]
pub struct RunStart<'a> {
    /// The experiment.
    pub scenario: &'a Scenario,
    /// Master seed.
    pub seed: u64,
    /// Folder of the seed, which exists.
    pub folder: &'a Path,
    /// The moment from which the seed goes on, if it does not begin.
    pub resumed: Option<&'a Checkpoint>,
}

impl RunStart<'_> {
    /// What the observer of this name noted at the moment from which the seed goes on; none if it begins, or if there was no such
    /// observer.
    pub fn saved<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        saved(self.resumed?, name)
    }
}

/// What an observer of this name notes in a checkpoint, for [`RunObserver::save`].
///
/// # Panics
/// If `state` cannot be written down: it is no plain value.
pub fn save(name: &'static str, state: &impl Serialize) -> Option<SavedObserver> {
    let bytes = rmp_serde::to_vec(state).expect("plain values can be written down");
    Some((name, bytes))
}

/// What the observer of this name noted.
pub(super) fn saved<T: DeserializeOwned>(checkpoint: &Checkpoint, name: &str) -> Option<T> {
    rmp_serde::from_slice(checkpoint.observers.get(name)?).ok()
}

/// Refresh that has just happened, and what is known after it.
pub struct Refresh<'a> {
    /// What was done.
    pub record: &'a RefreshRecord,
    /// What is known now.
    pub knowledge: Knowledge<'a>,
}

/// Episode that has just ended.
pub struct Episode<'a> {
    /// What happened in it.
    pub record: &'a EpisodeRecord,
    /// ρ of the run so far.
    pub regret: f64,
    /// Wall seconds it took.
    pub seconds: f64,
}

/// State of a run between two episodes. What costs something is worked out only for whoever asks.
pub trait RunState {
    /// Environment steps taken so far.
    fn steps(&self) -> u64;

    /// What is known of the world.
    fn knowledge(&self) -> Knowledge<'_>;

    /// Visits and best action of each state, with the advice of φ but not of a search. O(states × actions).
    fn policy(&self) -> Vec<PolicyRow>;

    /// What the run comes to so far. O(episodes in the last tenth).
    fn result(&self) -> SeedResult;

    /// What the clock says.
    fn timing(&self) -> SeedTiming;
}

/// What an agent knows of its world at one moment.
pub struct Knowledge<'a> {
    /// The graph of visited states.
    pub graph: &'a TransitionGraph,
    /// φ.
    pub potential: &'a PotentialTable,
    /// The low end of the spectrum as it was at its last refresh.
    pub eigenpairs: Option<&'a Eigenpairs>,
    /// Fields of a state's label in tables, below [`columns`](Self::columns).
    pub label: Box<dyn Fn(StateId) -> Vec<String> + 'a>,
    /// Name of an action.
    pub action: Box<dyn Fn(Action) -> &'a str + 'a>,
    /// The map, if there is one.
    pub map: Option<KnownMap<'a>>,
}

/// Map, and where states are on it.
pub struct KnownMap<'a> {
    /// The whole map.
    pub layout: &'a Layout,
    /// Cell of a state.
    pub cell: Box<dyn Fn(StateId) -> Cell + 'a>,
}

impl Knowledge<'_> {
    /// States known, in the order of their numbers.
    pub fn states(&self) -> impl ExactSizeIterator<Item = StateId> + use<> {
        (0..self.graph.num_states() as u32).map(StateId)
    }

    /// Names of the columns of a label: a place on the map has two, a name one.
    pub fn columns(&self) -> &'static [&'static str] {
        match self.map {
            Some(_) => &["row", "col"],
            None => &["name"],
        }
    }

    /// Labels of the states, `row,col` or a name, in the order of their numbers. O(states).
    pub fn labels(&self) -> Vec<String> {
        let label = |state| (self.label)(state).join(",");
        self.states().map(label).collect()
    }

    /// Names of the actions, in the order of their numbers.
    pub fn action_names(&self) -> Vec<&'_ str> {
        let actions = (0..self.graph.num_actions()).map(|action| Action(action as u16));
        actions.map(|action| (self.action)(action)).collect()
    }

    /// Rows of `graph.csv`, in the order in which the transitions were first seen.
    pub fn graph_rows(&self) -> impl Iterator<Item = GraphRow> {
        let digraph = self.graph.digraph();
        digraph.edge_references().map(|edge| {
            let stats = edge.weight();
            GraphRow {
                from: edge.source().index() as u32,
                action: stats.action.0,
                to: edge.target().index() as u32,
                count: stats.count,
                reward_sum: stats.reward_sum,
                terminal: stats.terminal,
            }
        })
    }
}

impl Refresh<'_> {
    /// Row of `refreshes.csv`.
    pub fn row(&self) -> RefreshRow {
        let record = self.record;
        let spectrum = record.spectrum.as_ref();
        let convergence = spectrum.map(|s| &s.convergence);
        let fit = record.fit.as_ref().and_then(|f| f.fit.as_ref());
        RefreshRow {
            step: record.step,
            nodes: record.nodes,
            edges: record.edges,
            pairs: spectrum.map(|s| s.eigenvalues.len()),
            converged: convergence.map(|c| c.converged),
            cold_start: spectrum.map(|s| s.cold_start),
            applications: convergence.map(|c| c.applications),
            solves: convergence.map(|c| c.solves),
            max_relative_residual: convergence.map(|c| c.max_relative_residual),
            largest_eigenvalue: spectrum.and_then(|s| s.eigenvalues.last().copied()),
            fitted: record.fit.is_some(),
            fit_epochs: fit.map(|f| f.epochs),
            initial_loss: fit.map(|f| f.initial_loss),
            loss: fit.map(|f| f.loss),
        }
    }
}

impl Episode<'_> {
    /// Row of `episodes.csv`.
    pub fn row(&self) -> EpisodeRow {
        let record = self.record;
        let status = match record.status {
            StepStatus::Running => "running",
            StepStatus::Terminated => "terminated",
            StepStatus::Truncated => "truncated",
        };
        EpisodeRow {
            episodes: 1,
            episode: record.episode,
            step: record.step,
            length: record.length,
            plain_return: record.plain_return,
            shaped_return: record.shaped_return,
            status: status.into(),
            regret: self.regret,
            nodes: record.nodes,
            edges: record.edges,
        }
    }
}
