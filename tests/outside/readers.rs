//! What the program writes, read by the programs that it is written for.

use crate::runs::{eigentrail, event_file, two_seeds};
use std::path::Path;
use std::process::Command;

/// pandas, DuckDB and networkx.
pub fn other_programs_read_the_exports(python: &str) {
    let folder = tempfile::tempdir().unwrap();
    let export = |arguments: &[&str]| {
        let mut command = eigentrail();
        command
            .current_dir(folder.path())
            .arg("export")
            .args(arguments);
        command.assert().success();
    };
    two_seeds(folder.path());
    export(&["run", "--to", "csv", "-o", "csv"]);
    export(&["run", "--to", "npz", "-o", "run.npz"]);
    if cfg!(feature = "parquet") {
        export(&["run", "--to", "parquet", "-o", "parquet"]);
    }
    export(&["run/seed-0000", "--to", "graphml"]);
    agrees(python, "read_export.py", folder.path());
}

/// TensorBoard's own reader.
pub fn tensorboard_reads_every_kind_of_value(python: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = event_file(folder.path());
    agrees(python, "read_events.py", path.parent().unwrap());
}

/// Runs a script of this folder.
#[track_caller]
fn agrees(python: &str, script: &str, folder: &Path) {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/outside");
    let mut command = Command::new(python);
    let output = command
        .arg(scripts.join(script))
        .arg(folder)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
}
