//! Random sequences of everything that may happen to a pipeline, on random worlds: steps, refreshes, fits, goals that move, saving and
//! loading, other numbers of threads.
//!
//! After each operation the pipeline is held against
//! - a second one, loaded from what the first had saved and led the same way in a pool of threads of another size: equal to the last bit;
//! - a map of the pairs of states that were seen beside each other, kept here;
//! - whenever its spectrum is new: a dense solver that shares no code with ours, residuals and orthonormality, and a spectrum that
//!   was computed from nothing.
//!
//! `EIGENTRAIL_SIMULATE=1000000 cargo test --test library simulator -- --nocapture` goes on for so many operations;
//! `EIGENTRAIL_SIMULATE_SEED=7` plays the sequence of one seed.

use eigentrail::engine::{Observed, PipelineParams, ShapingPipeline};
use eigentrail::env::{Action, Step, StepStatus};
use eigentrail::faer::Mat;
use eigentrail::graph::StateId;
use eigentrail::spectral::{GrowingEigensolver, LaplacianKind, SpectralParams};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

type Pipeline = ShapingPipeline<u32>;

/// Operations that the test makes in all, and in each sequence at most.
const OPERATIONS: u64 = 40_000;
const PER_SEQUENCE: u64 = 2_000;

/// A world of numbered states: where each action leads, with equal chances, what a step pays, and which states end an episode.
struct World {
    ways: Vec<Vec<Vec<u32>>>,
    costs: f64,
    goals: BTreeMap<u32, f64>,
    limit: u32,
}

impl World {
    fn random(rng: &mut ChaCha8Rng) -> Self {
        let states: u32 = match rng.random_range(0..40) {
            0 => rng.random_range(330..420), // where the sparse solver is
            _ => rng.random_range(2..40),
        };
        let actions = rng.random_range(1..5);
        let far = rng.random_bool(0.3);
        let slips = rng.random_bool(0.3);
        let mut near = |state: u32| match far {
            true => rng.random_range(0..states),
            false => (state + rng.random_range(0..4) + states - 1) % states,
        };
        let mut ways = vec![vec![Vec::new(); actions]; states as usize];
        for state in 0..states {
            for ends in &mut ways[state as usize] {
                *ends = (0..if slips { 2 } else { 1 })
                    .map(|_| near(state))
                    .collect();
            }
        }
        let mut world = Self {
            ways,
            costs: [0.0, 1.0][rng.random_range(0..2)],
            goals: BTreeMap::new(),
            limit: rng.random_range(2..200),
        };
        world.move_goals(rng);
        world
    }

    fn move_goals(&mut self, rng: &mut ChaCha8Rng) {
        let states = self.ways.len() as u32;
        let count = rng.random_range(0..3);
        let rewards = [1.0, 10.0, -5.0];
        self.goals = (0..count)
            .map(|_| (rng.random_range(0..states), rewards[rng.random_range(0..3)]))
            .collect();
    }

    fn step(&self, from: u32, action: usize, age: u32, rng: &mut ChaCha8Rng) -> Step<u32> {
        let ends = &self.ways[from as usize][action];
        let state = ends[rng.random_range(0..ends.len())];
        let (reward, status) = match self.goals.get(&state) {
            Some(&reward) => (reward, StepStatus::Terminated),
            None if age + 1 >= self.limit => (-self.costs, StepStatus::Truncated),
            None => (-self.costs, StepStatus::Running),
        };
        Step {
            state,
            reward,
            status,
        }
    }
}

/// What was checked.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    operations: u64,
    spectra: u64,
    loads: u64,
    fits: u64,
}

struct Simulation {
    world: World,
    params: PipelineParams,
    first: Pipeline,
    second: Pipeline,
    /// Threads of the second.
    threads: usize,
    /// Pairs of numbers of states that were seen beside each other.
    seen: BTreeSet<(u32, u32)>,
    numbers: BTreeMap<u32, u32>,
    at: Option<(u32, u32)>,
    rng: ChaCha8Rng,
    counts: Counts,
}

