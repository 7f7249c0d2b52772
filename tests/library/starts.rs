//! Several starts with weights, on maps and edge lists.

use eigentrail::env::conformance::check_model;
use eigentrail::env::{
    EnvError, Environment, GoalCell, GridWorld, GridWorldParams, Layout, TabularMdp,
};
use eigentrail::scenario::{Loaded, Scenario, World};
use eigentrail::seeds::{Stream, stream};
use std::collections::BTreeMap;
use std::path::Path;

/// 0.999 quantile of χ² with 2 degrees of freedom.
const CHI_SQUARE_2: f64 = 13.816;

fn parse(text: &str) -> Result<Loaded, String> {
    let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
    loaded.map_err(|error| error.to_string())
}

fn first(text: &str) -> World {
    let loaded = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    loaded.worlds.first().clone()
}

fn map(text: &str, starts: &[([usize; 2], f64)]) -> Result<GridWorld, EnvError> {
    let mut layout = Layout::from_ascii(text, &BTreeMap::new())?;
    for (at, weight) in starts {
        layout = layout.with_drawn_start(*at, *weight)?;
    }
    let rng = stream(7, Stream::Environment);
    GridWorld::new(layout, GridWorldParams::default(), rng)
}

#[test]
fn a_map_begins_as_often_as_weights_say_and_keeps_the_contract() {
    let starts = [([0, 0], 1.0), ([2, 0], 5.0), ([0, 2], 2.0)];
    let build = |seed| {
        let mut world = map("...\n.#.\n..G", &starts).unwrap();
        world.reseed(stream(seed, Stream::Environment));
        world
    };
    let mut world = build(1);
    let draws = 16_000;
    let mut counts = BTreeMap::new();
    for _ in 0..draws {
        *counts.entry(world.reset().0).or_insert(0.0) += 1.0;
    }
    let chi_square: f64 = [(0, 0.125), (6, 0.625), (2, 0.25)]
        .iter()
        .map(|(cell, share)| {
            let expected = share * f64::from(draws);
            (counts[cell] - expected).powi(2) / expected
        })
        .sum();
    assert!(counts.len() == 3 && chi_square < CHI_SQUARE_2, "{counts:?}");
    check_model(build, true).unwrap();
    check_model(|seed| build(seed).turning().unwrap(), true).unwrap();
    assert_eq!(world.layout().to_string(), "S.S\n.#.\nS.G");
}

/// The optimum of weighted starts is the weighted mean of what each of them would give alone.
#[test]
fn the_optimum_is_the_mean_of_the_single_ones() {
    let file = std::env::temp_dir().join(format!("eigentrail-starts-{}.csv", std::process::id()));
    std::fs::write(
        &file,
        "from,action,to\na,on,b\nb,on,c\nc,on,d\nc,back,a\nd,on,e\n",
    )
    .unwrap();
    let list = format!("kind = \"edge-list\"\nfile = {file:?}\ngoals = [{{ at = \"e\" }}]");
    let grid = "kind = \"open\"\nrows = 6\ncols = 7\nslip = 0.2".to_owned();
    let turns = format!("{grid}\nactions = \"turns\"");
    let cells = ["[0, 0]", "[5, 5]", "\"center\""];
    let names = ["\"a\"", "\"d\"", "\"b\""];
    for (kind, places) in [(&grid, cells), (&turns, cells), (&list, names)] {
        let begin = |start: &str| first(&format!("[env]\n{kind}\nstart = {start}"));
        let (mut earned, mut taken) = (0.0, 0.0);
        for (place, share) in places.iter().zip([0.5, 0.125, 0.375]) {
            let single = begin(place).optimum();
            earned += share * single.expected_return;
            taken += share * single.expected_steps;
        }
        let [one, two, three] = places;
        let whole = begin(&format!(
            "[{{ at = {one}, weight = 4 }}, {{ at = {two} }}, {{ at = {three}, weight = 3.0 }}]"
        ));
        let best = whole.optimum();
        assert!(
            (best.expected_return - earned).abs() < 1e-9,
            "{kind}: {best:?}"
        );
        assert!(
            (best.expected_steps - taken).abs() < 1e-9,
            "{kind}: {best:?}"
        );
        assert_eq!(whole.start_distribution().places().len(), 3);
        // Places without weights are as likely as each other.
        let equally = begin(&format!("[{one}, {two}, {three}]"));
        let ones = format!("[{{ at = {one} }}, {{ at = {two} }}, {{ at = {three} }}]");
        assert_eq!(equally.optimum(), begin(&ones).optimum());
        let mixed = begin(&format!("[{one}, {{ at = {two} }}, {three}]"));
        assert_eq!(equally.start_distribution(), mixed.start_distribution());
        // A list of one is that one.
        let alone = begin(&format!("[{{ at = {one}, weight = 9 }}]"));
        assert_eq!(alone.optimum(), begin(one).optimum());
    }
    std::fs::remove_file(file).unwrap();
}

