//! Maps of one seed as the page draws them: φ, eigenvectors, visits and policy by place.
//!
//! A place is a cell of the map, a square of cells where the map is so large that single ones could not be seen, or
//! a state where there is no map. Places are numbered in the order of discovery, so that every frame knows the first
//! few of them.

use super::packed::Packed;
use crate::archive::RecordedSeed;
use crate::archive::Snapshot;
use crate::env::layouts::{Layout, Tile};
use crate::report::validity::cell;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Places drawn at most, so that a moment takes a third of a megabyte at most.
const MAX_PLACES: usize = 40_000;

/// Bytes that the names of states may take.
const MAX_NAMES: usize = 500_000;

/// Edges drawn at most where there is no map.
const MAX_EDGES: usize = 30_000;

/// Eigenvectors drawn: the second to the fourth.
const VECTORS: usize = 3;

/// One seed through time.
#[derive(Serialize)]
pub(super) struct Sights {
    map: Option<Map>,
    /// Square of each place on the map; nothing where there is no map.
    cells: Vec<u32>,
    /// Name of each state, where there is no map; nothing where they are too long together.
    names: Vec<String>,
    /// Name of each action; nothing where they have none.
    actions: Vec<String>,
    /// Undirected edges between places, where there is no map.
    edges: Vec<(u32, u32)>,
    pub(super) frames: Vec<Frame>,
    /// log₁₀(1 + times left) by place.
    visits: Packed,
    /// The action held best by place, where a place is a state.
    greedy: Vec<Option<u16>>,
    /// The place that the action held best leads to most often, where there is no map.
    next: Vec<Option<u32>>,
}

#[derive(Serialize)]
struct Map {
    rows: usize,
    cols: usize,
    /// Cells of the world along a side of a square.
    side: usize,
    walls: Vec<u32>,
    start: Option<u32>,
    goals: Vec<u32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    hazards: Vec<u32>,
}

/// What was known at one moment.
#[derive(Serialize)]
pub(super) struct Frame {
    step: u64,
    nodes: usize,
    edges: usize,
    potential: Packed,
    eigenvalues: Vec<f64>,
    pub(super) vectors: Vec<Packed>,
}

impl Frame {
    /// How much room it takes.
    pub(super) fn weight(&self) -> usize {
        self.potential.len() + self.vectors.iter().map(Packed::len).sum::<usize>()
    }
}

impl Sights {
    /// What `seed` has left on its map, if there is one.
    pub(super) fn new(seed: &RecordedSeed, layout: Option<&Layout>) -> Self {
        let side = layout.map_or(1, |map| side(map.num_cells()));
        let map = layout.map(|layout| Map::new(layout, side));
        let places = Places::new(seed, layout, side);
        Self {
            visits: places.visits(seed),
            names: match layout {
                Some(_) => Vec::new(),
                None => names(&seed.labels[..places.count]),
            },
            actions: seed.actions.clone().unwrap_or_default(),
            greedy: match side {
                1 => places.greedy(seed),
                _ => Vec::new(),
            },
            edges: match layout {
                Some(_) => Vec::new(),
                None => places.edges(seed),
            },
            next: match layout {
                Some(_) => Vec::new(),
                None => places.next(seed),
            },
            frames: seed.snapshots.iter().map(|s| places.frame(s)).collect(),
            cells: places.cells,
            map,
        }
    }

    /// What the reader should know about what is not drawn.
    pub(super) fn note(&self) -> Option<String> {
        let side = self.map.as_ref().map_or(1, |map| map.side);
        if side > 1 {
            return Some(format!(
                "The map is large: each square stands for {side} × {side} cells and shows their mean."
            ));
        }
        (self.map.is_none() && self.visits.len() == MAX_PLACES).then(|| {
            format!(
                "The graph is large: only the first {MAX_PLACES} states are drawn, and {MAX_EDGES} of their edges."
            )
        })
    }
}

/// The names of all states, or of none.
fn names(labels: &[String]) -> Vec<String> {
    let bytes: usize = labels.iter().map(String::len).sum();
    match bytes <= MAX_NAMES {
        true => labels.to_vec(),
        false => Vec::new(),
    }
}

/// Cells along a side of a square, so that there are not too many of these.
fn side(cells: usize) -> usize {
    (cells as f64 / MAX_PLACES as f64).sqrt().ceil().max(1.0) as usize
}

/// Where each state is drawn.
struct Places {
    /// By state; states beyond the end, and those without a place on the map, are not drawn.
    of_state: Vec<Option<usize>>,
    cells: Vec<u32>,
    count: usize,
}

impl Places {
    fn new(seed: &RecordedSeed, layout: Option<&Layout>, side: usize) -> Self {
        let Some(layout) = layout else {
            let count = seed.labels.len().min(MAX_PLACES);
            return Self {
                of_state: (0..count).map(Some).collect(),
                cells: Vec::new(),
                count,
            };
        };
        let mut cells = Vec::new();
        let mut known: HashMap<u32, usize> = HashMap::new();
        let square = |label: &String| {
            let (row, col) = layout.position(cell(layout, label)?);
            Some((row / side * layout.cols().div_ceil(side) + col / side) as u32)
        };
        let of_state = (seed.labels.iter())
            .map(|label| {
                let square = square(label)?;
                Some(*known.entry(square).or_insert_with(|| {
                    cells.push(square);
                    cells.len() - 1
                }))
            })
            .collect();
        Self {
            of_state,
            count: cells.len(),
            cells,
        }
    }

    fn place(&self, state: usize) -> Option<usize> {
        self.of_state.get(state).copied().flatten()
    }

