//! The pages of runs, comparisons and figures, opened in a real browser where there is one.
//!
//! Screenshots go to `target/screenshots/`.

use assert_cmd::Command;
use eigentrail::archive::{
    EpisodeRow, PolicyRow, RecordedRun, RecordedSeed, SeedResult, SeedTiming, Snapshot, Summary,
};
use eigentrail::report::html_report;
use eigentrail::scenario::Scenario;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Output};

/// A page below this many bytes can be mailed.
const LARGEST: usize = 5_000_000;

const SPARSE: [&str; 4] = [
    "--set",
    "shaping.potential=none",
    "--set",
    "exploration.kind=none",
];

fn eigentrail() -> Command {
    Command::cargo_bin("eigentrail").unwrap()
}

/// Two short runs and their page.
fn run_page(folder: &Path) -> PathBuf {
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
fn comparison_page(folder: &Path) -> PathBuf {
    let out = folder.join("comparison");
    eigentrail()
        .args(["compare", "four_rooms", "-q", "--seeds", "0..4"])
        .args(["--arms", "sparse,gcn,planner", "--set", "run.episodes=60"])
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    out.join("report.html")
}

/// A run on a ring of eight states with a way off it, which is no grid.
fn graph_page(folder: &Path) -> PathBuf {
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
fn figures(folder: &Path) -> PathBuf {
    let out = folder.join("figures");
    eigentrail()
        .args(["figures", "--all", "-q", "--seeds", "2"])
        .args(["--set", "run.episodes=30", "-o"])
        .arg(&out)
        .assert()
        .success();
    out.join("index.html")
}

/// The object that a page is drawn from.
fn data(html: &str) -> serde_json::Value {
    let text = html.split("type=\"application/json\">").nth(1).unwrap();
    serde_json::from_str(text.split("</script>").next().unwrap()).unwrap()
}

/// Nothing in a page names an address but that of the SVG name space.
fn assert_self_contained(html: &str) {
    assert!(html.contains("default-src 'none'"));
    let addresses = html.matches("http").count() - html.matches("http-equiv").count();
    assert_eq!(
        addresses,
        html.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(
        !html.contains("{{"),
        "a place of the template is not filled"
    );
    assert!(html.len() < LARGEST);
}

#[test]
fn runs_leave_a_page_that_asks_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    assert_self_contained(&std::fs::read_to_string(run_page(folder.path())).unwrap());
    assert!(folder.path().join("shaped/report.html").is_file());
}

#[test]
fn shaping_of_the_default_run_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    let html = std::fs::read_to_string(run_page(folder.path())).unwrap();
    assert!(html.contains("optimal actions differ in 0 of"));
    assert!(html.contains("\"holds\":true"));
    assert!(!html.contains("\"holds\":false"));
}

#[test]
fn a_comparison_leaves_a_page_with_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let page = comparison_page(folder.path());
    let html = std::fs::read_to_string(&page).unwrap();
    assert_self_contained(&html);
    let numbers = std::fs::read_to_string(page.with_file_name("compare.json")).unwrap();
    let numbers: serde_json::Value = serde_json::from_str(&numbers).unwrap();
    let data = data(&html);
    for (arm, summary) in
        (data["arms"].as_array().unwrap().iter()).zip(numbers["arms"].as_array().unwrap())
    {
        assert_eq!(arm["name"], summary["name"]);
        assert_eq!(arm["versus"]["ratio"], summary["ratio_to_sparse"]);
        assert_eq!(
            arm["versus"]["improvement"],
            summary["probability_of_improvement"]
        );
        // Sixty episodes are few enough to be points of their own; the curve ends where the table begins.
        assert_eq!(arm["episodes"].as_array().unwrap().len(), 60);
        let last = |part: &str| arm["regret"][part][59].as_f64().unwrap();
        let iqm = summary["regret"]["iqm"].as_f64().unwrap();
        assert!((last("middle") - iqm).abs() <= 1e-4 * iqm.abs(), "{arm}");
        assert!(last("low") <= last("middle") && last("middle") <= last("high"));
        assert!(!arm["sights"]["frames"].as_array().unwrap().is_empty());
    }
    // The command again, and without a page.
    let folder = page.parent().unwrap();
    let again = folder.join("again.html");
    eigentrail()
        .arg("report")
        .arg(folder)
        .arg("-o")
        .arg(&again)
        .assert()
        .success();
    assert_eq!(std::fs::read_to_string(again).unwrap(), html);
    eigentrail()
        .args([
            "compare",
            "four_rooms",
            "-q",
            "--seeds",
            "0",
            "--arms",
            "planner",
        ])
        .args(["--set", "run.episodes=5", "--no-report", "--force", "--out"])
        .arg(folder)
        .assert()
        .success();
    assert!(!page.exists());
}

