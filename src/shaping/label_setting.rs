//! The order in which soft values settle: label setting on a decision process.
//!
//! ```text
//! V_i ← τ_i ln Σ_c w_c e^{Q(i, c) / τ_i}        over the choices c that lead to states with final labels
//! ```
//!
//! Dijkstra's algorithm for the soft Bellman equation: of all labels the best is made final, and the states that may lead to it take it in. Where a
//! choice has one outcome this is the fast marching of Tsitsiklis (1995) with a soft maximum in the place of the least. It leaves out what
//! the choices that lead away from the ends add to a value, so the labels are only near V; but a sweep in their order carries news as the walk of
//! the solution carries it. By the number of steps to an end, the order of [`DecisionProcess::new`], it would not: where temperatures differ from place to place
//! the softly best way is not the shortest one. On 140 000 states with τ between 0.4 and 1.8 steps a solve took 24 Newton steps and 180 sweeps in that order, 7 and 95
//! in this one.

use super::decision_process::DecisionProcess;
use crate::exponential::exp;
use std::collections::BinaryHeap;

/// A soft maximum that choices join one by one: τ ln total is what it lies above `best`.
#[derive(Clone, Copy)]
struct SoftMaximum {
    best: f64,
    total: f64,
}

impl SoftMaximum {
    const NOTHING: Self = Self {
        best: f64::NEG_INFINITY,
        total: 0.0,
    };

    fn add(&mut self, worth: f64, weight: f64, tau: f64) {
        let share = |difference: f64| match tau > 0.0 {
            true => exp(difference / tau),
            false => 0.0,
        };
        if worth <= self.best {
            self.total += weight * share(worth - self.best);
        } else {
            let before = if self.total > 0.0 {
                self.total * share(self.best - worth)
            } else {
                0.0
            };
            *self = Self {
                best: worth,
                total: before + weight,
            };
        }
    }

    fn value(&self, tau: f64) -> f64 {
        match tau > 0.0 {
            true => self.best + tau * libm::log(self.total),
            false => self.best,
        }
    }
}

/// A label that may be final, ordered by its value; the nearer position settles ties.
struct Entry {
    label: f64,
    position: u32,
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_position = other.position.cmp(&self.position);
        self.label.total_cmp(&other.label).then(by_position)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

/// Labels under way. By choice: what its outcomes with final labels are worth with its reward (−∞ without any), and the chance of the others.
struct Labels<'a> {
    process: &'a DecisionProcess,
    tau: &'a [f64],
    worth: Vec<f64>,
    pending: Vec<f64>,
    num_outcomes: Vec<u32>,
    maxima: Vec<SoftMaximum>,
    is_final: Vec<bool>,
    heap: BinaryHeap<Entry>,
}

/// Positions of `process` in the order in which their labels at temperatures `tau` become final, the best first; those that lead to no end follow
/// in their old order. O((n + outcomes) log n).
///
/// # Panics
/// If `tau` has not one entry per position.
pub(super) fn settling_order(process: &DecisionProcess, tau: &[f64]) -> Vec<u32> {
    assert_eq!(tau.len(), process.len(), "one temperature per position");
    let (offsets, sources) = process.predecessors();
    let mut labels = Labels::new(process, tau);
    let mut order = Vec::with_capacity(process.len());
    let mut waiting = 0..process.num_reached();
    loop {
        // Where all choices may lead to something without a label, as beside an end where moves slip, the nearest begins.
        let next = labels.best();
        let next = next.or_else(|| {
            waiting
                .find(|&p| !labels.is_final[p])
                .map(|p| (p, process.worth_for_ever(p)))
        });
        let Some((position, label)) = next else { break };
        labels.is_final[position] = true;
        order.push(position as u32);
        for &(source, entry) in &sources[offsets[position]..offsets[position + 1]] {
            if !labels.is_final[source as usize] {
                labels.take_in(source as usize, entry as usize, label);
            }
        }
    }
    order.extend(process.num_reached() as u32..process.len() as u32);
    order
}

impl<'a> Labels<'a> {
    /// With labels where a choice has no outcome but the end.
    fn new(process: &'a DecisionProcess, tau: &'a [f64]) -> Self {
        let mut labels = Self {
            process,
            tau,
            worth: vec![f64::NEG_INFINITY; process.num_choices()],
            pending: vec![0.0; process.num_choices()],
            num_outcomes: vec![0; process.num_choices()],
            maxima: vec![SoftMaximum::NOTHING; process.len()],
            is_final: vec![false; process.len()],
            heap: BinaryHeap::new(),
        };
        for (&choice, probability) in process.owners().iter().zip(process.probabilities()) {
            labels.pending[choice as usize] += probability;
            labels.num_outcomes[choice as usize] += 1;
        }
        for position in 0..process.num_reached() {
            for choice in process.choices_of(position) {
                if labels.num_outcomes[choice] == 0 {
                    labels.worth[choice] = process.reward(choice);
                    labels.join(position, choice);
                }
            }
            labels.offer(position);
        }
        labels
    }

