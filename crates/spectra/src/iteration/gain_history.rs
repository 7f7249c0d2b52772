//! Gains that past updates have needed, and from them how strong the first filter of the next should be.
//!
//! A filter of degree d costs d block solves. Where it turns out too weak a second round follows: a
//! Rayleigh–Ritz step, and a filter for what is still missing. An update needs much the same gain as
//! those before it, give or take a factor of ten. So the degree is chosen that would have cost least
//! over the last few updates, whose needs g_i are known:
//!
//!   argmin_d Σ_i  d + [gain_d < g_i] · (round + the least d' with gain_d' ≥ margin · g_i / gain_d).
//!
//! What a round costs, in block solves, is estimated from sizes rather than timed, so that results do
//! not depend on the clock.

use super::filter::Filter;

/// The next filter's gain on λ_k, relative to the reduction that is missing: residuals fall by
/// several times the gain, since part of what is wrong lies well beyond the cut. Where that was too little
/// the filter after it aims [`RAISE`] times higher, and so on.
pub(crate) const MARGIN: f64 = 0.3;
pub(crate) const RAISE: f64 = 8.0;

/// Updates remembered: enough to tell one in eight, few enough to follow a graph that changes.
const REMEMBERED: usize = 8;

/// Gain expected of a first update: what a growth of some per cent needs.
const FIRST_GAIN: f64 = 30.0;

/// Least degree of a first filter. Weaker ones leave guards so rough that the error bounds say nothing,
/// and the need measured behind them is several times too large.
const LEAST_SOLVES: usize = 3;

/// Time per row and column, in units of one entry of the factor, of a round and of what a solve does
/// besides going through the factor. Measured on grids, rooms and mazes of 1e5 nodes.
const ROUND: f64 = 26.0;
const SOLVE: f64 = 8.0;

/// What a round costs besides its filter, in block solves with a factor of `fill` entries for `rows`.
pub(crate) fn round_cost(rows: usize, fill: usize) -> f64 {
    ROUND * rows as f64 / (SOLVE * rows as f64 + fill as f64)
}

/// Gains that would just have sufficed in the first round of the last updates.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct GainHistory(
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::numbers"))] Vec<f64>,
);

impl GainHistory {
    /// One gain, as if it had been needed.
    pub(crate) fn of(gain: f64) -> Self {
        Self(vec![gain])
    }

    /// With one more; the oldest is forgotten.
    pub(crate) fn and(mut self, gain: f64) -> Self {
        self.0.push(gain);
        self.0.drain(..self.0.len().saturating_sub(REMEMBERED));
        self
    }

    /// Their geometric mean.
    pub(crate) fn usual(&self) -> f64 {
        let logarithms: f64 = self.known().iter().map(|&gain| libm::log(gain)).sum();
        libm::exp(logarithms / self.known().len() as f64)
    }

    fn known(&self) -> &[f64] {
        match &self.0[..] {
            [] => &[FIRST_GAIN],
            known => known,
        }
    }

    /// The filter of `family` (degrees 1, 2, …) that would have cost least for the gains on
    /// λ = `wanted` that were needed, with a round at the price of `round_cost` block solves.
    ///
    /// # Panics
    /// If the family is empty.
    pub(crate) fn cheapest(&self, family: &[Filter], wanted: f64, round_cost: f64) -> Filter {
        let gains: Vec<f64> = family.iter().map(|f| f.gain(wanted)).collect();
        let needs = self.known();
        let solves = |gain: f64| 1 + gains.partition_point(|&g| g < gain).min(gains.len() - 1);
        let second = |need: f64, first: f64| round_cost + solves(MARGIN * need / first) as f64;
        let cost = |d: usize| -> f64 {
            let missed = needs.iter().filter(|&&need| need > gains[d]);
            (needs.len() * (d + 1)) as f64 + missed.map(|&g| second(g, gains[d])).sum::<f64>()
        };
        let least = LEAST_SOLVES.min(family.len()) - 1;
        // The stronger one where two cost the same.
        let cheapest = (least..family.len())
            .rev()
            .min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
        family[cheapest.expect("a family has a first member")]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WANTED: f64 = 1.0;

    fn family() -> Vec<Filter> {
        Filter::family(&[], 1.5, 0.1, 2)
    }

    fn degree(needs: &[f64], round_cost: f64) -> usize {
        let needs = needs.iter().fold(GainHistory::default(), |n, &g| n.and(g));
        needs.cheapest(&family(), WANTED, round_cost).solves()
    }

    fn gain(degree: usize) -> f64 {
        family()[degree - 1].gain(WANTED)
    }

    #[test]
    fn the_usual_need_is_a_mean_of_magnitudes() {
        assert!((GainHistory::default().usual() - FIRST_GAIN).abs() < 1e-9);
        let needs = GainHistory::of(1.0).and(10.0).and(1000.0).and(1e4);
        assert!((needs.usual() - 100.0).abs() < 1e-9);
    }

    #[test]
    fn steady_needs_are_met_in_one_round() {
        for d in 3..9 {
            for cost in [0.5, 2.0] {
                assert_eq!(degree(&[0.99 * gain(d); 8], cost), d);
            }
        }
    }

    #[test]
    fn a_rare_large_need_is_worth_a_solve_every_time_only_where_rounds_are_dear() {
        let mut needs = [0.99 * gain(4); 8];
        needs[3] = 0.99 * gain(5);
        // One more solve in eight updates against a round and a short filter in one of them.
        assert_eq!(degree(&needs, 2.0), 4);
        assert_eq!(degree(&needs, 20.0), 5);
    }

    #[test]
    fn needs_out_of_reach_change_nothing() {
        let mut needs = [0.99 * gain(4); 8];
        needs[0] = f64::INFINITY;
        needs[5] = 1e100;
        assert_eq!(degree(&needs, 2.0), 4);
    }

    #[test]
    fn old_needs_are_forgotten() {
        let mut needs = vec![0.99 * gain(8); 20];
        needs.extend([0.99 * gain(3); REMEMBERED]);
        assert_eq!(degree(&needs, 1.0), 3);
    }

    #[test]
    fn fuller_factors_make_rounds_cheaper_beside_solves() {
        assert!(round_cost(1000, 30_000) < 0.5 * round_cost(1000, 2_000));
    }
}
