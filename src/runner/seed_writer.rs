//! The files of one seed, written while it runs and at its end.

use super::observer::{Episode, Refresh, RunObserver, RunState, SavedObserver, save, saved};
use super::snapshots::Snapshots;
use crate::archive::{
    ArchiveError, Checkpoint, SeedTables, TableLengths, names, write_actions, write_graph,
    write_matrix, write_policy, write_potential, write_snapshots, write_states,
};
use crate::disk;
use crate::shaping::Potential;
use std::path::{Path, PathBuf};

/// Writer of everything that `run` leaves about a seed.
pub(super) struct SeedWriter {
    folder: PathBuf,
    tables: SeedTables,
    sights: SightsWriter,
}

impl SeedWriter {
    /// Creates the folder and begins its files anew.
    pub fn create(folder: &Path) -> Result<Self, ArchiveError> {
        Ok(Self {
            folder: folder.to_owned(),
            tables: SeedTables::create(folder)?,
            sights: SightsWriter::new(folder),
        })
    }

    /// Goes on with the files as they were at a checkpoint.
    ///
    /// # Errors
    /// If they are not there, or have less in them.
    pub fn go_on(folder: &Path, checkpoint: &Checkpoint) -> Result<Self, ArchiveError> {
        let Some((lengths, snapshots)) = saved(checkpoint, NAME) else {
            return Err(ArchiveError::damaged(
                folder,
                "the checkpoint does not know its files",
            ));
        };
        Ok(Self {
            folder: folder.to_owned(),
            tables: SeedTables::go_on(folder, lengths)?,
            sights: SightsWriter {
                folder: folder.to_owned(),
                snapshots,
            },
        })
    }
}

/// The writer's name in checkpoints.
const NAME: &str = "files";

impl RunObserver for SeedWriter {
    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        self.sights.refreshed(refresh)?;
        let record = refresh.record;
        let spectrum_seconds = record.spectrum.as_ref().map(|_| record.spectrum_seconds);
        let fit_seconds = record.fit.as_ref().map(|_| record.fit_seconds);
        self.tables
            .refresh(&refresh.row(), spectrum_seconds, fit_seconds)
    }

    fn episode_ended(
        &mut self,
        episode: &Episode<'_>,
        _: &dyn RunState,
    ) -> Result<(), ArchiveError> {
        self.tables.episode(&episode.row(), episode.seconds)
    }

    fn flush(&mut self) -> Result<(), ArchiveError> {
        self.tables.flush()
    }

    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        let lengths: TableLengths = self.tables.sync()?;
        Ok(save(NAME, &(lengths, &self.sights.snapshots)))
    }

    fn ended(&mut self, run: &dyn RunState) -> Result<(), ArchiveError> {
        self.tables.sync()?; // before anything says that the seed has ended
        let known = run.knowledge();
        let potential: Vec<f64> = known.states().map(|s| known.potential.value(s)).collect();
        write_potential(&self.folder, &potential)?;
        if let Some(pairs) = known.eigenpairs {
            write_matrix(
                &self.folder.join(names::EIGENVECTORS),
                pairs.vectors.as_ref(),
            )?;
        }
        self.sights.ended(run)
    }
}

/// Writer of what is drawn on maps: states, snapshots, graph, actions and policy.
pub(super) struct SightsWriter {
    folder: PathBuf,
    snapshots: Snapshots,
}

impl SightsWriter {
    /// One that writes into `folder` at the end of the run, and makes it if it is not there.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            snapshots: Snapshots::default(),
        }
    }

    /// The same, going on from a checkpoint.
    pub fn go_on(folder: &Path, checkpoint: &Checkpoint) -> Self {
        Self {
            folder: folder.to_owned(),
            snapshots: saved(checkpoint, SIGHTS).unwrap_or_default(),
        }
    }
}

/// The name in checkpoints of a writer that has no tables beside it.
const SIGHTS: &str = "sights";

impl RunObserver for SightsWriter {
    fn save(&mut self) -> Result<Option<SavedObserver>, ArchiveError> {
        Ok(save(SIGHTS, &self.snapshots))
    }

    fn refreshed(&mut self, refresh: &Refresh<'_>) -> Result<(), ArchiveError> {
        self.snapshots
            .refreshed(refresh.record.step, &refresh.knowledge);
        Ok(())
    }

    fn ended(&mut self, run: &dyn RunState) -> Result<(), ArchiveError> {
        disk::create_subfolder(&self.folder).map_err(ArchiveError::write(&self.folder))?;
        let known = run.knowledge();
        let labels = known.states().map(|state| (known.label)(state));
        write_states(&self.folder, known.columns(), labels)?;
        let frames = self.snapshots.up_to_now(run.steps(), &known);
        write_snapshots(&self.folder, &frames)?;
        write_graph(&self.folder, known.graph_rows())?;
        let actions = known.action_names();
        write_actions(&self.folder, &actions)?;
        write_policy(&self.folder, run.policy(), &actions)
    }
}
