//! Rooms by spectral clustering: k-means on the rows of the lowest eigenvectors (Shi & Malik 2000; Ng, Jordan & Weiss
//! 2001), every cluster then cut into its connected parts.

use eigentrail::graph::SymmetricCsr;
use faer::MatRef;
use std::collections::VecDeque;

/// Which room each node is in, rooms numbered from 0.
pub struct Partition {
    pub room_of: Vec<usize>,
    pub num_rooms: usize,
}

/// How many rooms the spectrum speaks of: the place of its largest relative gap. Ascending eigenvalues, λ_1 = 0.
pub fn number_of_rooms(eigenvalues: &[f64]) -> usize {
    let gap = |j: usize| eigenvalues[j] / eigenvalues[j - 1];
    (2..eigenvalues.len())
        .max_by(|&a, &b| gap(a).total_cmp(&gap(b)))
        .unwrap_or(1)
}

/// Rooms from the first `rooms` eigenvectors of L_sym, one row per node. Rows are scaled to length 1, so that
/// nodes of one room point the same way however well visited they are.
pub fn partition(graph: &SymmetricCsr, vectors: MatRef<'_, f64>, rooms: usize) -> Partition {
    let points: Vec<Vec<f64>> = (0..graph.num_nodes())
        .map(|i| unit((0..rooms).map(|c| vectors[(i, c)]).collect()))
        .collect();
    let cluster_of = k_means(&points, rooms);
    connected_parts(graph, &cluster_of)
}

fn unit(mut point: Vec<f64>) -> Vec<f64> {
    let norm = point.iter().map(|x| x * x).sum::<f64>().sqrt();
    point
        .iter_mut()
        .for_each(|x| *x /= norm.max(f64::MIN_POSITIVE));
    point
}

fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}

/// Lloyd's iteration from centres that are far from each other: nothing is drawn, so nothing depends on a seed.
fn k_means(points: &[Vec<f64>], k: usize) -> Vec<usize> {
    const ROUNDS: usize = 30;
    let mut centres = farthest_first(points, k);
    let mut cluster_of = vec![0; points.len()];
    for _ in 0..ROUNDS {
        for (cluster, point) in cluster_of.iter_mut().zip(points) {
            let nearest = (0..k).min_by(|&a, &b| {
                squared_distance(point, &centres[a])
                    .total_cmp(&squared_distance(point, &centres[b]))
            });
            *cluster = nearest.expect("at least one centre");
        }
        for (c, centre) in centres.iter_mut().enumerate() {
            let members = || points.iter().zip(&cluster_of).filter(|(_, of)| **of == c);
            let count = members().count();
            for (d, x) in centre.iter_mut().enumerate().filter(|_| count > 0) {
                *x = members().map(|(p, _)| p[d]).sum::<f64>() / count as f64;
            }
        }
    }
    cluster_of
}

fn farthest_first(points: &[Vec<f64>], k: usize) -> Vec<Vec<f64>> {
    let mut centres = vec![points[0].clone()];
    let mut nearest = vec![f64::INFINITY; points.len()];
    while centres.len() < k {
        let newest = centres.last().expect("never empty");
        for (distance, point) in nearest.iter_mut().zip(points) {
            *distance = distance.min(squared_distance(point, newest));
        }
        let farthest = (0..points.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        centres.push(points[farthest.expect("at least one point")].clone());
    }
    centres
}

fn connected_parts(graph: &SymmetricCsr, cluster_of: &[usize]) -> Partition {
    let mut room_of = vec![usize::MAX; graph.num_nodes()];
    let mut num_rooms = 0;
    for first in 0..graph.num_nodes() {
        if room_of[first] != usize::MAX {
            continue;
        }
        room_of[first] = num_rooms;
        let mut queue = VecDeque::from([first]);
        while let Some(i) = queue.pop_front() {
            for &j in graph.row(i).0 {
                let j = j as usize;
                if room_of[j] == usize::MAX && cluster_of[j] == cluster_of[first] {
                    room_of[j] = num_rooms;
                    queue.push_back(j);
                }
            }
        }
        num_rooms += 1;
    }
    Partition { room_of, num_rooms }
}
