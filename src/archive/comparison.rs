//! Results of a comparison: arms side by side over the same seeds.

use crate::statistics::Verdict;
use serde::{Deserialize, Serialize};

/// Moment when returns had come near the optimum, counted from the last move of the goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FirstWithin {
    /// Episodes run until then.
    pub episodes: u64,
    /// Environment steps taken until then.
    pub steps: u64,
}

/// Results of one seed of one arm. Equal runs have equal results, bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialResult {
    /// Master seed.
    pub seed: u64,
    /// Episodes run.
    pub episodes: usize,
    /// Environment steps taken.
    pub steps: u64,
    /// ρ(T) = T R* − Σ R_t in units of reward (eq. 15 of the source paper).
    pub regret: f64,
    /// Mean length of an episode under the best policy.
    pub optimal_steps: f64,
    /// Mean length of the last tenth of the episodes, at least 20 of them.
    pub final_mean_steps: f64,
    /// Mean return of an episode under the best policy, R*.
    pub optimal_return: f64,
    /// Mean return of the episodes of `final_mean_steps`, R̄.
    pub final_return: f64,
    /// 1 + (R* − R̄) / |R*|, with the largest |reward| of the world in place of |R*| where R* = 0: 1 is the best, and where
    /// every step costs the same this is `final_mean_steps` ÷ `optimal_steps`.
    pub final_ratio: f64,
    /// Expected return of an episode of the final greedy policy under the step limit, exactly, with the advice of φ; none if
    /// the agent prefers no action anywhere.
    #[serde(default)]
    pub greedy_return: Option<f64>,
    /// The same without any advice: of what was learnt alone.
    #[serde(default)]
    pub greedy_return_unadvised: Option<f64>,
    /// Whether `greedy_return` is below R* − 0.05 |R*|, with the largest |reward| in place of |R*| where R* = 0.
    #[serde(default)]
    pub failed: Option<bool>,
    /// Whether `greedy_return_unadvised` is.
    #[serde(default)]
    pub failed_unadvised: Option<bool>,
    /// Episodes before the goals moved, if they did: what is optimal, what is final and the approach to the optimum are
    /// then of the episodes since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goals_moved_after: Option<usize>,
    /// The environment step, from 1, that first reached a goal; none if none did.
    pub first_goal_step: Option<u64>,
    /// When the mean return of the last 20 episodes was first within 1.5 times the optimum, at least R* − 0.5 |R*|, with
    /// the largest |reward| in place of |R*| where R* = 0; none if never.
    pub within_1_5x: Option<FirstWithin>,
    /// The same for 1.1 times, R* − 0.1 |R*|.
    pub within_1_1x: Option<FirstWithin>,
    /// States discovered.
    pub nodes: usize,
    /// Undirected edges discovered.
    pub edges: usize,
    /// How often the eigenvectors were brought up to date.
    pub spectrum_refreshes: usize,
    /// How often the potential's network was fitted.
    pub gcn_fits: usize,
    /// Epochs that it was trained for in all fits together.
    #[serde(default)]
    pub gcn_epochs: usize,
    /// States where φ at the end of the run would hold up an agent that climbs it; none without a potential.
    pub spurious_maxima: Option<usize>,
}

impl TrialResult {
    /// Regret ÷ regret of `base`; none where `base` has none, or so little that the ratio is no number.
    pub fn regret_ratio(&self, base: &Self) -> Option<f64> {
        let ratio = self.regret / base.regret;
        (base.regret > 0.0 && ratio.is_finite()).then_some(ratio)
    }
}

/// Time that one seed of one arm took, by what took it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrialTiming {
    /// Seconds of all episodes.
    pub wall_seconds: f64,
    /// Seconds in the eigensolver.
    pub spectrum_seconds: f64,
    /// Seconds in fits of the potential.
    pub fit_seconds: f64,
    /// Seconds in everything else: environment, graph, exploration, learner.
    pub rest_seconds: f64,
    /// Environment steps ÷ `wall_seconds`.
    pub steps_per_second: f64,
}

impl TrialTiming {
    /// Fills in what follows from the whole: `steps` took `wall_seconds`.
    pub fn finish(&mut self, wall_seconds: f64, steps: u64) {
        self.wall_seconds = wall_seconds;
        self.rest_seconds = wall_seconds - self.spectrum_seconds - self.fit_seconds;
        self.steps_per_second = steps as f64 / wall_seconds.max(1e-9);
    }
}

/// Lengths and regret of one seed of one arm, in blocks of episodes ([`blocks`](crate::statistics::blocks)).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearningCurve {
    /// Number of the last episode of each block, from 1.
    pub episodes: Vec<usize>,
    /// Mean steps of its episodes.
    pub length: Vec<f64>,
    /// ρ of the run (eq. 15) up to its end, in units of reward.
    pub regret: Vec<f64>,
}

