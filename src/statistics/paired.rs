//! Paired difference of two arms over the same seeds, with a verdict.
//!
//! ```text
//! d_i     = (x_i − y_i) ÷ median(y)                     of seed i, in shares of what the other arm needs
//! verdict = equivalent   if the interval of the median of d lies within ± margin
//!           less, more   if it lies below or above 0, and not within the margin
//!           open         otherwise: nothing is shown
//! ```
//!
//! Equivalence is two one-sided tests (Schuirmann 1987): that nothing was found is no sign that nothing is there, so it has to
//! be shown. m differences at a time have intervals of confidence 1 − α / m each (Bonferroni), so that all m verdicts hold
//! together with confidence 1 − α.

use super::order::MedianBetween;
use super::robust::median;
use serde::{Deserialize, Serialize};

/// Share of the other arm's median that counts as no difference.
pub const EQUIVALENCE_MARGIN: f64 = 0.1;

/// What a difference shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// No more than the margin lies between the two.
    Equivalent,
    /// The first has less.
    Less,
    /// The first has more.
    More,
    /// Too few seeds, or too different, to tell.
    Open,
}

/// A paired difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedDifference {
    /// Median of d and its interval.
    pub difference: MedianBetween,
    /// What it shows.
    pub verdict: Verdict,
}

impl PairedDifference {
    /// That of `ours` and `theirs`, of the same seeds in the same order, as one of `together` differences whose verdicts are to
    /// hold at a time with 95 %. None without seeds, or if the median of `theirs` is not above 0: there are no shares of it.
    ///
    /// # Panics
    /// If they are not as many, or `together` is 0.
    pub fn of(ours: &[f64], theirs: &[f64], together: usize) -> Option<Self> {
        assert_eq!(ours.len(), theirs.len(), "pairs");
        assert!(together > 0, "there is this one");
        let whole = median(theirs);
        if whole.is_nan() || whole <= 0.0 {
            return None;
        }
        let pairs = ours.iter().zip(theirs);
        let shares: Vec<f64> = pairs
            .map(|(ours, theirs)| (ours - theirs) / whole)
            .collect();
        let wanted = 1.0 - 0.05 / together as f64;
        let difference = MedianBetween::of(&shares, wanted)?;
        Some(Self {
            difference,
            verdict: verdict(&difference, wanted),
        })
    }
}

fn verdict(difference: &MedianBetween, wanted: f64) -> Verdict {
    let MedianBetween {
        low,
        high,
        confidence,
        ..
    } = *difference;
    if confidence < wanted {
        Verdict::Open
    } else if -EQUIVALENCE_MARGIN <= low && high <= EQUIVALENCE_MARGIN {
        Verdict::Equivalent
    } else if high < 0.0 {
        Verdict::Less
    } else if low > 0.0 {
        Verdict::More
    } else {
        Verdict::Open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn shown(ours: [f64; 8], together: usize) -> Option<Verdict> {
        let theirs = [8.0, 9.0, 10.0, 10.0, 10.0, 10.0, 11.0, 12.0];
        PairedDifference::of(&ours, &theirs, together).map(|paired| paired.verdict)
    }

    #[test]
    fn differences_are_shown_by_every_seed_or_not_at_all() {
        let theirs = [8.0, 9.0, 10.0, 10.0, 10.0, 10.0, 11.0, 12.0];
        assert_eq!(shown(theirs, 1), Some(Verdict::Equivalent));
        assert_eq!(shown(theirs.map(|y| y + 0.9), 1), Some(Verdict::Equivalent));
        assert_eq!(shown(theirs.map(|y| y + 1.1), 1), Some(Verdict::More));
        assert_eq!(shown(theirs.map(|y| y * 0.5), 1), Some(Verdict::Less));
        let mut mixed = theirs.map(|y| y * 0.5);
        mixed[0] = 20.0;
        assert_eq!(shown(mixed, 1), Some(Verdict::Open));
        // All of 8 are sure to 1 − 2⁻⁷ = .992, enough for 6 at a time and not for 7.
        let less = theirs.map(|y| y * 0.5);
        assert_eq!(shown(less, 6), Some(Verdict::Less));
        assert_eq!(shown(less, 7), Some(Verdict::Open));
    }

    #[test]
    fn there_are_no_shares_of_nothing() {
        assert_eq!(PairedDifference::of(&[1.0; 8], &[0.0; 8], 1), None);
        assert_eq!(PairedDifference::of(&[], &[], 1), None);
    }

    proptest! {
        /// Seeds that are hard for both cancel out; and to swap the better for the worse turns the verdict.
        #[test]
        fn a_share_more_or_less_is_seen_through_the_spread(
            theirs in prop::collection::vec(1.0..1000.0_f64, 12..30),
            share in 0.3..3.0_f64,
        ) {
            let whole = median(&theirs);
            let more: Vec<f64> = theirs.iter().map(|y| y + share * whole).collect();
            let paired = PairedDifference::of(&more, &theirs, 1).unwrap();
            prop_assert!((paired.difference.median - share).abs() < 1e-9);
            prop_assert_eq!(paired.verdict, Verdict::More);
            let less = PairedDifference::of(&theirs, &more, 1).unwrap();
            prop_assert_eq!(less.verdict, Verdict::Less);
        }
    }
}
