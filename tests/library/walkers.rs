//! Several walkers on one model of the world, and errors in the middle of a step.

use crate::env_worlds::grid_world;
use eigentrail::engine::{PipelineError, PipelineParams, ShapingPipeline, Walker, WorldModel};
use eigentrail::env::{
    Action, Cell, Environment, GridWorld, GridWorldParams, Landmark, Layout, Step, StepStatus,
};
use eigentrail::graph::StateId;
use eigentrail::shaping::Potential;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, BTreeSet, HashMap};

fn open(side: usize, seed: u64) -> GridWorld {
    let layout = Layout::open(side, side)
        .and_then(|map| map.with_start(Landmark::TopLeft))
        .and_then(|map| map.with_goal(Landmark::BottomRight, None));
    let params = GridWorldParams {
        max_steps: Some(60),
        ..Default::default()
    };
    grid_world(&layout.unwrap(), &params, seed)
}

/// The best advised action, at random among equals.
fn advised(advice: &[f64], rng: &mut ChaCha8Rng) -> Action {
    let best = advice.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let equals: Vec<_> = (0..advice.len()).filter(|&a| advice[a] == best).collect();
    Action(equals[rng.random_range(0..equals.len())] as u16)
}

/// Of walkers that do nothing but follow advice.
fn params() -> PipelineParams {
    let mut params = PipelineParams::default();
    params.exploration.potential_advice = 20.0;
    params
}

/// Walkers that take turns, each in its own copy of the world.
struct Team {
    world: WorldModel<Cell>,
    members: Vec<(GridWorld, Walker)>,
    rng: ChaCha8Rng,
}

