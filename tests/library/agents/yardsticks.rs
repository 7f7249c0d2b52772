//! Learners of the literature: what their papers and books say of them.

use super::world::{Numbering, Outcome, World, max, play};
use eigentrail::agent::{
    Agent, AgentKind, AgentParams, AnyAgent, DynaQPlus, DynaQPlusParams, EpisodePlanParams, MbieEb,
    MbieEbParams, Planner, PlannerParams, Situation, Untried,
};
use eigentrail::env::Action;
use eigentrail::graph::StateId;

/// Every (state, action) of a world that can be tried before an episode ends.
fn pairs(world: &World) -> usize {
    (world.num_states() - world.goals.len()) * world.outcomes[0].len()
}

/// States and actions of a run, episode by episode; `tries` counts how often each pair was tried.
struct Watched<A> {
    agent: A,
    tries: Vec<[usize; 4]>,
    /// Steps that tried a pair less known than this.
    known_after: usize,
    explored: usize,
}

impl<A: Agent> Watched<A> {
    fn new(agent: A, known_after: usize) -> Self {
        Watched {
            agent,
            tries: vec![[0; 4]; 100],
            known_after,
            explored: 0,
        }
    }
}

impl<A: Agent> Agent for Watched<A> {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        let action = self.agent.select_action(situation);
        let tries = &mut self.tries[situation.state.index()][action.index()];
        self.explored += usize::from(*tries < self.known_after);
        *tries += 1;
        action
    }

    fn update(
        &mut self,
        experience: &eigentrail::agent::Experience<'_>,
    ) -> eigentrail::agent::UpdateInfo {
        self.agent.update(experience)
    }
}

/// Brafman & Tennenholtz (2002): no more than |S||A| m steps try what is not known, and in a deterministic world, where
/// nothing then turns out to be otherwise, the way is optimal from then on.
#[test]
fn r_max_tries_each_pair_so_many_times_and_no_more() {
    for m in [1, 3] {
        let mut world = World::grid(5, 5, 0.0, 1);
        let params = PlannerParams {
            known_after: m,
            // More than any way is worth: everything has to be known first.
            optimistic_value: Some(1.0),
            ..PlannerParams::default()
        };
        let mut agent = Watched::new(Planner::new(params, 4, 1), m as usize);
        let log = play(&mut world, &mut agent, &mut Numbering::default(), 400);
        assert_eq!(agent.explored, pairs(&world) * m as usize, "m = {m}");
        assert_eq!(log.final_mean(100), 8.0, "m = {m}");
        let early = log.lengths.iter().position(|&length| length == 8);
        assert!(early.is_some_and(|episode| episode > 2), "{early:?}");
    }
}

fn mbie_eb(bonus: f64, horizon: usize) -> MbieEb {
    let plan = EpisodePlanParams {
        horizon,
        ..EpisodePlanParams::default()
    };
    MbieEb::new(MbieEbParams { plan, bonus }, 4, 3)
}

/// Without a bonus: certainty equivalence. Each pair that could still be better is tried once, and the values are those of
/// value iteration along the way that is taken.
#[test]
fn mbie_eb_without_a_bonus_believes_what_it_has_seen() {
    let mut world = World::grid(5, 5, 0.0, 1);
    let mut numbering = Numbering::default();
    let mut agent = Watched::new(mbie_eb(0.0, 250), 1);
    let log = play(&mut world, &mut agent, &mut numbering, 100);
    assert_eq!(log.final_mean(50), 8.0);
    let right = world.optimal_values(1.0);
    let found = agent.agent.action_values(numbering.id(0)).unwrap();
    assert!((max(found) - max(&right[0])).abs() < 1e-9, "{found:?}");
    assert!(agent.explored <= pairs(&world));
}

