//! Facts about each potential: no false maxima, the way up leads to a goal, what it is worth in numbers, moves that exist.

use eigentrail::env::Action;
use eigentrail::gcn::GcnParams;
use eigentrail::graph::{Adjacency, StateId, SymmetricCsr, TransitionGraph};
use eigentrail::shaping::{
    AnyPotential, Goal, PotentialFit, PotentialInputs, PotentialKind, PotentialTable, ScaleMode,
    ShapingError, ShapingParams, build_potential, false_maxima, potential_on_graph,
    spurious_maxima,
};
use faer::Mat;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// The kinds that promise to have no false maximum.
const DEPENDABLE: [PotentialKind; 5] = [
    PotentialKind::Gcn,
    PotentialKind::Heat,
    PotentialKind::Dr,
    PotentialKind::Sr,
    PotentialKind::Hops,
];

/// Those of them that are returns on the learnt model.
const RETURNS: [PotentialKind; 3] = [PotentialKind::Gcn, PotentialKind::Heat, PotentialKind::Hops];

/// Those that are made of ways to goals, and stretched to the longest one.
const STRETCHED: [PotentialKind; 2] = [PotentialKind::Dr, PotentialKind::Sr];

/// φ is computed to a Bellman residual of 1e-5 of a step.
const TOL: f64 = 1e-4;

/// What that residual may come to, along a way for ever.
fn tolerance(g: f64) -> f64 {
    2.0 * 1e-5 / (1.0 - g)
}

/// g of a world of `n` states.
fn discount(gamma: f64, n: usize) -> f64 {
    gamma * (1.0 - 1.0 / (10.0 * n as f64))
}

/// Return of `steps` steps of reward 1 each; for ever from ∞ on.
fn sum_of(g: f64, steps: f64) -> f64 {
    (1.0 - g.powf(steps)) / (1.0 - g)
}

// ---- maps -------------------------------------------------------------------------------------------------------

/// An ASCII map: `#` wall, `G` goal, `X` an end that is none, `^ v < >` a cell that can only be left that way, `~` a slow cell, the rest
/// free.
struct Map {
    columns: usize,
    cells: Vec<char>,
    /// State of each cell that is no wall, in reading order.
    states: Vec<Option<u32>>,
}

impl Map {
    fn new(text: &str) -> Self {
        let lines: Vec<&str> = text.split_whitespace().collect();
        let cells: Vec<char> = lines.concat().chars().collect();
        let mut next = 0..;
        let states = cells
            .iter()
            .map(|&c| (c != '#').then(|| next.next().unwrap()))
            .collect();
        Self {
            columns: lines[0].len(),
            cells,
            states,
        }
    }

    fn open(rows: usize, columns: usize, goals: &[usize]) -> Self {
        let mut cells = vec!['.'; rows * columns];
        goals.iter().for_each(|&g| cells[g] = 'G');
        let lines: Vec<String> = cells
            .chunks(columns)
            .map(|line| line.iter().collect())
            .collect();
        Self::new(&lines.join(" "))
    }

    fn num_states(&self) -> usize {
        self.states.iter().flatten().count()
    }

    fn goals(&self) -> Vec<StateId> {
        let goals = (0..self.cells.len()).filter(|&i| self.cells[i] == 'G');
        goals.map(|i| StateId(self.states[i].unwrap())).collect()
    }

    /// Where the action leads from the cell: the cell itself on a bump.
    fn target(&self, cell: usize, action: usize) -> usize {
        if "^>v<"
            .chars()
            .position(|c| c == self.cells[cell])
            .is_some_and(|only| only != action)
        {
            return cell;
        }
        let (r, c) = (cell / self.columns, cell % self.columns);
        let rows = self.cells.len() / self.columns;
        let target = match action {
            0 if r > 0 => cell - self.columns,
            1 if c + 1 < self.columns => cell + 1,
            2 if r + 1 < rows => cell + self.columns,
            3 if c > 0 => cell - 1,
            _ => cell,
        };
        if self.cells[target] == '#' {
            cell
        } else {
            target
        }
    }

    /// The undirected graph of cells side by side.
    fn adjacency(&self) -> SymmetricCsr {
        let n = self.num_states();
        let mut edges = BTreeSet::new();
        for (cell, state) in self.states.iter().enumerate() {
            for action in 0..4 {
                let next = self.states[self.target(cell, action)];
                if let (Some(i), Some(j)) = (state, next)
                    && i != &j
                {
                    edges.extend([(*i, j), (j, *i)]);
                }
            }
        }
        let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
        edges
            .iter()
            .for_each(|&(i, j)| triplets.add_triplet(i as usize, j as usize, 1.0));
        SymmetricCsr::new(triplets.to_csr()).unwrap()
    }

    fn is_end(&self, cell: usize) -> bool {
        matches!(self.cells[cell], 'G' | 'X')
    }

    /// Every action of every state but ends tried once, for which `tried(state, action)`.
    fn explored(&self, reward: f64, tried: impl Fn(u32, usize) -> bool) -> World {
        self.explored_with(reward, |_| 0.0, 0, tried)
    }

