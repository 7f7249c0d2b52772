//! Where episodes begin, and how often in each place.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Places where an episode may begin, with the chance of each. A list of places converts into equally likely ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Starts<S = usize> {
    places: Vec<S>,
    /// One per place, their sum 1; none if all places are equally likely.
    chances: Vec<f64>,
}

impl<S> Starts<S> {
    /// Each of `places` as likely as any other.
    pub fn equally_likely(places: Vec<S>) -> Self {
        Self {
            places,
            chances: Vec::new(),
        }
    }

    /// Each place as likely as its weight says beside those of the others. Equal weights are [equally
    /// likely](Self::equally_likely).
    ///
    /// # Panics
    /// If a weight is not a finite number above 0.
    pub fn weighted(weighted: impl IntoIterator<Item = (S, f64)>) -> Self {
        let (places, weights): (Vec<S>, Vec<f64>) = weighted.into_iter().unzip();
        let sound = |weight: &f64| weight.is_finite() && *weight > 0.0;
        assert!(
            weights.iter().all(sound),
            "weights are finite numbers above 0"
        );
        if weights.windows(2).all(|pair| pair[0] == pair[1]) {
            return Self::equally_likely(places);
        }
        // In parts of the largest, so that their sum is a number.
        let largest = weights.iter().copied().fold(0.0, f64::max);
        let parts = weights.iter().map(|weight| weight / largest);
        let sum: f64 = parts.clone().sum();
        let chances = parts.map(|part| part / sum).collect();
        Self { places, chances }
    }

    /// The places, in the order given.
    pub fn places(&self) -> &[S] {
        &self.places
    }

    /// The places, each with its chance.
    pub fn chances(&self) -> impl Iterator<Item = (&S, f64)> {
        let equal = 1.0 / self.places.len() as f64;
        let chance = move |place| self.chances.get(place).copied().unwrap_or(equal);
        self.places.iter().zip((0..).map(chance))
    }

    /// The places, each with a number in proportion to its chance: 1 where all are equally likely, without a rounding.
    pub(super) fn weights(&self) -> impl Iterator<Item = (&S, f64)> {
        let weight = |place: usize| self.chances.get(place).copied().unwrap_or(1.0);
        self.places.iter().zip((0..).map(weight))
    }

    /// The same starts by other names.
    pub fn map<T>(&self, name: impl FnMut(&S) -> T) -> Starts<T> {
        Starts {
            places: self.places.iter().map(name).collect(),
            chances: self.chances.clone(),
        }
    }

    /// The mean of a number over the starts; NaN if there are none.
    pub fn mean(&self, of: impl Fn(&S) -> f64) -> f64 {
        if self.chances.is_empty() {
            return self.places.iter().map(of).sum::<f64>() / self.places.len() as f64;
        }
        self.chances()
            .map(|(place, chance)| chance * of(place))
            .sum()
    }

    /// One of them. A single one takes no random number.
    ///
    /// # Panics
    /// If there are none.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng) -> S
    where
        S: Copy,
    {
        match self.places.as_slice() {
            [only] => *only,
            several if self.chances.is_empty() => several[rng.random_range(0..several.len())],
            several => {
                let mut left = rng.random::<f64>();
                let drawn = self.chances().find(|(_, chance)| {
                    left -= chance;
                    left < 0.0
                });
                // The sum may fall short of 1 by rounding: the last place takes the rest.
                drawn.map_or(several[several.len() - 1], |(place, _)| *place)
            }
        }
    }
}

impl From<&[usize]> for Starts {
    fn from(places: &[usize]) -> Self {
        Self::equally_likely(places.to_vec())
    }
}

impl<const N: usize> From<&[usize; N]> for Starts {
    fn from(places: &[usize; N]) -> Self {
        Self::equally_likely(places.to_vec())
    }
}

impl From<&Vec<usize>> for Starts {
    fn from(places: &Vec<usize>) -> Self {
        Self::equally_likely(places.clone())
    }
}

impl From<&Starts> for Starts {
    fn from(starts: &Starts) -> Self {
        starts.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds::{Stream, stream};

    fn rng() -> ChaCha8Rng {
        stream(5, Stream::Environment)
    }

    /// 0.999 quantile of χ² with 2 degrees of freedom.
    const CHI_SQUARE_2: f64 = 13.816;

    #[test]
    fn places_are_drawn_as_often_as_they_weigh() {
        let starts = Starts::weighted([('a', 1.0), ('b', 5.0), ('c', 2.0)]);
        let mut rng = rng();
        let draws = 20_000;
        let drawn: Vec<char> = (0..draws).map(|_| starts.draw(&mut rng)).collect();
        let chi_square: f64 = [('a', 0.125), ('b', 0.625), ('c', 0.25)]
            .iter()
            .map(|&(place, share)| {
                let seen = drawn.iter().filter(|&&d| d == place).count() as f64;
                let expected = share * f64::from(draws);
                (seen - expected).powi(2) / expected
            })
            .sum();
        assert!(chi_square < CHI_SQUARE_2, "{chi_square}");
    }

    #[test]
    fn equal_weights_draw_what_no_weights_draw() {
        let equal = Starts::equally_likely(vec![3, 1, 4]);
        let weighted = Starts::weighted([(3, 0.7), (1, 0.7), (4, 0.7)]);
        assert_eq!(equal, weighted);
        let (mut one, mut other) = (rng(), rng());
        for _ in 0..100 {
            let plain = [3, 1, 4][other.random_range(0..3)];
            assert_eq!(weighted.draw(&mut one), plain);
        }
        // A single place leaves the generator alone.
        let untouched = one.clone();
        assert_eq!(Starts::weighted([(9, 1e300)]).draw(&mut one), 9);
        assert_eq!(one, untouched);
    }

    #[test]
    fn chances_sum_to_one_however_large_the_weights() {
        let starts = Starts::weighted([(0, 1e308), (1, 1.5e308), (2, 0.5e308)]);
        let chances: Vec<f64> = starts.chances().map(|(_, chance)| chance).collect();
        for (found, expected) in chances.iter().zip([1.0 / 3.0, 0.5, 1.0 / 6.0]) {
            assert!((found - expected).abs() < 1e-15, "{chances:?}");
        }
        assert!((starts.mean(|&place| f64::from(place)) - 5.0 / 6.0).abs() < 1e-15);
        assert_eq!(Starts::from(&[2, 5]).mean(|&place| place as f64), 3.5);
    }

    #[test]
    #[should_panic(expected = "above 0")]
    fn a_weight_of_nothing_is_refused() {
        Starts::weighted([(0, 1.0), (1, 0.0)]);
    }
}
