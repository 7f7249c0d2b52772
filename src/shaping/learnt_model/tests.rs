use super::*;
use crate::env::Action;
use crate::shaping::fixtures::{any_graph, graph};
use crate::shaping::soft_bellman::SoftBellman;
use proptest::prelude::*;

/// A world of `n` states as it was seen in these steps: from, action, reward, to.
fn world(n: usize, actions: usize, steps: &[(u32, u16, f64, u32)]) -> TransitionGraph {
    let mut graph = TransitionGraph::new(actions);
    (0..n).for_each(|_| {
        graph.add_state();
    });
    for &(from, action, reward, to) in steps {
        graph.record(StateId(from), Action(action), reward, StateId(to), false);
    }
    graph
}

/// V by state at `tau` typical steps.
fn values(model: &LearntModel, tau: f64) -> Vec<f64> {
    let tau = model.temperatures(tau);
    let (v, statistics) =
        SoftBellman::new(&model.process).solve_cold(&tau, 1e-9 * model.step_reward);
    assert!(statistics.converged, "{statistics:?}");
    model.process.scatter(&v)
}

fn observed(graph: &TransitionGraph, ends: &[u32], goal_known: bool) -> LearntModel {
    let is_end = |s: usize| ends.contains(&(s as u32));
    let ends: Vec<bool> = (0..graph.num_states()).map(is_end).collect();
    LearntModel::observed(graph, &ends, goal_known, 1.0).unwrap()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (s, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() < 1e-7 * (1.0 + b.abs()),
            "state {s}: {a} against {b}"
        );
    }
}

// ---- what was tried ---------------------------------------------------------------------------------------------

/// An action that slips is worth the mean of its outcomes, whatever the temperature: chance cannot be steered.
#[test]
fn chance_is_averaged_over() {
    let steps = [
        (0, 0, -1.0, 2),
        (0, 0, -1.0, 2),
        (0, 0, -5.0, 2),
        (0, 0, -1.0, 1),
        (1, 0, -1.0, 0),
    ];
    let model = observed(&world(3, 1, &steps), &[2], true);
    let g = discount(1.0, 3);
    // V_0 = −2 + g/4 V_1,  V_1 = −1 + g V_0
    let first = (-2.0 - g / 4.0) / (1.0 - g * g / 4.0);
    for tau in [0.0, 0.5, 20.0] {
        assert_close(&values(&model, tau), &[first, -1.0 + g * first, 0.0]);
    }
}

/// A corridor with an end that costs and one that pays.
fn corridor() -> TransitionGraph {
    let steps = [
        (1, 1, -1.0, 2),
        (2, 0, -1.0, 1),
        (2, 1, -1.0, 3),
        (3, 0, -1.0, 2),
    ];
    let mut graph = world(5, 2, &steps);
    graph.record(StateId(1), Action(0), -20.0, StateId(0), true);
    graph.record(StateId(3), Action(1), 5.0, StateId(4), true);
    graph
}

#[test]
fn ends_that_pay_attract_and_ends_that_cost_repel() {
    let ends = [true, false, false, false, true];
    let model = LearntModel::observed(&corridor(), &ends, true, 0.9).unwrap();
    let g = 0.9 * (1.0 - 1.0 / 50.0);
    assert_close(
        &values(&model, 0.0),
        &[0.0, -1.0 + g * (-1.0 + 5.0 * g), -1.0 + 5.0 * g, 5.0, 0.0],
    );
    let warm = values(&model, 4.0);
    let cold = values(&model, 0.0);
    assert!(warm[1..4].is_sorted_by(|a, b| a < b), "{warm:?}");
    assert!((1..4).all(|s| warm[s] < cold[s]), "{warm:?}");
    // The end that costs weighs on the state beside it most.
    assert!(
        cold[1] - warm[1] > 1.5 * (cold[2] - warm[2]),
        "{warm:?} {cold:?}"
    );
    assert_eq!((warm[0], warm[4]), (0.0, 0.0), "nothing follows an end");
    assert_eq!(model.process.order(), [3, 2, 1], "away from the best end");
    let steps: Vec<f64> = model.process.distances().to_vec();
    assert_eq!(steps, [1.0, 2.0, 3.0]);
}

