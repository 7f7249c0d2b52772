//! A walker that turns, against a simulator of its own.

use crate::env_worlds::{grid_world, maps};
use crate::environments::any_map;
use eigentrail::env::conformance::check_model;
use eigentrail::env::{
    Action, Environment, GridWorld, GridWorldParams, Layout, MdpState, Model, StepStatus,
    TabularEnvironment,
};
use eigentrail::seeds::{Stream, stream};
use proptest::prelude::*;
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

/// 0.999 quantile of χ² with 2 degrees of freedom.
const CHI_SQUARE_2: f64 = 13.816;

const FORWARD: Action = Action(2);
const NAMES: [&str; 4] = ["east", "south", "west", "north"];
const AHEAD: [(i32, i32); 4] = [(0, 1), (1, 0), (0, -1), (-1, 0)];
const ARROWS: [char; 4] = ['>', 'v', '<', '^'];

/// Row, column, heading.
type Pose = (i32, i32, usize);

/// A map as it is drawn.
struct Drawing(Vec<Vec<char>>);

impl Drawing {
    fn of(layout: &Layout) -> Self {
        let text = layout.to_string();
        Drawing(text.lines().map(|line| line.chars().collect()).collect())
    }

    fn at(&self, row: i32, col: i32) -> char {
        let line = usize::try_from(row).ok().and_then(|row| self.0.get(row));
        let found = line.and_then(|line| line.get(usize::try_from(col).ok()?));
        *found.unwrap_or(&'#')
    }

    fn is_goal(&self, (row, col, _): Pose) -> bool {
        matches!(self.at(row, col), 'G' | '1')
    }

    fn start(&self) -> Pose {
        let cells = (0..self.0.len()).flat_map(|r| (0..self.0[r].len()).map(move |c| (r, c)));
        let mut starts = cells.filter(|&(r, c)| self.0[r][c] == 'S');
        let (row, col) = starts.next().unwrap();
        (row as i32, col as i32, 0)
    }

    /// One step towards `way`, whatever the heading.
    fn moved(&self, (row, col, heading): Pose, way: usize) -> Pose {
        let here = self.at(row, col);
        let may_leave = !ARROWS.contains(&here) || here == ARROWS[way];
        let (down, right) = AHEAD[way];
        match may_leave && self.at(row + down, col + right) != '#' {
            true => (row + down, col + right, heading),
            false => (row, col, heading),
        }
    }

    fn acted(&self, pose: Pose, action: u16) -> Pose {
        let (row, col, heading) = pose;
        match action {
            0 => (row, col, (heading + 3) % 4),
            1 => (row, col, (heading + 1) % 4),
            _ => self.moved(pose, heading),
        }
    }

    /// Steps of the shortest way to a goal.
    fn steps_to_a_goal(&self) -> Option<u32> {
        let mut queue = VecDeque::from([(self.start(), 0)]);
        let mut seen = HashSet::from([self.start()]);
        while let Some((pose, steps)) = queue.pop_front() {
            if self.is_goal(pose) {
                return Some(steps);
            }
            for action in 0..3 {
                let next = self.acted(pose, action);
                if seen.insert(next) {
                    queue.push_back((next, steps + 1));
                }
            }
        }
        None
    }
}

fn name((row, col, heading): Pose) -> String {
    format!("{row},{col},{}", NAMES[heading])
}

fn pose(name: &str) -> Pose {
    let parts: Vec<&str> = name.split(',').collect();
    let heading = NAMES.iter().position(|n| *n == parts[2]).unwrap();
    (
        parts[0].parse().unwrap(),
        parts[1].parse().unwrap(),
        heading,
    )
}

fn slippery(slip: f64) -> GridWorldParams {
    GridWorldParams {
        slip,
        ..GridWorldParams::default()
    }
}

fn ascii(map: &str) -> Layout {
    Layout::from_ascii(map, &BTreeMap::new()).unwrap()
}

fn turning(map: &str, params: &GridWorldParams) -> (TabularEnvironment, Vec<String>) {
    let world = grid_world(&ascii(map), params, 0);
    (world.turning().unwrap(), world.turning_names())
}

#[test]
fn every_map_keeps_the_contract() {
    let anywhere = GridWorldParams {
        random_start: true,
        max_steps: Some(37),
        ..slippery(0.0)
    };
    for (name, layout) in maps() {
        for (params, random) in [
            (slippery(0.0), false),
            (slippery(0.3), true),
            (anywhere.clone(), true),
        ] {
            let make = |seed| grid_world(&layout, &params, seed).turning().unwrap();
            let checked = check_model(make, random);
            checked.unwrap_or_else(|broken| panic!("{name}, {params:?}:\n{broken}"));
        }
    }
}

