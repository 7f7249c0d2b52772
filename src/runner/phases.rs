//! A run's worlds one after the other, and what the best policy could have earned in them.
//!
//! ρ(T) = Σ_t (R*_t − R_t), eq. 15 of the source paper with R*_t the optimum **of the goals in force in episode t**:
//! of a goal that moves, no policy can earn what the goal before it paid.

use super::nearness::Nearness;
use crate::env::{GridWorld, Model, TabularEnvironment};
use crate::scenario::{MovedWorld, Scenario, World};

/// The worlds of a run: the same states, other goals.
#[derive(Clone, Debug)]
pub struct Phases<E> {
    /// What it begins with.
    pub first: E,
    /// What it goes on with, and after how many episodes.
    pub moved: Option<(usize, Box<E>)>,
}

/// The worlds of a run, by their type.
pub enum Worlds {
    /// Maps.
    Grid(Phases<GridWorld>),
    /// Edge lists, with the names of their states.
    Listed(Phases<TabularEnvironment>, Vec<String>),
}

impl Worlds {
    /// Those of a scenario that was checked when it was loaded.
    pub fn of(scenario: &Scenario, seed: u64) -> Self {
        let checked = "the scenario was checked when it was loaded";
        let first = scenario.world(seed).expect(checked);
        let moved = scenario.moved_world(seed).expect(checked);
        match first {
            World::Grid(first) => {
                let moved = moved.and_then(|MovedWorld { after, world }| match world {
                    World::Grid(world) => Some((after, Box::new(world))),
                    World::Listed(..) => None, // both are of the scenario's one kind
                });
                Worlds::Grid(Phases { first, moved })
            }
            World::Listed(first, names) => {
                let moved = moved.and_then(|MovedWorld { after, world }| match world {
                    World::Listed(world, _) => Some((after, Box::new(world))),
                    World::Grid(_) => None,
                });
                Worlds::Listed(Phases { first, moved }, names)
            }
        }
    }
}

impl<E: Model> Phases<E> {
    /// The optimum of each phase; see [`Nearness::of`] for the cost.
    pub fn yardstick(&self) -> Yardstick {
        let moved = self.moved.as_ref();
        Yardstick {
            first: Nearness::of(&self.first),
            moved: moved.map(|(after, world)| (*after, Nearness::of(world.as_ref()))),
        }
    }

    /// The world to go on with, if episode number `episode`, from 0, is the first one in it.
    pub fn take_moved(&mut self, episode: usize) -> Option<E> {
        let (_, world) = self.moved.take_if(|(after, _)| *after == episode)?;
        Some(*world)
    }
}

/// What the best policy earns and takes in each episode of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardstick {
    first: Nearness,
    moved: Option<(usize, Nearness)>,
}

impl Yardstick {
    /// Episodes played before the goals moved, of the first `episodes`; none if they did not move in them.
    pub fn moved_after(&self, episodes: usize) -> Option<usize> {
        let (after, _) = self.moved?;
        (after < episodes).then_some(after)
    }

    /// The optimum under the goals of the last of `episodes` episodes.
    pub fn last(&self, episodes: usize) -> Nearness {
        match (self.moved, self.moved_after(episodes)) {
            (Some((_, moved)), Some(_)) => moved,
            _ => self.first,
        }
    }

    /// Σ R* of the first `episodes` episodes.
    pub fn expected_return(&self, episodes: usize) -> f64 {
        let before = self.moved_after(episodes).unwrap_or(episodes);
        let since = episodes - before;
        let first = before as f64 * self.first.optimum.expected_return;
        match self.moved {
            Some((_, moved)) if since > 0 => first + since as f64 * moved.optimum.expected_return,
            _ => first,
        }
    }

    /// Of something that was noted for each episode so far, what was noted under the last goals.
    pub fn since_move<'a, T>(&self, noted: &'a [T]) -> &'a [T] {
        &noted[self.moved_after(noted.len()).unwrap_or(0)..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Optimum;
    use std::path::Path;

    fn optimum(steps: f64) -> Nearness {
        let optimum = Optimum {
            expected_return: 1.0 - steps,
            expected_steps: steps,
        };
        Nearness::new(optimum, (-1.0, 0.0))
    }

    #[test]
    fn each_episode_is_measured_by_the_goals_in_force() {
        let moving = Yardstick {
            first: optimum(9.0),
            moved: Some((3, optimum(5.0))),
        };
        let by_hand = [-8.0, -8.0, -8.0, -4.0, -4.0];
        for episodes in 0..=5 {
            let sum: f64 = by_hand[..episodes].iter().sum();
            assert_eq!(moving.expected_return(episodes), sum, "{episodes}");
        }
        assert_eq!(moving.last(3), optimum(9.0));
        assert_eq!(moving.last(4), optimum(5.0));
        assert_eq!(moving.moved_after(3), None);
        assert_eq!(moving.moved_after(4), Some(3));
        assert_eq!(moving.since_move(&[7, 7, 7]), [7, 7, 7]);
        assert_eq!(moving.since_move(&[7, 7, 7, 4, 4]), [4, 4]);
        let still = Yardstick {
            first: optimum(9.0),
            moved: None,
        };
        assert_eq!(still.expected_return(5), 5.0 * -8.0);
        assert_eq!(still.since_move(&[1, 2]), [1, 2]);
    }

    #[test]
    fn a_scenario_says_when_and_where_to() {
        let text = "[env]\nrows = 4\ncols = 5\nmoved_goals = [{ at = \"top-right\" }]\n[run]\nepisodes = 9\n";
        let scenario = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]);
        let Worlds::Grid(mut phases) = Worlds::of(&scenario.unwrap().scenario, 0) else {
            panic!("an open field is a map");
        };
        let yardstick = phases.yardstick();
        assert_eq!(yardstick.last(5).optimum.expected_steps, 7.0);
        assert_eq!(yardstick.last(6).optimum.expected_steps, 4.0);
        assert!(phases.take_moved(4).is_none());
        let world = phases.take_moved(5).expect("half of 9, rounded up");
        assert_eq!(world.optimum().expected_steps, 4.0);
        assert!(phases.take_moved(5).is_none(), "it is taken once");
    }
}
