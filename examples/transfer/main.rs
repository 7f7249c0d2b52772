//! Where learning pays, and where plain heat does as well: weights of the `gcn` potential carried to goals, maps and
//! nodes that they were not fitted on. The experiment can fail: `heat` learns nothing, `hops` plans on what is known. Nobody walks
//! here: labels are the returns of shortest ways on the graph as known.
//!
//! ```sh
//! cargo run --release --example transfer -- 20          # seeds; some ten seconds on four cores
//! ```
//!
//! | question | fitted on | asked on | true cost-to-go |
//! |---|---|---|---|
//! | `new-goal` | a map | the same map, another goal | of the map |
//! | `new-map` | a map | another map of the family | of the other map |
//! | `new-nodes` | the first 80 % of a map | the other 20 %, features extended | of the map |
//! | `missing-edges` | a map | another one, 15 % of its edges unknown | of the whole other map |
//! | `false-edges` | a map | another one with 2 % of false edges | of the other map without them |
//!
//! | arm | φ |
//! |---|---|
//! | `inherit` | what the program does between two fits: a new node has φ of the node it was found from, here of `heat` |
//! | `hops`, `heat` | solved on the graph as known |
//! | `untrained` | `heat` at the temperature of the `gcn` form before it has learnt anything |
//! | `coldest` | `heat` at the lowest temperature that the `gcn` form can give every state |
//! | `here:X` | the `gcn` form, fitted on the graph as known with features X |
//! | `carried:X` | the same with weights from the first column, not one epoch on what is asked |
//!
//! Features X: `pvf` (signs fixed by the largest entry), `square` (their squares, which have no sign), `random`,
//! `constant`. Printed are medians over seeds; after error and detour the 95 % interval of the ratio to `heat`.

mod maps;
mod measure;

use eigentrail::features::RandomFeatures;
use eigentrail::gcn::{GcnParameters, GcnParams};
use eigentrail::graph::{StateId, SymmetricCsr};
use eigentrail::seeds::{Stream, stream};
use eigentrail::shaping::{
    HeatPotential, HopsPotential, LearnedTemperaturePotential, LearntModel, PotentialFit,
    ReturnContext, ReturnPotential, ShapingParams, ShortestPathProblem, TransitionMatrix,
};
use eigentrail::spectral::{ProtoValueFunctions, SpectralParams};
use faer::{Mat, MatRef};
use maps::{Family, random_node, with_false_edges, with_missing_edges};
use measure::{Quality, median_interval};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;

type Failure = Box<dyn std::error::Error + Send + Sync>;
/// Quality by (question, arm).
type Results = BTreeMap<(&'static str, String), Quality>;

const FEATURES: [&str; 4] = ["pvf", "square", "random", "constant"];

fn main() -> Result<(), Failure> {
    let seeds: u64 = match std::env::args().nth(1) {
        Some(count) => count.parse()?,
        None => 10,
    };
    for family in Family::ALL {
        let results: Vec<Results> = (1000..1000 + seeds)
            .into_par_iter()
            .map(|seed| one_seed(family, seed))
            .collect::<Result<_, _>>()?;
        print_table(family, &results);
    }
    Ok(())
}

/// A graph with a goal and features.
struct Place {
    graph: SymmetricCsr,
    goal: StateId,
    problem: ShortestPathProblem,
    model: LearntModel,
    /// Of shortest ways.
    returns: Vec<(StateId, f64)>,
}

impl Place {
    fn new(graph: SymmetricCsr, goal: StateId) -> Result<Self, Failure> {
        let problem = ShortestPathProblem::uniform(&TransitionMatrix::undirected(&graph), &[goal]);
        let model = LearntModel::uniform(&graph, &[goal]);
        Ok(Self {
            returns: model.optimal_returns(),
            graph,
            goal,
            problem,
            model,
        })
    }

    fn fit(
        &self,
        potential: &mut dyn ReturnPotential,
        features: MatRef<'_, f64>,
    ) -> Result<PotentialFit, Failure> {
        Ok(potential.fit_to_returns(&ReturnContext {
            model: &self.model,
            adjacency: &self.graph,
            features,
            returns: &self.returns,
        })?)
    }

    fn features(&self, kind: &str, seed: u64) -> Result<Mat<f64>, Failure> {
        let n = self.graph.num_nodes();
        Ok(match kind {
            "random" => {
                let mut random = RandomFeatures::new(16, seed);
                random.grow(n);
                random.features().to_owned()
            }
            "constant" => Mat::full(n, 1, 1.0),
            _ => {
                let mut functions = ProtoValueFunctions::new(SpectralParams::default(), seed);
                functions.refresh(&self.graph)?;
                let x = functions.features().expect("refreshed");
                let square = kind == "square";
                Mat::from_fn(n, x.ncols(), |i, c| {
                    if square { x[(i, c)].powi(2) } else { x[(i, c)] }
                })
            }
        })
    }

    /// Hops to the goal.
    fn distances(&self) -> Vec<f64> {
        let order = self.problem.chain.order();
        let mut distances = vec![0.0; self.graph.num_nodes()];
        for (&state, &d) in order.iter().zip(&self.problem.distances) {
            distances[state as usize] = d;
        }
        distances
    }
}

/// The potential as it is by default, but trained as far as its epochs go, and on weights from elsewhere not at all.
fn gcn(seed: u64) -> LearnedTemperaturePotential {
    let shaping = ShapingParams {
        fit_tolerance: 0.0,
        warm_epochs: 0,
        ..ShapingParams::default()
    };
    LearnedTemperaturePotential::new(shaping, GcnParams::default(), seed)
}

fn heat() -> HeatPotential {
    let defaults = ShapingParams::default();
    HeatPotential {
        kept: defaults.heat_kept,
        scale_factor: defaults.scale_factor,
    }
}

/// One question: φ on `known`, judged on `truth` at `nodes`.
struct Question<'a> {
    name: &'static str,
    known: &'a Place,
    /// Where the features come from: `known`, or an earlier state of it.
    seen: &'a Place,
    truth: &'a Place,
    nodes: &'a [usize],
    seed: u64,
}