impl Simulation {
    fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let world = World::random(&mut rng);
        let params = params(&mut rng);
        let first = Pipeline::new(&params, world.ways[0].len(), None, seed).unwrap();
        Self {
            world,
            params,
            second: first.clone(),
            first,
            threads: 2,
            seen: BTreeSet::new(),
            numbers: BTreeMap::new(),
            at: None,
            rng,
            counts: Counts::default(),
        }
    }

    fn play(mut self, operations: u64) -> Result<Counts, String> {
        for _ in 0..operations {
            self.counts.operations += 1;
            match self.rng.random_range(0..200) {
                0..2 => self.refresh(Pipeline::refresh)?,
                2..4 => self.refresh(Pipeline::fit)?,
                4 => self.world.move_goals(&mut self.rng),
                5..8 => self.load()?,
                8..10 => self.threads = self.rng.random_range(1..4),
                _ => self.grow()?,
            }
            self.compare()?;
        }
        Ok(self.counts)
    }

    /// One step of the walker, or the start of its next episode.
    fn grow(&mut self) -> Result<(), String> {
        let Some((from, age)) = self.at else {
            let start = match self.rng.random_bool(0.9) {
                true => 0,
                false => self.rng.random_range(0..self.world.ways.len() as u32),
            };
            let numbers = [&mut self.first, &mut self.second].map(|p| p.begin_episode(&start));
            self.meet(start, numbers[0])?;
            self.at = Some((start, 0));
            return Ok(());
        };
        let action = match self.rng.random_bool(0.7) {
            true => best(self.first.advice()),
            false => self.rng.random_range(0..self.world.ways[0].len()),
        };
        let step = self.world.step(from, action, age, &mut self.rng);
        let [first, second] = self.both(|pipeline| observe(pipeline, action, &step));
        let (first, second) = (first?, second?);
        require(same(&first, &second), || {
            format!("{first:?} and {second:?} were observed")
        })?;
        require(
            first.new_state != self.numbers.contains_key(&step.state),
            || "a new state is none".into(),
        )?;
        self.meet(step.state, first.state)?;
        let (a, b) = (self.numbers[&from], self.numbers[&step.state]);
        if a != b {
            self.seen.insert((a.min(b), a.max(b)));
        }
        self.at = (step.status == StepStatus::Running).then_some((step.state, age + 1));
        if let Some(refresh) = &first.refresh {
            self.counts.fits += u64::from(refresh.fit.is_some());
            if refresh.spectrum.is_some() {
                self.spectrum()?;
            }
        }
        Ok(())
    }

    /// States are numbered as they are met.
    fn meet(&mut self, state: u32, number: StateId) -> Result<(), String> {
        let next = self.numbers.len() as u32;
        let right = *self.numbers.entry(state).or_insert(next);
        require(number.0 == right, || {
            format!("state {state} is {number:?} and not {right}")
        })
    }

    fn refresh(
        &mut self,
        what: impl Fn(&mut Pipeline) -> Result<bool, String> + Sync,
    ) -> Result<(), String> {
        let [first, second] = self.both(&what);
        require(first == second, || format!("{first:?} and {second:?}"))?;
        match first? {
            true => self.spectrum(),
            false => Ok(()),
        }
    }

    /// The second goes on from what the first has saved.
    fn load(&mut self) -> Result<(), String> {
        self.counts.loads += 1;
        self.second =
            postcard::from_bytes(&saved(&self.first)).map_err(|error| error.to_string())?;
        Ok(())
    }

    /// The same done to both.
    fn both<T: Send>(&mut self, what: impl Fn(&mut Pipeline) -> T + Sync) -> [T; 2] {
        let pool = &POOLS.with(|pools| pools[self.threads].clone());
        let first = what(&mut self.first);
        let second = &mut self.second;
        [first, pool.install(|| what(second))]
    }

    fn compare(&self) -> Result<(), String> {
        let [first, second] = [&self.first, &self.second];
        let bits = |values: &[f64]| {
            values
                .iter()
                .map(|value| value.to_bits())
                .collect::<Vec<_>>()
        };
        let phi = [first, second].map(|pipeline| bits(pipeline.potential().values()));
        require(phi[0] == phi[1], || "φ differs".into())?;
        require(
            first
                .potential()
                .values()
                .iter()
                .all(|value| value.is_finite()),
            || "φ is not finite".into(),
        )?;
        if self.at.is_some() {
            require(bits(first.advice()) == bits(second.advice()), || {
                "advice differs".into()
            })?;
        }
        let graph = first.transitions();
        let edges = graph.adjacency().num_edges();
        require(graph.num_states() == self.numbers.len(), || {
            "states are missing".into()
        })?;
        require(edges == self.seen.len(), || {
            format!("{edges} edges instead of {}", self.seen.len())
        })?;
        if self.counts.operations.is_multiple_of(64) {
            require(saved(first) == saved(second), || {
                "what is saved differs".into()
            })?;
            let adjacency = graph.adjacency();
            for row in 0..adjacency.num_nodes() as u32 {
                let there: Vec<u32> = adjacency.neighbors(row).to_vec();
                let pairs = self.seen.iter().filter(|&&(a, b)| a == row || b == row);
                let mut right: Vec<u32> =
                    pairs.map(|&(a, b)| if a == row { b } else { a }).collect();
                right.sort_unstable();
                require(there == right, || {
                    format!("state {row} is beside {there:?} and not {right:?}")
                })?;
            }
        }
        Ok(())
    }

    /// The spectrum, which is of the present graph, against a dense solver and against one from nothing.
    fn spectrum(&mut self) -> Result<(), String> {
        let Some(pairs) = self.first.spectrum().eigenpairs() else {
            return Ok(());
        };
        self.counts.spectra += 1;
        let params = &self.params.spectral;
        let (n, k) = pairs.vectors.shape();
        require(
            n == self.numbers.len() && k == params.num_eigenpairs.min(n),
            || format!("{n} × {k}"),
        )?;
        let laplacian = laplacian(n, &self.seen, params.laplacian);
        let exact = dense_values(&laplacian);
        let norm = exact[n - 1].max(1.0);
        let unit = exact[k - 1].max(1e-13 * norm);
        let cold = {
            let adjacency = self.first.transitions().adjacency().to_csr();
            let mut cold = GrowingEigensolver::new(params.clone(), self.counts.spectra);
            cold.refresh(&adjacency)
                .map_err(|error| error.to_string())?;
            cold.into_eigenpairs().expect("they were computed")
        };
        let allowed = params.tol * params.tol * unit + 1e-12 * norm;
        for (j, &right) in exact.iter().take(k).enumerate() {
            for (how, value) in [("warm", pairs.values[j]), ("cold", cold.values[j])] {
                require((value - right).abs() <= allowed, || {
                    format!("{how} λ_{} is {value:e} and not {right:e}", j + 1)
                })?;
            }
        }
        let v = &pairs.vectors;
        let gram = (v.transpose() * v - Mat::<f64>::identity(k, k)).norm_max();
        require(gram <= 1e-10, || format!("VᵀV − I = {gram:e}"))?;
        let product = &laplacian * v;
        for (j, &value) in pairs.values.iter().enumerate() {
            let residual = (0..n)
                .map(|i| (product[(i, j)] - value * v[(i, j)]).powi(2))
                .sum::<f64>()
                .sqrt();
            require(residual <= params.tol * unit + 1e-11 * norm, || {
                format!("residual {} is {residual:e}", j + 1)
            })?;
        }
        Ok(())
    }
}