/// Where an episode ended formerly, it now goes on, and the bonus is gone: the step costs what steps do.
#[test]
fn an_end_that_was_moved_is_a_state_like_others() {
    let mut corridor = corridor();
    corridor.forget_end(StateId(4), -1.0);
    let goal_elsewhere = values(&observed(&corridor, &[0], true), 0.0);
    let g = discount(1.0, 5);
    // Nothing was tried in 4: the way back may be open, at the price of a step.
    let mut expected = vec![0.0, -20.0];
    (2..5).for_each(|s| expected.push(-1.0 + g * expected[s - 1]));
    assert_close(&goal_elsewhere, &expected);
    let nothing_known = values(&observed(&corridor, &[0], false), 0.0);
    assert_close(&nothing_known[2..], &[-1.0 - g, -1.0, 0.0]);
    // Ends may be told of fewer states than there are.
    let short = LearntModel::observed(&corridor, &[true], false, 1.0).unwrap();
    assert_close(&values(&short, 0.0), &nothing_known);
}

/// Half of the tries stay: they are paid for, until one leaves.
#[test]
fn an_action_that_may_stay_counts_until_it_leaves() {
    let steps = [(0, 0, -1.0, 0), (0, 0, -3.0, 1), (1, 0, -2.0, 2)];
    let model = observed(&world(3, 1, &steps), &[2], true);
    let g = discount(1.0, 3);
    // V_0 = −2 + g (V_0 + V_1) / 2
    let first = (-2.0 - g) / (1.0 - g / 2.0);
    for tau in [0.0, 3.0] {
        assert_close(&values(&model, tau), &[first, -2.0, 0.0]);
    }
}

/// Choices of state 0: action 0 leads to an end, action 1 stays and pays `pay`.
fn beside_a_wall(pay: f64) -> LearntModel {
    observed(&world(2, 2, &[(0, 0, -1.0, 1), (0, 1, pay, 0)]), &[1], true)
}

#[test]
fn an_action_that_only_stays_is_left_out_unless_it_pays() {
    let g = discount(1.0, 2);
    for pay in [-1.0, -50.0, 0.0] {
        assert_close(&values(&beside_a_wall(pay), 7.0), &[-1.0, 0.0]);
    }
    assert_close(&values(&beside_a_wall(0.5), 0.0), &[0.5 / (1.0 - g), 0.0]);
    let (stay, leave): (f64, f64) = (0.5 / (1.0 - g), -1.0);
    // The one that pays is no step that costs, and neither is the end.
    assert_eq!(beside_a_wall(0.5).step_reward, 1.0);
    let mean = 0.5 * (stay.exp() + leave.exp());
    assert_close(&values(&beside_a_wall(0.5), 1.0), &[mean.ln(), 0.0]);
}

#[test]
fn where_all_actions_stay_the_best_of_them_does_for_ever() {
    let walled_in = world(
        3,
        2,
        &[
            (0, 0, -2.0, 0),
            (0, 1, -1.0, 0),
            (1, 0, -1.0, 2),
            (1, 1, -1.0, 2),
        ],
    );
    let model = observed(&walled_in, &[2], true);
    let expected = -1.0 / (1.0 - discount(1.0, 3));
    for tau in [0.0, 1.0] {
        assert_close(&values(&model, tau), &[expected, -1.0, 0.0]);
    }
    assert_eq!(
        (model.process.order(), model.process.num_reached()),
        (&[1, 0][..], 1)
    );
}

#[test]
fn loops_that_pay_have_a_finite_return() {
    let steps = [
        (0, 0, 1.0, 1),
        (0, 1, -1.0, 2),
        (1, 0, 1.0, 0),
        (1, 1, 1.0, 0),
    ];
    let around = values(&observed(&world(3, 2, &steps), &[2], true), 0.0);
    let forever = 1.0 / (1.0 - discount(1.0, 3));
    assert_close(&around, &[forever, forever, 0.0]);
}

