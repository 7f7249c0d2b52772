//! The loop, and the pipeline without the loop.

use crate::env_worlds::grid_world;
use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, Experience, FeatureKind, RandomAgent, Situation,
    UpdateInfo, build_agent,
};
use eigentrail::engine::{
    Engine, EpisodeRecord, PipelineError, PipelineParams, RefreshRecord, ShapingPipeline,
};
use eigentrail::env::layouts::{Cell, GoalCell};
use eigentrail::env::{
    Action, Environment, GridWorld, GridWorldParams, Landmark, Layout, Model, Step, StepStatus,
};
use eigentrail::exploration::{ExplorationKind, ExplorationParams};
use eigentrail::graph::StateId;
use eigentrail::shaping::{Potential, PotentialKind, ShapingParams};

fn open(side: usize) -> GridWorld {
    let layout = Layout::open(side, side)
        .and_then(|map| map.with_start(Landmark::TopLeft))
        .and_then(|map| map.with_goal(Landmark::BottomRight, None));
    grid_world(&layout.unwrap(), &GridWorldParams::default(), 0)
}

fn params(potential: PotentialKind, exploration: ExplorationKind) -> PipelineParams {
    PipelineParams {
        shaping: ShapingParams {
            potential,
            ..Default::default()
        },
        exploration: ExplorationParams {
            kind: exploration,
            ..Default::default()
        },
        gamma: 1.0,
        ..Default::default()
    }
}

fn agent(seed: u64) -> AnyAgent {
    build_agent(&AgentParams::default(), 4, 1.0, seed)
}

fn engine(world: GridWorld, params: &PipelineParams, seed: u64) -> Engine<GridWorld, AnyAgent> {
    Engine::new(
        world,
        ShapingPipeline::new(params, 4, None, seed).unwrap(),
        agent(seed),
    )
}

fn run(engine: &mut Engine<GridWorld, AnyAgent>, episodes: usize) -> Vec<EpisodeRecord> {
    (0..episodes)
        .map(|_| engine.run_episode(|_, _| ()).unwrap())
        .collect()
}

/// Acts like an agent and writes down what it is told.
struct Recorder {
    inner: AnyAgent,
    seen: Vec<(Action, f64, StepStatus)>,
}

impl Agent for Recorder {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.inner.select_action(situation)
    }

    fn update(&mut self, experience: &Experience<'_>) -> eigentrail::agent::UpdateInfo {
        let Experience {
            action,
            shaping,
            status,
            ..
        } = *experience;
        self.seen.push((action, shaping, status));
        self.inner.update(experience)
    }
}

#[test]
fn the_pipeline_alone_shapes_as_it_does_inside_the_engine() {
    let params = params(PotentialKind::Gcn, ExplorationKind::Frontier);
    let recorder = Recorder {
        inner: agent(5),
        seen: Vec::new(),
    };
    let pipeline = ShapingPipeline::new(&params, 4, None, 5).unwrap();
    let mut engine = Engine::new(open(7), pipeline, recorder);
    for _ in 0..15 {
        engine.run_episode(|_, _| ()).unwrap();
    }

    let mut alone = ShapingPipeline::new(&params, 4, None, 5).unwrap();
    let mut world = open(7);
    let mut begun = false;
    for &(action, shaping, status) in &engine.agent().seen {
        if !begun {
            alone.begin_episode(&world.reset());
        }
        let step = world.step(action);
        assert_eq!(step.status, status);
        let seen = alone.observe(action, &step).unwrap();
        assert_eq!(seen.shaping.to_bits(), shaping.to_bits());
        begun = !status.is_last();
    }
    assert_eq!(alone.potential(), engine.pipeline().potential());
    assert!(engine.agent().seen.iter().any(|seen| seen.1 != 0.0));
}

/// Compares what an agent is told of states with the potentials that it is given.
struct Listener {
    inner: AnyAgent,
    known: usize,
    fits: usize,
}

impl Agent for Listener {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.inner.select_action(situation)
    }

    fn update(&mut self, experience: &Experience<'_>) -> eigentrail::agent::UpdateInfo {
        self.known = self.known.max(experience.next.state.index() + 1);
        self.inner.update(experience)
    }

    fn set_potential(&mut self, potential: &[f64]) {
        assert_eq!(potential.len(), self.known, "φ of states it has heard of");
        self.fits += 1;
        self.inner.set_potential(potential);
    }
}

