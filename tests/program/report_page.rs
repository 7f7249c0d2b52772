//! The pages of runs, comparisons and figures; tests/outside opens them in a browser.

use crate::runs::{comparison_page, eigentrail, figures, graph_page, run_page};
use eigentrail::archive::{
    EpisodeRow, PolicyRow, RecordedRun, RecordedSeed, SeedResult, SeedTiming, Snapshot, Summary,
};
use eigentrail::report::html_report;
use eigentrail::scenario::{BUILT_IN_ARMS, Scenario};
use std::path::Path;

/// A page below this many bytes can be mailed.
const LARGEST: usize = 5_000_000;

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

/// Where the short way is the bad way, look-ahead advice says so nowhere but here; without advice there is nothing to say.
#[test]
fn what_advice_does_to_the_promise_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let check = |name: &str, sets: &[&str]| {
        let out = folder.path().join(name);
        let mut command = eigentrail();
        command.args([
            "run",
            "bridge_pit",
            "-q",
            "--set",
            "run.episodes=300",
            "--out",
        ]);
        command.arg(&out);
        for set in sets {
            command.args(["--set", set]);
        }
        command.assert().success();
        let data = data(&std::fs::read_to_string(out.join("report.html")).unwrap());
        let checks = data["arms"][0]["checks"].as_array().unwrap().clone();
        let about_advice = |check: &serde_json::Value| {
            let name = check["name"].as_str().unwrap();
            name.starts_with("Following φ")
        };
        checks.into_iter().find(about_advice)
    };
    let advice = "exploration.potential_advice=20";
    let right = check("right", &[advice]).expect("it advises");
    assert_eq!(right["holds"], true, "φ knows of the falls: {right}");
    let wrong = check("wrong", &[advice, "shaping.potential=negated-oracle"]);
    assert_eq!(wrong.expect("it advises")["holds"], false);
    assert_eq!(check("by-default", &[]), None);
    let alone = ["exploration.potential_advice=20", "exploration.kind=none"];
    assert_eq!(check("alone", &alone), None);
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

/// Runs a scenario for a few episodes into a folder.
fn short_run(scenario: &str, out: &Path, sets: &[&str]) {
    let mut command = eigentrail();
    command.args(["run", scenario, "-q", "--no-report"]);
    command.args(["--set", "run.episodes=8", "--out"]).arg(out);
    for set in sets {
        command.args(["--set", set]);
    }
    command.assert().success();
}

/// The data of a page about these runs.
fn page_of(folder: &Path, runs: &[&str]) -> serde_json::Value {
    let page = folder.join("page.html");
    let mut command = eigentrail();
    command
        .arg("report")
        .args(runs.iter().map(|run| folder.join(run)));
    command.arg("-o").arg(&page).assert().success();
    data(&std::fs::read_to_string(page).unwrap())
}

#[test]
fn runs_are_named_by_what_they_differ_in() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    short_run("four_rooms", &path.join("one"), &[]);
    short_run("four_rooms", &path.join("two"), &["agent.gamma=0.9"]);
    let page = page_of(path, &["one", "two"]);
    let told = |i: usize| {
        let arm = &page["arms"][i];
        [&arm["name"], &arm["label"], &arm["facts"][0][1]]
            .map(|text| text.as_str().unwrap().to_owned())
    };
    assert_eq!(
        told(0),
        ["four_rooms · agent.gamma=1.0", "gamma=1.0", "one"]
    );
    assert_eq!(
        told(1),
        ["four_rooms · agent.gamma=0.9", "gamma=0.9", "two"]
    );
    assert_eq!(page_of(path, &["two"])["arms"][0]["name"], "two");
}

#[test]
fn runs_of_different_worlds_do_not_share_a_chart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    short_run("four_rooms", &path.join("rooms"), &[]);
    short_run("spiral", &path.join("spiral"), &[]);
    short_run("four_rooms", &path.join("short"), &["agent.gamma=0.9"]);
    let page = page_of(path, &["rooms", "spiral", "short"]);
    assert_eq!(page["title"], "four_rooms");
    assert_eq!(page["arms"].as_array().unwrap().len(), 2);
    let [other] = page["others"].as_array().unwrap().as_slice() else {
        panic!("{}", page["others"]);
    };
    assert_eq!(other["title"], "spiral");
    assert_eq!(other["arms"].as_array().unwrap().len(), 1);
    assert_eq!(other["arms"][0]["name"], "spiral");
}

#[test]
fn states_and_actions_keep_the_names_of_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let html = std::fs::read_to_string(graph_page(folder.path())).unwrap();
    let page = data(&html);
    let sights = &page["arms"][0]["sights"];
    assert_eq!(sights["actions"], serde_json::json!(["on", "back", "off"]));
    assert_eq!(sights["names"][0], "s0");
    let names = sights["names"].as_array().unwrap();
    let place = |name: &str| names.iter().position(|known| known == name).unwrap();
    let held = &sights["greedy"][place("s4")];
    assert_eq!(held, 2, "the action that leaves the ring");
    assert_eq!(sights["next"][place("s4")], place("goal"));
}