/// 300 × 300 cells, 30 moments, 100 000 episodes.
#[test]
fn pages_of_large_worlds_and_long_runs_stay_small_and_say_so() {
    const SIDE: usize = 300;
    let text = format!("[env]\nrows = {SIDE}\ncols = {SIDE}\n");
    let loaded = Scenario::parse(Path::new("large.toml"), text.clone(), &[]).unwrap();
    let states = SIDE * SIDE;
    let rough = |i: usize| (i as f32 * 0.7).sin() * i as f32;
    let snapshot = |step: u64| Snapshot {
        step,
        nodes: states,
        edges: 2 * states,
        potential: (0..states).map(rough).collect(),
        eigenvalues: vec![0.0; 16],
        vectors: vec![(0..states).map(rough).collect(); 4],
    };
    let episode = |i: u64| EpisodeRow {
        episodes: 1,
        episode: i,
        step: 601 * (i + 1),
        length: 598 + i % 7,
        plain_return: -((598 + i % 7) as f64),
        shaped_return: 1.0 / (1 + i) as f64,
        status: "terminated".into(),
        regret: i as f64 / 3.0,
        nodes: states,
        edges: 2 * states,
    };
    let seed = RecordedSeed {
        episodes: (0..100_000).map(episode).collect(),
        snapshots: (0..30).map(snapshot).collect(),
        labels: (0..states)
            .map(|i| format!("{},{}", i / SIDE, i % SIDE))
            .collect(),
        policy: (0..states as u32)
            .map(|state| PolicyRow {
                state,
                visits: u64::from(state),
                greedy: Some(1),
            })
            .collect(),
        ..RecordedSeed::default()
    };
    let mut summary = Summary::default();
    let result = SeedResult {
        seed: 0,
        finished: true,
        episodes: 100_000,
        steps: 60_000_000,
        regret: 33_333.0,
        optimal_steps: 598.0,
        final_mean_steps: 601.0,
        optimal_return: None,
        final_return: None,
        goals_moved_after: None,
        first_goal_step: Some(70_000),
        nodes: states,
        edges: 2 * states,
        spectrum_refreshes: 30,
        gcn_fits: 30,
    };
    let timing = SeedTiming {
        seed: 0,
        wall_seconds: 1.0,
        steps_per_second: 1.0,
    };
    summary.put(result, timing);
    let run = RecordedRun {
        name: "large".to_owned(),
        scenario: loaded.scenario,
        resolved: text,
        arguments: vec!["eigentrail".to_owned()],
        summary,
        seeds: vec![seed],
    };
    let html = html_report(&[run]);
    assert!(html.len() < LARGEST, "{} bytes", html.len());
    assert!(html.contains("Moments were left out to keep this file below 5 MB."));
    assert!(html.contains("each square stands for 2 × 2 cells"));
    let data = data(&html);
    let arm = &data["arms"][0];
    let frames = arm["sights"]["frames"].as_array().unwrap();
    assert!(frames.len() > 2, "{} moments", frames.len());
    assert_eq!(frames.last().unwrap()["step"], 29);
    let episodes = arm["episodes"].as_array().unwrap();
    assert!(episodes.len() < 400);
    assert_eq!(episodes.last().unwrap(), 100_000);
}

#[test]
fn figures_are_the_same_every_time() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (first, second) = (figures(one.path()), figures(two.path()));
    let html = std::fs::read_to_string(&first).unwrap();
    assert_self_contained(&html);
    assert_eq!(html, std::fs::read_to_string(&second).unwrap());
    for number in 4..=9 {
        assert!(html.contains(&format!("<b>Figure {number}.</b>")));
        let name = format!("fig{number}.svg");
        let svg = std::fs::read_to_string(first.with_file_name(&name)).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("<title>"), "{name}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
    }
}