/// Or else φ of a state found in the step of a fit would be lost on the agent, and values would begin at φ without the end that it is about.
#[test]
fn an_agent_hears_of_a_step_before_the_potential_that_was_fitted_on_it() {
    let params = params(PotentialKind::Gcn, ExplorationKind::Frontier);
    let listener = Listener {
        inner: agent(5),
        known: 1,
        fits: 0,
    };
    let pipeline = ShapingPipeline::new(&params, 4, None, 5).unwrap();
    let mut engine = Engine::new(open(7), pipeline, listener);
    for _ in 0..15 {
        engine.run_episode(|_, _| ()).unwrap();
    }
    assert!(engine.agent().fits > 3);
}

/// Σ F over an episode is φ_T(s_T) − φ_0(s_0) (γ = 1), φ being re-fitted on the way; and 0 − φ_0(s_0) at a goal.
#[test]
fn shaping_telescopes_over_episodes_with_fits_in_between() {
    let layout = Layout::open(12, 12)
        .and_then(|map| map.with_start(Landmark::TopLeft))
        .and_then(|map| map.with_goal([6, 2], None))
        .unwrap();
    let limited = GridWorldParams {
        max_steps: Some(300),
        ..Default::default()
    };
    for potential in [
        PotentialKind::Gcn,
        PotentialKind::Heat,
        PotentialKind::Hops,
        PotentialKind::Report,
    ] {
        let mut world = grid_world(&layout, &limited, 0);
        let params = params(potential, ExplorationKind::None);
        let mut pipeline = ShapingPipeline::new(&params, 4, None, 1).unwrap();
        // It wanders, so that there is something new in the middle of episodes, and some of them are cut off.
        let mut agent = RandomAgent::new(4, 1);
        let (mut fits, mut truncated, mut terminated) = (0, 0, 0);
        for _ in 0..40 {
            let mut state = pipeline.begin_episode(&world.reset());
            let first = pipeline.potential().value(state);
            let mut sum = 0.0;
            let status = loop {
                let advice = pipeline.advice();
                let action = agent.select_action(Situation { state, advice });
                let step = world.step(action);
                let seen = pipeline.observe(action, &step).unwrap();
                sum += seen.shaping;
                state = seen.state;
                if step.status.is_last() {
                    break step.status;
                }
                fits += u32::from(seen.refresh.is_some_and(|refresh| refresh.fit.is_some()));
            };
            let last = match status {
                StepStatus::Terminated => 0.0,
                _ => pipeline.potential().value(state),
            };
            let expected = last - first;
            assert!(
                (sum - expected).abs() < 1e-9,
                "{potential:?}: {sum} for {last} − {first}"
            );
            truncated += u32::from(status == StepStatus::Truncated);
            terminated += u32::from(status == StepStatus::Terminated);
        }
        let all = [fits, truncated, terminated];
        assert!(all.iter().all(|&n| n > 0), "{potential:?}: {all:?}");
    }
}

/// Everything a run leaves behind, bit for bit.
fn fingerprint(seed: u64) -> (Vec<EpisodeRecord>, Vec<u64>) {
    let params = params(PotentialKind::Gcn, ExplorationKind::Frontier);
    let mut engine = engine(open(9), &params, seed);
    let records = run(&mut engine, 30);
    let phi = engine.pipeline().potential().values();
    (records, phi.iter().map(|v| v.to_bits()).collect())
}

#[test]
fn equal_seeds_give_equal_runs_at_any_number_of_threads() {
    let threads = |n| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n)
            .build()
            .unwrap()
    };
    let one = threads(1).install(|| fingerprint(3));
    assert_eq!(one, threads(1).install(|| fingerprint(3)));
    assert_eq!(one, threads(4).install(|| fingerprint(3)));
    assert_ne!(one, fingerprint(4), "the seed is not ignored");
}

/// ρ(T) = T R* − Σ R_t.
fn regret(records: &[EpisodeRecord], best: f64) -> f64 {
    records
        .iter()
        .map(|record| best - record.plain_return)
        .sum()
}

#[test]
fn shaping_and_exploration_save_most_of_the_regret() {
    let best = open(15).optimum();
    for seed in 0..4 {
        let shaped = run(
            &mut engine(
                open(15),
                &params(PotentialKind::Gcn, ExplorationKind::Frontier),
                seed,
            ),
            200,
        );
        let params = params(PotentialKind::None, ExplorationKind::None);
        let actor_critic = AgentParams {
            kind: AgentKind::ActorCritic,
            ..Default::default()
        };
        let pipeline = ShapingPipeline::new(&params, 4, None, seed).unwrap();
        let actor_critic = build_agent(&actor_critic, 4, 1.0, seed);
        let plain = run(&mut Engine::new(open(15), pipeline, actor_critic), 200);
        let ratio = regret(&shaped, best.expected_return) / regret(&plain, best.expected_return);
        assert!(ratio <= 0.15, "seed {seed}: ratio {ratio}");
        let last = &shaped[shaped.len() - 20..];
        let mean = last.iter().map(|record| record.length as f64).sum::<f64>() / 20.0;
        assert!(
            mean <= 1.1 * best.expected_steps,
            "seed {seed}: {mean} steps"
        );
    }
}

