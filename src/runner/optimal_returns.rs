//! Returns that the best policy could have earned in each episode of a run.
//!
//! ρ(T) = Σ_t (R*_t − R_t), eq. 15 of the source paper with R*_t the optimum **of the goals in force in episode t**:
//! of a goal that moves, no policy can earn what the goal before it paid.

use super::nearness::Nearness;
use crate::scenario::{World, Worlds};

/// Returns and lengths of the best policy in each episode of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimalReturns {
    first: Nearness,
    moved: Option<(usize, Nearness)>,
}

impl OptimalReturns {
    /// The optimum before and after the goals move; see [`Nearness::of`] for the cost. No seed has a part in it.
    pub fn of(worlds: &Worlds) -> Self {
        let nearness = |world: &World| match world {
            World::Grid(world) => Nearness::of(world),
            World::Listed(world, _) => Nearness::of(world),
        };
        let moved = worlds.moved();
        Self {
            first: nearness(worlds.first()),
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
        let optimal = OptimalReturns::of(&loaded.worlds);
        assert_eq!(optimal.last(5).optimum.expected_steps, 7.0);
        assert_eq!(optimal.last(6).optimum.expected_steps, 4.0);
        assert_eq!(optimal.moved_after(9), Some(5), "half of 9, rounded up");
    }
}
