//! From the trials of a comparison to its numbers.

use crate::archive::{
    ArmDifference, ArmSummary, ArmTiming, IqmInterval, MedianInterval, Moments,
    ProbabilityInterval, TrialRecord, TrialResult, TrialTiming, TrialsByArm,
};
use crate::statistics::{
    Bootstrap, Interval, MedianBetween, PairedDifference, interquartile_mean, median,
    probability_of_improvement,
};

/// The chance that an interval holds what it is the interval of.
const CONFIDENCE: f64 = 0.95;

/// The summary of an arm against the sparse arm, and against a tuned one if there is one. All are over the same
/// seeds in the same order; `trials` must not be empty.
pub fn summarise(
    name: &str,
    trials: &[TrialRecord],
    sparse: &[TrialRecord],
    tuned: Option<&[TrialRecord]>,
) -> ArmSummary {
    let moments = |part: &dyn Fn(&TrialRecord) -> Option<u64>| {
        let reached: Vec<Option<u64>> = trials.iter().map(part).collect();
        median_moment(&reached)
    };
    let of_all = |part: fn(&TrialResult) -> f64| -> Vec<f64> {
        trials.iter().map(|t| part(&t.result)).collect()
    };
    let of_some = |part: fn(&TrialResult) -> Option<f64>| -> Vec<f64> {
        trials.iter().filter_map(|t| part(&t.result)).collect()
    };
    ArmSummary {
        name: name.to_owned(),
        regret: regret_interval(trials),
        ratio_to_sparse: ratio_interval(trials, sparse),
        ratio_to_tuned_sparse: tuned.map(|tuned| ratio_interval(trials, tuned)),
        probability_of_improvement: improvement(trials, sparse),
        first_goal_step: moments(&|t| t.result.first_goal_step),
        episodes_to_1_5x: moments(&|t| t.result.within_1_5x.map(|a| a.episodes)),
        steps_to_1_5x: moments(&|t| t.result.within_1_5x.map(|a| a.steps)),
        episodes_to_1_1x: moments(&|t| t.result.within_1_1x.map(|a| a.episodes)),
        steps_to_1_1x: moments(&|t| t.result.within_1_1x.map(|a| a.steps)),
        final_return: median_interval(&of_all(|result| result.final_return)),
        final_ratio: median(&of_all(|result| result.final_ratio)),
        greedy_return: median_interval(&of_some(|result| result.greedy_return)),
        greedy_return_unadvised: median_interval(&of_some(|result| result.greedy_return_unadvised)),
        failures: share(trials, |result| result.failed),
        failures_unadvised: share(trials, |result| result.failed_unadvised),
        worst_seed: worst_seed(trials),
        gcn_epochs: median(&of_all(|result| result.gcn_epochs as f64)),
        spurious_maxima: trials.iter().filter_map(|t| t.result.spurious_maxima).max(),
    }
}

/// Mean over the trials, of which there must be one; where all have the same number it is that one to the last bit.
pub fn mean_over(trials: &[TrialRecord], part: fn(&TrialResult) -> f64) -> f64 {
    mean_from_first(trials.iter().map(|t| part(&t.result)))
}

/// x₀ + Σ (x − x₀) / n.
fn mean_from_first(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len() as f64;
    let first = values.clone().next().expect("a mean of something");
    first + values.map(|value| value - first).sum::<f64>() / count
}

/// Interquartile mean of the regret.
pub fn regret_interval(trials: &[TrialRecord]) -> IqmInterval {
    let Interval { value, low, high } =
        Bootstrap::default().interval(&regrets(trials), interquartile_mean);
    IqmInterval {
        iqm: value,
        low,
        high,
    }
}

/// Median of regret ÷ regret of `base` with the same seed; seeds where `base` has no regret do not count.
pub fn ratio_interval(trials: &[TrialRecord], base: &[TrialRecord]) -> MedianInterval {
    let pairs = trials.iter().zip(base);
    let ratios = pairs.filter_map(|(trial, base)| trial.result.regret_ratio(&base.result));
    median_interval(&ratios.collect::<Vec<_>>())
}

/// The median of what may be nothing.
pub fn median_interval(sample: &[f64]) -> MedianInterval {
    let between = MedianBetween::of(sample, CONFIDENCE);
    MedianInterval {
        median: between.map(|between| between.median),
        low: between.map(|between| between.low),
        high: between.map(|between| between.high),
    }
}

