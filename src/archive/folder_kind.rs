//! Kinds of folders: a run, a comparison, a sweep, or somebody else's.

use super::files::read_json;
use super::names;
use serde_json::Value;
use std::io;
use std::path::Path;

/// Kind of what a folder holds, told by the file that is written to it first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FolderKind {
    /// Seeds of one scenario.
    #[default]
    Run,
    /// Arms × seeds of one scenario, in `runs/NAME/TIME-compare`.
    Comparison,
    /// Points of a grid × seeds, in `runs/NAME/sweep-HASH`.
    Sweep,
}

impl FolderKind {
    /// The file that tells.
    pub fn marker(self) -> &'static str {
        match self {
            FolderKind::Run => names::RUN,
            FolderKind::Comparison => names::ARMS,
            FolderKind::Sweep => names::SWEEP,
        }
    }

    pub(super) fn suffix(self) -> &'static str {
        match self {
            FolderKind::Run => "",
            FolderKind::Comparison => "-compare",
            FolderKind::Sweep => "-sweep",
        }
    }

    /// Whether such a thing was written to `path`.
    pub(super) fn is_at(self, path: &Path) -> bool {
        path.join(self.marker()).is_file()
    }

    /// Whether it was written by this program: others have files of such names, too.
    pub(super) fn is_ours_at(self, path: &Path) -> bool {
        let about: io::Result<Value> = read_json(&path.join(self.marker()));
        let program = about.as_ref().ok().and_then(|v| v["program"].as_str());
        program.is_some_and(|name| name.starts_with("eigentrail "))
    }
}

/// Whether a run was written to `path`.
pub fn is_run(path: &Path) -> bool {
    FolderKind::Run.is_at(path)
}

/// Whether `path` holds a comparison, or began to.
pub fn is_comparison(path: &Path) -> bool {
    FolderKind::Comparison.is_at(path)
}