/// What simulations ask of a pipeline beside steps; whether the spectrum is new.
trait Renewed {
    fn refresh(&mut self) -> Result<bool, String>;
    fn fit(&mut self) -> Result<bool, String>;
}

impl Renewed for Pipeline {
    fn refresh(&mut self) -> Result<bool, String> {
        let record = self.world_mut().refresh_features();
        let record = record.map_err(|error| error.to_string())?;
        Ok(record.is_some_and(|record| record.spectrum.is_some()))
    }

    fn fit(&mut self) -> Result<bool, String> {
        let record = self
            .world_mut()
            .refit()
            .map_err(|error| error.to_string())?;
        Ok(record.is_some_and(|record| record.spectrum.is_some()))
    }
}

thread_local! {
    /// Of so many threads.
    static POOLS: [std::sync::Arc<rayon::ThreadPool>; 4] = std::array::from_fn(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        std::sync::Arc::new(pool.unwrap())
    });
}

fn params(rng: &mut ChaCha8Rng) -> PipelineParams {
    let mut params = PipelineParams {
        spectral: SpectralParams {
            num_eigenpairs: [1, 3, 8, 16][rng.random_range(0..4)],
            tol: [1e-2, 1e-4][rng.random_range(0..2)],
            laplacian: [LaplacianKind::Normalized, LaplacianKind::Combinatorial]
                [rng.random_range(0..2)],
            threads: rng.random_range(1..3),
            certify: true,
            ..SpectralParams::default()
        },
        gamma: [1.0, 0.9][rng.random_range(0..2)],
        ..PipelineParams::default()
    };
    params.gcn.epochs = 20;
    params
}

fn observe(pipeline: &mut Pipeline, action: usize, step: &Step<u32>) -> Result<Observed, String> {
    let observed = pipeline.observe(Action(action as u16), step);
    observed.map_err(|error| error.to_string())
}

fn same(a: &Observed, b: &Observed) -> bool {
    let parts = |o: &Observed| {
        let spectrum = o
            .refresh
            .as_ref()
            .map(|r| (r.spectrum.is_some(), r.fit.is_some()));
        (
            o.state,
            o.shaping.to_bits(),
            o.bonus.to_bits(),
            o.new_state,
            o.first_goal,
            o.lost_goal,
            spectrum,
        )
    };
    parts(a) == parts(b)
}

