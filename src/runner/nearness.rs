//! Nearness of a return to the best one there is.
//!
//! ```text
//! R is within x times the optimum   where   R ≥ R* − (x − 1) s,   s = |R*|, or the largest |r| of the world where R* = 0
//! final ratio                       =       1 + (R* − R̄) / s      so that R̄ is within x times iff its ratio is at most x
//! a policy of return R fails        where   R < R* − 0.05 s
//! ```
//!
//! Where every step costs the same, R = −c · length and R* = −c · length*: both say of returns what they said of lengths.
//! Elsewhere a length says nothing. An arm that dies at once is soon done, and earns nothing: its ratio is 2, or more.

use crate::env::{Model, Optimum};
use serde::{Deserialize, Serialize};

/// What R* may be of the largest reward and still be 0 but for rounding.
const ROUNDING: f64 = 1e-12;

/// Share of s that a sum of rewards may fall short by: 1.1 × 8 is not 8.8 in binary, nor is eight times −0.1.
const SLACK: f64 = 1e-10;

/// Share of s that the return of a policy may be below R* without failing.
const FAILURE: f64 = 0.05;

/// The best there is in one world, and what is near it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Nearness {
    /// What the best policy earns and takes.
    pub optimum: Optimum,
    /// s.
    scale: f64,
    /// Whether every step costs the same, whatever it leads to.
    one_cost: bool,
}

impl Nearness {
    /// That of a world. See [`TabularMdp::optimum`](crate::env::TabularMdp::optimum) for the cost.
    pub fn of(world: &impl Model) -> Self {
        Self::new(world.optimum(), world.to_mdp().reward_range())
    }

    /// That of a world with this optimum, whose rewards lie between the two.
    pub(super) fn new(optimum: Optimum, (lowest, highest): (f64, f64)) -> Self {
        let largest = lowest.abs().max(highest.abs());
        let best = optimum.expected_return.abs();
        Self {
            optimum,
            scale: if best > ROUNDING * largest {
                best
            } else {
                largest
            },
            one_cost: lowest == highest && lowest < 0.0,
        }
    }

    /// Whether the mean of `returns` is within `times` times the optimum.
    ///
    /// # Panics
    /// If there are none.
    pub fn holds(&self, returns: &[f64], times: f64) -> bool {
        assert!(!returns.is_empty(), "a mean of nothing");
        let best = self.optimum.expected_return;
        let least = match best < 0.0 && self.scale == -best {
            true => times * best, // R* − (x − 1) |R*|, without a rounding on the way
            false => best - (times - 1.0) * self.scale,
        };
        let n = returns.len() as f64;
        returns.iter().sum::<f64>() >= (least - SLACK * self.scale) * n
    }

    /// Whether a policy with this expected return has failed.
    pub fn fails(&self, expected_return: f64) -> bool {
        !self.holds(&[expected_return], 1.0 + FAILURE)
    }

    /// The final ratio of episodes with this mean return and mean length; 1 is the best.
    pub fn ratio(&self, mean_return: f64, mean_steps: f64) -> f64 {
        let best = self.optimum.expected_return;
        if self.one_cost {
            mean_steps / self.optimum.expected_steps // the same, and no rounding of probabilities in it
        } else if self.scale == 0.0 {
            1.0 // nothing can be earned or lost
        } else {
            1.0 + (best - mean_return) / self.scale
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn world(expected_return: f64, expected_steps: f64, rewards: (f64, f64)) -> Nearness {
        let optimum = Optimum {
            expected_return,
            expected_steps,
        };
        Nearness::new(optimum, rewards)
    }

    #[test]
    fn nothing_earned_is_not_near() {
        // Two steps to 1, or one into a hole: R* = 1.
        let holes = world(1.0, 3.0, (0.0, 1.0));
        assert!(!holes.holds(&[0.0; 20], 1.5));
        assert_eq!(holes.ratio(0.0, 1.0), 2.0);
        assert_eq!(holes.ratio(1.0, 3.0), 1.0);
        // Half of them, and nine of ten.
        assert!(holes.holds(&[0.0, 1.0], 1.5) && !holes.holds(&[0.0, 1.0], 1.4));
        let mut nine = [1.0; 10];
        nine[3] = 0.0;
        assert!(holes.holds(&nine, 1.1) && !holes.holds(&nine[..9], 1.1));
    }

    #[test]
    fn where_the_best_is_nothing_the_largest_reward_is_the_measure() {
        let swamp = world(0.0, 2.0, (-5.0, 3.0));
        assert!(swamp.holds(&[-0.5; 20], 1.1) && !swamp.holds(&[-0.51; 20], 1.1));
        assert_eq!(swamp.ratio(-5.0, 1.0), 2.0);
        // 0.1 + 0.2 − 0.3 is not 0, but no more than that.
        let rounded = world(0.1 + 0.2 - 0.3, 3.0, (-0.3, 0.2));
        assert!(rounded.holds(&[0.0; 20], 1.1));
        assert_eq!(world(0.0, 1.0, (0.0, 0.0)).ratio(0.0, 4.0), 1.0);
    }

    proptest! {
        /// Where every step costs the same, returns say what lengths say, to the last step.
        #[test]
        fn equal_costs_count_steps(
            shortest in 1_u32..4000,
            times in prop::sample::select(vec![1.1, 1.5]),
            off in -3_i64..4,
            parts in prop::collection::vec(0_u32..50, 19),
            cost in prop::sample::select(vec![1.0, 0.1, 0.3, 7.0]),
        ) {
            let at_most = (u64::from(shortest) * 20 * (10.0 * times) as u64) / 10;
            let total = (at_most as i64 + off).max(0) as u64;
            let mut lengths: Vec<u64> = parts.into_iter().map(u64::from).collect();
            let so_far: u64 = lengths.iter().sum();
            prop_assume!(so_far <= total);
            lengths.push(total - so_far);
            // As the loop adds them up.
            let earned = |steps: u64| (0..steps).fold(0.0, |sum, _| sum - cost);
            let returns: Vec<f64> = lengths.iter().map(|&l| earned(l)).collect();
            let best = -cost * f64::from(shortest);
            let near = world(best, f64::from(shortest), (-cost, -cost));
            prop_assert_eq!(near.holds(&returns, times), total <= at_most);
            let mean = total as f64 / 20.0;
            prop_assert_eq!(near.ratio(-cost * mean, mean), mean / f64::from(shortest));
        }
    }
}