/// The same where a long way leads there.
#[test]
fn a_loop_that_pays_is_worth_going_to_from_afar() {
    let n = 12;
    let mut steps = vec![
        (0, 0, 1.0, 1),
        (0, 1, -1.0, n),
        (1, 0, 1.0, 0),
        (1, 1, 1.0, 0),
    ];
    steps.extend((2..n).flat_map(|s| [(s, 0, -1.0, s - 1), (s, 1, -1.0, s - 1)]));
    let v = values(
        &observed(&world(n as usize + 1, 2, &steps), &[n], true),
        0.0,
    );
    let g = discount(1.0, n as usize + 1);
    let forever = 1.0 / (1.0 - g);
    for s in 1..n {
        let away = g.powi(s as i32 - 1);
        let expected = away * forever - (1.0 - away) / (1.0 - g);
        let found = v[s as usize];
        assert!(
            (found - expected).abs() < 1e-5 * forever,
            "state {s}: {found} against {expected}"
        );
    }
}

// ---- what was not -----------------------------------------------------------------------------------------------

/// Untried actions take the steps back, at the reward of the steps there, once it is known that there is a goal.
#[test]
fn ways_back_are_open_when_a_goal_is_known() {
    // 0 ← 1 → 2 → 3, of which 0 is the goal; two steps into 2, at −1 and −3.
    let steps = [
        (1, 0, -1.0, 0),
        (1, 1, -1.0, 2),
        (1, 1, -3.0, 2),
        (2, 0, -1.0, 3),
    ];
    let g = discount(1.0, 4);
    let model = observed(&world(4, 2, &steps), &[0], true);
    assert_close(
        &values(&model, 0.0),
        &[0.0, -1.0, -2.0 - g, -1.0 - g * (2.0 + g)],
    );
    // In 2 back and on are a choice each; in 3 there is no choice but back.
    let v = values(&model, 1.5);
    let tau = 1.5 * model.step_reward;
    let two = [-2.0 + g * v[1], -1.0 + g * v[3]].map(|q| (q / tau).exp());
    assert_close(
        &v[2..],
        &[tau * (0.5 * (two[0] + two[1])).ln(), -1.0 + g * v[2]],
    );
    // Not where it was entered from is tried, too, nor when all is.
    let tried = [
        &steps[..],
        &[(2, 1, -9.0, 1), (3, 0, -1.0, 3), (3, 1, -2.0, 3)],
    ]
    .concat();
    let trap = values(&observed(&world(4, 2, &tried), &[0], true), 0.0);
    assert_close(&trap[2..], &[-9.0 - g, -1.0 / (1.0 - g)]);
}

/// Nothing leads back out of an end, even if a state was entered from it before it was one.
#[test]
fn no_way_back_leads_into_an_end() {
    let steps = [(0, 0, -1.0, 1), (2, 0, -1.0, 0), (2, 1, -1.0, 1)];
    let model = observed(&world(3, 2, &steps), &[0], true);
    // 1 was entered from 0 and 2, and 2 leads to the end.
    let g = discount(1.0, 3);
    assert_close(&values(&model, 0.0), &[0.0, -1.0 - g, -1.0]);
}

#[test]
fn what_is_untried_is_worth_nothing_while_no_goal_is_known() {
    // A pit, and a corridor that leads away from it as far as was seen.
    let steps = |step: f64| {
        let mut steps = vec![(1, 0, -20.0, 0), (1, 1, step, 2)];
        steps.extend((2..6).flat_map(|s| [(s, 0, step, s - 1), (s, 1, step, s + 1)]));
        world(7, 2, &steps)
    };
    let g = discount(1.0, 7);
    let dear = observed(&steps(-1.0), &[0], false);
    let to_go = |hops: i32| -(1.0 - g.powi(hops)) / (1.0 - g);
    let expected = [0.0, to_go(5), to_go(4), to_go(3), to_go(2), -1.0, 0.0];
    assert_close(&values(&dear, 0.0), &expected);
    for model in [dear, observed(&steps(0.0), &[0], false)] {
        for tau in [0.5, 10.0] {
            let v = values(&model, tau);
            assert!(v[1..].is_sorted_by(|a, b| a < b), "{v:?}");
            assert!(v[1] < -1.0 && v[6] == 0.0 && v[0] == 0.0, "{v:?}");
        }
    }
}

