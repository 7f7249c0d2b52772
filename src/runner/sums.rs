//! The sums over the episodes of a run: lengths, returns, regret, and when they came near the optimum.

use super::nearness::Nearness;
use super::optimal_returns::OptimalReturns;
use crate::archive::{FirstWithin, LearningCurve, TrialTiming};
use crate::engine::{EpisodeRecord, RefreshRecord};
use crate::statistics::blocks;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Episodes whose mean return must be near the optimum.
const WINDOW: usize = 20;

/// Blocks of a [`LearningCurve`], about.
const BLOCKS: usize = 120;

/// Sums over the episodes of a run so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Sums {
    /// As many as there are to be.
    episodes: usize,
    /// The clock goes on from what it said when it was written down.
    #[serde(with = "elapsed")]
    begun: Instant,
    optimal: OptimalReturns,
    lengths: Vec<u32>,
    returns: Vec<f64>,
    /// Σ of them.
    total: f64,
    /// Episodes before the goals moved to where they are at the end of the run, and the steps they took.
    before_last_goals: usize,
    moved_at: u64,
    within_1_5x: Approach,
    within_1_1x: Approach,
    spectrum_refreshes: usize,
    gcn_fits: usize,
    gcn_epochs: usize,
    spectrum_seconds: f64,
    fit_seconds: f64,
}

impl Sums {
    /// Those of a run of `episodes` that begins now.
    pub fn new(optimal: OptimalReturns, episodes: usize) -> Self {
        let best = optimal.last(episodes);
        Self {
            episodes,
            begun: Instant::now(),
            optimal,
            lengths: Vec::new(),
            returns: Vec::new(),
            total: 0.0,
            before_last_goals: optimal.moved_after(episodes).unwrap_or(0),
            moved_at: 0,
            within_1_5x: Approach::to(best, 1.5),
            within_1_1x: Approach::to(best, 1.1),
            spectrum_refreshes: 0,
            gcn_fits: 0,
            gcn_epochs: 0,
            spectrum_seconds: 0.0,
            fit_seconds: 0.0,
        }
    }

    /// Counts a refresh.
    pub fn refreshed(&mut self, refresh: &RefreshRecord) {
        self.spectrum_refreshes += usize::from(refresh.spectrum.is_some());
        let fit = refresh.fit.as_ref().and_then(|fit| fit.fit.as_ref());
        self.gcn_fits += usize::from(fit.is_some());
        self.gcn_epochs += fit.map_or(0, |fit| fit.epochs);
        self.spectrum_seconds += refresh.spectrum_seconds;
        self.fit_seconds += refresh.fit_seconds;
    }

    /// Counts an episode.
    pub fn episode_ended(&mut self, record: &EpisodeRecord) {
        self.lengths
            .push(u32::try_from(record.length).unwrap_or(u32::MAX));
        self.returns.push(record.plain_return);
        self.total += record.plain_return;
        self.look(record.step);
    }

    /// Whether the episodes under the goals that the run ends with have come near the optimum.
    fn look(&mut self, step: u64) {
        if self.returns.len() <= self.before_last_goals {
            self.moved_at = step;
            return;
        }
        let returns = &self.returns[self.before_last_goals..];
        self.within_1_5x.look(returns, step - self.moved_at);
        self.within_1_1x.look(returns, step - self.moved_at);
    }

    /// Whether every episode was played.
    pub fn is_complete(&self) -> bool {
        self.lengths.len() >= self.episodes
    }

    /// Steps of each episode.
    pub fn lengths(&self) -> &[u32] {
        &self.lengths
    }

    /// ρ(T) = Σ R* − Σ R_t (eq. 15).
    pub fn regret(&self) -> f64 {
        self.optimal.expected_return(self.lengths.len()) - self.total
    }

    /// The best there is under the goals of the last episode.
    pub fn best(&self) -> Nearness {
        self.optimal.last(self.lengths.len())
    }

    /// Episodes before the goals moved, if they did.
    pub fn moved_after(&self) -> Option<usize> {
        self.optimal.moved_after(self.lengths.len())
    }

    /// Mean length of the last episodes, all of them under the last goals.
    pub fn final_steps(&self) -> f64 {
        final_mean_steps(self.optimal.since_move(&self.lengths))
    }

    /// Their mean return.
    pub fn final_return(&self) -> f64 {
        final_mean_return(self.optimal.since_move(&self.returns))
    }

    /// When the mean return was first within 1.5 times the optimum.
    pub fn within_1_5x(&self) -> Option<FirstWithin> {
        self.within_1_5x.first
    }

    /// When the mean return was first within 1.1 times the optimum.
    pub fn within_1_1x(&self) -> Option<FirstWithin> {
        self.within_1_1x.first
    }

    /// How often the eigenvectors were brought up to date.
    pub fn spectrum_refreshes(&self) -> usize {
        self.spectrum_refreshes
    }

    /// How often the potential's network was fitted.
    pub fn gcn_fits(&self) -> usize {
        self.gcn_fits
    }