impl Question<'_> {
    fn judge(&self, results: &mut Results, arm: &str, phi: &[f64]) {
        let quality = Quality::of(phi, &self.truth.distances(), &self.truth.graph, self.nodes);
        results.insert((self.name, arm.to_owned()), quality);
    }

    fn ask(&self, results: &mut Results, weights: &[(&str, GcnParameters)]) -> Result<(), Failure> {
        let defaults = ShapingParams::default();
        let scale_factor = defaults.scale_factor;
        let none = Mat::zeros(0, 0);
        let heat_at = |temperature: f64| HeatPotential {
            kept: (-1.0 / temperature).exp(),
            scale_factor,
        };
        let mut untrained = heat_at(defaults.temperature);
        let lowest = defaults.temperature * (-defaults.log_temperature_clip).exp();
        let mut coldest = heat_at(lowest);
        let mut hops = HopsPotential { scale_factor };
        let solved: [(&str, &mut dyn ReturnPotential); 4] = [
            ("heat", &mut heat()),
            ("untrained", &mut untrained),
            ("coldest", &mut coldest),
            ("hops", &mut hops),
        ];
        for (arm, model) in solved {
            let fit = self.known.fit(model, none.as_ref())?;
            self.judge(results, arm, &fit.values);
        }
        for (kind, weights) in weights {
            // Nodes without a row get the mean of their older neighbours'.
            let features = self.seen.features(kind, self.seed)?;
            let features = features.as_ref();
            let mut carried = gcn(self.seed).with_parameters(weights.clone())?;
            let fit = self.known.fit(&mut carried, features)?;
            self.judge(results, &format!("carried:{kind}"), &fit.values);
            if self.seen.graph.num_nodes() == self.known.graph.num_nodes() {
                let fit = self.known.fit(&mut gcn(self.seed), features)?;
                self.judge(results, &format!("here:{kind}"), &fit.values);
            }
        }
        Ok(())
    }
}

/// Weights fitted on a place, for each kind of features.
fn fitted(place: &Place, seed: u64) -> Result<Vec<(&'static str, GcnParameters)>, Failure> {
    let fit = |kind| {
        let mut model = gcn(seed);
        place.fit(&mut model, place.features(kind, seed)?.as_ref())?;
        Ok((kind, model.parameters().expect("just fitted").clone()))
    };
    FEATURES.into_iter().map(fit).collect()
}