    /// The same, where entering an end pays what `pay` says on top of the step, and of ten tries of an action so many slip to either side.
    fn explored_with(
        &self,
        reward: f64,
        pay: impl Fn(u32) -> f64,
        slips: usize,
        tried: impl Fn(u32, usize) -> bool,
    ) -> World {
        let mut graph = TransitionGraph::new(4);
        (0..self.num_states()).for_each(|_| {
            graph.add_state();
        });
        for (cell, state) in self.states.iter().enumerate() {
            let Some(state) = *state else { continue };
            for action in (0..4).filter(|&a| !self.is_end(cell) && tried(state, a)) {
                let slow = if self.cells[cell] == '~' { 5.0 } else { 1.0 };
                let aside = [(action + 1) % 4, (action + 3) % 4];
                let slipped = aside
                    .into_iter()
                    .flat_map(|way| std::iter::repeat_n(way, slips));
                let tries = if slips == 0 { 1 } else { 10 - 2 * slips };
                for way in std::iter::repeat_n(action, tries).chain(slipped) {
                    let next = self.target(cell, way);
                    let (ends, to) = (self.is_end(next), self.states[next].unwrap());
                    let reward = reward * slow + if ends { pay(to) } else { 0.0 };
                    graph.record(
                        StateId(state),
                        Action(action as u16),
                        reward,
                        StateId(to),
                        ends,
                    );
                }
            }
        }
        let goal = |state: StateId| Goal {
            state,
            reward: reward + pay(state.0),
        };
        let cells = (0..self.cells.len()).filter(|&cell| self.states[cell].is_some());
        World {
            graph,
            goals: self.goals().into_iter().map(goal).collect(),
            ends: cells.map(|cell| self.is_end(cell)).collect(),
            gamma: 1.0,
        }
    }

    fn fully_explored(&self) -> World {
        self.explored(-1.0, |_, _| true)
    }
}

struct World {
    graph: TransitionGraph,
    goals: Vec<Goal>,
    ends: Vec<bool>,
    gamma: f64,
}