#[test]
fn the_features_of_the_spectrum_reach_an_agent_that_wants_them() {
    let params = params(PotentialKind::Heat, ExplorationKind::Frontier);
    let own = AgentParams {
        features: FeatureKind::Pvf,
        ..Default::default()
    };
    let pipeline = ShapingPipeline::new(
        &params,
        4,
        Some(eigentrail::features::FeatureSource::Pvf),
        0,
    )
    .unwrap();
    let mut engine = Engine::new(open(6), pipeline, build_agent(&own, 4, 1.0, 0));
    let mut refreshes = 0;
    let records: Vec<_> = (0..60)
        .map(|_| {
            engine
                .run_episode(|r: &RefreshRecord, _| refreshes += u32::from(r.spectrum.is_some()))
                .unwrap()
        })
        .collect();
    assert!(refreshes > 1);
    assert!(
        records[40..]
            .iter()
            .all(|record| record.status == StepStatus::Terminated)
    );
    let features = engine
        .pipeline()
        .spectrum()
        .features()
        .expect("it was refreshed");
    assert!(features.nrows() <= engine.pipeline().transitions().num_states());
    let without = ShapingPipeline::<Cell>::new(&params, 4, None, 0).unwrap();
    assert!(without.spectrum().features().is_none());
}

fn step(state: u32, reward: f64, status: StepStatus) -> Step<u32> {
    Step {
        state,
        reward,
        status,
    }
}

#[test]
fn a_reward_that_is_no_number_is_an_error_and_changes_nothing() {
    let mut pipeline = ShapingPipeline::new(
        &PipelineParams {
            gamma: 1.0,
            ..Default::default()
        },
        2,
        None,
        0,
    )
    .unwrap();
    pipeline.begin_episode(&0);
    for reward in [f64::NAN, f64::INFINITY] {
        let error = pipeline
            .observe(Action(1), &step(7, reward, StepStatus::Running))
            .unwrap_err();
        assert!(
            matches!(error, PipelineError::Reward { step: 0, .. }),
            "{error}"
        );
        assert!(error.to_string().contains("must be finite"), "{error}");
        assert_eq!(pipeline.graph().num_states(), 1);
    }
    pipeline
        .observe(Action(1), &step(7, -1.0, StepStatus::Running))
        .unwrap();
}

#[test]
fn a_slip_of_the_caller_is_an_error_and_changes_nothing() {
    let mut pipeline = ShapingPipeline::new(&PipelineParams::default(), 2, None, 0).unwrap();
    let on = |state| step(state, -1.0, StepStatus::Running);
    let tries = |pipeline: &ShapingPipeline<u32>| {
        let graph = pipeline.transitions();
        let states = 0..graph.num_states() as u32;
        let pairs = states.flat_map(|s| [0, 1].map(|a| (StateId(s), Action(a))));
        pairs.map(|(s, a)| graph.tries(s, a)).collect::<Vec<_>>()
    };
    let too_early = pipeline.observe(Action(0), &on(1)).unwrap_err();
    assert!(matches!(too_early, PipelineError::NoEpisode { step: 0 }));
    assert_eq!(pipeline.graph().num_states(), 0);
    pipeline.begin_episode(&0);
    let no_action = pipeline.observe(Action(2), &on(1)).unwrap_err();
    let told = no_action.to_string();
    assert!(
        told.contains("action 2 of a world whose actions are 0..2"),
        "{told}"
    );
    assert_eq!(tries(&pipeline), [0, 0]);
    pipeline
        .observe(Action(0), &step(1, -1.0, StepStatus::Truncated))
        .unwrap();
    let too_late = pipeline.observe(Action(0), &on(2)).unwrap_err();
    assert!(
        too_late.to_string().contains("call begin_episode"),
        "{too_late}"
    );
    assert_eq!(tries(&pipeline), [1, 0, 0, 0]);
}