fn one_seed(family: Family, seed: u64) -> Result<Results, Failure> {
    let mut rng = stream(seed, Stream::Layout);
    let map = family.map(&mut rng);
    let (goal, other_goal) = (
        random_node(map.num_nodes(), &mut rng),
        random_node(map.num_nodes(), &mut rng),
    );
    let source = Place::new(map.clone(), goal)?;
    let weights = fitted(&source, seed)?;
    let mut results = Results::new();

    let same_map = Place::new(map.clone(), other_goal)?;
    ask_everywhere(
        "new-goal",
        &same_map,
        &same_map,
        &weights,
        seed,
        &mut results,
    )?;

    let other = family.map(&mut rng);
    let goal = random_node(other.num_nodes(), &mut rng);
    let partial = Place::new(with_missing_edges(&other, 0.15, &mut rng), goal)?;
    let noisy = Place::new(with_false_edges(&other, 0.02, &mut rng), goal)?;
    let other = Place::new(other, goal)?;
    ask_everywhere("new-map", &other, &other, &weights, seed, &mut results)?;
    ask_everywhere(
        "missing-edges",
        &partial,
        &other,
        &weights,
        seed,
        &mut results,
    )?;
    ask_everywhere("false-edges", &noisy, &other, &weights, seed, &mut results)?;
    ask_new_nodes(&map, seed, &mut rng, &mut results)?;
    Ok(results)
}

fn ask_everywhere(
    name: &'static str,
    known: &Place,
    truth: &Place,
    weights: &[(&'static str, GcnParameters)],
    seed: u64,
    results: &mut Results,
) -> Result<(), Failure> {
    let n = known.graph.num_nodes();
    let nodes: Vec<usize> = (0..n).filter(|&i| i != truth.goal.index()).collect();
    let question = Question {
        name,
        known,
        seen: known,
        truth,
        nodes: &nodes,
        seed,
    };
    question.ask(results, weights)
}

/// Fitted when 80 % of the map were known, asked on the rest.
fn ask_new_nodes(
    map: &SymmetricCsr,
    seed: u64,
    rng: &mut ChaCha8Rng,
    results: &mut Results,
) -> Result<(), Failure> {
    let n = map.num_nodes();
    let old = n * 4 / 5;
    let goal = random_node(old, rng);
    let prefix = eigentrail::graph::Adjacency::from_csr(map).prefix_csr(old);
    let before = Place::new(prefix, goal)?;
    let now = Place::new(map.clone(), goal)?;
    let nodes: Vec<usize> = (old..n).collect();
    let question = Question {
        name: "new-nodes",
        known: &now,
        seen: &before,
        truth: &now,
        nodes: &nodes,
        seed,
    };
    let heat = before.fit(&mut heat(), Mat::zeros(0, 0).as_ref())?;
    question.judge(results, "inherit", &inherited(heat.values, map));
    question.ask(results, &fitted(&before, seed)?)
}

/// φ of a new node is φ of the node it was discovered from.
fn inherited(mut phi: Vec<f64>, map: &SymmetricCsr) -> Vec<f64> {
    for i in phi.len()..map.num_nodes() {
        let parent = map.row(i).0[0] as usize;
        phi.push(phi[parent]);
    }
    phi
}

fn print_table(family: Family, results: &[Results]) {
    let mut rng = stream(0, Stream::Bootstrap);
    println!("\n{family:?}, {} seeds", results.len());
    println!(
        "| question | arm | error | ÷ heat | rank | detour | ÷ heat |\n|---|---|---|---|---|---|---|"
    );
    for (question, arm) in results[0].keys() {
        let pick = |arm: &str, part: fn(&Quality) -> f64| -> Vec<f64> {
            let key = (*question, arm.to_owned());
            results.iter().map(|r| part(&r[&key])).collect()
        };
        let mut cell = |part: fn(&Quality) -> f64| {
            let (own, heat) = (pick(arm, part), pick("heat", part));
            let ratios: Vec<f64> = own.iter().zip(&heat).map(|(a, b)| a / b).collect();
            (
                median_interval(&own, &mut rng)[0],
                median_interval(&ratios, &mut rng),
            )
        };
        let (error, e) = cell(|q| q.error);
        let (detour, d) = cell(|q| q.detour);
        let (rank, _) = cell(|q| q.rank);
        println!(
            "| {question} | {arm} | {error:.3} | {:.2} [{:.2}, {:.2}] | {rank:.4} | {detour:.3} | {:.2} [{:.2}, {:.2}] |",
            e[0], e[1], e[2], d[0], d[1], d[2]
        );
    }
}