impl World {
    /// The agent has come within a tenth of the best returns.
    fn with<T>(&self, use_inputs: impl FnOnce(&PotentialInputs<'_>) -> T) -> T {
        let adjacency = self.graph.adjacency().to_csr();
        let features = features(self.graph.num_states());
        let labels: Vec<_> = self.goals.iter().map(|g| (g.state, 1)).collect();
        let mut inputs = PotentialInputs {
            graph: &self.graph,
            adjacency: &adjacency,
            goals: &self.goals,
            ends: &self.ends,
            returns: &[],
            gamma: self.gamma,
            labels: &labels,
            features: features.as_ref(),
        };
        let best = build_with(PotentialKind::Hops, &ShapingParams::default()).fit(&inputs);
        let values = best.map(|fit| fit.values).unwrap_or_default();
        let states = (0..).map(StateId).zip(values);
        let returns: Vec<_> = states
            .filter(|(state, _)| self.ends.get(state.index()) != Some(&true))
            .map(|(state, value)| (state, value - 0.1 * value.abs()))
            .collect();
        inputs.returns = &returns;
        use_inputs(&inputs)
    }

    fn fit(&self, kind: PotentialKind) -> PotentialFit {
        self.with(|inputs| build(kind).fit(inputs)).unwrap()
    }

    fn false_maxima(&self, phi: &[f64]) -> Vec<StateId> {
        let mut table = PotentialTable::new();
        let values = phi.to_vec();
        let fit = PotentialFit {
            values,
            ..Default::default()
        };
        table.replace(&fit).unwrap();
        false_maxima(&self.graph, &self.goals, &self.ends, &table, self.gamma)
    }
}

/// Parameters under which φ is twice a return.
fn twice() -> ShapingParams {
    ShapingParams {
        scale_factor: 2.0,
        ..Default::default()
    }
}

fn build(kind: PotentialKind) -> AnyPotential {
    build_with(kind, &twice())
}

fn build_with(kind: PotentialKind, shaping: &ShapingParams) -> AnyPotential {
    let shaping = ShapingParams {
        potential: kind,
        ..shaping.clone()
    };
    build_potential(&shaping, &GcnParams::default(), 1)
}

/// Smooth, of size 1, and of no meaning.
fn features(n: usize) -> Mat<f64> {
    Mat::from_fn(n, 5, |i, c| (i as f64 * 0.37 * (c + 1) as f64).cos() * 1.4)
}

fn on_graph(
    adjacency: &SymmetricCsr,
    goals: &[StateId],
    kind: PotentialKind,
) -> Result<PotentialFit, ShapingError> {
    on_graph_with(adjacency, goals, kind, &twice())
}

fn on_graph_with(
    adjacency: &SymmetricCsr,
    goals: &[StateId],
    kind: PotentialKind,
    shaping: &ShapingParams,
) -> Result<PotentialFit, ShapingError> {
    let features = features(adjacency.num_nodes());
    potential_on_graph(
        adjacency,
        goals,
        kind,
        features.as_ref(),
        shaping,
        &GcnParams::default(),
        1,
    )
}

fn neighbors(adjacency: &SymmetricCsr, i: usize) -> Vec<usize> {
    adjacency.row(i).0.iter().map(|&j| j as usize).collect()
}

/// Whether always going to the neighbour with the largest φ leads from everywhere to a goal.
fn greedy_way_reaches_a_goal(phi: &[f64], adjacency: &SymmetricCsr, goals: &[StateId]) -> bool {
    let is_goal = |i: usize| goals.iter().any(|g| g.index() == i);
    (0..phi.len()).all(|start| {
        let mut at = start;
        for _ in 0..phi.len() {
            if is_goal(at) {
                return true;
            }
            let best = neighbors(adjacency, at)
                .into_iter()
                .max_by(|&a, &b| phi[a].total_cmp(&phi[b]));
            at = best.unwrap();
        }
        is_goal(at)
    })
}

fn maps() -> Vec<(&'static str, Map)> {
    let u_trap = Map::new(
        "...........
         ..#######..
         ........#..
         ........#.G
         ........#..
         ..#######..
         ...........",
    );
    vec![
        ("open", Map::open(9, 11, &[98])),
        ("u-trap", u_trap),
        ("centre", Map::open(9, 9, &[40])),
        ("two goals", Map::open(7, 13, &[0, 90])),
        ("corridor", Map::open(1, 60, &[0])),
    ]
}

// ---- on a bare graph --------------------------------------------------------------------------------------------

#[test]
fn dependable_kinds_have_no_false_maximum_and_lead_to_a_goal() {
    for (name, map) in maps() {
        let (adjacency, goals) = (map.adjacency(), map.goals());
        for kind in DEPENDABLE {
            let phi = on_graph(&adjacency, &goals, kind).unwrap().values;
            assert_eq!(
                spurious_maxima(&phi, &adjacency, &goals),
                [],
                "{kind} on {name}"
            );
            assert!(
                greedy_way_reaches_a_goal(&phi, &adjacency, &goals),
                "{kind} on {name}"
            );
        }
    }
}

#[test]
fn goals_have_zero_and_others_less() {
    // Steps from the farthest cell to the nearest goal.
    let eccentricities = [18.0, 21.0, 8.0, 9.0, 59.0];
    for ((name, map), eccentricity) in maps().into_iter().zip(eccentricities) {
        for kind in DEPENDABLE {
            let phi = on_graph(&map.adjacency(), &map.goals(), kind)
                .unwrap()
                .values;
            assert!(
                map.goals().iter().all(|g| phi[g.index()] == 0.0),
                "{kind} on {name}"
            );
            let others = (0..phi.len()).filter(|&i| !map.goals().contains(&StateId(i as u32)));
            assert!(others.into_iter().all(|i| phi[i] < 0.0), "{kind} on {name}");
            let lowest = phi.iter().copied().fold(0.0, f64::min);
            if STRETCHED.contains(&kind) {
                let error = lowest + 2.0 * eccentricity;
                assert!(error.abs() < TOL, "{kind} on {name}: {lowest}");
            }
        }
    }
}

/// The warmer, the less: `heat` is warmer than `gcn` may become, and `hops` has no temperature.
#[test]
fn temperature_costs() {
    for (name, map) in maps() {
        let [gcn, heat, hops] = RETURNS.map(|kind| {
            on_graph(&map.adjacency(), &map.goals(), kind)
                .unwrap()
                .values
        });
        for i in 0..hops.len() {
            assert!(
                heat[i] <= gcn[i] + TOL && gcn[i] <= hops[i] + TOL,
                "{name}, state {i}"
            );
        }
    }
}

#[test]
fn hops_are_two_per_step() {
    let map = Map::open(4, 5, &[0]);
    let phi = on_graph(&map.adjacency(), &map.goals(), PotentialKind::Hops)
        .unwrap()
        .values;
    let g = discount(1.0, 20);
    for (i, phi) in phi.iter().enumerate() {
        let steps = (i / 5 + i % 5) as f64;
        assert!((phi + 2.0 * sum_of(g, steps)).abs() < TOL, "{i}: {phi}");
        assert!(-2.0 * steps <= *phi && *phi <= -2.0 * steps * (1.0 - steps / 400.0));
    }
}

#[test]
fn the_scale_factor_multiplies() {
    let map = Map::open(6, 6, &[0]);
    for kind in DEPENDABLE.into_iter().chain([PotentialKind::Report]) {
        let phi = |scale_factor| {
            let shaping = ShapingParams {
                scale_factor,
                ..Default::default()
            };
            on_graph_with(&map.adjacency(), &map.goals(), kind, &shaping)
                .unwrap()
                .values
        };
        for (single, triple) in phi(1.0).iter().zip(phi(3.0)) {
            assert!((3.0 * single - triple).abs() < TOL, "{kind}");
        }
    }
}

#[test]
fn the_reports_potential_is_the_probability_of_the_rewarding_class() {
    let map = Map::open(5, 5, &[24]);
    let raw = ShapingParams {
        scale: ScaleMode::Raw,
        ..Default::default()
    };
    let fit = on_graph_with(&map.adjacency(), &map.goals(), PotentialKind::Report, &raw).unwrap();
    assert!(fit.values.iter().all(|p| (0.0..=1.0).contains(p)));
    assert!(
        fit.values[24] > fit.values[0],
        "goal {} start {}",
        fit.values[24],
        fit.values[0]
    );
    assert_eq!(fit.fit.unwrap().epochs, 40);
    let scaled = on_graph(&map.adjacency(), &map.goals(), PotentialKind::Report)
        .unwrap()
        .values;
    assert_eq!(scaled[24], 0.0);
    assert!((scaled.iter().copied().fold(0.0, f64::min) + 16.0).abs() < TOL);
}

#[test]
fn what_cannot_reach_a_goal_has_the_lowest_finite_value() {
    let map = Map::new("G..#... ...#...");
    for kind in DEPENDABLE.into_iter().chain([PotentialKind::Report]) {
        let phi = on_graph(&map.adjacency(), &map.goals(), kind)
            .unwrap()
            .values;
        let reached = [0, 1, 2, 6, 7, 8];
        let lowest = reached
            .iter()
            .map(|&i| phi[i])
            .fold(f64::INFINITY, f64::min);
        // A return of steps for ever, or the lowest of what can reach one.
        let expected = match RETURNS.contains(&kind) {
            true => -2.0 * sum_of(discount(1.0, 12), f64::INFINITY),
            false => lowest,
        };
        assert!(expected <= lowest, "{kind}");
        for i in (0..12).filter(|i| !reached.contains(i)) {
            let error = (phi[i] - expected).abs();
            assert!(
                error < tolerance(discount(1.0, 12)),
                "{kind}, state {i}: {}",
                phi[i]
            );
        }
    }
}

#[test]
fn graphs_of_goals_alone_are_flat() {
    for kind in DEPENDABLE {
        let single = Adjacency::with_nodes(1).to_csr();
        assert_eq!(
            on_graph(&single, &[StateId(0)], kind).unwrap().values,
            [0.0]
        );
        let all = Map::new("GGG GGG");
        let phi = on_graph(&all.adjacency(), &all.goals(), kind)
            .unwrap()
            .values;
        assert_eq!(phi, [0.0; 6], "{kind}");
        // Those beside it stay where they are, for ever or as if that were nothing.
        let isolated = Adjacency::with_nodes(3).to_csr();
        let stay = match RETURNS.contains(&kind) {
            true => -2.0 * 30.0,
            false => 0.0,
        };
        for (phi, expected) in on_graph(&isolated, &[StateId(1)], kind)
            .unwrap()
            .values
            .iter()
            .zip([stay, 0.0, stay])
        {
            assert!((phi - expected).abs() < 1e-9, "{kind}: {phi}");
        }
    }
}

#[test]
fn bad_input_is_an_error_that_says_what() {
    let map = Map::open(2, 3, &[0]);
    let adjacency = map.adjacency();
    let message = |adjacency: &SymmetricCsr, goals: &[StateId], kind| {
        on_graph(adjacency, goals, kind).unwrap_err().to_string()
    };
    assert_eq!(
        message(&adjacency, &[], PotentialKind::Heat),
        "a potential needs at least one goal"
    );
    assert_eq!(
        message(&adjacency, &[StateId(6)], PotentialKind::Heat),
        "goal 6 is not a node of a graph of 6 nodes (numbered from 0)"
    );
    assert_eq!(
        message(&adjacency, &[StateId(0)], PotentialKind::Oracle),
        "potential kind `oracle` needs more than a graph: choose gcn, report, heat, dr, sr, hops or random"
    );
    for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let mut matrix = adjacency.as_csr().clone();
        *matrix.get_mut(1, 2).unwrap() = bad;
        let expected =
            format!("edge weight at row 1, column 2 is {bad}: weights must be finite and positive");
        let refused = SymmetricCsr::new(matrix).unwrap_err();
        assert_eq!(
            refused.to_string(),
            expected,
            "before it gets to a potential"
        );
    }
}