/// Share of the trials of which something is true; none if there is one of which it is not known.
pub fn share(trials: &[TrialRecord], is_true: fn(&TrialResult) -> Option<bool>) -> Option<f64> {
    let known: Option<Vec<bool>> = trials.iter().map(|trial| is_true(&trial.result)).collect();
    known.map(|known| known.iter().filter(|&&is| is).count() as f64 / known.len() as f64)
}

/// The first seed with the most regret.
pub fn worst_seed(trials: &[TrialRecord]) -> u64 {
    let worse =
        |worst: &'_ TrialRecord, trial: &'_ TrialRecord| trial.result.regret > worst.result.regret;
    let worst = trials
        .iter()
        .reduce(|worst, trial| if worse(worst, trial) { trial } else { worst });
    worst.expect("every arm has trials").result.seed
}

/// The regret of every other arm against that of `against`, seed by seed.
pub fn differences(against: &str, trials: &TrialsByArm) -> Vec<ArmDifference> {
    let theirs = trials.iter().find(|(name, _)| name == against);
    let Some((_, theirs)) = theirs else {
        return Vec::new();
    };
    let others: Vec<_> = trials.iter().filter(|(name, _)| name != against).collect();
    let difference = |(name, ours): &&(String, Vec<TrialRecord>)| {
        let paired = PairedDifference::of(&regrets(ours), &regrets(theirs), others.len())?;
        let between = paired.difference;
        Some(ArmDifference {
            arm: name.clone(),
            against: against.to_owned(),
            share: MedianInterval {
                median: Some(between.median),
                low: Some(between.low),
                high: Some(between.high),
            },
            confidence: between.confidence,
            verdict: paired.verdict,
        })
    };
    others.iter().filter_map(difference).collect()
}

/// The two arms are two strata.
fn improvement(trials: &[TrialRecord], sparse: &[TrialRecord]) -> ProbabilityInterval {
    let (ours, theirs) = (regrets(trials), regrets(sparse));
    let Interval { value, low, high } = Bootstrap::default().stratified(&[&ours, &theirs], |s| {
        probability_of_improvement(&s[0], &s[1])
    });
    ProbabilityInterval { value, low, high }
}

fn regrets(trials: &[TrialRecord]) -> Vec<f64> {
    trials.iter().map(|t| t.result.regret).collect()
}

/// Never is later than every moment.
pub fn median_moment(moments: &[Option<u64>]) -> Moments {
    let times: Vec<f64> = moments
        .iter()
        .map(|m| m.map_or(f64::INFINITY, |m| m as f64))
        .collect();
    Moments {
        median: Some(median(&times)).filter(|m| m.is_finite()),
        reached: moments.iter().flatten().count(),
    }
}

/// Medians of each part of the time.
pub fn timing(name: &str, trials: &[TrialRecord]) -> ArmTiming {
    let part = |part: fn(&TrialTiming) -> f64| {
        median(&trials.iter().map(|t| part(&t.timing)).collect::<Vec<_>>())
    };
    ArmTiming {
        name: name.to_owned(),
        median: TrialTiming {
            wall_seconds: part(|t| t.wall_seconds),
            spectrum_seconds: part(|t| t.spectrum_seconds),
            fit_seconds: part(|t| t.fit_seconds),
            rest_seconds: part(|t| t.rest_seconds),
            steps_per_second: part(|t| t.steps_per_second),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_numbers_have_themselves_as_their_mean() {
        let mean = |values: &[f64]| mean_from_first(values.iter().copied());
        let tenth = [0.1; 10];
        assert_ne!(tenth.iter().sum::<f64>(), 1.0);
        assert_eq!(mean(&tenth), 0.1);
        assert_eq!(mean(&[20.0, 26.0, 23.0, 11.0]), 20.0);
    }

    #[test]
    fn never_counts_as_latest() {
        assert_eq!(median_moment(&[Some(3), None, Some(5)]).median, Some(5.0));
        let mostly_never = median_moment(&[Some(3), None, None]);
        assert_eq!((mostly_never.median, mostly_never.reached), (None, 1));
        // Half of them: the middle two are a moment and never.
        assert_eq!(median_moment(&[Some(3), None]).median, None);
    }
}