/// Beside what was tried it is one choice, however many actions are untried.
#[test]
fn what_is_untried_is_a_choice_beside_others() {
    let graph = world(3, 5, &[(0, 0, -1.0, 1), (0, 1, -3.0, 2), (2, 0, -1.0, 0)]);
    for tau in [0.0, 2.0] {
        let v = values(&observed(&graph, &[1], false), tau);
        let soft = |worths: &[f64]| match tau == 0.0 {
            true => worths.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            false => {
                let heat: f64 = worths.iter().map(|q| (q / tau).exp()).sum();
                tau * (heat / worths.len() as f64).ln()
            }
        };
        let g = discount(1.0, 3);
        assert_close(
            &v,
            &[
                soft(&[-1.0, -3.0 + g * v[2], 0.0]),
                0.0,
                soft(&[-1.0 + g * v[0], 0.0]),
            ],
        );
    }
}

/// Bumps tell nothing of a place where something else is untried, with a goal or without one.
#[test]
fn a_bump_is_left_out_where_something_is_untried() {
    let bumped = world(
        3,
        3,
        &[
            (0, 0, -1.0, 1),
            (1, 1, -1.0, 1),
            (0, 1, -1.0, 2),
            (0, 2, -1.0, 2),
        ],
    );
    for tau in [0.0, 5.0] {
        let v = values(&observed(&bumped, &[2], true), tau);
        let back = -1.0 + discount(1.0, 3) * v[0];
        assert_close(&v[1..], &[back, 0.0]);
        assert_close(
            &values(&observed(&bumped, &[2], false), tau)[1..],
            &[0.0, 0.0],
        );
    }
}

/// A state that nobody entered nor left is worth 0, whatever is known elsewhere.
#[test]
fn nothing_known_is_worth_nothing() {
    let graph = world(3, 2, &[(0, 0, -1.0, 1), (0, 1, -1.0, 1)]);
    for goal_known in [false, true] {
        assert_close(
            &values(&observed(&graph, &[1], goal_known), 2.0),
            &[-1.0, 0.0, 0.0],
        );
    }
    assert_eq!(values(&observed(&world(1, 2, &[]), &[], false), 2.0), [0.0]);
    assert!(observed(&world(0, 2, &[]), &[], false).process.is_empty());
}

// ---- the unit ---------------------------------------------------------------------------------------------------

#[test]
fn the_unit_is_the_median_of_what_steps_cost() {
    let steps = [
        (0, 0, -3.0, 1),
        (1, 0, 4.0, 0),
        (1, 1, 0.0, 0),
        (0, 1, -1.0, 0),
        (0, 2, -100.0, 2),
        (1, 2, 5.0, 0),
    ];
    assert_eq!(observed(&world(3, 3, &steps), &[2], true).step_reward, 4.0);
    assert_eq!(
        observed(&world(3, 3, &steps[..2]), &[2], true).step_reward,
        3.0,
        "the lower one"
    );
}

#[test]
fn where_steps_are_free_the_unit_spreads_the_largest_end_over_the_longest_way() {
    let free = |bad: f64| {
        let steps = [
            (1, 0, bad, 0),
            (1, 1, 0.0, 2),
            (2, 0, 0.0, 1),
            (2, 1, 0.0, 3),
            (3, 0, 0.0, 2),
            (3, 1, 6.0, 4),
        ];
        observed(&world(5, 2, &steps), &[0, 4], true)
    };
    // Two steps from 2 to either end.
    assert_eq!(free(0.0).step_reward, 3.0);
    assert_eq!(free(-60.0).step_reward, 30.0);
    assert_eq!(
        observed(&world(2, 1, &[(0, 0, 0.0, 1)]), &[1], false).step_reward,
        1.0
    );
    let model = free(0.0);
    assert_eq!(model.temperatures(2.5), [7.5; 3]);
    assert!((model.tolerance() - 3e-5).abs() < 1e-18);
}

