//! Names are those that run, and choices those that there are.

use crate::program::Program;

fn names(list: &serde_json::Value) -> Vec<&str> {
    let entries = list.as_array().unwrap().iter();
    entries
        .map(|entry| entry["name"].as_str().unwrap())
        .collect()
}

#[test]
fn the_name_printed_is_the_name_that_runs() {
    let program = Program::new();
    let listed = program.prints_json(&["list", "--json"]);
    // Those that are checked in no time.
    let small = ["smoke", "four_rooms", "deep_sea_10", "river_swim_6"];
    for name in small {
        assert!(names(&listed["scenarios"]).contains(&name), "{name}");
        let hyphened = name.replace('_', "-");
        for typed in [name, &hyphened] {
            let facts = program.prints_json(&["check", typed, "--json"]);
            assert_eq!(facts["scenario"], name, "{typed}");
        }
    }
}

#[test]
fn a_new_scenario_and_the_list_name_every_choice() {
    let program = Program::new();
    let template = program.prints(&["new", "mine"]);
    let text = program.prints(&["list"]);
    let listed = program.prints_json(&["list", "--json"]);
    let comment = template.replace("\n#", ""); // wrapped where it is long
    for (list, key) in [
        ("kinds", "kind = \"open\""),
        ("potentials", "potential = \"gcn\""),
        ("explorations", "kind = \"frontier\""),
        ("agents", "kind = \"replay-actor-critic\""),
        ("updates", "update = \"advantage\""),
        ("features", "features = \"tabular\""),
    ] {
        let names = names(&listed[list]);
        assert!(names.len() > 1, "{list}");
        let quoted: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        let choices = format!("One of: {}.", quoted.join(", "));
        let (_, after) = comment
            .split_once(&choices)
            .unwrap_or_else(|| panic!("{choices}"));
        assert!(after.starts_with(key), "{list}: {}", &after[..40]);
        for name in names {
            assert!(text.contains(&format!("\n  {name}")), "{name}");
        }
    }
}