#[test]
fn parameters_out_of_range_are_refused_before_anything_is_built() {
    let refused = |params: &PipelineParams, num_actions| {
        let pipeline = ShapingPipeline::<u32>::new(params, num_actions, None, 0);
        pipeline.map(|_| ()).unwrap_err().to_string()
    };
    let good = PipelineParams::default();
    for num_actions in [0, 65_537] {
        let told = refused(&good, num_actions);
        assert!(told.starts_with("env.num_actions = "), "{told}");
    }
    let mut bad = good.clone();
    bad.schedule.refit_every = 0;
    assert!(refused(&bad, 2).starts_with("schedule.refit_every = 0"));
}

#[test]
fn truncation_keeps_the_potential_and_the_advice_of_the_last_state() {
    let mut params = params(PotentialKind::Hops, ExplorationKind::Frontier);
    params.exploration.potential_advice = 20.0;
    let mut pipeline = ShapingPipeline::new(&params, 1, None, 0).unwrap();
    // 0 → 1 → 2 → 3, a goal.
    pipeline.begin_episode(&0);
    for state in 1..=3 {
        let status = if state == 3 {
            StepStatus::Terminated
        } else {
            StepStatus::Running
        };
        let seen = pipeline
            .observe(Action(0), &step(state, -1.0, status))
            .unwrap();
        assert_eq!(seen.first_goal, state == 3);
    }
    assert_eq!(pipeline.advice(), [0.0]);
    let phi = |pipeline: &ShapingPipeline<u32>, state: u32| {
        let id = pipeline.graph().id(&state).unwrap();
        pipeline.potential().value(id)
    };
    let start = pipeline.begin_episode(&1);
    assert_eq!(start.0, 1);
    let (one, two) = (phi(&pipeline, 1), phi(&pipeline, 2));
    assert!(two > one);
    let seen = pipeline
        .observe(Action(0), &step(2, -1.0, StepStatus::Truncated))
        .unwrap();
    assert!((seen.shaping - (two - one)).abs() < 1e-12);
    assert!(pipeline.advice()[0] > 0.0, "from 2 on the potential rises");
    // One of its three actions is known to lead to the goal.
    pipeline.begin_episode(&1);
    pipeline
        .observe(Action(0), &step(2, -1.0, StepStatus::Running))
        .unwrap();
    let seen = pipeline
        .observe(Action(0), &step(3, -1.0, StepStatus::Terminated))
        .unwrap();
    assert!(
        (seen.shaping + two).abs() < 1e-12,
        "φ counts as 0 after termination"
    );
}

#[test]
fn a_goal_where_the_episode_goes_on_is_forgotten() {
    let mut pipeline = ShapingPipeline::new(
        &params(PotentialKind::Gcn, ExplorationKind::Frontier),
        2,
        None,
        0,
    )
    .unwrap();
    pipeline.begin_episode(&0);
    pipeline
        .observe(Action(0), &step(1, -1.0, StepStatus::Running))
        .unwrap();
    pipeline
        .observe(Action(0), &step(2, -1.0, StepStatus::Terminated))
        .unwrap();
    pipeline.begin_episode(&0);
    pipeline
        .observe(Action(0), &step(1, -1.0, StepStatus::Running))
        .unwrap();
    pipeline
        .observe(Action(1), &step(3, -1.0, StepStatus::Terminated))
        .unwrap();
    assert_eq!(pipeline.goals().len(), 2);
    pipeline.begin_episode(&0);
    pipeline
        .observe(Action(0), &step(1, -1.0, StepStatus::Running))
        .unwrap();
    let seen = pipeline
        .observe(Action(0), &step(2, -1.0, StepStatus::Running))
        .unwrap();
    assert!(seen.lost_goal && !seen.first_goal);
    assert_eq!(pipeline.goals().len(), 1);
    assert!(
        seen.refresh.is_some_and(|r| r.fit.is_some()),
        "fitted anew on the goal that is left"
    );
    let other = pipeline
        .observe(Action(0), &step(3, -1.0, StepStatus::Truncated))
        .unwrap();
    assert!(other.lost_goal && other.refresh.is_none_or(|r| r.fit.is_none()));
    assert!(pipeline.goals().is_empty());
    assert!(pipeline.potential().values().iter().all(|&phi| phi == 0.0));
    pipeline.begin_episode(&0);
    let found = pipeline
        .observe(Action(1), &step(4, -1.0, StepStatus::Terminated))
        .unwrap();
    assert!(found.first_goal && found.refresh.is_some_and(|r| r.fit.is_some()));
}

/// Goes one way; what it learns doubles with each step.
struct Diverging {
    td_error: f64,
}