    /// The epochs that it was trained for in them.
    pub fn gcn_epochs(&self) -> usize {
        self.gcn_epochs
    }

    /// Seconds since the beginning.
    fn wall_seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// Where the time went in which `steps` were taken.
    pub fn timing(&self, steps: u64) -> TrialTiming {
        let mut timing = TrialTiming {
            spectrum_seconds: self.spectrum_seconds,
            fit_seconds: self.fit_seconds,
            ..TrialTiming::default()
        };
        timing.finish(self.wall_seconds(), steps);
        timing
    }

    /// Lengths and regret by blocks of episodes.
    pub fn curve(&self) -> LearningCurve {
        let mut curve = LearningCurve::default();
        let mut total = 0.0;
        for block in blocks(self.lengths.len(), BLOCKS) {
            let lengths = self.lengths[block.clone()].iter();
            let steps: u64 = lengths.map(|&length| u64::from(length)).sum();
            total = self.returns[block.clone()]
                .iter()
                .fold(total, |total, earned| total + earned);
            let best = self.optimal.expected_return(block.end);
            curve.episodes.push(block.end);
            curve.length.push(steps as f64 / block.len() as f64);
            curve.regret.push(best - total);
        }
        curve
    }
}

/// The beginning of something, written down as the seconds since then.
mod elapsed {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::time::{Duration, Instant};

    pub fn serialize<S: Serializer>(begun: &Instant, serializer: S) -> Result<S::Ok, S::Error> {
        begun.elapsed().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Instant, D::Error> {
        let elapsed = Duration::deserialize(deserializer)?;
        let now = Instant::now();
        Ok(now.checked_sub(elapsed).unwrap_or(now))
    }
}

/// Watch for the trailing mean of returns to come near the optimum.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Approach {
    best: Nearness,
    times: f64,
    first: Option<FirstWithin>,
}

impl Approach {
    /// To within `times` times the optimum.
    fn to(best: Nearness, times: f64) -> Self {
        Self {
            best,
            times,
            first: None,
        }
    }

    fn look(&mut self, returns: &[f64], step: u64) {
        let Some(from) = returns.len().checked_sub(WINDOW) else {
            return;
        };
        if self.first.is_none() && self.best.holds(&returns[from..], self.times) {
            self.first = Some(FirstWithin {
                episodes: returns.len() as u64,
                steps: step,
            });
        }
    }
}

/// Mean of the last tenth of `steps`, at least 20 of them (all, if there are fewer); 0 for none.
fn final_mean_steps(steps: &[u32]) -> f64 {
    let last = last_tenth(steps);
    let sum: u64 = last.iter().map(|&s| u64::from(s)).sum();
    sum as f64 / last.len().max(1) as f64
}

/// The same of the episodes' returns.
fn final_mean_return(returns: &[f64]) -> f64 {
    let last = last_tenth(returns);
    last.iter().sum::<f64>() / last.len().max(1) as f64
}

/// Of something that was noted for each episode, the last tenth, at least 20.
fn last_tenth<T>(noted: &[T]) -> &[T] {
    let window = (noted.len() / 10).max(20).min(noted.len());
    &noted[noted.len() - window..]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Optimum;

    #[test]
    fn nearness_needs_a_full_window_at_the_limit() {
        let optimum = Optimum {
            expected_return: -8.0,
            expected_steps: 8.0,
        };
        let mut approach = Approach::to(Nearness::new(optimum, (-1.0, -1.0)), 1.1);
        let mut returns = vec![-8.0; 19];
        approach.look(&returns, 152);
        assert_eq!(approach.first, None);
        returns[0] = -8.0 - 17.0; // the sum of 20 is then −177, one too many
        returns.push(-8.0);
        approach.look(&returns, 177);
        assert_eq!(approach.first, None);
        returns[0] += 1.0;
        approach.look(&returns, 176);
        returns.push(-1000.0);
        approach.look(&returns, 1176);
        let first = approach.first.unwrap();
        assert_eq!((first.episodes, first.steps), (20, 176));
    }

    #[test]
    fn final_mean_takes_the_last_tenth_but_at_least_twenty() {
        let steps: Vec<u32> = (0..1000).collect();
        assert_eq!(
            final_mean_steps(&steps),
            (900..1000).sum::<u32>() as f64 / 100.0
        );
        assert_eq!(
            final_mean_steps(&steps[..30]),
            (10..30).sum::<u32>() as f64 / 20.0
        );
        assert_eq!(final_mean_steps(&[4, 6]), 5.0);
        assert_eq!(final_mean_steps(&[]), 0.0);
        let returns: Vec<f64> = steps.iter().map(|&s| -f64::from(s)).collect();
        for n in [1000, 30, 2, 1] {
            assert_eq!(
                final_mean_return(&returns[..n]),
                -final_mean_steps(&steps[..n])
            );
        }
        assert_eq!(final_mean_return(&[]), 0.0);
    }
}