/// With a large one every pair is tried again and again, none less than five times in 60 episodes but
/// the two that end an episode and with it all bonuses.
#[test]
fn mbie_eb_with_a_large_bonus_explores_everything() {
    let mut world = World::grid(5, 5, 0.0, 1);
    let mut agent = Watched::new(mbie_eb(1000.0, 250), 10);
    let mut numbering = Numbering::default();
    play(&mut world, &mut agent, &mut numbering, 60);
    let known = (0..24).map(|state| agent.tries[numbering.id(state).index()]);
    let mut tries: Vec<usize> = known.flatten().collect();
    tries.sort_unstable();
    assert!(tries[0] >= 1 && tries[2] >= 5, "{tries:?}");
}

/// The maze of examples 8.2 and 8.3 (Sutton & Barto 2018): 6 × 9, start in the middle of the lowest row, goal in the upper right
/// corner, a wall in the fourth row with the `gaps`.
fn maze(gaps: &[usize]) -> World {
    let is_wall = |cell: usize| cell / 9 == 3 && !gaps.contains(&(cell % 9));
    let outcomes = (0..54).map(|cell| {
        let to = [
            (cell >= 9).then(|| cell - 9),
            (cell % 9 < 8).then_some(cell + 1),
            (cell < 45).then_some(cell + 9),
            (cell % 9 > 0).then(|| cell - 1),
        ];
        let outcome = |to: Option<usize>| Outcome {
            probability: 1.0,
            next: to.filter(|&to| !is_wall(to)).unwrap_or(cell),
            reward: if to == Some(8) { 1.0 } else { 0.0 },
        };
        to.map(|to| vec![outcome(to)]).to_vec()
    });
    let mut world = World::new(outcomes.collect(), vec![8], 0);
    (world.start, world.max_steps) = (48, 3000);
    world
}

/// Dyna-Q+ as in the book; Dyna-Q is the same without the bonus.
fn dyna(time_bonus: f64, seed: u64) -> DynaQPlus {
    let params = DynaQPlusParams {
        gamma: 0.95,
        learning_rate: 0.5,
        epsilon: 0.1,
        planning_steps: 50,
        time_bonus,
        ..DynaQPlusParams::default()
    };
    DynaQPlus::new(params, 4, seed)
}

/// Mean steps of the last 20 episodes, of 60 in the maze with the first gaps and `after` in that with the others.
fn after_the_change(bonus: f64, seed: u64, gaps: [&[usize]; 2], after: usize) -> f64 {
    let (mut agent, mut numbering) = (dyna(bonus, seed), Numbering::default());
    play(&mut maze(gaps[0]), &mut agent, &mut numbering, 60);
    play(&mut maze(gaps[1]), &mut agent, &mut numbering, after).final_mean(20)
}

/// Example 8.3: a short cut opens, of 10 steps instead of 16. Dyna-Q never looks; Dyna-Q+ finds it.
#[test]
fn dyna_q_plus_finds_the_short_cut() {
    for seed in 0..3 {
        let steps = |bonus| after_the_change(bonus, seed, [&[0], &[0, 8]], 300);
        let (without, with) = (steps(0.0), steps(1e-3));
        assert!(without > 15.9, "seed {seed}: {without}");
        assert!(with < 15.0, "seed {seed}: {with}");
    }
}

/// Example 8.2: the short way is blocked, and a longer one opens.
#[test]
fn dyna_q_plus_finds_the_way_round() {
    for seed in 0..3 {
        let with = after_the_change(1e-3, seed, [&[8], &[0]], 100);
        assert!(with < 24.0, "seed {seed}: {with}");
    }
}

/// A goal that moves to another corner, with the default parameters: Dyna-Q replays itself into believing that no place is better
/// than another.
#[test]
fn dyna_q_plus_comes_back_after_the_goal_moved() {
    for seed in 0..3 {
        let mut world = World::grid(9, 9, 0.0, seed);
        let params = AgentParams {
            kind: AgentKind::DynaQPlus,
            ..AgentParams::default()
        };
        let mut agent = AnyAgent::new(&params, 4, 1.0, seed);
        let mut numbering = Numbering::default();
        play(&mut world, &mut agent, &mut numbering, 100);
        world.goals = vec![72];
        let log = play(&mut world, &mut agent, &mut numbering, 100);
        assert_eq!(log.final_mean(50), 8.0, "seed {seed}");
    }
}