#[test]
fn rewards_that_are_not_finite_are_an_error() {
    for bad in [f64::NAN, f64::INFINITY] {
        let graph = world(3, 2, &[(0, 0, -1.0, 2), (1, 1, bad, 2), (1, 0, -1.0, 2)]);
        let error = LearntModel::observed(&graph, &[false, false, true], true, 1.0).unwrap_err();
        let message = format!("the mean reward seen at state 1 is {bad}: rewards must be finite");
        assert_eq!(error.to_string(), message);
    }
}

// ---- bare graphs ------------------------------------------------------------------------------------------------

/// An edge is as likely as it weighs.
#[test]
fn weights_of_a_graph_are_chances() {
    let mut triplets = sprs::TriMatI::<f64, u32>::new((3, 3));
    for (i, j, weight) in [
        (0, 1, 1.0),
        (1, 0, 1.0),
        (1, 2, 3.0),
        (2, 1, 3.0),
        (1, 1, 9.0),
    ] {
        triplets.add_triplet(i, j, weight);
    }
    let adjacency = SymmetricCsr::new(triplets.to_csr()).unwrap();
    let v = values(&LearntModel::uniform(&adjacency, &[StateId(0)]), 2.0);
    let g = discount(1.0, 3);
    let (back, on) = (f64::exp(-0.5), f64::exp(0.5 * (-1.0 + g * v[2])));
    assert_close(
        &v,
        &[0.0, 2.0 * (0.25 * back + 0.75 * on).ln(), -1.0 + g * v[1]],
    );
}

proptest! {
    /// −(1 + g + … + g^{d−1}) at d hops, and for ever where there is no way.
    #[test]
    fn hops_on_any_graph(adjacency in any_graph(), goal in 0_u32..2) {
        let model = LearntModel::uniform(&adjacency, &[StateId(goal)]);
        let n = adjacency.num_nodes();
        let mut hops = vec![i32::MAX; n];
        hops[goal as usize] = 0;
        for round in 0..n as i32 {
            for i in 0..n {
                let mut next = adjacency.row(i).0.iter();
                if hops[i] == i32::MAX && next.any(|&j| hops[j as usize] == round) {
                    hops[i] = round + 1;
                }
            }
        }
        let g = discount(1.0, n);
        prop_assert_eq!(model.step_reward, 1.0);
        for (i, found) in values(&model, 0.0).into_iter().enumerate() {
            let expected = match hops[i] {
                i32::MAX => -1.0 / (1.0 - g),
                d => -(1.0 - g.powi(d)) / (1.0 - g),
            };
            prop_assert!((found - expected).abs() < 1e-6, "{}: {} against {}", i, found, expected);
        }
    }
}

#[test]
fn an_edge_into_a_goal_goes_no_farther() {
    // 0 – 1 – 2 – 3 with goals 1 and 3: nothing is learnt of 0 from beyond the goal.
    let model = LearntModel::uniform(
        &graph(4, &[(0, 1), (1, 2), (2, 3)]),
        &[StateId(1), StateId(3)],
    );
    assert_close(&values(&model, 3.0), &[-1.0, 0.0, -1.0, 0.0]);
}

// ---- any world, explored ----------------------------------------------------------------------------------------

/// What was seen of one action: rewards and next states.
type Seen = Vec<(f64, u32)>;