impl Team {
    fn new(size: u32, side: usize, seed: u64) -> Self {
        let world = WorldModel::new(&params(), 4, None, seed).unwrap();
        let members = (0..size)
            .map(|i| (open(side, seed + u64::from(i)), Walker::new(&world, i)))
            .collect();
        Self {
            world,
            members,
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// One step of member `i`: where it stood, what it did, what came, and F.
    fn step(&mut self, i: usize) -> (Cell, Action, Step<Cell>, f64) {
        let (env, walker) = &mut self.members[i];
        if !walker.is_in_episode() {
            walker.begin_episode(&mut self.world, &env.reset());
        }
        let from = *self.world.graph().state(walker.state());
        let action = match self.rng.random_bool(0.2) {
            true => Action(self.rng.random_range(0..4)),
            false => advised(walker.advice(), &mut self.rng),
        };
        let step = env.step(action);
        let seen = walker.observe(&mut self.world, action, &step).unwrap();
        assert_eq!(self.world.graph().state(seen.state), &step.state);
        (from, action, step, seen.shaping)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The shared graph holds each walker's steps, and nothing else; what each was paid telescopes over its own episodes,
    /// whatever the others did to φ meanwhile.
    #[test]
    fn a_shared_model_holds_what_all_of_them_did(size in 1u32..5, side in 3usize..7, seed in any::<u32>()) {
        let mut team = Team::new(size, side, u64::from(seed));
        let mut counts: BTreeMap<(Cell, Action, Cell), u32> = BTreeMap::new();
        let mut paid = vec![0.0; size as usize];
        for turn in 0..600 {
            let i = turn % size as usize;
            let begins = !team.members[i].1.is_in_episode();
            let (from, action, step, shaping) = team.step(i);
            *counts.entry((from, action, step.state)).or_default() += 1;
            if begins {
                // γ = 1: the sum over an episode that terminates is −φ(s_0), whatever φ(s_0) was on entering.
                paid[i] = 0.0;
            }
            paid[i] += shaping;
        }
        let graph = team.world.graph();
        let mut found = BTreeMap::new();
        for s in 0..graph.num_states() as u32 {
            for outcome in graph.transitions().outcomes(StateId(s)) {
                let key = (*graph.state(StateId(s)), outcome.action, *graph.state(outcome.next));
                found.insert(key, outcome.count);
            }
        }
        prop_assert_eq!(found, counts);
        prop_assert_eq!(team.world.steps(), 600);
        graph.assert_consistent();
    }

    /// One walker on a model is the pipeline.
    #[test]
    fn one_walker_is_the_pipeline(side in 3usize..6, seed in any::<u32>()) {
        let seed = u64::from(seed);
        let mut team = Team::new(1, side, seed);
        let mut pipeline = ShapingPipeline::new(&params(), 4, None, seed).unwrap();
        let mut in_episode = false;
        for _ in 0..400 {
            let (from, action, step, shaping) = team.step(0);
            if !in_episode {
                pipeline.begin_episode(&from);
            }
            let seen = pipeline.observe(action, &step).unwrap();
            prop_assert_eq!(seen.shaping.to_bits(), shaping.to_bits());
            prop_assert_eq!(pipeline.advice(), team.members[0].1.advice());
            in_episode = !step.status.is_last();
        }
        prop_assert_eq!(pipeline.potential(), team.world.potential());
    }
}

#[test]
fn rewards_of_every_walker_telescope_over_its_own_episodes() {
    let mut team = Team::new(3, 6, 5);
    let mut entered: Vec<f64> = vec![0.0; 3];
    let mut sums = [0.0; 3];
    let mut episodes = 0;
    for turn in 0..3000 {
        let i = turn % 3;
        if !team.members[i].1.is_in_episode() {
            let start = *team.members[i].0.layout().start.as_ref().unwrap();
            let known = team.world.graph().id(&start);
            entered[i] = known.map_or(0.0, |state| team.world.potential().value(state));
            sums[i] = 0.0;
        }
        let (_, _, step, shaping) = team.step(i);
        sums[i] += shaping;
        if step.status == StepStatus::Terminated {
            episodes += 1;
            assert!(
                (sums[i] + entered[i]).abs() < 1e-9,
                "{} of {}",
                sums[i],
                entered[i]
            );
        }
    }
    assert!(episodes > 50, "{episodes}");
}

#[test]
fn what_one_walker_finds_the_others_know() {
    let mut team = Team::new(2, 6, 1);
    while team.world.goals().is_empty() {
        team.step(0);
    }
    let (env, walker) = &mut team.members[1];
    walker.begin_episode(&mut team.world, &env.reset());
    let mut length = 0;
    loop {
        let action = advised(walker.advice(), &mut team.rng);
        let step = env.step(action);
        walker.observe(&mut team.world, action, &step).unwrap();
        length += 1;
        if step.status.is_last() {
            assert_eq!(step.status, StepStatus::Terminated);
            break;
        }
    }
    assert!(
        length <= 40,
        "its first episode took {length} steps of at least 10"
    );
}

#[test]
fn walkers_of_one_model_draw_from_streams_of_their_own() {
    let mut team = Team::new(4, 12, 0);
    let first_places: BTreeSet<Vec<Cell>> = (0..4)
        .map(|i| {
            let mut alone = Team::new(4, 12, 0);
            (0..30).map(|_| alone.step(i).2.state).collect()
        })
        .collect();
    assert!(first_places.len() > 1, "all four walk the same way");
    team.step(0);
}

fn step(state: u32, reward: f64, status: StepStatus) -> Step<u32> {
    Step {
        state,
        reward,
        status,
    }
}

/// Rewards that are numbers, but whose sums are not, make the next fit fail: in the middle of an episode.
#[test]
fn an_error_in_the_middle_of_a_step_leaves_nothing_half_done() {
    let mut pipeline = ShapingPipeline::new(&PipelineParams::default(), 2, None, 0).unwrap();
    let on = |state, reward| step(state, reward, StepStatus::Running);
    pipeline.begin_episode(&0);
    pipeline.observe(Action(0), &on(1, -1.0)).unwrap();
    let end = step(2, 0.0, StepStatus::Terminated);
    pipeline.observe(Action(0), &end).unwrap();
    let mut before = pipeline.potential().clone();

    let mut recorded: HashMap<(u32, u16, u32), u32> = HashMap::new();
    pipeline.begin_episode(&0);
    let mut at = 0;
    let mut failed = None;
    for next in 3..40 {
        before = pipeline.potential().clone();
        let seen = pipeline.observe(Action(1), &on(next, -f64::MAX / 2.0));
        *recorded.entry((at, 1, next)).or_default() += 1;
        at = next;
        if let Err(error) = seen {
            failed = Some(error);
            break;
        }
    }
    let error = failed.expect("the sums of the rewards are no numbers");
    assert!(matches!(error, PipelineError::Shaping(_)), "{error}");
    assert!(!pipeline.walker().is_in_episode());
    // Whoever does not listen and goes on is told so, and no edge is made of it.
    let nodes = pipeline.graph().num_states();
    let ignored = pipeline.observe(Action(0), &on(99, -1.0)).unwrap_err();
    assert!(
        matches!(ignored, PipelineError::NoEpisode { .. }),
        "{ignored}"
    );
    assert_eq!(pipeline.graph().num_states(), nodes);
    assert!(pipeline.graph().id(&99).is_none());
    for (s, value) in before.values().iter().enumerate() {
        let kept = pipeline.potential().value(StateId(s as u32));
        assert_eq!(kept.to_bits(), value.to_bits(), "φ is as it was");
    }
    // The next episode begins where it begins: every edge in the graph was walked.
    pipeline.begin_episode(&0);
    let graph = pipeline.graph();
    for ((from, action, to), count) in recorded {
        let [from, to] = [from, to].map(|state| graph.id(&state).unwrap());
        let mut outcomes = graph.transitions().outcomes(from);
        let outcome = outcomes.find(|o| o.action == Action(action) && o.next == to);
        assert_eq!(outcome.map(|o| o.count), Some(count));
    }
    let edges = graph.transitions().adjacency().num_edges();
    assert_eq!(edges, nodes - 1, "a path and nothing else");
}

#[test]
fn refreshes_and_fits_can_be_asked_for() {
    let mut team = Team::new(1, 5, 3);
    let nothing = team.world.refit().unwrap();
    assert!(nothing.is_none(), "there is nothing to fit anything on");
    while team.world.goals().is_empty() {
        team.step(0);
    }
    let features = team.world.refresh_features().unwrap();
    let features = features.expect("the potential uses features");
    assert!(features.spectrum.is_some() && features.fit.is_none());
    let fitted = team.world.refit().unwrap().expect("a goal is known");
    assert!(fitted.spectrum.is_some() && fitted.fit.is_some());
    let pairs = team.world.spectrum().eigenpairs().unwrap();
    let states = team.world.transitions().num_states();
    assert_eq!(pairs.vectors.nrows(), states);
    assert_eq!(team.world.potential().len(), states);
}