/// Chromium under one of its names.
fn browser() -> Option<&'static str> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| {
        let version = Process::new(name).arg("--version").output();
        version.is_ok_and(|output| output.status.success())
    });
    if found.is_none() {
        eprintln!("skipped: no Chromium on this machine");
    }
    found
}

/// Opens `address` in a window of this width.
fn open(
    browser: &str,
    profile: &Path,
    width: u32,
    dark: bool,
    more: &str,
    address: &str,
) -> Output {
    let scheme = if dark { 0 } else { 1 };
    Process::new("timeout")
        .args(["90", browser])
        .args(["--headless=new", "--no-sandbox", "--disable-gpu"])
        .args(["--no-first-run", "--disable-background-networking"])
        .args(["--enable-logging=stderr", "--hide-scrollbars"])
        .arg(format!("--window-size={width},{}", 4 * width.max(900)))
        .arg(format!("--blink-settings=preferredColorScheme={scheme}"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(more)
        .arg(address)
        .output()
        .unwrap()
}

/// Pictures of a page on a desktop and on a phone, for people to look at.
fn take_screenshots(browser: &str, profile: &Path, page: &Path, name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/screenshots");
    std::fs::create_dir_all(&folder).unwrap();
    for (width, dark) in [(1280, false), (1280, true), (390, false)] {
        let ground = if dark { "dark" } else { "light" };
        let picture = folder.join(format!("{name}-{width}-{ground}.png"));
        let _ = std::fs::remove_file(&picture);
        let option = format!("--screenshot={}", picture.display());
        let address = format!("file://{}", page.display());
        open(browser, profile, width, dark, &option, &address);
        // A blank picture of this size compresses to a few kilobytes.
        let bytes = std::fs::metadata(&picture).unwrap().len();
        assert!(bytes > 40_000, "{}: {bytes} bytes", picture.display());
    }
}

/// Lets a page operate itself, and returns what it saw.
fn self_test(browser: &str, profile: &Path, page: &Path, width: u32) -> serde_json::Value {
    let address = format!("file://{}#selftest", page.display());
    let output = open(browser, profile, width, false, "--dump-dom", &address);
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(!messages.contains("CONSOLE"), "{messages}");
    let dom = String::from_utf8_lossy(&output.stdout);
    let result = dom.split("<pre id=\"selftest\">").nth(1);
    let result = result.and_then(|rest| rest.split("</pre>").next());
    serde_json::from_str(result.unwrap_or("null")).unwrap()
}

fn assert_works(browser: &str, folder: &Path, page: &Path, name: &str) {
    let profile = folder.join("profile");
    for width in [1280, 390] {
        let result = self_test(browser, &profile, page, width);
        for fact in [
            "sliderStartsAtTheEnd",
            "sliderMoves",
            "updateKeepsTheMoment",
            "sliderComesBack",
            "armSwitchesOff",
            "updateKeepsArmsOff",
            "armComesBack",
            "axisSwitches",
            "figuresHaveText",
            "numbersAreFinite",
            "fitsWidth",
            "noRequests",
        ] {
            assert_eq!(result[fact], true, "{name}, {width}: {fact}: {result}");
        }
        assert_eq!(result["errors"], serde_json::json!([]), "{result}");
    }
    take_screenshots(browser, &profile, page, name);
}

#[test]
fn the_page_of_runs_works_in_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    assert_works(browser, folder.path(), &run_page(folder.path()), "run");
}

#[test]
fn the_page_of_a_comparison_works_in_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = comparison_page(folder.path());
    assert_works(browser, folder.path(), &page, "compare");
}

#[test]
fn the_page_of_a_graph_works_in_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    assert_works(browser, folder.path(), &graph_page(folder.path()), "graph");
}

#[test]
fn the_figures_fit_into_a_browser() {
    let Some(browser) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("profile");
    take_screenshots(browser, &profile, &figures(folder.path()), "figures");
}