    fn join(&mut self, position: usize, choice: usize) {
        let (worth, weight) = (self.worth[choice], self.process.prior(choice));
        self.maxima[position].add(worth, weight, self.tau[position]);
    }

    fn offer(&mut self, position: usize) {
        let label = self.maxima[position].value(self.tau[position]);
        if label > f64::NEG_INFINITY {
            let position = position as u32;
            self.heap.push(Entry { label, position });
        }
    }

    /// The position with the best label of those that are not final, and the label.
    fn best(&mut self) -> Option<(usize, f64)> {
        while let Some(Entry { label, position }) = self.heap.pop() {
            let position = position as usize;
            if self.is_final[position] {
                continue;
            }
            let now = self.maxima[position].value(self.tau[position]);
            if now >= label {
                return Some((position, now));
            }
            self.offer(position); // a further outcome was worse than the first one
        }
        None
    }

    /// The outcome `entry` of a choice of `position` has got its final label.
    fn take_in(&mut self, position: usize, entry: usize, label: f64) {
        let process = self.process;
        let choice = process.owners()[entry] as usize;
        let probability = process.probabilities()[entry];
        let known = match self.worth[choice] {
            f64::NEG_INFINITY => process.reward(choice),
            worth => worth,
        };
        self.worth[choice] = known + probability * label;
        self.pending[choice] -= probability;
        let choices = process.choices_of(position);
        if choices.clone().all(|c| self.num_outcomes[c] <= 1) {
            self.join(position, choice);
        } else {
            // Outcomes that have no label yet are taken for as good as the last one that got one.
            let mut maximum = SoftMaximum::NOTHING;
            for c in choices.filter(|&c| self.worth[c] > f64::NEG_INFINITY) {
                let worth = self.worth[c] + self.pending[c] * label;
                maximum.add(worth, process.prior(c), self.tau[position]);
            }
            self.maxima[position] = maximum;
        }
        self.offer(position);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{Alternative, process};
    use crate::shaping::soft_bellman::SoftBellman;

    /// A ring of 2 · `arm` states around an end at 0: the cold half of it is worth more than the warm one.
    fn ring(arm: u32) -> DecisionProcess {
        let last = 2 * arm;
        let mut states = vec![vec![]];
        for i in 1..=last {
            let nearer = if i <= arm {
                i - 1
            } else {
                (i + 1) % (last + 1)
            };
            let farther = if i <= arm { i + 1 } else { i - 1 };
            let step = |to: u32| match to {
                0 => Alternative::new(-1.0, true, &[]),
                _ => Alternative::new(-1.0, false, &[(to, 1.0)]),
            };
            states.push(vec![step(nearer), step(farther)]);
        }
        process(&states, 1.0)
    }

    #[test]
    fn labels_settle_from_the_best_value_to_the_worst() {
        let process = ring(30);
        let warmth = |state: u32| if state <= 30 { 0.1 } else { 0.6 };
        let tau: Vec<f64> = process.order().iter().map(|&s| warmth(s)).collect();
        let order = settling_order(&process, &tau);
        let (v, statistics) = SoftBellman::new(&process).solve_cold(&tau, 1e-9);
        assert!(statistics.converged);
        let settled: Vec<f64> = order.iter().map(|&p| v[p as usize]).collect();
        // But for where the two arms meet the order is that of the values.
        let inversions = |values: &[f64]| values.windows(2).filter(|w| w[1] > w[0]).count();
        assert!(inversions(&settled) <= 2, "{settled:?}");
        assert!(inversions(&v) > 20, "by hops the arms take turns");
        // In this order, fewer sweeps lead to the same values.
        let rearranged = process.rearranged(&order);
        let tau: Vec<f64> = rearranged.order().iter().map(|&s| warmth(s)).collect();
        let (again, sooner) = SoftBellman::new(&rearranged).solve_cold(&tau, 1e-9);
        assert!(
            sooner.converged && sooner.sweeps < statistics.sweeps,
            "{sooner:?} {statistics:?}"
        );
        let (v, again) = (process.scatter(&v), rearranged.scatter(&again));
        assert!(v.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-7));
    }

    #[test]
    fn every_position_settles_once_whatever_the_chances() {
        // 1 reaches the end by good luck only, 2 and 3 lead to it, 4 leads nowhere.
        let states = [
            vec![],
            vec![Alternative::new(-1.0, true, &[(2, 0.7)])],
            vec![Alternative::new(-1.0, false, &[(1, 0.5), (3, 0.5)])],
            vec![
                Alternative::new(-1.0, false, &[(1, 0.2), (2, 0.3), (3, 0.5)]),
                Alternative::new(-2.0, false, &[(2, 1.0)]),
            ],
            vec![Alternative::new(-1.0, false, &[(4, 0.9)])],
        ];
        let process = process(&states, 1.0);
        for temperature in [0.0, 0.7] {
            let order = settling_order(&process, &vec![temperature; process.len()]);
            let by_state: Vec<u32> = order.iter().map(|&p| process.order()[p as usize]).collect();
            assert_eq!(by_state, [1, 2, 3, 4], "{temperature}");
        }
    }
}
