//! Proof that Ritz pairs are the lowest eigenpairs, none missed.
//!
//! Small residuals show that pairs are eigenpairs, not that they are the lowest. Two bounds together do:
//!
//! - *At least* m eigenvalues lie where the pairs say. Let the orthonormal columns Q of a cluster of c Ritz
//!   pairs have residuals R = LQ − QΘ. Then c eigenvalues of L, counted with multiplicity, lie within ‖R‖₂ of
//!   Θ, paired in order (Kahan 1967; Parlett, theorem 11.5.1). Clusters whose intervals do not meet cannot
//!   mean the same eigenvalue, while single pairs with overlapping intervals can: those are joined.
//! - *At most* m lie there. By Sylvester's law L − μI has as many negative pivots as L has eigenvalues below
//!   μ; rounding in C S Cᵀ moves eigenvalues by at most e, so that no more than that many lie below μ − e.
//!
//! If the intervals of the m lowest pairs end below μ − e and the count at μ is m, nothing else lies there.
//! No Ritz value that has not settled is relied upon: an unsettled guard below μ may stand for a missed
//! eigenvalue, and the count cannot tell.

use super::assess::{Assessment, value_error};
use super::subspace::Outcome;
use crate::cholesky::Inertia;
use std::ops::Range;

/// The widest offset of μ above a Ritz value, relative to it.
const OFFSET: f64 = 0.05;

/// Loss of orthogonality up to which the theorem on residuals holds but for a rounding of its bound.
pub(crate) const ORTHOGONAL: f64 = 1e-8;

/// Ritz pairs with what their bounds depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evidence<'a> {
    /// Ascending; infinite for columns that hold nothing.
    values: &'a [f64],
    residuals: &'a [f64],
    /// Bound on the rounding error of a residual norm.
    rounding: f64,
    /// Largest residual of a pair that counts as settled, and largest error that its value may have.
    allowed: f64,
}

/// An interval that holds as many eigenvalues as it has pairs.
#[derive(Clone, Debug, PartialEq)]
struct Cluster {
    pairs: Range<usize>,
    /// Σ of squared residuals: ‖R‖_F².
    squares: f64,
}

impl Cluster {
    fn radius(&self, rounding: f64) -> f64 {
        (1.0 + ORTHOGONAL) * (self.squares.sqrt() + rounding * (self.pairs.len() as f64).sqrt())
    }
}

impl<'a> Evidence<'a> {
    /// The pairs of `outcome`. `rounding` bounds the rounding error of a residual norm; a pair has settled
    /// when its residual is at most `tol` · λ_k, or as small as rounding lets it be.
    pub(crate) fn new(outcome: &'a Outcome, tol: f64, rounding: f64) -> Self {
        Self {
            values: &outcome.values,
            residuals: &outcome.residuals,
            rounding,
            allowed: (tol * outcome.assessment.unit).max(2.0 * rounding),
        }
    }

    /// Where to count: in the first gap behind the wanted pairs, as far as settled pairs reach; without
    /// one a little above λ_k, which tells how many more belong to its cluster. `None` if a wanted pair
    /// has not settled.
    pub(crate) fn place(&self, wanted: usize, assessment: &Assessment) -> Option<f64> {
        let settled = self.settled();
        if settled < wanted {
            return None;
        }
        let gap_behind = |count: usize| {
            let top = self.clusters(count).last().map(|c| self.high(c))?;
            let (&next, &residual) = self.values.get(count).zip(self.residuals.get(count))?;
            let next = next - value_error(next, residual, assessment.eta);
            let offset = (0.5 * (next - top)).min(OFFSET * top.abs());
            (offset > 4.0 * self.rounding).then_some(top + offset)
        };
        let last = self.clusters(wanted).pop()?;
        (wanted..=settled)
            .find_map(gap_behind)
            .or_else(|| Some(self.high(&last) + OFFSET * self.values[wanted - 1].abs()))
    }

    /// Whether `count`, of which `nulls` are null vectors known apart, proves that the `wanted` lowest
    /// pairs are the lowest eigenpairs, each value within what is allowed.
    pub(crate) fn is_complete(&self, wanted: usize, nulls: usize, count: &Inertia) -> bool {
        let Some(below) = count.negative.checked_sub(nulls) else {
            return false;
        };
        if below < wanted || below > self.settled() {
            return false;
        }
        // By Cauchy's interlacing every Ritz value has an eigenvalue below it: one more would be another.
        if self.values.get(below).is_some_and(|&v| v < count.certain) {
            return false;
        }
        let clusters = self.clusters(below);
        let ends_below = clusters
            .last()
            .is_some_and(|c| self.high(c) < count.certain);
        ends_below
            && (0..clusters.len())
                .take_while(|&c| clusters[c].pairs.start < wanted)
                .all(|c| self.error(&clusters, c, count.certain) <= self.allowed)
    }

    /// Ritz values below `mu`.
    pub(crate) fn known_below(&self, mu: f64) -> usize {
        self.values.partition_point(|&v| v < mu)
    }

    /// Leading pairs that have settled.
    fn settled(&self) -> usize {
        self.residuals
            .iter()
            .take_while(|&&r| r <= self.allowed)
            .count()
    }