impl Agent for Diverging {
    fn select_action(&mut self, _: Situation<'_>) -> Action {
        Action(0)
    }

    fn update(&mut self, _: &Experience<'_>) -> UpdateInfo {
        self.td_error *= 2.0;
        UpdateInfo {
            td_error: self.td_error,
        }
    }
}

/// A world with faults of its own: it panics at some steps, or pretends to have other actions.
struct Faulty {
    world: GridWorld,
    steps: u32,
    panics_every: u32,
    num_actions: usize,
}

impl Environment for Faulty {
    type State = Cell;

    fn num_actions(&self) -> usize {
        self.num_actions
    }

    fn reset(&mut self) -> Cell {
        self.world.reset()
    }

    fn step(&mut self, action: Action) -> Step<Cell> {
        self.steps += 1;
        assert!(
            !self.steps.is_multiple_of(self.panics_every),
            "out of order"
        );
        self.world.step(action)
    }
}

fn faulty(panics_every: u32, num_actions: usize) -> Engine<Faulty, AnyAgent> {
    let world = Faulty {
        world: open(4),
        steps: 0,
        panics_every,
        num_actions,
    };
    let pipeline = ShapingPipeline::new(&PipelineParams::default(), 4, None, 0).unwrap();
    Engine::new(world, pipeline, agent(0))
}

/// Whoever catches the panics of an environment goes on: nothing is made of the steps that did not happen.
#[test]
fn an_environment_that_panics_leaves_an_engine_that_goes_on() {
    let mut engine = faulty(17, 4);
    let (mut panics, mut episodes) = (0, 0);
    while episodes < 60 {
        let stepped =
            std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| engine.step(|_, _| ())));
        match stepped {
            Ok(record) => episodes += u32::from(record.unwrap().is_some()),
            Err(_) => panics += 1,
        }
    }
    assert!(panics > 10, "{panics}");
    let graph = engine.pipeline().transitions();
    let tries: u32 = (0..graph.num_states() as u32)
        .flat_map(|state| (0..4).map(move |action| (StateId(state), Action(action))))
        .map(|(state, action)| graph.tries(state, action))
        .sum();
    assert_eq!(
        u64::from(tries),
        engine.steps(),
        "each step that happened is known, and no other"
    );
    assert!(
        graph.adjacency().num_edges() <= 24,
        "a grid of 4 × 4 has no more"
    );
    let last = engine.pipeline().potential().values();
    assert!(last.iter().all(|value| value.is_finite()));
}

#[test]
fn an_environment_with_other_actions_is_refused() {
    for num_actions in [3, 5] {
        let error = faulty(u32::MAX, num_actions).step(|_, _| ()).unwrap_err();
        let said =
            format!("the environment has {num_actions} actions and the pipeline was made for 4");
        assert!(error.to_string().starts_with(&said), "{error}");
    }
}

#[test]
fn an_agent_whose_values_diverge_ends_the_run() {
    let params = params(PotentialKind::None, ExplorationKind::None);
    let pipeline = ShapingPipeline::new(&params, 4, None, 0).unwrap();
    let mut engine = Engine::new(open(3), pipeline, Diverging { td_error: 1.0 });
    // 90 steps an episode: after five of them 2⁴⁵⁰, whose square is still a number; after six no more.
    for _ in 0..5 {
        engine.run_episode(|_, _| {}).unwrap();
    }
    let error = engine.run_episode(|_, _| {}).unwrap_err();
    assert!(matches!(error, PipelineError::Diverged { step: 540 }));
    assert!(error.to_string().contains("agent.critic_learning_rate"));
}

#[test]
fn after_the_goal_has_moved_the_agent_finds_the_new_one() {
    for seed in 0..3 {
        let params = params(PotentialKind::Gcn, ExplorationKind::Frontier);
        let mut engine = engine(open(10), &params, seed);
        run(&mut engine, 100);
        let first = engine.first_goal_step();
        let layout = engine.env().layout().clone();
        let corner = layout.cell(9, 0).unwrap();
        engine
            .env_mut()
            .set_goals(vec![GoalCell::new(corner)])
            .unwrap();
        let best = engine.env().optimum().expected_steps;
        let after = run(&mut engine, 300);
        assert_eq!(
            engine.first_goal_step(),
            first,
            "the first goal stays the first"
        );
        let last = &after[280..];
        let mean = last.iter().map(|record| record.length as f64).sum::<f64>() / 20.0;
        assert!(mean <= 1.1 * best, "seed {seed}: {mean} steps for {best}");
    }
}
