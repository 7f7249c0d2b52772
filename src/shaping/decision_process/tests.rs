use super::*;
use crate::shaping::fixtures::{Alternative, any_process, grid, process, walks};
use proptest::prelude::*;

/// Typical steps to the nearest end by sweeps over all choices until nothing changes, ∞ where there is none.
fn distances(states: &[Vec<Alternative>], step_reward: f64) -> Vec<f64> {
    let ends = states.iter().flatten().filter(|a| a.may_end);
    let best = ends.map(|a| a.reward).reduce(f64::max).unwrap_or(0.0);
    let mut distance = vec![f64::INFINITY; states.len()];
    for _ in 0..=states.len() {
        for (i, choices) in states.iter().enumerate() {
            for choice in choices {
                let cost = (-choice.reward / step_reward).clamp(COST_RANGE.0, COST_RANGE.1);
                let next = choice
                    .outcomes
                    .iter()
                    .map(|&(j, _)| distance[j as usize] + cost);
                let end = choice
                    .may_end
                    .then(|| 1.0 + (best - choice.reward) / step_reward);
                distance[i] = next.chain(end).fold(distance[i], f64::min);
            }
        }
    }
    distance
}

#[test]
fn the_near_come_first_and_what_reaches_no_end_comes_last() {
    // 0 is an end; 1 – 2 – 3 lead there; 4 and 5 lead to each other; 6 leads to 3 and 4.
    let to = |states: &[u32]| -> Vec<Alternative> {
        let one = |&j: &u32| Alternative::new(-1.0, j == 0, &[(j, 1.0)]);
        states.iter().map(one).collect()
    };
    let states = [&[][..], &[2, 0], &[1, 3], &[2], &[5], &[4], &[4, 3]].map(to);
    let process = process(&states, 1.0);
    assert_eq!(process.order(), [1, 2, 3, 6, 4, 5]);
    assert_eq!(
        (process.len(), process.num_states(), process.num_reached()),
        (6, 7, 4)
    );
    assert_eq!(process.distances(), [1.0, 2.0, 3.0, 4.0]);
    // Position 3 is state 6, whose nearer neighbour 3 has position 2, and the other 4.
    let columns = |range: Range<usize>| process.columns()[range].to_vec();
    assert_eq!(columns(process.near_range(3)), [2]);
    assert_eq!(columns(process.far_range(3)), [4]);
    // The columns are sorted, and their choices are not: the first one leads to state 4.
    assert_eq!(
        process.owners()[process.range(3)],
        [
            process.choices_of(3).start as u32 + 1,
            process.choices_of(3).start as u32
        ]
    );
    assert_eq!(
        process.scatter(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        [0.0, 1.0, 2.0, 3.0, 5.0, 6.0, 4.0]
    );
    assert!(columns(process.range(0)) == [1], "the end is left out");
}

/// The best end is one step away; another one is farther by what it pays less.
#[test]
fn a_worse_end_is_farther() {
    let choice =
        |reward, next: &[(u32, f64)]| vec![Alternative::new(reward, next.is_empty(), next)];
    let states = [
        choice(6.0, &[]),
        choice(-1.0, &[(0, 1.0)]),
        choice(1.0, &[]),
        choice(-4.0, &[(1, 1.0)]),
    ];
    assert_eq!(process(&states, 2.0).distances(), [1.0, 1.5, 3.5, 3.5]);
    assert_eq!(process(&states, 2.0).order(), [0, 1, 2, 3]);
    let hops = process(&states, f64::INFINITY);
    assert_eq!(
        (hops.distances(), hops.order()),
        (&[1.0, 1.0, 2.0, 3.0][..], &[0, 2, 1, 3][..])
    );
}

#[test]
fn a_process_of_nothing_but_ends_is_empty() {
    for states in [vec![], vec![vec![]; 3]] {
        let process = process(&states, 1.0);
        assert!(process.is_empty() && process.distances().is_empty());
        assert_eq!(process.scatter(&[]), vec![0.0; states.len()]);
    }
}

/// A grid is laid out by hops: each row has a nearer column.
#[test]
fn every_row_of_a_grid_begins_with_something_nearer() {
    let process = process(&walks(&grid(9, 7, &[20, 21]), |_| -1.0), 1.0);
    let hops = |state: u32| f64::from(state / 7 + state % 7);
    let reached = &process.order()[..process.num_reached()];
    assert_eq!(reached.len(), 9 * 7 - 3);
    for (p, (&state, &distance)) in reached.iter().zip(process.distances()).enumerate() {
        assert!(distance >= hops(state));
        assert!(distance == 1.0 || !process.near_range(p).is_empty());
    }
}

/// The rows hold what was written down, near columns before far ones.
fn assert_rows(
    process: &DecisionProcess,
    states: &[Vec<Alternative>],
) -> Result<(), TestCaseError> {
    for (p, &state) in process.order().iter().enumerate() {
        let choices = &states[state as usize];
        let numbers = process.choices_of(p);
        prop_assert_eq!(numbers.len(), choices.len());
        let total: f64 = choices.iter().map(|a| a.weight).sum();
        for (number, choice) in numbers.clone().zip(choices) {
            prop_assert_eq!(process.reward(number), choice.reward);
            prop_assert!((process.prior(number) - choice.weight / total).abs() < 1e-14);
        }
        // Near columns, then far ones, ascending; together the outcomes that are no ends.
        let (near, far) = (process.near_range(p), process.far_range(p));
        prop_assert_eq!(
            (near.start, near.end, far.end),
            (process.range(p).start, far.start, process.range(p).end)
        );
        prop_assert!(process.columns()[process.range(p)].is_sorted());
        prop_assert!(process.columns()[near].iter().all(|&j| (j as usize) < p));
        prop_assert!(process.columns()[far].iter().all(|&j| (j as usize) > p));
        let entries = process.range(p).map(|e| {
            let target = process.order()[process.columns()[e] as usize];
            (
                process.owners()[e] as usize - numbers.start,
                target,
                process.probabilities()[e].to_bits(),
            )
        });
        let mut found: Vec<_> = entries.collect();
        let mut expected: Vec<_> = (choices.iter().enumerate())
            .flat_map(|(c, a)| {
                a.outcomes
                    .iter()
                    .map(move |&(j, chance)| (c, j, chance.to_bits()))
            })
            .filter(|&(_, j, _)| !states[j as usize].is_empty())
            .collect();
        found.sort_unstable();
        expected.sort_unstable();
        prop_assert_eq!(found, expected);
    }
    Ok(())
}

proptest! {
    #[test]
    fn the_layout_keeps_everything(states in any_process(0.0), step_reward in 0.1_f64..4.0) {
        let process = process(&states, step_reward);
        let distance = distances(&states, step_reward);
        prop_assert_eq!(process.num_states(), states.len());

        // Every state with a choice has one position.
        let mut sorted = process.order().to_vec();
        sorted.sort_unstable();
        let with_choices: Vec<u32> = (0..states.len() as u32)
            .filter(|&i| !states[i as usize].is_empty())
            .collect();
        prop_assert_eq!(&sorted, &with_choices);

        // Nearest first, and last what leads to no end.
        let (reached, left) = process.order().split_at(process.num_reached());
        prop_assert!(process.distances().is_sorted());
        for (&state, found) in reached.iter().zip(process.distances()) {
            prop_assert!((found - distance[state as usize]).abs() < 1e-9);
        }
        prop_assert!(left.iter().all(|&s| distance[s as usize].is_infinite()));

        assert_rows(&process, &states)?;
        // In any order that leaves what leads to no end at the end.
        let reached = process.num_reached() as u32;
        let order: Vec<u32> = (0..reached).rev().chain(reached..process.len() as u32).collect();
        let rearranged = process.rearranged(&order);
        assert_rows(&rearranged, &states)?;
        prop_assert_eq!((rearranged.num_states(), rearranged.num_reached()), (states.len(), reached as usize));
        for (&state, found) in rearranged.order().iter().zip(rearranged.distances()) {
            prop_assert!((found - distance[state as usize]).abs() < 1e-9);
        }
        let (offsets, sources) = process.predecessors();
        for (entry, &column) in process.columns().iter().enumerate() {
            let into = &sources[offsets[column as usize]..offsets[column as usize + 1]];
            let row = into.iter().find(|source| source.1 as usize == entry).unwrap().0;
            prop_assert!(process.range(row as usize).contains(&entry));
        }
        prop_assert_eq!(sources.len(), process.nnz());

        if let Some(last) = process.len().checked_sub(1) {
            prop_assert_eq!(process.range(last).end, process.nnz());
        }

        let numbered: Vec<f64> = (1..=process.len()).map(|p| p as f64).collect();
        let scattered = process.scatter(&numbered);
        for (state, value) in scattered.iter().enumerate() {
            let position = process.order().iter().position(|&s| s as usize == state);
            prop_assert_eq!(*value, position.map_or(0.0, |p| (p + 1) as f64));
        }
    }
}