    /// Means by place of values by state.
    fn mean(&self, values: impl Iterator<Item = f64>) -> Packed {
        let mut sums = vec![(0.0, 0_u32); self.count];
        let mut last = 0;
        for (state, value) in values.enumerate() {
            if let Some(place) = self.place(state) {
                sums[place].0 += value;
                sums[place].1 += 1;
                last = last.max(place + 1);
            }
        }
        let means = sums[..last].iter().map(|&(sum, n)| sum / f64::from(n));
        Packed::new(&means.collect::<Vec<f64>>())
    }

    fn frame(&self, snapshot: &Snapshot) -> Frame {
        let packed = |values: &Vec<f32>| self.mean(values.iter().map(|&v| f64::from(v)));
        Frame {
            step: snapshot.step,
            nodes: snapshot.nodes,
            edges: snapshot.edges,
            potential: packed(&snapshot.potential),
            eigenvalues: snapshot.eigenvalues.iter().map(|&v| short(v)).collect(),
            vectors: snapshot.vectors.iter().take(VECTORS).map(packed).collect(),
        }
    }

    fn visits(&self, seed: &RecordedSeed) -> Packed {
        let mut sums = vec![0_u64; self.count];
        for (state, row) in seed.policy.iter().enumerate() {
            if let Some(place) = self.place(state) {
                sums[place] += row.visits;
            }
        }
        let logs = sums.iter().map(|&n| libm::log10(1.0 + n as f64));
        Packed::new(&logs.collect::<Vec<f64>>())
    }

    fn greedy(&self, seed: &RecordedSeed) -> Vec<Option<u16>> {
        let mut greedy = vec![None; self.count];
        for (state, row) in seed.policy.iter().enumerate() {
            if let Some(place) = self.place(state) {
                greedy[place] = row.greedy.filter(|_| row.visits > 0);
            }
        }
        greedy
    }

    fn edges(&self, seed: &RecordedSeed) -> Vec<(u32, u32)> {
        let count = self.count as u32;
        let rows = seed.graph.iter().filter(|row| row.from != row.to);
        let mut edges: Vec<_> = rows
            .map(|row| (row.from.min(row.to), row.from.max(row.to)))
            .filter(|&(_, far)| far < count)
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let stride = edges.len().div_ceil(MAX_EDGES).max(1);
        edges.into_iter().step_by(stride).collect()
    }

    fn next(&self, seed: &RecordedSeed) -> Vec<Option<u32>> {
        let mut best: BTreeMap<u32, (u32, u32)> = BTreeMap::new();
        for row in &seed.graph {
            let held = seed.policy.get(row.from as usize);
            let held = held.is_some_and(|held| held.greedy == Some(row.action));
            let most = best.entry(row.from).or_default();
            if held && row.from != row.to && row.count > most.0 {
                *most = (row.count, row.to);
            }
        }
        let next = |state: u32| {
            let &(count, to) = best.get(&state)?;
            (count > 0 && (to as usize) < self.count).then_some(to)
        };
        (0..self.count as u32).map(next).collect()
    }
}

impl Map {
    fn new(layout: &Layout, side: usize) -> Self {
        let (rows, cols) = (layout.rows().div_ceil(side), layout.cols().div_ceil(side));
        let square = |cell| {
            let (row, col) = layout.position(cell);
            (row / side * cols + col / side) as u32
        };
        // A square is a wall if all of it is.
        let mut walled = vec![true; rows * cols];
        for i in 0..layout.num_cells() {
            let cell = layout.cell(i / layout.cols(), i % layout.cols());
            if let Some(cell) = cell.filter(|&cell| layout.tile(cell) != Tile::Wall) {
                walled[square(cell) as usize] = false;
            }
        }
        Self {
            rows,
            cols,
            side,
            walls: (0..walled.len() as u32)
                .filter(|&i| walled[i as usize])
                .collect(),
            start: layout.start.map(square),
            goals: layout.goals.iter().map(|goal| square(goal.cell)).collect(),
            hazards: layout.hazards.iter().map(|h| square(h.cell)).collect(),
        }
    }
}

/// To five digits.
pub(super) fn short(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let decimals = 4 - libm::log10(value.abs()).floor() as i32;
    if decimals >= 0 {
        let scale = 10_f64.powi(decimals);
        // Tiny values have no such scale.
        let rounded = (value * scale).round() / scale;
        if rounded.is_finite() { rounded } else { value }
    } else {
        let unit = 10_f64.powi(-decimals);
        (value / unit).round() * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_maps_become_squares() {
        assert_eq!(side(100), 1);
        assert_eq!(side(200 * 200), 1);
        assert_eq!(side(1_000 * 1_000), 5);
        let layout = Layout::open(4, 6).unwrap();
        let seed = RecordedSeed {
            labels: ["0,0", "0,1", "1,1", "3,5", "2,4"]
                .map(String::from)
                .to_vec(),
            ..RecordedSeed::default()
        };
        let places = Places::new(&seed, Some(&layout), 2);
        assert_eq!(places.cells, [0, 5]);
        let means = places.mean([1.0, 2.0, 6.0, 4.0, 5.0].into_iter());
        assert_eq!(means, Packed::new(&[3.0, 4.5]));
        // Before the second square is known.
        assert_eq!(places.mean([1.0].into_iter()), Packed::new(&[1.0]));
    }

    #[test]
    fn five_digits_are_kept() {
        for (value, expected) in [
            (123_456.7, 123_460.0),
            (-0.001_234_567, -0.001_234_6),
            (0.0, 0.0),
            (1e-310, 1e-310),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
