//! Small runs, and the pages and files that come of them.

use assert_cmd::Command;
use std::path::{Path, PathBuf};

const SPARSE: [&str; 4] = [
    "--set",
    "shaping.potential=none",
    "--set",
    "exploration.kind=none",
];

pub fn eigentrail() -> Command {
    Command::cargo_bin("eigentrail").unwrap()
}

/// Two short runs and their page.
pub fn run_page(folder: &Path) -> PathBuf {
    for (arm, sets) in [("shaped", &[][..]), ("sparse", &SPARSE[..])] {
        eigentrail()
            .args(["run", "four_rooms", "-q", "--set", "run.episodes=60"])
            .arg("--out")
            .arg(folder.join(arm))
            .args(sets)
            .assert()
            .success();
    }
    let page = folder.join("page.html");
    eigentrail()
        .arg("report")
        .args([folder.join("shaped"), folder.join("sparse")])
        .arg("-o")
        .arg(&page)
        .assert()
        .success();
    page
}

/// A short comparison and the page it leaves.
pub fn comparison_page(folder: &Path) -> PathBuf {
    let out = folder.join("comparison");
    eigentrail()
        .args(["compare", "four_rooms", "-q", "--seeds", "0..4"])
        .args([
            "--arms",
            "sparse,gcn,no-advice,planner",
            "--set",
            "run.episodes=60",
        ])
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    out.join("report.html")
}

/// A run on a ring of eight states with a way off it, which is no grid.
pub fn graph_page(folder: &Path) -> PathBuf {
    let mut rows = String::from("from,action,to\n");
    for i in 0..8 {
        rows += &format!("s{i},on,s{}\ns{},back,s{i}\n", (i + 1) % 8, (i + 1) % 8);
    }
    rows += "s4,off,goal\n";
    std::fs::write(folder.join("ring.csv"), rows).unwrap();
    let text = "[env]\nkind = \"edge-list\"\nfile = \"ring.csv\"\nstart = \"s0\"\ngoals = [{ at = \"goal\" }]\n[run]\nepisodes = 40\n";
    std::fs::write(folder.join("ring.toml"), text).unwrap();
    eigentrail()
        .args(["run", "-q"])
        .arg(folder.join("ring.toml"))
        .arg("--out")
        .arg(folder.join("ring"))
        .assert()
        .success();
    folder.join("ring/report.html")
}

/// The paper's figures, with few seeds and episodes.
pub fn figures(folder: &Path) -> PathBuf {
    let out = folder.join("figures");
    eigentrail()
        .args(["figures", "--all", "-q", "--seeds", "2"])
        .args(["--set", "run.episodes=30", "-o"])
        .arg(&out)
        .assert()
        .success();
    out.join("index.html")
}

/// Two seeds of a short run.
pub fn two_seeds(folder: &Path) {
    for seed in ["0", "3"] {
        eigentrail()
            .current_dir(folder)
            .args(["run", "four_rooms", "-q", "--no-report", "--resume"])
            .args(["--set", "run.episodes=30", "--out", "run", "--seed", seed])
            .assert()
            .success();
    }
}

/// A short run and its event file.
pub fn event_file(folder: &Path) -> PathBuf {
    let run = folder.join("run");
    eigentrail()
        .args(["run", "four_rooms", "-q", "--no-report"])
        .args(["--set", "run.episodes=60", "--out"])
        .arg(&run)
        .assert()
        .success();
    run.join("seed-0000/events.out.tfevents.0.eigentrail")
}