fn best(advice: &[f64]) -> usize {
    (0..advice.len())
        .max_by(|&a, &b| advice[a].total_cmp(&advice[b]))
        .unwrap_or(0)
}

fn saved(pipeline: &Pipeline) -> Vec<u8> {
    postcard::to_stdvec(pipeline).unwrap()
}

/// The matrix of the pairs by its definition.
fn laplacian(n: usize, pairs: &BTreeSet<(u32, u32)>, kind: LaplacianKind) -> Mat<f64> {
    let mut degrees = vec![0.0; n];
    for &(a, b) in pairs {
        degrees[a as usize] += 1.0;
        degrees[b as usize] += 1.0;
    }
    let mut matrix = Mat::zeros(n, n);
    for (i, &degree) in degrees.iter().enumerate() {
        matrix[(i, i)] = match kind {
            LaplacianKind::Combinatorial => degree,
            LaplacianKind::Normalized => f64::from(u8::from(degree > 0.0)),
        };
    }
    for &(a, b) in pairs {
        let (a, b) = (a as usize, b as usize);
        let weight = match kind {
            LaplacianKind::Combinatorial => -1.0,
            LaplacianKind::Normalized => -1.0 / f64::sqrt(degrees[a] * degrees[b]),
        };
        (matrix[(a, b)], matrix[(b, a)]) = (weight, weight);
    }
    matrix
}

/// All eigenvalues, ascending. nalgebra's are not numbers for some matrices of little else than zeros: then faer's.
fn dense_values(dense: &Mat<f64>) -> Vec<f64> {
    let n = dense.nrows();
    let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| dense[(i, j)]);
    let mut values = matrix.symmetric_eigenvalues().as_slice().to_vec();
    if values.iter().any(|value| value.is_nan()) {
        values = dense
            .self_adjoint_eigenvalues(eigentrail::faer::Side::Lower)
            .unwrap();
    }
    values.sort_by(f64::total_cmp);
    values
}

fn require(holds: bool, fault: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(fault()) }
}

/// Of each kind, in all.
fn sum(counts: impl Iterator<Item = Counts>) -> Counts {
    counts.fold(Counts::default(), |a, b| Counts {
        operations: a.operations + b.operations,
        spectra: a.spectra + b.spectra,
        loads: a.loads + b.loads,
        fits: a.fits + b.fits,
    })
}

/// Each seed's sequence, on as many threads as there are processors. Not on rayon's: whoever waits there for another pool takes up
/// the next sequence meanwhile, and so on.
fn played(seeds: &[u64]) -> Vec<Result<Counts, String>> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let next = AtomicUsize::new(0);
    let one = || {
        let mut outcomes = Vec::new();
        while let Some(&seed) = seeds.get(next.fetch_add(1, Ordering::Relaxed)) {
            let played = Simulation::new(seed).play(PER_SEQUENCE);
            outcomes.push(played.map_err(|fault| {
                format!(
                    "EIGENTRAIL_SIMULATE_SEED={seed} cargo test --test library simulator: {fault}"
                )
            }));
        }
        outcomes
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(one)).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap())
            .collect()
    })
}

#[test]
fn whatever_happens_in_whatever_order_the_paths_agree() {
    let number = |name| {
        std::env::var(name)
            .ok()
            .map(|text: String| text.parse::<u64>().unwrap())
    };
    let seeds: Vec<u64> = match number("EIGENTRAIL_SIMULATE_SEED") {
        Some(seed) => vec![seed],
        None => (0..number("EIGENTRAIL_SIMULATE")
            .unwrap_or(OPERATIONS)
            .div_ceil(PER_SEQUENCE))
            .collect(),
    };
    let outcomes = played(&seeds);
    let faults: Vec<&String> = outcomes
        .iter()
        .filter_map(|outcome| outcome.as_ref().err())
        .collect();
    assert!(
        faults.is_empty(),
        "{} sequences went wrong, the first ones:\n{}",
        faults.len(),
        faults
            .iter()
            .take(10)
            .map(|f| f.as_str())
            .collect::<Vec<_>>()
            .join("\n")
    );
    let counts = sum(outcomes
        .iter()
        .filter_map(|outcome| outcome.as_ref().ok().copied()));
    println!("{counts:?}");
    assert!(
        number("EIGENTRAIL_SIMULATE_SEED").is_some()
            || counts.spectra > 0 && counts.fits > 0 && counts.loads > 0
    );
}
