//! Returns that the best policy could have earned in each episode of a run.
//!
//! ρ(T) = Σ_t (R*_t − R_t), eq. 15 of the source paper with R*_t the optimum **of the goals in force in episode t**:
//! of a goal that moves, no policy can earn what the goal before it paid.

use super::nearness::Nearness;
use crate::scenario::{World, Worlds};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Returns and lengths of the best policy in each episode of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimalReturns {
    first: Nearness,
    moved: Option<(usize, Nearness)>,
}

impl OptimalReturns {
    /// The optimum before and after the goals move, for a run with this seed, which has a part in it only if the worlds
    /// [differ by seed](Worlds::differ_by_seed); see [`Nearness::of`] for the cost.
    pub fn of(worlds: &Worlds, seed: u64) -> Self {
        let nearness = |world: &World| match world {
            World::Grid(world) => Nearness::of(world),
            World::Listed(world, _) => Nearness::of(world),
        };
        let moved = worlds.moved();
        let first = match worlds.differ_by_seed() {
            true => nearness(&worlds.first_for(seed)),
            false => nearness(worlds.first()),
        };
        Self {
            first,
            moved: moved.map(|moved| (moved.after, nearness(&moved.world))),
        }
    }

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

/// The optima of a scenario, each worked out once, when it is first asked for.
#[derive(Debug, Default)]
pub struct KnownOptima {
    /// By seed; under no seed that of worlds without differences.
    known: Mutex<HashMap<Option<u64>, Arc<OnceLock<OptimalReturns>>>>,
}

impl KnownOptima {
    /// The one for a run with this seed in these worlds, which are the same ones at every call. Who asks for one that is being
    /// worked out waits for it; others do not.
    pub fn of(&self, worlds: &Worlds, seed: u64) -> OptimalReturns {
        let key = worlds.differ_by_seed().then_some(seed);
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let optimal = Arc::clone(known.entry(key).or_default());
        drop(known);
        *optimal.get_or_init(|| OptimalReturns::of(worlds, seed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Optimum;
    use crate::scenario::Scenario;
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
        let moving = OptimalReturns {
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
        let still = OptimalReturns {
            first: optimum(9.0),
            moved: None,
        };
        assert_eq!(still.expected_return(5), 5.0 * -8.0);
        assert_eq!(still.since_move(&[1, 2]), [1, 2]);
    }

    #[test]
    fn a_scenario_says_when_and_where_to() {
        let text = "[env]\nrows = 4\ncols = 5\nmoved_goals = [{ at = \"top-right\" }]\n[run]\nepisodes = 9\n";
        let loaded = Scenario::parse(Path::new("x.toml"), text.to_owned(), &[]).unwrap();
        let optimal = OptimalReturns::of(&loaded.worlds, 0);
        assert_eq!(optimal.last(5).optimum.expected_steps, 7.0);
        assert_eq!(optimal.last(6).optimum.expected_steps, 4.0);
        assert_eq!(optimal.moved_after(9), Some(5), "half of 9, rounded up");
    }
}