/// Interquartile mean and its 95 % bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct IqmInterval {
    /// Interquartile mean over seeds.
    pub iqm: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Median and its exact 95 % interval between two of the values; of fewer than 6 between all of them, which is less sure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MedianInterval {
    /// Median over seeds; none if it is not defined.
    pub median: Option<f64>,
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// Difference of the regrets of two arms, seed by seed, in shares of the median regret of the second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmDifference {
    /// The first arm.
    pub arm: String,
    /// The second.
    pub against: String,
    /// (ρ − ρ of the second) ÷ its median, over seeds; the interval allows for the number of differences.
    #[serde(flatten)]
    pub share: MedianInterval,
    /// How sure the interval is.
    pub confidence: f64,
    /// What it shows.
    pub verdict: Verdict,
}

/// Probability and its 95 % bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbabilityInterval {
    /// The probability.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Median of moments that may never come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Median over seeds; none if half of them or more never get there.
    pub median: Option<f64>,
    /// How many seeds get there.
    pub reached: usize,
}

/// Results of one arm over all seeds. Apart from the name and the numbers of `compare --json` there is more here than the format
/// asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmSummary {
    /// Its name.
    pub name: String,
    /// Regret in units of reward (eq. 15).
    pub regret: IqmInterval,
    /// Regret ÷ regret of the sparse arm with the same seed and the same step sizes.
    pub ratio_to_sparse: MedianInterval,
    /// The same against the sparse arm with step sizes tuned for this world; only if that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio_to_tuned_sparse: Option<MedianInterval>,
    /// Chance that a run of this arm has less regret than a run of the sparse one.
    pub probability_of_improvement: ProbabilityInterval,
    /// Environment steps until a goal was reached first.
    pub first_goal_step: Moments,
    /// Episodes until the mean return of 20 was within 1.5 times the optimum ([`TrialResult::within_1_5x`]).
    pub episodes_to_1_5x: Moments,
    /// Environment steps until then.
    pub steps_to_1_5x: Moments,
    /// Episodes until it was within 1.1 times the optimum.
    pub episodes_to_1_1x: Moments,
    /// Environment steps until then.
    pub steps_to_1_1x: Moments,
    /// Mean return of the last tenth of the episodes, at least 20 of them.
    pub final_return: MedianInterval,
    /// How far that is from the best, 1 ([`TrialResult::final_ratio`]): median over seeds.
    pub final_ratio: f64,
    /// Exact return of the final greedy policy, with the advice of φ; none if it prefers nothing.
    pub greedy_return: MedianInterval,
    /// The same without any advice.
    pub greedy_return_unadvised: MedianInterval,
    /// Share of seeds whose greedy policy falls short of the optimum by more than a twentieth ([`TrialResult::failed`]).
    pub failures: Option<f64>,
    /// The same without any advice.
    pub failures_unadvised: Option<f64>,
    /// The seed with the most regret.
    pub worst_seed: u64,
    /// Median of the epochs that the network was trained for in a run.
    pub gcn_epochs: f64,
    /// Largest number of false maxima of φ at the end of a run; none without a potential.
    pub spurious_maxima: Option<usize>,
}

/// Step sizes tried for the sparse arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TuningEntry {
    /// Step size of the critic.
    pub critic_learning_rate: f64,
    /// Step size of the actor.
    pub actor_learning_rate: f64,
    /// Interquartile mean of the regret over the tuning seeds.
    pub regret_iqm: f64,
}

/// Tuning of the sparse arm for the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Seeds used for it; none of them is a seed of the comparison.
    pub seeds: Vec<u64>,
    /// Everything that was tried.
    pub tried: Vec<TuningEntry>,
    /// What had the least regret, and is compared with.
    pub chosen: TuningEntry,
    /// Its regret over the seeds of the comparison.
    pub regret: IqmInterval,
}

/// Medians over seeds of where an arm's time went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ArmTiming {
    /// The arm.
    pub name: String,
    /// Medians over seeds.
    #[serde(flatten)]
    pub median: TrialTiming,
}

/// Contents of `compare.json`: everything but `timing` is the same for equal runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Name of the scenario.
    pub scenario: String,
    /// Seeds, as asked for.
    pub seeds: Vec<u64>,
    /// Arms, as asked for.
    pub arms: Vec<ArmSummary>,
    /// Episodes of each run.
    pub episodes: usize,
    /// Mean length of an episode under the best policy, over the seeds.
    pub optimal_steps: f64,
    /// Mean return of such an episode, R*, over the seeds.
    pub optimal_return: f64,
    /// Episodes before the goals moved, if they did: what is optimal, the steps and episodes to 1.5 and 1.1 times the
    /// optimum, and what is final are of the episodes since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goals_moved_after: Option<usize>,
    /// Regret of the sparse arm that the ratios refer to, whether it was asked for or not.
    pub sparse_regret: IqmInterval,
    /// The other arms against the default one (against the first one, if that is not there); none with a single arm.
    #[serde(default)]
    pub differences: Vec<ArmDifference>,
    /// How the sparse arm was tuned, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tuning: Option<Tuning>,
    /// What the clock said, by arm.
    pub timing: Vec<ArmTiming>,
}

impl Comparison {
    /// The difference of the arm `name` to the one that all are shown against; none of that arm itself.
    pub fn difference(&self, name: &str) -> Option<&ArmDifference> {
        self.differences.iter().find(|found| found.arm == name)
    }
}