/// From an end one begins anew: the chain that does so draws its starts by their chances.
#[test]
fn the_diameter_counts_starts_by_their_chances() {
    // Two cells, s and t, that lead to the end g alone: from s to t one must end, and be lucky.
    let sure = |next| {
        vec![eigentrail::env::Outcome {
            next,
            probability: 1.0,
            reward: 0.0,
        }]
    };
    let mdp = TabularMdp::new(
        &[vec![sure(2)], vec![sure(2)], vec![]],
        vec![false, false, true],
    )
    .unwrap();
    let weighted = eigentrail::env::Starts::weighted([(0, 3.0), (1, 1.0)]);
    // Each try takes the step to the end and the step anew, and succeeds with chance 1/4.
    assert!((mdp.diameter(&weighted).unwrap() - 8.0).abs() < 1e-9);
    assert!((mdp.diameter(&[0, 1]).unwrap() - 4.0).abs() < 1e-9);
}

#[test]
fn starts_that_make_no_sense_are_refused() {
    let place = |place: &str| place.to_owned();
    for (text, starts, error) in [
        ("..G", vec![], EnvError::NoStart),
        (
            "#.G",
            vec![([0, 0], 1.0)],
            EnvError::StartInWall { row: 0, col: 0 },
        ),
        (
            "..G",
            vec![([0, 2], 1.0)],
            EnvError::StartIsGoal {
                place: place("[0, 2]"),
            },
        ),
        (
            "..G",
            vec![([0, 0], 1.0), ([0, 0], 2.0)],
            EnvError::DuplicateStart {
                place: place("[0, 0]"),
            },
        ),
        (
            "..G",
            vec![([0, 0], 0.0)],
            EnvError::StartWeight {
                place: place("[0, 0]"),
                weight: 0.0,
            },
        ),
        (
            "..G#.",
            vec![([0, 0], 1.0), ([0, 4], 1.0)],
            EnvError::StartLeadsNowhere {
                place: place("[0, 4]"),
            },
        ),
        (
            "..G#.G",
            vec![([0, 0], 1.0), ([0, 1], 1.0)],
            EnvError::GoalUnreachable {
                goal: place("[0, 5]"),
                start: place("any start"),
            },
        ),
    ] {
        assert_eq!(map(text, &starts).map(|_| ()), Err(error), "{text}");
    }
    // Each goal needs one of the starts only.
    assert!(map("..G#.G", &[([0, 0], 1.0), ([0, 4], 1.0)]).is_ok());
    let mut world = map("..G#.G", &[([0, 0], 1.0), ([0, 4], 1.0)]).unwrap();
    let refused = world.set_goals(vec![GoalCell::new(world.layout().goals[0].cell)]);
    assert!(
        matches!(refused, Err(EnvError::StartLeadsNowhere { .. })),
        "{refused:?}"
    );
    for (start, told) in [
        (
            "[{ at = \"center\" }, { at = \"random\" }]",
            "\"random\" is no place on a map",
        ),
        (
            "[{ at = \"center\" }, { at = [7, 7], weight = 0 }]",
            "env.start[1].weight = 0",
        ),
        (
            "[{ at = \"center\" }, { at = \"center\" }]",
            "[7, 7] is given twice",
        ),
        ("[{ at = [99, 0] }]", "env.start[0].at"),
        ("[{ at = [0, 0], wieght = 2 }]", "did you mean `weight`"),
        ("[]", "name at least one place"),
        ("[1]", "a list of places, or of"),
        ("[\"center\", [99, 0]]", "env.start[1]: [99, 0]"),
    ] {
        let error = parse(&format!("[env]\nstart = {start}"))
            .map(|_| ())
            .unwrap_err();
        assert!(error.contains(told), "{start}: {error}");
    }
}
