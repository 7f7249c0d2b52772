//! Curves with bands over two logarithmic axes.

use super::{Anchor, Drawing};
use crate::archive::{EpisodeRow, RecordedRun};
use crate::report::band::Band;

/// A mean over seeds, with its band, by episode.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// Number of the episode at each point, from 1.
    episodes: Vec<usize>,
    pub band: Band,
}

impl Curve {
    /// `value` over the episodes that every seed of `run` has had.
    pub(super) fn over(run: &RecordedRun, value: fn(&EpisodeRow) -> f64) -> Self {
        let rows = run.seeds.iter().map(|seed| seed.episodes.len()).min();
        let rows = rows.unwrap_or(0);
        let mut episodes = run.seeds.first().map_or(Vec::new(), |seed| seed.ends());
        episodes.truncate(rows);
        let band = Band::over(run.seeds.len(), rows, |seed, row| {
            value(&run.seeds[seed].episodes[row])
        });
        Self { episodes, band }
    }

    /// The number of the last episode.
    pub(super) fn num_episodes(&self) -> usize {
        self.episodes.last().copied().unwrap_or(0)
    }

    /// The mean there.
    pub(super) fn at_end(&self) -> f64 {
        self.band.middle.last().copied().unwrap_or(0.0)
    }
}

/// Where a chart stands, and the powers of ten at the ends of its axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogChart {
    /// Left, upper, right, lower edge in pixels.
    pub edges: [f64; 4],
    /// Decades of x.
    pub x: (f64, f64),
    /// Decades of y.
    pub y: (f64, f64),
}

impl LogChart {
    /// Values below the axes' ends are drawn at these ends: regret can be 0.
    pub(super) fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let [left, top, right, bottom] = self.edges;
        let share = |v: f64, (low, high): (f64, f64)| {
            ((libm::log10(v.max(f64::MIN_POSITIVE)) - low) / (high - low)).clamp(0.0, 1.0)
        };
        (
            left + share(x, self.x) * (right - left),
            bottom - share(y, self.y) * (bottom - top),
        )
    }
}

impl Drawing {
    /// Grid lines and labels at the powers of ten.
    pub(super) fn log_axes(&mut self, chart: &LogChart, x_title: &str, y_title: &str) {
        let [left, top, right, bottom] = chart.edges;
        for power in decades(chart.y) {
            let (_, y) = chart.place(1.0, 10_f64.powi(power));
            self.line((left, y), (right, y), "grid");
            self.text(left - 8.0, y + 4.5, Anchor::End, "", &ten_to(power));
        }
        for power in decades(chart.x) {
            let (x, _) = chart.place(10_f64.powi(power), 1.0);
            self.line((x, bottom), (x, bottom + 5.0), "axis");
            self.text(x, bottom + 20.0, Anchor::Middle, "", &ten_to(power));
        }
        self.line((left, bottom), (right, bottom), "axis");
        self.text(
            (left + right) / 2.0,
            bottom + 38.0,
            Anchor::Middle,
            "",
            x_title,
        );
        self.text(left - 70.0, top - 14.0, Anchor::Start, "h", y_title);
    }

    /// A curve over its episodes, thinned to a point for each pixel or so, with its band. Returns where it ends.
    pub(super) fn band(&mut self, chart: &LogChart, curve: &Curve, class: &str) -> (f64, f64) {
        let (episodes, band) = (&curve.episodes, &curve.band);
        let mut last = f64::NEG_INFINITY;
        let shown: Vec<usize> = (0..band.middle.len())
            .filter(|&i| {
                let (x, _) = chart.place(episodes[i] as f64, 1.0);
                let apart = x - last >= 1.5;
                if apart {
                    last = x;
                }
                apart || i + 1 == band.middle.len()
            })
            .collect();
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            let point = |&i: &usize| chart.place(episodes[i] as f64, values[i]);
            shown.iter().map(point).collect()
        };
        let upper = points(&band.high);
        let lower = points(&band.low);
        self.path(
            upper.into_iter().chain(lower.into_iter().rev()),
            &format!("{class}b"),
        );
        let mean = points(&band.middle);
        let end = mean.last().copied().unwrap_or_default();
        self.path(mean.into_iter(), class);
        end
    }
}

fn decades((low, high): (f64, f64)) -> std::ops::RangeInclusive<i32> {
    low.ceil() as i32..=high.floor() as i32
}

/// 1, 10, 100, 1 000 …; 1e12 where there would be too many zeros.
fn ten_to(power: i32) -> String {
    match power {
        0..=9 => crate::report::grouped(10_u64.pow(power.unsigned_abs())),
        -6..=-1 => format!("{}", 10_f64.powi(power)),
        _ => format!("1e{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::ten_to;

    #[test]
    fn powers_of_ten_have_few_zeros() {
        let powers = [0, 3, 9, 10, 27, -2, -30].map(ten_to);
        let texts = [
            "1",
            "1 000",
            "1 000 000 000",
            "1e10",
            "1e27",
            "0.01",
            "1e-30",
        ];
        assert_eq!(powers, texts);
    }
}
