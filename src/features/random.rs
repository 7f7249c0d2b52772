//! Features that know nothing of the graph: the control that shows what the others know.

use crate::seeds::{Stream, standard_normal, stream};
use faer::{Mat, MatRef};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Independent standard normal rows, one for each state by its number. Rows never change once they are drawn.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RandomFeatures {
    #[serde(with = "crate::spectral::plain::matrix")]
    rows: Mat<f64>,
    rng: ChaCha8Rng,
}

impl RandomFeatures {
    /// No rows yet, `columns` wide.
    pub fn new(columns: usize, seed: u64) -> Self {
        Self {
            rows: Mat::zeros(0, columns),
            rng: stream(seed, Stream::Features),
        }
    }

    /// Draws rows up to `nodes`; O(new rows × columns).
    pub fn grow(&mut self, nodes: usize) {
        let known = self.rows.nrows();
        if nodes <= known {
            return;
        }
        let columns = self.rows.ncols();
        self.rows.resize_with(nodes, columns, |_, _| 0.0);
        // Row by row, so that the numbers do not depend on how many rows were asked for at once.
        for i in known..nodes {
            for c in 0..columns {
                self.rows[(i, c)] = standard_normal(&mut self.rng);
            }
        }
    }

    /// The rows drawn so far, n × columns.
    pub fn features(&self) -> MatRef<'_, f64> {
        self.rows.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_do_not_depend_on_how_they_were_asked_for() {
        let mut at_once = RandomFeatures::new(5, 9);
        at_once.grow(40);
        let mut piecemeal = RandomFeatures::new(5, 9);
        [3, 3, 17, 2, 40]
            .into_iter()
            .for_each(|n| piecemeal.grow(n));
        assert_eq!(at_once.features(), piecemeal.features());
        let mut other = RandomFeatures::new(5, 10);
        other.grow(40);
        assert_ne!(at_once.features(), other.features());
    }

    #[test]
    fn entries_have_the_moments_of_a_normal_number() {
        let mut random = RandomFeatures::new(4, 0);
        random.grow(5000);
        let x = random.features();
        let mean = |power: i32| {
            (0..5000)
                .flat_map(|i| (0..4).map(move |c| x[(i, c)].powi(power)))
                .sum::<f64>()
                / 20_000.0
        };
        // Four standard errors of the mean of 20 000: 1, √2, √96 over √20 000.
        assert!(mean(1).abs() < 0.03);
        assert!((mean(2) - 1.0).abs() < 0.04);
        assert!((mean(4) - 3.0).abs() < 0.28);
    }
}
