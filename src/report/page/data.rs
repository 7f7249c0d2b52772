//! Data that the page's script draws, as plain values.

use super::sights::{Sights, short};
use crate::archive::{MedianInterval, ProbabilityInterval};
use crate::report::band::Band;
use crate::report::terminal::whole;
use crate::report::validity::Check;
use serde::Serialize;

/// Everything on the page.
#[derive(Serialize)]
pub(super) struct PageData {
    pub(super) title: String,
    pub(super) program: &'static str,
    /// The result, a sentence in each line.
    pub(super) headline: String,
    /// What the reader should know about what is not drawn.
    pub(super) notes: Vec<String>,
    /// What the middle of bands and the numbers of the table are.
    pub(super) statistic: &'static str,
    pub(super) arms: Vec<Arm>,
    /// The same about other worlds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) others: Vec<PageData>,
}

/// One run, or one arm of a comparison.
#[derive(Serialize)]
pub(super) struct Arm {
    pub(super) name: String,
    /// The name where there is little room.
    pub(super) label: String,
    /// What it is, in one line; nothing if the name says it.
    pub(super) about: Option<String>,
    pub(super) command: String,
    pub(super) resolved: String,
    pub(super) seeds: Vec<u64>,
    pub(super) facts: Vec<(&'static str, String)>,
    /// Numbers of the last episodes, from 1, of the blocks that the points of the curves stand for.
    pub(super) episodes: Vec<usize>,
    pub(super) length: Band,
    pub(super) regret: Band,
    pub(super) plain: Option<Band>,
    pub(super) shaped: Option<Band>,
    /// Against the sparse arm of a comparison.
    pub(super) versus: Option<Versus>,
    pub(super) phases: Option<Phases>,
    pub(super) checks: Vec<Check>,
    pub(super) sights: Option<Sights>,
    pub(super) solver: Vec<Effort>,
}

/// An arm against the sparse one.
#[derive(Serialize)]
pub(super) struct Versus {
    pub(super) ratio: MedianInterval,
    pub(super) improvement: ProbabilityInterval,
}

/// Seconds of one run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Phases {
    pub(super) spectrum: f64,
    pub(super) fit: f64,
    pub(super) rest: f64,
}

/// One refresh.
#[derive(Serialize)]
pub(super) struct Effort {
    pub(super) step: u64,
    pub(super) applications: Option<usize>,
    pub(super) solves: Option<usize>,
    pub(super) residual: Option<f64>,
    pub(super) loss: Option<f64>,
}

const THINNED: &str = "Moments were left out to keep this file below 5 MB.";

impl PageData {
    /// Drops every second moment of the arm with the most numbers, then eigenvectors, then maps; false if nothing is
    /// left to drop.
    pub(super) fn thin(&mut self) -> bool {
        let own = self.weight();
        let heaviest = self.others.iter_mut().max_by_key(|page| page.weight());
        if let Some(other) = heaviest.filter(|other| other.weight() > own) {
            return other.thin();
        }
        if !self.notes.iter().any(|note| note == THINNED) {
            self.notes.push(THINNED.to_owned());
        }
        let heaviest = self.arms.iter_mut().max_by_key(|arm| arm.weight());
        heaviest.is_some_and(Arm::thin)
    }

    /// What its heaviest arm weighs.
    fn weight(&self) -> usize {
        self.arms.iter().map(Arm::weight).max().unwrap_or(0)
    }
}

impl Arm {
    fn weight(&self) -> usize {
        let frames = self.sights.iter().flat_map(|sights| &sights.frames);
        frames.map(|frame| frame.weight()).sum()
    }

    fn thin(&mut self) -> bool {
        let Some(sights) = &mut self.sights else {
            return false;
        };
        let frames = &mut sights.frames;
        if frames.len() > 1 {
            let mut left = frames.len();
            // Counted from the end, so that the last frame stays.
            frames.retain(|_| {
                left -= 1;
                left % 2 == 0
            });
        } else if frames.iter().any(|frame| !frame.vectors.is_empty()) {
            frames.iter_mut().for_each(|frame| frame.vectors.clear());
        } else {
            self.sights = None;
        }
        true
    }
}

/// The band to five digits, which no eye can tell from more.
pub(super) fn short_band(mut band: Band) -> Band {
    for curve in [&mut band.middle, &mut band.low, &mut band.high] {
        curve.iter_mut().for_each(|value| *value = short(*value));
    }
    band
}

/// `middle [low, high]`, each to a tenth, without an interval that has no width.
pub(super) fn with_interval((middle, low, high): (f64, f64, f64)) -> String {
    if high > low {
        format!("{} [{}, {}]", tenths(middle), tenths(low), tenths(high))
    } else {
        tenths(middle)
    }
}

/// To a tenth, without a needless one; from a thousand on to a whole number.
pub(super) fn tenths(number: f64) -> String {
    if number.abs() >= 1000.0 {
        return whole(number);
    }
    let text = format!("{number:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// The command without the name of its folder and without what is about this one folder.
pub(super) fn command(arguments: &[String]) -> String {
    let mut words = vec!["eigentrail".to_owned()];
    let mut arguments = arguments.iter().skip(1);
    while let Some(word) = arguments.next() {
        match word.as_str() {
            "--out" => {
                arguments.next();
            }
            "--force" | "--resume" => {}
            _ if word.starts_with("--out=") => {}
            _ if word.contains([' ', '"', '$', '*', '[']) => words.push(format!("'{word}'")),
            _ => words.push(word.clone()),
        }
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_can_be_pasted() {
        let words = ["/bin/eigentrail", "run", "x", "--out", "y", "--force"];
        let mut words = words.map(String::from).to_vec();
        words.extend(["--set", "env.room=[3, 3]"].map(String::from));
        assert_eq!(command(&words), "eigentrail run x --set 'env.room=[3, 3]'");
    }
}
