//! Maps and finite MDPs for tests: one of every kind, and random ones.

use eigentrail::env::{Doors, GridWorld, GridWorldParams, Landmark, Layout, Outcome, TabularMdp};
use eigentrail::seeds::{Stream, stream};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// One map of every kind, with start and goals, none larger than a few hundred cells.
pub fn maps() -> Vec<(&'static str, Layout)> {
    let rng = &mut stream(11, Stream::Layout);
    let rewards = BTreeMap::from([('1', 5.0), ('2', -20.0)]);
    let ascii = Layout::from_ascii("S...1\n.>v..\n..^<2\n#...G", &rewards).unwrap();
    let generated = [
        ("open", Layout::open(5, 5).unwrap()),
        ("one row", Layout::open(1, 9).unwrap()),
        (
            "four rooms",
            Layout::rooms(2, 2, [5, 5], Doors::Center, rng).unwrap(),
        ),
        (
            "random doors",
            Layout::rooms(2, 3, [3, 4], Doors::Random, rng).unwrap(),
        ),
        ("linked", Layout::linked(2, 2, [5, 5], 3).unwrap()),
        ("maze", Layout::maze(11, 13, 0.0, rng).unwrap()),
        ("maze with loops", Layout::maze(9, 9, 0.3, rng).unwrap()),
        ("caves", Layout::caves(14, 17, 0.4, 4, rng).unwrap()),
    ];
    let corners = |layout: Layout| {
        layout
            .with_start(Landmark::TopLeft)
            .unwrap()
            .with_goal(Landmark::Farthest, None)
            .unwrap()
    };
    let mut maps: Vec<_> = generated
        .map(|(name, layout)| (name, corners(layout)))
        .into();
    maps.push(("ascii", ascii));
    maps
}

pub fn grid_world(layout: &Layout, params: &GridWorldParams, seed: u64) -> GridWorld {
    GridWorld::new(
        layout.clone(),
        params.clone(),
        stream(seed, Stream::Environment),
    )
    .unwrap()
}

/// A random MDP whose last state is terminal and can be reached from every state by every action, so that every policy
/// ends. Rewards lie in [−2, 1).
pub fn random_mdp(states: usize, actions: usize, seed: u64) -> TabularMdp {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let terminal = (0..states).map(|state| state + 1 == states).collect();
    let filled = TabularMdp::from_fn(actions, terminal, |_, _, outcomes| {
        let to_end = rng.random_range(0.05..0.5);
        let split = rng.random_range(0.0..1.0 - to_end);
        for probability in [to_end, split, 1.0 - to_end - split] {
            let next = if outcomes.is_empty() {
                states - 1
            } else {
                rng.random_range(0..states)
            };
            let reward = rng.random_range(-2.0..1.0);
            outcomes.push(Outcome {
                next: next as u32,
                probability,
                reward,
            });
        }
    });
    filled.unwrap()
}
