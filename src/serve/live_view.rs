//! The observer of a run behind the live page.

use super::painter::LiveUpdate;
use super::server::Server;
use crate::archive::{ArchiveError, BoundedEpisodes, RefreshRow};
use crate::runner::{Episode, Refresh, RunObserver, RunState, Snapshots};
use crate::statistics::Thinning;
use std::time::{Duration, Instant};

/// The run may spend one part in so many on telling.
const SHARE: u32 = 100;

/// Episodes that have a row each; of more, several share one.
const EPISODES: usize = 1000;

/// Refreshes that are all kept; of more, ever fewer.
const REFRESHES: u64 = 1000;

/// Observer of one seed that keeps a server up to date, in bounded memory however long the run.
pub struct LiveView<'a> {
    server: &'a Server,
    episodes: BoundedEpisodes,
    refreshes: Vec<RefreshRow>,
    thinning: Thinning,
    /// The last fit, if it is not among the refreshes that are kept.
    last_fit: Option<RefreshRow>,
    snapshots: Snapshots,
    not_before: Instant,
}

impl<'a> LiveView<'a> {
    /// One that has seen nothing yet.
    pub fn new(server: &'a Server) -> Self {
        Self {
            server,
            episodes: BoundedEpisodes::new(EPISODES),
            refreshes: Vec::new(),
            thinning: Thinning::new(REFRESHES),
            last_fit: None,
            snapshots: Snapshots::default(),
            not_before: Instant::now(),
        }
    }

    /// Shows how things stand.
    fn show(&mut self, run: &dyn RunState) {
        let begun = Instant::now();
        let known = run.knowledge();
        let refreshes = self.refreshes.iter().chain(&self.last_fit);
        self.server.show(LiveUpdate {
            result: run.result(),
            timing: run.timing(),
            episodes: self.episodes.rows().to_vec(),
            refreshes: refreshes.cloned().collect(),
            snapshots: self.snapshots.up_to_now(run.steps(), &known),
            labels: known.labels(),
            actions: known
                .action_names()
                .into_iter()
                .map(str::to_owned)
                .collect(),
            policy: run.policy(),
            graph: known.graph_rows().collect(),
        });
        let cost = begun.elapsed().max(Duration::from_micros(100));
        self.not_before = Instant::now() + cost * SHARE;
    }
}

impl RunObserver for LiveView<'_> {
    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        self.snapshots
            .refreshed(refresh.record.step, &refresh.knowledge);
        let row = refresh.row();
        let keeps = self.thinning.keeps();
        if row.fitted {
            self.last_fit = (!keeps).then(|| row.clone());
        }
        if keeps {
            self.refreshes.push(row);
        }
        Ok(())
    }

    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        run: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        self.episodes.push(episode.row());
        if self.server.wants() && Instant::now() >= self.not_before {
            self.show(run);
        }
        Ok(())
    }

    fn ended(&mut self, run: &dyn RunState) -> Result<(), ArchiveError> {
        self.show(run);
        Ok(())
    }
}
