//! How good a potential is: against the true cost-to-go, and to an agent that climbs it.

use eigentrail::graph::SymmetricCsr;

/// Of one potential on one map.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// mean |a v/d − 1| with the best a: relative error of v = −φ as a distance.
    pub error: f64,
    /// Spearman's rank correlation of v and d.
    pub rank: f64,
    /// Steps of an agent that always moves to the neighbour with the largest φ, ÷ the shortest way; a walk that does
    /// not arrive within ten times the shortest way counts as 10.
    pub detour: f64,
}

impl Quality {
    /// Of φ at `nodes`, none of them the goal, on the true graph with true distances.
    pub fn of(phi: &[f64], distances: &[f64], graph: &SymmetricCsr, nodes: &[usize]) -> Self {
        let v: Vec<f64> = nodes.iter().map(|&i| -phi[i]).collect();
        let d: Vec<f64> = nodes.iter().map(|&i| distances[i]).collect();
        let detours = nodes.iter().map(|&i| detour(phi, distances, graph, i));
        Self {
            error: relative_error(&v, &d),
            rank: pearson(&ranks(&v), &ranks(&d)),
            detour: detours.sum::<f64>() / nodes.len() as f64,
        }
    }
}

/// The mean of |a x − 1| over x = v/d is least for an a with a x = 1 at one of the x.
fn relative_error(v: &[f64], d: &[f64]) -> f64 {
    let x: Vec<f64> = v.iter().zip(d).map(|(v, d)| v / d).collect();
    let error = |a: f64| x.iter().map(|x| (a * x - 1.0).abs()).sum::<f64>() / x.len() as f64;
    let candidates = x.iter().filter(|x| **x > 0.0).map(|x| error(1.0 / x));
    candidates.fold(error(0.0), f64::min)
}

/// Places in ascending order; equal values share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let mean = first as f64 + (group.len() - 1) as f64 / 2.0;
        group.iter().for_each(|&i| ranks[i] = mean);
        first += group.len();
    }
    ranks
}

fn pearson(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, my) = (mean(x), mean(y));
    let cov = |a: &[f64], ma: f64, b: &[f64], mb: f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum()
    };
    let scale = (cov(x, mx, x, mx) * cov(y, my, y, my)).sqrt();
    if scale > 0.0 {
        cov(x, mx, y, my) / scale
    } else {
        0.0
    }
}

fn detour(phi: &[f64], distances: &[f64], graph: &SymmetricCsr, start: usize) -> f64 {
    const LIMIT: f64 = 10.0;
    let mut at = start;
    let mut steps = 0.0;
    while distances[at] > 0.0 && steps < LIMIT * distances[start] {
        let neighbors = graph.row(at).0.iter();
        let best = neighbors.max_by(|&&a, &&b| phi[a as usize].total_cmp(&phi[b as usize]));
        at = best.copied().expect("the graph is connected") as usize;
        steps += 1.0;
    }
    steps / distances[start]
}

/// Median of the values, and a 95 % interval of it by resampling.
pub fn median_interval(values: &[f64], rng: &mut rand_chacha::ChaCha8Rng) -> [f64; 3] {
    use rand::RngExt;
    let median = |mut v: Vec<f64>| {
        v.sort_by(f64::total_cmp);
        let half = v.len() / 2;
        if v.len() % 2 == 1 {
            v[half]
        } else {
            (v[half - 1] + v[half]) / 2.0
        }
    };
    let mut medians: Vec<f64> = (0..1000)
        .map(|_| {
            median(
                (0..values.len())
                    .map(|_| values[rng.random_range(0..values.len())])
                    .collect(),
            )
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    [median(values.to_vec()), medians[25], medians[974]]
}