/// The river of Strehl and Littman with six states; `right` says where the action to the right leads from a state.
fn river_swim(seed: u64) -> World {
    let outcome = |probability, next, reward| Outcome {
        probability,
        next,
        reward,
    };
    let right = |state: usize| match state {
        0 => vec![outcome(0.4, 0, 0.0), outcome(0.6, 1, 0.0)],
        5 => vec![outcome(0.4, 4, 0.0), outcome(0.6, 5, 10_000.0)],
        _ => vec![
            outcome(0.05, state - 1, 0.0),
            outcome(0.6, state, 0.0),
            outcome(0.35, state + 1, 0.0),
        ],
    };
    let left = |state: usize| match state {
        0 => vec![outcome(1.0, 0, 5.0)],
        _ => vec![outcome(1.0, state - 1, 0.0)],
    };
    let outcomes = (0..6).map(|state| vec![left(state), right(state)]);
    let mut world = World::new(outcomes.collect(), vec![], seed);
    world.max_steps = 20;
    world
}

/// The exact value of going right for 20 steps in all states. (The best policy goes left where the end is out of reach.)
fn returns_of_swimming(world: &World) -> f64 {
    let mut values = [0.0; 6];
    for _ in 0..20 {
        let worth = |s: usize| {
            let outcomes = world.outcomes[s][1].iter();
            outcomes
                .map(|o| o.probability * (o.reward + values[o.next]))
                .sum()
        };
        values = std::array::from_fn(worth);
    }
    values[0]
}

/// Optimism and posterior sampling swim against the current for as long as it takes, where others settle for the 5 that are near:
/// over the last tenth of 2000 episodes they go right in all but a few steps. What they hope for goes by what they have
/// seen, so that now and then one of them gives up.
#[test]
fn the_river_is_swum() {
    assert!((returns_of_swimming(&river_swim(0)) - 20_380.0).abs() < 5.0);
    for kind in [AgentKind::Psrl, AgentKind::Ucbvi, AgentKind::MbieEb] {
        let swims = |seed: &u64| {
            let seed = *seed;
            let mut world = river_swim(seed);
            let params = AgentParams {
                kind,
                ..AgentParams::default()
            };
            let params = params.with_step_limit(world.max_steps);
            let mut agent = AnyAgent::new(&params, 2, 1.0, seed);
            let mut numbering = Numbering::default();
            let log = play(&mut world, &mut agent, &mut numbering, 2000);
            let last = &log.actions[log.actions.len() - 4000..];
            last.iter().filter(|action| action.0 == 1).count() > 3800
        };
        let swum = (0..10).filter(swims).count();
        assert!(swum >= 8, "{kind:?}: {swum} of 10");
    }
}

/// Told to leave untried actions to the advice, the planner goes where it is advised, though it knows a better way, and goes by
/// its plan where it is not.
#[test]
fn advice_comes_before_the_plan_and_the_plan_before_the_unknown() {
    let mut world = World::grid(4, 4, 0.0, 0);
    let params = PlannerParams {
        untried: Untried::Advised,
        ..PlannerParams::default()
    };
    let (mut agent, mut numbering) = (Planner::new(params, 4, 0), Numbering::default());
    // Without advice it walks at random until it meets the goal, and from then on the way that it knows.
    let log = play(&mut world, &mut agent, &mut numbering, 20);
    let known_way = log.lengths[19];
    assert_eq!(log.lengths[10..], [known_way; 10], "{:?}", log.lengths);
    let start = numbering.id(world.start);
    for action in 0..4u16 {
        let mut advice = [0.0; 4];
        advice[usize::from(action)] = 1.0;
        assert_eq!(agent.greedy_action(start, &advice), Some(Action(action)));
        let situation = Situation {
            state: start,
            advice: &advice,
        };
        assert_eq!(agent.select_action(situation), Action(action));
    }
    assert_eq!(agent.greedy_action(StateId(99), &[0.0; 4]), None);
}
