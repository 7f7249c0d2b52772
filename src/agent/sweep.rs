//! A queue of items to update, most urgent first (prioritised sweeping, Moore & Atkeson 1993).
//!
//! Priorities within a factor of two are one class, and come out in the order in which they came: a sweep gains nothing from a finer order, and an item that becomes
//! slightly more urgent need not move. One that enters a higher class leaves its old place behind, which is skipped when it surfaces.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};

/// Items 0, 1, 2, … with priorities > 0. Memory O(items + places left in classes that have not come up since).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SweepQueue {
    /// Items by class, and places that items have left.
    classes: BTreeMap<u16, VecDeque<u32>>,
    /// The class of each item; 0 when it does not wait.
    waiting: Vec<u16>,
}

impl SweepQueue {
    /// Makes `item` wait with `priority`, or raises it to that; ignored if priority is not above 0. O(log classes).
    #[inline]
    pub fn push(&mut self, item: usize, priority: f64) {
        if item >= self.waiting.len() {
            self.waiting.resize(item + 1, 0);
        }
        let class = class_of(priority);
        if class > self.waiting[item] {
            self.waiting[item] = class;
            let item = u32::try_from(item).expect("items are numbered by u32");
            self.classes.entry(class).or_default().push_back(item);
        }
    }

    /// A power of two that no waiting item's priority exceeds and the most urgent one's half; 0 if none waits. Amortised O(log classes).
    pub fn most_urgent(&mut self) -> f64 {
        let Some(item) = self.first() else {
            return 0.0;
        };
        let above = (self.waiting[item] + 1).min(INFINITE);
        f64::from_bits(u64::from(above) << 52)
    }

    /// Takes the most urgent item. Amortised O(log classes).
    #[inline]
    pub fn pop(&mut self) -> Option<usize> {
        let item = self.first()?;
        self.waiting[item] = 0;
        Some(item)
    }

    /// The most urgent item; it stays. Drops the places that items have left before it.
    fn first(&mut self) -> Option<usize> {
        while let Some(mut class) = self.classes.last_entry() {
            let waits = |&item: &u32| self.waiting[item as usize] == *class.key();
            match class.get().front().copied().filter(waits) {
                Some(item) => return Some(item as usize),
                None if class.get().is_empty() => drop(class.remove()),
                None => drop(class.get_mut().pop_front()),
            }
        }
        None
    }
}

/// The class of ∞.
const INFINITE: u16 = 0x7ff;

/// The binary exponent of a number, from 1; 0 for what is not above 0.
fn class_of(priority: f64) -> u16 {
    match priority > 0.0 {
        true => ((priority.to_bits() >> 52) as u16).max(1),
        false => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    #[test]
    fn most_urgent_first_each_once() {
        let mut queue = SweepQueue::default();
        let pushed = [
            (4, 1.0),
            (2, 4.0),
            (7, 5.0),
            (4, 8.0),
            (2, 0.5),
            (9, 0.0),
            (1, f64::NAN),
        ];
        for (item, priority) in pushed {
            queue.push(item, priority);
        }
        let popped: Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(
            popped,
            [4, 2, 7],
            "those of a class in the order in which they came"
        );
        assert_eq!(queue.most_urgent(), 0.0);
        queue.push(4, 0.05);
        queue.push(4, 0.1);
        assert_eq!(queue.most_urgent(), 0.125);
        assert_eq!(queue.pop(), Some(4), "an item may wait again");
        assert_eq!(queue.pop(), None);
    }

    #[test]
    fn no_priority_is_too_large_or_too_small() {
        let mut queue = SweepQueue::default();
        queue.push(0, f64::INFINITY);
        assert_eq!(queue.most_urgent(), f64::INFINITY);
        queue.push(1, f64::MIN_POSITIVE / 8.0);
        queue.push(2, f64::MAX);
        let popped: Vec<_> = std::iter::from_fn(|| queue.pop()).collect();
        assert_eq!(popped, [0, 2, 1]);
    }

    proptest! {
        /// Against a table of what waits: whatever comes out is at most twice less urgent than anything else.
        #[test]
        fn nothing_twice_as_urgent_is_left_waiting(
            calls in prop::collection::vec(prop::option::of((0..12_usize, 1e-3..1e3_f64)), 1..200),
        ) {
            let mut queue = SweepQueue::default();
            let mut waiting: BTreeMap<usize, f64> = BTreeMap::new();
            for call in calls {
                if let Some((item, priority)) = call {
                    queue.push(item, priority);
                    let known = waiting.entry(item).or_insert(priority);
                    *known = known.max(priority);
                } else {
                    let most = waiting.values().copied().fold(0.0, f64::max);
                    let bound = queue.most_urgent();
                    prop_assert!(most <= bound && bound <= 2.0 * most);
                    let popped = queue.pop();
                    prop_assert_eq!(popped.is_some(), !waiting.is_empty());
                    let priority = popped.map(|item| waiting.remove(&item).expect("it waited"));
                    prop_assert!(priority.is_none_or(|priority| 2.0 * priority > most));
                }
            }
        }
    }
}
