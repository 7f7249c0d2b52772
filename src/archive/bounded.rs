//! The episodes of a run of any length in a bounded number of rows.
//!
//! ```text
//! rows of m and of n episodes, before which there were b, become one as soon as   m + n ≤ 1 + b / R
//! ```
//!
//! What is learnt is learnt early, so the first R episodes keep a row each, and of N there are at most about
//! 2 R (1 + ln(N / R)) rows. Blocks of a curve on a logarithmic scale ([`blocks`](crate::statistics::blocks)) are much wider. As long
//! as there are less than 2 R nothing is merged.

use super::rows::EpisodeRow;

/// Rows of the episodes of a run, later ones several in a row.
#[derive(Clone, Debug)]
pub struct BoundedEpisodes {
    rows: Vec<EpisodeRow>,
    /// R.
    resolution: usize,
    /// When there are so many rows they are made fewer.
    limit: usize,
}

impl BoundedEpisodes {
    /// No episodes; R = `resolution`, at least 1.
    pub fn new(resolution: usize) -> Self {
        Self {
            rows: Vec::new(),
            resolution,
            limit: 2 * resolution,
        }
    }

    /// One more. O(1) on average.
    pub fn push(&mut self, row: EpisodeRow) {
        self.rows.push(row);
        if self.rows.len() >= self.limit {
            self.merge();
            // Half as many again before the next time.
            self.limit = self.rows.len() + self.rows.len() / 2 + self.resolution;
        }
    }

    /// All of them, in order.
    pub fn rows(&self) -> &[EpisodeRow] {
        &self.rows
    }

    /// The same.
    pub fn into_rows(self) -> Vec<EpisodeRow> {
        self.rows
    }

    fn merge(&mut self) {
        let mut merged: Vec<EpisodeRow> = Vec::new();
        let mut before = 0; // the last one of `merged`
        for row in self.rows.drain(..) {
            match merged.last_mut() {
                Some(last) if last.episodes + row.episodes <= 1 + before / self.resolution => {
                    *last = joined(last, row);
                }
                last => {
                    before += last.map_or(0, |last| last.episodes);
                    merged.push(row);
                }
            }
        }
        self.rows = merged;
    }
}

/// Two rows as one: sums, and the rest as at the end of the second one.
fn joined(first: &EpisodeRow, second: EpisodeRow) -> EpisodeRow {
    EpisodeRow {
        episodes: first.episodes + second.episodes,
        length: first.length + second.length,
        plain_return: first.plain_return + second.plain_return,
        shaped_return: first.shaped_return + second.shaped_return,
        ..second
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(episode: u64) -> EpisodeRow {
        EpisodeRow {
            episodes: 1,
            episode,
            step: 3 * (episode + 1),
            length: 3,
            plain_return: -3.0,
            shaped_return: -1.0,
            status: "terminated".into(),
            regret: episode as f64,
            nodes: 1,
            edges: 0,
        }
    }

    #[test]
    fn rows_are_bounded_and_nothing_is_lost() {
        const RESOLUTION: usize = 1000;
        let mut bounded = BoundedEpisodes::new(RESOLUTION);
        let total = 1_000_000;
        let mut most = 0;
        for episode in 0..total {
            bounded.push(row(episode));
            most = most.max(bounded.rows().len());
        }
        // 2 · 1000 · (1 + ln 1000) = 15 816, and half as many again before they are merged.
        assert!(most < 26_000, "{most}");
        let rows = bounded.rows();
        let sum = |of: fn(&EpisodeRow) -> f64| rows.iter().map(of).sum::<f64>();
        assert_eq!(sum(|row| row.episodes as f64), total as f64);
        assert_eq!(sum(|row| row.length as f64), 3.0 * total as f64);
        assert_eq!(sum(|row| row.plain_return), -3.0 * total as f64);
        assert_eq!(sum(|row| row.shaped_return), -(total as f64));
        assert!(rows.iter().take(RESOLUTION).all(|row| row.episodes == 1));
        let mut end = 0;
        for row in rows {
            let wide = 1 + end / RESOLUTION;
            assert!(row.episodes <= wide, "{} after {end}", row.episodes);
            end += row.episodes;
            assert_eq!(row.step, 3 * end as u64);
            assert_eq!(row.regret, (end - 1) as f64);
        }
    }
}