/// 2 to 5 states, in some of which episodes end, 1 to 3 actions, each of them tried 1 to 5 times in every other state.
fn any_explored_world() -> impl Strategy<Value = (Vec<Vec<Seen>>, Vec<bool>)> {
    (2_usize..6, 1_usize..4).prop_flat_map(|(n, actions)| {
        let step = (-3.0_f64..2.0, 0..n as u32);
        let seen = prop::collection::vec(step, 1..6);
        let states = prop::collection::vec(prop::collection::vec(seen, actions), n);
        (states, prop::collection::vec(prop::bool::weighted(0.3), n))
    })
}

/// V = τ ln mean_a e^{Q / τ}, by value iteration on frequencies. At τ = 0 waiting is a step like any other; at τ > 0 it is waited until an
/// action leaves, since a choice is made once.
fn by_hand(states: &[Vec<Seen>], ends: &[bool], g: f64, tau: f64) -> Vec<f64> {
    let mut v = vec![0.0; states.len()];
    for _ in 0..100_000 {
        let before = v.clone();
        for (s, actions) in states.iter().enumerate().filter(|&(s, _)| !ends[s]) {
            let worth = |seen: &Seen| {
                let reward: f64 =
                    seen.iter().map(|(reward, _)| reward).sum::<f64>() / seen.len() as f64;
                let chance = |j: usize| {
                    seen.iter().filter(|o| o.1 as usize == j).count() as f64 / seen.len() as f64
                };
                let next = (0..states.len()).filter(|&j| j != s && !ends[j]);
                let others = g * next.map(|j| chance(j) * before[j]).sum::<f64>();
                match tau == 0.0 {
                    true => reward + g * chance(s) * before[s] + others,
                    false => (reward + others) / (1.0 - g * chance(s)),
                }
            };
            let stays = |seen: &&Seen| seen.iter().all(|o| o.1 as usize == s);
            let pays = |seen: &&Seen| seen.iter().map(|o| o.0).sum::<f64>() > 0.0;
            let staying = actions.iter().filter(stays);
            let leaving: Vec<f64> = actions
                .iter()
                .filter(|seen| !stays(seen))
                .map(worth)
                .collect();
            // Of those that only stay, the best one; none if it does not pay and there is another choice.
            let reward = |seen: &&Seen| seen.iter().map(|o| o.0).sum::<f64>() / seen.len() as f64;
            let stay = staying.max_by(|a, b| reward(a).total_cmp(&reward(b)));
            let stay = stay
                .filter(|seen| pays(seen) || leaving.is_empty())
                .map(worth);
            let worths: Vec<f64> = leaving.into_iter().chain(stay).collect();
            let best = worths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            v[s] = best;
            if tau > 0.0 {
                let mean = worths.iter().map(|q| ((q - best) / tau).exp()).sum::<f64>()
                    / worths.len() as f64;
                v[s] += tau * mean.ln();
            }
        }
        let changes = v.iter().zip(&before).map(|(new, old)| (new - old).abs());
        if changes.fold(0.0, f64::max) < 1e-13 {
            break;
        }
    }
    v
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]
    #[test]
    fn an_explored_world_is_solved_as_by_hand(
        (states, ends) in any_explored_world(),
        gamma in prop_oneof![Just(1.0), 0.8_f64..1.0],
        tau in prop_oneof![Just(0.0), 0.1_f64..10.0],
        goal_known in any::<bool>(),
    ) {
        let mut steps = Vec::new();
        for (s, actions) in states.iter().enumerate().filter(|&(s, _)| !ends[s]) {
            for (action, seen) in actions.iter().enumerate() {
                steps.extend(seen.iter().map(|&(reward, to)| (s as u32, action as u16, reward, to)));
            }
        }
        let graph = world(states.len(), states[0].len(), &steps);
        let model = LearntModel::observed(&graph, &ends, goal_known, gamma).unwrap();
        let g = gamma * (1.0 - 1.0 / (10.0 * states.len() as f64));
        let expected = by_hand(&states, &ends, g, tau * model.step_reward);
        for (found, expected) in values(&model, tau).into_iter().zip(expected) {
            prop_assert!((found - expected).abs() < 1e-6, "{} against {}", found, expected);
        }
    }
}