    /// The first `count` pairs in clusters whose intervals do not meet.
    fn clusters(&self, count: usize) -> Vec<Cluster> {
        let mut clusters: Vec<Cluster> = Vec::new();
        for j in 0..count {
            let mut cluster = Cluster {
                pairs: j..j + 1,
                squares: self.residuals[j] * self.residuals[j],
            };
            while let Some(before) = clusters.pop_if(|c| self.high(c) >= self.low(&cluster)) {
                cluster.pairs.start = before.pairs.start;
                cluster.squares += before.squares;
            }
            clusters.push(cluster);
        }
        clusters
    }

    fn low(&self, cluster: &Cluster) -> f64 {
        self.values[cluster.pairs.start] - cluster.radius(self.rounding)
    }

    fn high(&self, cluster: &Cluster) -> f64 {
        self.values[cluster.pairs.end - 1] + cluster.radius(self.rounding)
    }

    /// Bound on the error of the values of a cluster: its radius ρ, or ρ² / (gap − ρ) with the gap to
    /// what lies outside (Mathias 1998); nothing else lies below `certain`.
    fn error(&self, clusters: &[Cluster], c: usize, certain: f64) -> f64 {
        let cluster = &clusters[c];
        let radius = cluster.radius(self.rounding);
        let below = c
            .checked_sub(1)
            .map_or(0.0, |before| self.high(&clusters[before]));
        let above = clusters.get(c + 1).map_or(certain, |after| self.low(after));
        let gap = (self.values[cluster.pairs.start] - below)
            .min(above - self.values[cluster.pairs.end - 1]);
        if gap > radius {
            radius.min(radius * radius / (gap - radius))
        } else {
            radius
        }
    }
}

#[cfg(test)]
mod searched;

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence<'a>(values: &'a [f64], residuals: &'a [f64]) -> Evidence<'a> {
        Evidence {
            values,
            residuals,
            rounding: 1e-15,
            allowed: 1e-3,
        }
    }

    fn assessment(eta: f64) -> Assessment {
        Assessment {
            converged: 0,
            excess: 0.0,
            unit: 1.0,
            eta,
            cut: eta,
            cluster_cut: false,
        }
    }

    fn count(negative: usize, certain: f64) -> Inertia {
        Inertia { negative, certain }
    }

    #[test]
    fn the_count_is_taken_behind_the_cluster_that_k_cuts() {
        let values = [0.1, 0.2, 0.2, 0.5, 0.9];
        let residuals = [1e-9; 5];
        let evidence = evidence(&values, &residuals);
        let mu = evidence.place(2, &assessment(0.9)).unwrap();
        assert!(mu > 0.2 && mu < 0.22);
        assert!(evidence.is_complete(2, 1, &count(4, mu)));
        assert!(!evidence.is_complete(2, 1, &count(5, mu)), "one is missing");
        assert!(!evidence.is_complete(2, 1, &count(3, mu)), "rounding");
    }

    #[test]
    fn a_guard_that_has_not_settled_stands_for_nothing() {
        // Four eigenvalues below .4, say .1, .2, .3 and .35, of which the block lacks .35: its last guard
        // happens to lie at .38.
        let values = [0.1, 0.2, 0.3, 0.38];
        let unsettled = [1e-9, 1e-9, 1e-9, 0.2];
        let evidence = evidence(&values, &unsettled);
        assert!(!evidence.is_complete(3, 0, &count(4, 0.4)));
        assert!(!evidence.is_complete(3, 0, &count(3, 0.4)));
        assert!(evidence.is_complete(3, 0, &count(3, 0.32)));
    }

    #[test]
    fn overlapping_intervals_do_not_count_one_eigenvalue_twice() {
        // Alone, each pair has an eigenvalue within 8e-4; both may mean the same one. Together two lie
        // within 8e-4 · √2.
        let values = [0.1, 0.1001, 0.5];
        let residuals = [8e-4, 8e-4, 1e-9];
        let evidence = evidence(&values, &residuals);
        let clusters = evidence.clusters(3);
        assert_eq!(clusters.len(), 2);
        assert_eq!(clusters[0].pairs, 0..2);
        let radius = clusters[0].radius(0.0);
        assert!((radius - 8e-4 * 2.0f64.sqrt()).abs() < 1e-9);
        assert!(evidence.is_complete(2, 0, &count(2, 0.3)));
        let close = 0.1001 + 1e-3;
        assert!(
            !evidence.is_complete(2, 0, &count(2, close)),
            "it reaches beyond"
        );
    }

    #[test]
    fn pairs_that_have_not_settled_cannot_be_certified() {
        let values = [0.1, 0.2, 0.9];
        assert_eq!(
            evidence(&values, &[1e-9, 0.01, 1e-9]).place(2, &assessment(0.9)),
            None
        );
        let nan = [1e-9, f64::NAN, 1e-9];
        assert_eq!(evidence(&values, &nan).place(2, &assessment(0.9)), None);
        assert!(!evidence(&values, &nan).is_complete(2, 0, &count(2, 0.5)));
    }
}
