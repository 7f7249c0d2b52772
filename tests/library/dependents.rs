//! How much is built for those who depend on a part: an upper bound on the packages behind each program below.

use std::path::Path;
use std::process::{Command, Output};
use std::{fs, io};

/// Packages behind the program in `folder`, those of this repository left out.
fn packages(folder: &str) -> usize {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = root.join("tests/dependents").join(folder);
    let copy = tempfile::tempdir().unwrap();
    copied(root, &program, copy.path()).unwrap();
    // What has been fetched to build this test is enough; a cache that was pruned is filled again.
    let offline = tree(copy.path(), &["--offline"]);
    let output = if offline.status.success() {
        offline
    } else {
        tree(copy.path(), &[])
    };
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let lines = String::from_utf8(output.stdout).unwrap();
    let mut packages: Vec<&str> = lines.lines().filter(|line| !line.contains("(/")).collect();
    packages.sort_unstable();
    packages.dedup();
    packages.len()
}

/// A copy of the program, so that its lock file comes from ours and stays out of the repository.
fn copied(root: &Path, program: &Path, copy: &Path) -> io::Result<()> {
    let manifest = fs::read_to_string(program.join("Cargo.toml"))?;
    let manifest = manifest.replace("../../..", &root.to_string_lossy());
    fs::write(copy.join("Cargo.toml"), manifest)?;
    fs::copy(root.join("Cargo.lock"), copy.join("Cargo.lock"))?;
    fs::create_dir(copy.join("src"))?;
    fs::copy(program.join("src/main.rs"), copy.join("src/main.rs"))?;
    Ok(())
}

fn tree(folder: &Path, more: &[&str]) -> Output {
    let format = [
        "tree",
        "--edges",
        "normal",
        "--prefix",
        "none",
        "--no-dedupe",
    ];
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(format).args(more).current_dir(folder);
    cargo.output().unwrap()
}

#[track_caller]
fn assert_at_most(most: usize, folder: &str) {
    let packages = packages(folder);
    println!("{folder}: {packages} packages");
    assert!(
        packages <= most,
        "{folder}: {packages} packages, {most} allowed"
    );
    assert!(
        packages > most / 2,
        "{folder}: {packages} packages, are they counted at all?"
    );
}

#[test]
fn the_eigensolver_needs_little() {
    assert_at_most(75, "eigensolver");
}

#[test]
fn the_library_without_features_needs_little() {
    assert_at_most(100, "library");
}

#[test]
fn experiments_without_the_command_line_need_less_than_the_program() {
    assert_at_most(140, "experiments");
}
