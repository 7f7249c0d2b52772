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

/// Where a chart stands, and the ends of its axes as powers of ten.
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
    /// The chart whose axes end where these curves do.
    pub(super) fn around(edges: [f64; 4], curves: [&Curve; 2]) -> Self {
        let episodes = curves.iter().map(|curve| curve.num_episodes()).max();
        let highest = curves.iter().flat_map(|curve| &curve.band.high);
        let highest = highest.copied().fold(0.0, f64::max);
        let highest = if highest > 0.0 { highest } else { 10.0 };
        let least = |values: fn(&Band) -> &[f64]| {
            let values = curves.iter().flat_map(|curve| values(&curve.band));
            let positive = values.copied().filter(|&v| v > 0.0);
            positive.fold(f64::INFINITY, f64::min)
        };
        let lowest = least(|band| &band.middle).min(highest / 3.0);
        // A band may reach down to nothing, which a logarithmic axis never does.
        let lowest = least(|band| &band.low).clamp(lowest / 3.0, lowest);
        let margin = 0.05 * libm::log10(highest / lowest);
        Self {
            edges,
            x: (0.0, libm::log10(episodes.unwrap_or(1).max(2) as f64)),
            y: (libm::log10(lowest) - margin, libm::log10(highest) + margin),
        }
    }

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
    /// Grid lines and labels.
    pub(super) fn log_axes(&mut self, chart: &LogChart, x_title: &str, y_title: &str) {
        let [left, top, right, bottom] = chart.edges;
        let letters = self.letters;
        for tick in ticks(chart.y) {
            let (_, y) = chart.place(1.0, tick);
            self.line((left, y), (right, y), "grid");
            let (x, y) = (left - 8.0, y + 0.35 * letters);
            self.text(x, y, Anchor::End, "", &tick_label(tick));
        }
        let end = libm::pow(10.0, chart.x.1).round();
        let half = |tick: f64| 0.3 * letters * tick_label(tick).chars().count() as f64;
        let room = |tick: f64| half(tick) + half(end) + 0.5 * letters;
        let apart = |tick: &f64| right - chart.place(*tick, 1.0).0 > room(*tick);
        for tick in ticks(chart.x).into_iter().filter(apart).chain([end]) {
            let (x, _) = chart.place(tick, 1.0);
            self.line((x, bottom), (x, bottom + 5.0), "axis");
            let below = bottom + 8.0 + letters;
            self.text(x, below, Anchor::Middle, "", &tick_label(tick));
        }
        self.line((left, bottom), (right, bottom), "axis");
        let (middle, below) = ((left + right) / 2.0, bottom + 12.0 + 2.2 * letters);
        self.text(middle, below, Anchor::Middle, "", x_title);
        self.text(6.0, top - 14.0, Anchor::Start, "h", y_title);
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

/// The powers of ten between two of them; with 2 and 5 times as much where these are few.
fn ticks((low, high): (f64, f64)) -> Vec<f64> {
    let factors = if high - low > 2.0 {
        &[1.0][..]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let powers = low.floor() as i32..=high.ceil() as i32;
    let all = powers.flat_map(|power| factors.iter().map(move |f| f * 10_f64.powi(power)));
    let inside = |tick: &f64| (low - 1e-9..=high + 1e-9).contains(&libm::log10(*tick));
    all.filter(inside).collect()
}

/// 1, 10, 100, 1 000 …; 1e12 where there would be too many zeros.
fn tick_label(tick: f64) -> String {
    let power = (libm::log10(tick) + 1e-9).floor();
    match power {
        0.0..=9.0 => crate::report::grouped(tick.round() as u64),
        -6.0..0.0 => format!("{:.*}", -power as usize, tick),
        _ => format!("{tick:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{tick_label, ticks};

    #[test]
    fn powers_of_ten_have_few_zeros() {
        let powers = [0, 3, 9, 10, 27, -2, -30].map(|p| tick_label(10_f64.powi(p)));
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
        assert_eq!([500.0, 0.05].map(tick_label), ["500", "0.05"]);
    }

    #[test]
    fn short_axes_have_more_ticks() {
        assert_eq!(ticks((0.0, 3.5)), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(ticks((0.5, 1.5)), [5.0, 10.0, 20.0]);
    }
}