/// Connected or not, weighted, with self-loops.
fn any_weighted_graph() -> impl Strategy<Value = SymmetricCsr> {
    let edge = (0_usize..20, 0_usize..20, 0.01_f64..100.0);
    (2_usize..20, prop::collection::vec(edge, 0..60)).prop_map(|(n, edges)| {
        let mut dense = vec![0.0; n * n];
        for (i, j, weight) in edges {
            let (i, j) = (i % n, j % n);
            dense[i * n + j] = weight;
            dense[j * n + i] = weight;
        }
        let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
        for (entry, &weight) in dense.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            triplets.add_triplet(entry / n, entry % n, weight);
        }
        SymmetricCsr::new(triplets.to_csr()).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_weights_make_a_false_maximum(adjacency in any_weighted_graph(), goal in 0_u32..2) {
        for kind in RETURNS {
            let goals = [StateId(goal)];
            let phi = on_graph(&adjacency, &goals, kind).unwrap().values;
            prop_assert!(phi.iter().all(|v| v.is_finite()));
            prop_assert_eq!(spurious_maxima(&phi, &adjacency, &goals), vec![], "{}", kind);
        }
    }
}

// ---- in an explored world ---------------------------------------------------------------------------------------

/// Bumps into walls are left out, so a fully explored grid is its graph.
#[test]
fn a_fully_explored_grid_equals_its_graph() {
    for (name, map) in maps() {
        for kind in [PotentialKind::Heat, PotentialKind::Hops] {
            let world = map.fully_explored().fit(kind).values;
            let graph = on_graph(&map.adjacency(), &map.goals(), kind)
                .unwrap()
                .values;
            for (a, b) in world.iter().zip(&graph) {
                assert!((a - b).abs() < TOL, "{kind} on {name}: {a} against {b}");
            }
        }
    }
}

#[test]
fn with_untried_actions_the_neighbours_stand_in() {
    let map = Map::open(5, 7, &[0]);
    // Every edge is known from one of its ends: no state but the border ones has tried all actions.
    let world = map.explored(-1.0, |_, action| action == 0 || action == 3);
    for kind in [PotentialKind::Heat, PotentialKind::Hops] {
        let partial = world.fit(kind).values;
        let graph = on_graph(&map.adjacency(), &map.goals(), kind)
            .unwrap()
            .values;
        for (a, b) in partial.iter().zip(&graph) {
            assert!((a - b).abs() < TOL, "{kind}: {a} against {b}");
        }
    }
}

/// A ring that can be walked one way only: the cell just past the goal is the farthest from it.
#[test]
fn one_way_moves_are_respected() {
    let map = Map::new(
        ">>>v
         ^##v
         G<<<",
    );
    let world = map.fully_explored();
    for kind in DEPENDABLE {
        let phi = world.fit(kind).values;
        // States in reading order: 0–3 the top row, 4 and 5 the sides, 6 the goal, 7–9 the rest of the bottom row.
        let along_the_ring = [4, 0, 1, 2, 3, 5, 9, 8, 7, 6];
        for pair in along_the_ring.windows(2) {
            assert!(phi[pair[0]] < phi[pair[1]], "{kind}: {phi:?}");
        }
        assert_eq!(world.false_maxima(&phi), [], "{kind}");
        // Nine steps, whatever the temperature: there is no choice.
        let steps = match STRETCHED.contains(&kind) {
            true => 9.0,
            false => sum_of(discount(1.0, 10), 9.0),
        };
        assert!((phi[4] + 2.0 * steps).abs() < TOL, "{kind}: {}", phi[4]);
    }
}

#[test]
fn a_trap_without_return_has_the_lowest_value() {
    // Through the one-way cell (state 4) into a dead end (5, 6).
    let map = Map::new("G...>..");
    let world = map.fully_explored();
    for kind in DEPENDABLE {
        let phi = world.fit(kind).values;
        let lowest = match STRETCHED.contains(&kind) {
            true => phi[3],
            false => -2.0 * 70.0,
        };
        assert!(
            phi[4..].iter().all(|p| (p - lowest).abs() < 1e-3),
            "{kind}: {phi:?}"
        );
        assert!(
            phi[..4].is_sorted_by(|a, b| a > b) && phi[3] >= lowest,
            "{kind}: {phi:?}"
        );
        assert_eq!(world.false_maxima(&phi), [], "{kind}");
    }
}

#[test]
fn slow_cells_are_far_away() {
    // Two ways of equal length round the wall; the lower one is slow.
    let map = Map::new(
        ".......
         .#####.
         G#####.
         .#####.
         .~~~~~.",
    );
    let world = map.fully_explored();
    for kind in RETURNS {
        let phi = world.fit(kind).values;
        let (upper, middle, lower) = (8, 10, 12);
        assert!(
            phi[upper] > phi[middle] && phi[middle] > phi[lower],
            "{kind}: {phi:?}"
        );
        assert_eq!(world.false_maxima(&phi), []);
    }
    let g = discount(1.0, map.num_states());
    let hops = world.fit(PotentialKind::Hops).values;
    for (state, expected) in [
        (8, sum_of(g, 9.0)),
        (12, sum_of(g, 11.0)),
        // Through the first two slow cells, and two steps on.
        (14, 5.0 + g * sum_of(g, 2.0)),
        (15, 5.0 * (1.0 + g) + g * g * sum_of(g, 2.0)),
    ] {
        assert!(
            (hops[state] + 2.0 * expected).abs() < TOL,
            "{state}: {}",
            hops[state]
        );
    }
}

#[test]
fn a_poorer_goal_attracts_less() {
    let map = Map::open(1, 41, &[0, 40]);
    let world = map.explored_with(
        -1.0,
        |goal| if goal == 40 { -10.0 } else { 0.0 },
        0,
        |_, _| true,
    );
    for kind in RETURNS {
        let phi = world.fit(kind).values;
        assert_eq!((phi[0], phi[40]), (0.0, 0.0), "nothing follows an end");
        // 25 steps to the first one cost as much as 15 and 10 more. At temperature T a step costs T arcosh e^{1/T}, which is 4.4 for `heat`
        // and 1 to 2.2 for `gcn`, and 10 are so many fewer of them.
        let watershed = (1..40).min_by(|&a, &b| phi[a].total_cmp(&phi[b])).unwrap();
        let expected = match kind {
            PotentialKind::Hops => 25..=25,
            PotentialKind::Heat => 21..=22,
            _ => 22..=25,
        };
        assert!(expected.contains(&watershed), "{kind}: {watershed}");
        // At a temperature somewhat more, for what is far is discounted a little.
        let error = (phi[39] - phi[1] + 2.0 * 10.0).abs();
        let most = if kind == PotentialKind::Hops {
            TOL
        } else {
            0.5
        };
        assert!(error < most, "{kind}: {} {}", phi[39], phi[1]);
    }
}

/// Ends that cost repel, whatever the kind of return; and all kinds are 0 there.
#[test]
fn ends_that_cost_repel() {
    let map = Map::new(
        "..X...
         ......
         ..X..G",
    );
    let pit = |end: u32| if end == 17 { 0.0 } else { -30.0 };
    let world = map.explored_with(-1.0, pit, 0, |_, _| true);
    for kind in PotentialKind::ALL {
        let mut potential = build(kind);
        (0..18).for_each(|s| potential.tell(StateId(s), 3.0));
        let phi = world.with(|inputs| potential.fit(inputs)).unwrap().values;
        assert_eq!([phi[2], phi[14], phi[17]], [0.0; 3], "{kind}");
    }
    let g = discount(1.0, 18);
    let hops = world.fit(PotentialKind::Hops).values;
    // Round the pits and not into them: they do not pay.
    assert!((hops[1] + 2.0 * sum_of(g, 6.0)).abs() < TOL, "{hops:?}");
    let heat = world.fit(PotentialKind::Heat).values;
    let safe = Map::new("...... ...... .....G")
        .fully_explored()
        .fit(PotentialKind::Heat)
        .values;
    // Before the gate more than past it.
    let loss = |s: usize| safe[s] - heat[s];
    for (before, past) in [(1, 4), (7, 10), (13, 16)] {
        assert!(
            loss(before) > 3.0 * loss(past) && loss(past) > 0.0,
            "{heat:?}"
        );
    }
    // A pit that costs less than the way is an end worth seeking, though it is no goal.
    let cheap = map.explored_with(
        -1.0,
        |end| if end == 17 { 0.0 } else { -2.0 },
        0,
        |_, _| true,
    );
    let hops = cheap.fit(PotentialKind::Hops).values;
    assert!((hops[1] + 2.0 * 3.0).abs() < TOL, "{hops:?}");
}

/// A goal that pays: φ is positive and rises towards it, but 0 there.
#[test]
fn ends_that_pay_attract() {
    let map = Map::open(1, 9, &[0]);
    let mut world = map.explored_with(0.0, |_| 3.0, 0, |_, _| true);
    world.gamma = 0.9;
    let g = discount(0.9, 9);
    for kind in RETURNS {
        let phi = world.fit(kind).values;
        assert_eq!(phi[0], 0.0);
        assert!(phi[1..].is_sorted_by(|a, b| a > b), "{kind}: {phi:?}");
        if kind == PotentialKind::Hops {
            for steps in 1..9 {
                let expected = 2.0 * 3.0 * g.powi(steps - 1);
                assert!((phi[steps as usize] - expected).abs() < TOL, "{phi:?}");
            }
        }
    }
}

/// The shortest way leads along a ledge. Who never slips takes it; who slips had better keep away.
#[test]
fn a_ledge_is_worth_less_to_who_slips() {
    let map = Map::new(
        "........
         ........
         ........
         .XXXXXXG",
    );
    let pit = |end: u32| if end == 31 { 0.0 } else { -100.0 };
    for kind in RETURNS {
        let slipping = map
            .explored_with(-1.0, pit, 1, |_, _| true)
            .fit(kind)
            .values;
        let (above, ledge) = (8 + 3, 16 + 3);
        let sure = map
            .explored_with(-1.0, pit, 0, |_, _| true)
            .fit(kind)
            .values;
        let wall = Map::new("........ ........ ........ .######G");
        let wall = wall.fully_explored().fit(kind).values;
        assert!(
            wall[ledge] > wall[above],
            "{kind}: without pits it is nearer"
        );
        assert!(
            sure[ledge] > sure[above] || kind == PotentialKind::Heat,
            "{kind}: {sure:?}"
        );
        assert!(slipping[ledge] < slipping[above], "{kind}: {slipping:?}");
    }
}

/// Moved ends: where one was, there is a state like others.
#[test]
fn an_end_that_is_none_any_more_counts_as_a_state() {
    let map = Map::open(1, 7, &[0, 6]);
    let mut world = map.fully_explored();
    world.ends[6] = false;
    world.goals.pop();
    let g = discount(1.0, 7);
    for kind in RETURNS {
        let phi = world.fit(kind).values;
        // Nothing was tried there, and the way back is open.
        assert!(phi[..].is_sorted_by(|a, b| a > b), "{kind}: {phi:?}");
        if kind == PotentialKind::Hops {
            assert!((phi[6] + 2.0 * sum_of(g, 6.0)).abs() < TOL, "{phi:?}");
        }
    }
}

#[test]
fn the_discount_is_that_of_the_agent() {
    let map = Map::open(3, 6, &[0]);
    let mut world = map.fully_explored();
    world.gamma = 0.8;
    let phi = world.fit(PotentialKind::Hops).values;
    for (i, phi) in phi.iter().enumerate() {
        let expected = -2.0 * sum_of(discount(0.8, 18), (i / 6 + i % 6) as f64);
        assert!(
            (phi - expected).abs() < TOL,
            "{i}: {phi} against {expected}"
        );
    }
}

#[test]
fn the_scale_is_that_of_the_reward() {
    let map = Map::open(5, 5, &[24]);
    for kind in DEPENDABLE {
        let unit = map.explored(-1.0, |_, _| true).fit(kind).values;
        let tenth = map.explored(-0.1, |_, _| true).fit(kind).values;
        for (unit, tenth) in unit.iter().zip(&tenth) {
            assert!(
                (0.1 * unit - tenth).abs() < 0.1 * TOL,
                "{kind}: {unit} {tenth}"
            );
        }
    }
    for kind in STRETCHED {
        let lowest = |world: World| world.fit(kind).values.iter().copied().fold(0.0, f64::min);
        assert!((lowest(map.explored(-1.0, |_, _| true)) + 16.0).abs() < TOL);
        // Nothing a step, 3 at the goal: twice the 3.
        let bonus = map.explored_with(0.0, |_| 3.0, 0, |_, _| true);
        assert!((lowest(bonus) + 6.0).abs() < TOL);
    }
}

#[test]
fn before_the_first_goal_kinds_made_of_ways_are_flat() {
    let mut world = Map::open(3, 3, &[8]).fully_explored();
    world.goals.clear();
    world.ends.fill(false);
    let made_of_returns = |kind| build(kind).is_made_of_returns();
    let kinds = PotentialKind::ALL.into_iter();
    assert_eq!(
        kinds.clone().filter(|&kind| made_of_returns(kind)).count(),
        3
    );
    for kind in kinds.filter(|&kind| !made_of_returns(kind)) {
        assert_eq!(world.fit(kind).values, [0.0; 9], "{kind}");
    }
    // Steps that cost nothing tell those made of returns nothing either.
    let mut free = Map::open(3, 3, &[8]).explored(0.0, |_, _| true);
    free.goals.clear();
    free.ends.fill(false);
    for kind in RETURNS {
        let phi = free.fit(kind).values;
        let small = tolerance(discount(1.0, 9));
        assert!(phi.iter().all(|phi| phi.abs() < small), "{kind}: {phi:?}");
    }
}

/// With bad ends alone on the map, φ is lowest beside them and rises to where something was not tried.
#[test]
fn before_the_first_goal_bad_ends_repel_and_the_unknown_attracts() {
    let map = Map::new("X.......");
    for step in [-1.0, 0.0] {
        let world = map.explored_with(step, |_| -20.0, 0, |state, _| state < 7);
        assert!(world.goals.is_empty());
        for kind in RETURNS {
            let phi = world.fit(kind).values;
            assert_eq!((phi[0], phi[7]), (0.0, 0.0), "{kind}: {phi:?}");
            let rises = match (step == 0.0, kind) {
                // The optimal policy loses nothing on the way.
                (true, PotentialKind::Hops) => phi[1..].iter().all(|phi| phi.abs() < 1e-3),
                _ => phi[1..].is_sorted_by(|a, b| a < b),
            };
            assert!(rises, "{kind}: {phi:?}");
        }
    }
}

#[test]
fn the_oracle_repeats_what_it_was_told() {
    let world = Map::open(2, 2, &[3]).explored(-0.5, |_, _| true);
    let mut oracle = build(PotentialKind::Oracle);
    for (state, distance) in [(0, 2.0), (1, 1.0), (3, 0.0), (7, f64::INFINITY)] {
        oracle.tell(StateId(state), distance);
    }
    let phi = world.with(|inputs| oracle.fit(inputs)).unwrap().values;
    assert_eq!(
        phi,
        [-2.0, -1.0, -2.0, 0.0],
        "state 2 was not told: the lowest value"
    );
    let mut oracle = build(PotentialKind::Oracle);
    oracle.tell(StateId(0), 2.0);
    let phi = world.with(|inputs| oracle.fit(inputs)).unwrap().values;
    assert_eq!(phi, [-2.0, -2.0, -2.0, 0.0], "a goal need not be told");
}

#[test]
fn the_negated_oracle_is_the_opposite_of_the_oracle() {
    let world = Map::open(3, 4, &[11]).explored(-0.3, |_, _| true);
    let [mut oracle, mut negated] =
        [PotentialKind::Oracle, PotentialKind::NegatedOracle].map(build);
    for told in 0..=12 {
        let fits = [&mut oracle, &mut negated].map(|potential| {
            let fit = world.with(|inputs| potential.fit(inputs));
            if told < 11 {
                let far = if told == 4 {
                    f64::INFINITY
                } else {
                    5.0 - f64::from(told) / 3.0
                };
                potential.tell(StateId(told), far);
            }
            fit.unwrap().values
        });
        let [phi, negated] = fits;
        assert!(phi.iter().all(|&phi| phi <= 0.0) && phi[11] == 0.0);
        let opposite: Vec<f64> = phi.iter().map(|phi| 0.0 - phi).collect();
        assert_eq!(bits(&negated), bits(&opposite), "{told} told");
        assert_eq!(phi.iter().any(|&phi| phi < 0.0), told > 0);
    }
}

#[test]
fn a_given_potential_is_what_was_given() {
    let mut world = Map::open(2, 2, &[3]).fully_explored();
    let mut given = build(PotentialKind::File);
    for (state, phi) in [(0, -2.5), (1, 7.0), (2, f64::NAN), (3, -1.0), (9, 1.0)] {
        given.tell(StateId(state), phi);
    }
    let mut fit = |world: &World| world.with(|inputs| given.fit(inputs)).unwrap().values;
    assert_eq!(fit(&world), [-2.5, 7.0, 0.0, 0.0], "0 at the goal");
    world.goals.clear();
    assert_eq!(fit(&world), [-2.5, 7.0, 0.0, 0.0], "and at any end");
    world.ends.clear();
    assert_eq!(fit(&world), [-2.5, 7.0, 0.0, -1.0]);
}

#[test]
fn rewards_that_are_not_finite_are_an_error() {
    let map = Map::open(2, 3, &[0]);
    let world = map.explored(f64::NAN, |_, _| true);
    let poor = map.explored_with(-1.0, |_| f64::NEG_INFINITY, 0, |_, _| true);
    for kind in DEPENDABLE {
        let message = |world: &World| {
            let error = world.with(|inputs| build(kind).fit(inputs)).unwrap_err();
            error.to_string()
        };
        let nan = message(&world);
        assert!(nan.contains("is NaN: rewards must be finite"), "{nan}");
        // The goal, or the state beside it.
        let beside = if STRETCHED.contains(&kind) { 0 } else { 1 };
        let expected = format!("state {beside} is -inf");
        assert!(message(&poor).contains(&expected), "{}", message(&poor));
    }
}

/// The graph grows between fits; features lag behind and gain columns.
#[test]
fn learnt_potentials_survive_growth() {
    let map = Map::open(6, 6, &[0]);
    for kind in [PotentialKind::Gcn, PotentialKind::Report] {
        let mut model = build(kind);
        for (rows, columns) in [(0, 0), (10, 3), (30, 4), (36, 4), (36, 2)] {
            let world = map.fully_explored();
            let lagging = Mat::from_fn(rows, columns, |i, c| ((i + 3 * c) as f64).sin());
            let fit = world.with(|inputs| {
                model.fit(&PotentialInputs {
                    features: lagging.as_ref(),
                    ..*inputs
                })
            });
            let values = fit.unwrap().values;
            assert_eq!(values.len(), 36);
            assert_eq!(values[0], 0.0);
        }
    }
}

/// A potential written down and read back between fits, on a world that is explored meanwhile, with features that gain
/// columns and change, fits on to the same bits. Learnt ones train, and start warm.
#[test]
fn a_potential_read_back_goes_on_to_the_same_bits() {
    let map = Map::open(9, 8, &[0]);
    let fits = [
        (30, 20, 3),
        (50, 50, 4),
        (50, 72, 4),
        (72, 72, 4),
        (72, 72, 2),
    ];
    for kind in PotentialKind::ALL {
        let shaping = ShapingParams {
            potential: kind,
            fit_tolerance: 0.0,
            ..twice()
        };
        let mut kept = build_potential(&shaping, &GcnParams::default(), 1);
        let mut read = read_back(&kept);
        for (explored, rows, columns) in fits {
            let world = map.explored(-1.0, |state, _| state < explored);
            let features = Mat::from_fn(rows, columns, |i, c| ((i + 3 * c + rows) as f64).sin());
            let [expected, found] = [&mut kept, &mut read].map(|potential| {
                potential.tell(StateId(explored - 1), f64::from(explored) / 3.0);
                potential.tell(StateId(1), f64::INFINITY);
                let fit = world.with(|inputs| {
                    potential.fit(&PotentialInputs {
                        features: features.as_ref(),
                        ..*inputs
                    })
                });
                fit.unwrap()
            });
            assert_eq!(bits(&found.values), bits(&expected.values), "{kind}");
            assert_eq!(found, expected, "{kind}");
            assert!(read == kept, "{kind}");
            read = read_back(&read);
        }
    }
}

fn read_back(potential: &AnyPotential) -> AnyPotential {
    postcard::from_bytes(&postcard::to_stdvec(potential).unwrap()).unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}