#[test]
fn ways_are_longer_by_their_turns() {
    for (map, moves, turns) in [
        ("S.G", 2.0, 2.0),
        // About face first.
        ("G.S", 2.0, 4.0),
        // East, and one turn at the corner; south first would take two.
        ("S..\n.#.\n..G", 4.0, 5.0),
        ("S#G\n.#.\n...", 6.0, 9.0),
        // An arrow is left southwards only, with a turn in it.
        ("Sv.\n#.G", 3.0, 5.0),
    ] {
        let world = grid_world(&ascii(map), &slippery(0.0), 0);
        assert_eq!(world.optimum().expected_steps, moves, "{map}");
        let turning = world.turning().unwrap();
        assert_eq!(turning.optimum().expected_steps, turns, "{map}");
        assert_eq!(turning.max_steps(), 40 * world.layout().num_free());
    }
}

#[test]
fn forward_slips_to_the_sides_of_the_heading_and_turns_do_not() {
    let (mut world, names) = turning("...\n.S.\n..G", &slippery(0.4));
    let mut counts: HashMap<&str, f64> = HashMap::new();
    let draws = 10_000;
    for _ in 0..draws {
        world.reset();
        assert_eq!(world.step(Action(1)).state, MdpState(4 * 4 + 1));
        let next = world.step(FORWARD).state;
        *counts.entry(&names[next.index()]).or_default() += 1.0;
    }
    let shares = [("2,1,south", 0.6), ("1,0,south", 0.2), ("1,2,south", 0.2)];
    let chi_square: f64 = shares
        .iter()
        .map(|(name, share)| {
            let expected = share * f64::from(draws);
            (counts[name] - expected).powi(2) / expected
        })
        .sum();
    assert!(counts.len() == 3 && chi_square < CHI_SQUARE_2, "{counts:?}");
}

proptest! {
    #[test]
    fn steps_are_those_of_the_simulator(layout in any_map(), actions in prop::collection::vec(0..3_u16, 60)) {
        let drawing = Drawing::of(&layout);
        let Ok(map) = GridWorld::new(layout, slippery(0.0), stream(0, Stream::Environment)) else { return Ok(()) };
        let (mut world, names) = (map.turning().unwrap(), map.turning_names());
        let nearest = world.mdp().distances_to_terminal()[world.start_states()[0]];
        prop_assert_eq!(nearest, drawing.steps_to_a_goal());
        let mut here = drawing.start();
        prop_assert_eq!(&names[world.reset().index()], &name(here));
        for action in actions {
            here = drawing.acted(here, action);
            let step = world.step(Action(action));
            prop_assert_eq!(&names[step.state.index()], &name(here));
            prop_assert_eq!(step.status == StepStatus::Terminated, drawing.is_goal(here));
            // The goal drawn as 1 pays 5 on top of a step.
            let bonus = if drawing.at(here.0, here.1) == '1' { 5.0 } else { 0.0 };
            prop_assert_eq!(step.reward, bonus - 1.0);
            if step.status.is_last() {
                here = drawing.start();
                world.reset();
            }
        }
    }

    #[test]
    fn chances_are_those_of_the_simulator(layout in any_map(), slip in 0.0..0.99) {
        let drawing = Drawing::of(&layout);
        let Ok(map) = GridWorld::new(layout, slippery(slip), stream(0, Stream::Environment)) else { return Ok(()) };
        let (world, names) = (map.turning().unwrap(), map.turning_names());
        for (state, of_state) in names.iter().enumerate() {
            let from = pose(of_state);
            prop_assert_eq!(world.mdp().is_terminal(state), drawing.is_goal(from));
            for action in 0..3 {
                let mut expected: HashMap<String, f64> = HashMap::new();
                if action < 2 {
                    expected.insert(name(drawing.acted(from, action)), 1.0);
                } else {
                    for (by, chance) in [(0, 1.0 - slip), (1, slip / 2.0), (3, slip / 2.0)] {
                        let next = drawing.moved(from, (from.2 + by) % 4);
                        *expected.entry(name(next)).or_default() += chance;
                    }
                }
                for outcome in world.mdp().outcomes(state, Action(action)) {
                    let left = expected.get_mut(&names[outcome.next as usize]);
                    let left = left.ok_or_else(|| TestCaseError::fail("an outcome too many"))?;
                    *left -= outcome.probability;
                }
                let settled = drawing.is_goal(from) || expected.values().all(|left| left.abs() < 1e-12);
                prop_assert!(settled, "{}, {}: {:?}", of_state, action, expected);
            }
        }
    }
}
