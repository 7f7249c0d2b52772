//! What a run tells to whom follows it while it goes on.

use super::graph_files::{GraphRow, PolicyRow, graph_rows, policy_rows};
use super::places::Places;
use super::records::status_name;
use super::snapshots::{Snapshot, Snapshots};
use super::thinning::Thinning;
use crate::agent::AnyAgent;
use crate::engine::{Engine, EpisodeRecord, RefreshRecord};
use crate::env::Environment;
use crate::graph::StateId;
use crate::report::{BoundedEpisodes, EpisodeRow, RefreshRow, SeedResult, SeedTiming};
use std::hash::Hash;
use std::time::{Duration, Instant};

/// Somebody who follows a run. Nothing here may wait.
pub trait Follower: Sync {
    /// Whether to tell how things stand; asked after each episode.
    fn wants(&self) -> bool;

    /// How things stand.
    fn show(&self, moment: Moment);
}

/// How things stand: the run from its beginning in a bounded number of rows, and the present of everything else.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The run so far.
    pub result: SeedResult,
    /// What the clock says.
    pub timing: SeedTiming,
    /// Its episodes, later ones several in a row.
    pub episodes: Vec<EpisodeRow>,
    /// Its refreshes, of later ones only some, but the last fit in any case.
    pub refreshes: Vec<RefreshRow>,
    /// Frames of the whole run, the present one last.
    pub snapshots: Vec<Snapshot>,
    /// Place (`row,col`) or name of each state.
    pub labels: Vec<String>,
    /// Visits and best action of each state.
    pub policy: Vec<PolicyRow>,
    /// What was seen.
    pub graph: Vec<GraphRow>,
}

/// The run may spend one part in so many on telling.
const SHARE: u32 = 100;

/// Episodes that have a row each; of more, several share one.
const EPISODES: usize = 1000;

/// Refreshes that are all kept; of more, ever fewer.
const REFRESHES: u64 = 1000;

/// Collects rows, in bounded memory however long the run.
pub(super) struct Feed<'a> {
    follower: &'a dyn Follower,
    episodes: BoundedEpisodes,
    refreshes: Vec<RefreshRow>,
    thinning: Thinning,
    /// The last fit, if it is not among the refreshes that are kept.
    last_fit: Option<RefreshRow>,
    not_before: Instant,
}

impl<'a> Feed<'a> {
    pub fn new(follower: &'a dyn Follower) -> Self {
        Self {
            follower,
            episodes: BoundedEpisodes::new(EPISODES),
            refreshes: Vec::new(),
            thinning: Thinning::new(REFRESHES),
            last_fit: None,
            not_before: Instant::now(),
        }
    }

    pub fn refreshed(&mut self, record: &RefreshRecord) {
        let row = refresh_row(record);
        let keeps = self.thinning.keeps();
        if row.fitted {
            self.last_fit = (!keeps).then(|| row.clone());
        }
        if keeps {
            self.refreshes.push(row);
        }
    }

    pub fn episode(&mut self, record: &EpisodeRecord, regret: f64) {
        self.episodes.push(episode_row(record, regret));
    }

    /// Whether to tell.
    pub fn is_due(&self) -> bool {
        self.follower.wants() && Instant::now() >= self.not_before
    }

    /// Tells how things stand.
    pub fn tell<E: Environment>(
        &mut self,
        result: SeedResult,
        timing: SeedTiming,
        engine: &Engine<E, AnyAgent>,
        snapshots: &Snapshots,
        places: &Places<E::State>,
    ) where
        E::State: Clone + Eq + Hash,
    {
        let begun = Instant::now();
        let pipeline = engine.pipeline();
        let graph = pipeline.graph();
        let states = (0..graph.transitions().num_states()).map(|s| StateId(s as u32));
        self.follower.show(Moment {
            result,
            timing,
            episodes: self.episodes.rows().to_vec(),
            refreshes: (self.refreshes.iter().chain(&self.last_fit))
                .cloned()
                .collect(),
            snapshots: snapshots.up_to_now(engine.steps(), pipeline),
            labels: states.map(|s| (places.label)(graph.state(s))).collect(),
            policy: policy_rows(graph.transitions(), engine.agent(), &pipeline.look_ahead())
                .collect(),
            graph: graph_rows(graph.transitions()).collect(),
        });
        let cost = begun.elapsed().max(Duration::from_micros(100));
        self.not_before = Instant::now() + cost * SHARE;
    }
}

fn episode_row(record: &EpisodeRecord, regret: f64) -> EpisodeRow {
    EpisodeRow {
        episodes: 1,
        step: record.step,
        length: record.length,
        plain_return: record.plain_return,
        shaped_return: record.shaped_return,
        status: status_name(record.status).to_owned(),
        regret,
        nodes: record.nodes,
        edges: record.edges,
    }
}

fn refresh_row(record: &RefreshRecord) -> RefreshRow {
    let convergence = record.spectrum.as_ref().map(|s| &s.convergence);
    let fit = record.fit.as_ref();
    RefreshRow {
        step: record.step,
        nodes: record.nodes,
        applications: convergence.map(|c| c.applications),
        solves: convergence.map(|c| c.solves),
        max_relative_residual: convergence.map(|c| c.max_relative_residual),
        fitted: fit.is_some(),
        loss: fit.and_then(|fit| Some(fit.fit.as_ref()?.loss)),
    }
}