#[test]
fn without_shaping_there_is_nothing_to_be_valid() {
    let folder = tempfile::tempdir().unwrap();
    let none = ["shaping.potential=none"];
    let unmixed = ["shaping.mix=0"];
    for (name, sets) in [("none", &none[..]), ("unmixed", &unmixed), ("shaped", &[])] {
        short_run("four_rooms", &folder.path().join(name), sets);
        let page = page_of(folder.path(), &[name]);
        let checks = page["arms"][0]["checks"].as_array().unwrap();
        let verdicts = checks.iter().filter(|check| !check["holds"].is_null());
        let expected = if name == "shaped" { 2 } else { 0 };
        assert_eq!(verdicts.count(), expected, "{name}: {checks:?}");
        let says_so = checks[0]["detail"].as_str().unwrap();
        assert_eq!(says_so.starts_with("not applicable"), name != "shaped");
    }
}

#[test]
fn arms_are_told_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("own.toml");
    let text = "[run]\nepisodes = 5\n[arms.steep]\nbase = \"gcn\"\nabout = \"a steeper one\"\n\
                \"shaping.scale_factor\" = 8.0\n[arms.mute]\n\"agent.gamma\" = 0.9\n";
    std::fs::write(&scenario, text).unwrap();
    let out = folder.path().join("comparison");
    eigentrail()
        .args([
            "compare",
            "-q",
            "--seeds",
            "0",
            "--arms",
            "sparse,steep,mute",
        ])
        .arg(&scenario)
        .arg("--out")
        .arg(&out)
        .assert()
        .success();
    let page = data(&std::fs::read_to_string(out.join("report.html")).unwrap());
    let sparse = BUILT_IN_ARMS.iter().find(|arm| arm.name == "sparse");
    let abouts = [sparse.unwrap().about, "a steeper one", "agent.gamma=0.9"];
    for (arm, about) in page["arms"].as_array().unwrap().iter().zip(abouts) {
        assert_eq!(arm["about"], about);
    }
}

#[test]
fn only_our_own_pages_and_figures_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    short_run("four_rooms", &path.join("run"), &[]);
    let (page, figure) = (path.join("page.html"), path.join("figure.svg"));
    let gallery = path.join("figures");
    std::fs::create_dir(&gallery).unwrap();
    let report = || {
        let mut command = eigentrail();
        command
            .arg("report")
            .arg(path.join("run"))
            .arg("-o")
            .arg(&page);
        command.assert()
    };
    let figures = |what: &str, out: &Path| {
        let mut command = eigentrail();
        command.args([
            "figures",
            what,
            "-q",
            "--seeds",
            "1",
            "--set",
            "run.episodes=3",
            "-o",
        ]);
        command.arg(out).assert()
    };
    for theirs in [&page, &figure, &gallery.join("fig7.svg")] {
        std::fs::write(theirs, "<html>my notes</html>").unwrap();
    }
    for refused in [
        report(),
        figures("four_rooms", &figure),
        figures("--all", &gallery),
    ] {
        let refused = refused.code(3).get_output().stderr.clone();
        let said = String::from_utf8(refused).unwrap();
        assert!(
            said.contains("eigentrail has not made it; name another file"),
            "{said}"
        );
    }
    for theirs in [&page, &figure, &gallery.join("fig7.svg")] {
        let kept = std::fs::read_to_string(theirs).unwrap();
        assert_eq!(kept, "<html>my notes</html>");
        std::fs::write(theirs, "").unwrap();
    }
    // What is empty holds nothing, and what is ours is replaced.
    for _ in 0..2 {
        report().success();
        figures("four_rooms", &figure).success();
    }
    assert!(
        std::fs::read_to_string(&page)
            .unwrap()
            .contains("made by eigentrail")
    );
    assert!(
        std::fs::read_to_string(&figure)
            .unwrap()
            .contains("made by eigentrail")
    );
}

#[test]
fn the_overview_has_one_scale_and_ends_at_its_data() {
    let folder = tempfile::tempdir().unwrap();
    let figure = folder.path().join("figure.svg");
    eigentrail()
        .args(["figures", "four_rooms", "-q", "--seeds", "2"])
        .args(["--set", "run.episodes=37", "-o"])
        .arg(&figure)
        .assert()
        .success();
    let svg = std::fs::read_to_string(figure).unwrap();
    let shades = svg.matches(r#"height="9" shape-rendering"#).count();
    assert_eq!(shades, 64, "one bar of colours");
    assert!(svg.contains(">37</text>"), "the last episode is marked");
    // At 390 pixels letters of 20 in 760 are as high as 10.
    assert!(svg.contains("text{font-size:20px}") && svg.contains("viewBox=\"0 0 760 "));
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
        ..Default::default()
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
