//! A queue of items to update, most urgent first (prioritised sweeping, Moore & Atkeson 1993).
//!
//! Priorities within a factor of two are one class, and come out latest first: a sweep gains nothing from a finer order, and an item that becomes
//! slightly more urgent need not move. One that enters a higher class leaves its old place behind, which is skipped when it surfaces.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};

/// Items 0, 1, 2, … with priorities > 0.
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
        f64::from_bits(u64::from(self.waiting[item] + 1) << 52)
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

    #[test]
    fn most_urgent_first_each_once() {
        let mut queue = SweepQueue::default();
        for (item, priority) in [
            (4, 1.0),
            (2, 3.0),
            (7, 3.0),
            (4, 5.0),
            (2, 0.5),
            (9, 0.0),
            (1, f64::NAN),
        ] {
            queue.push(item, priority);
        }
        assert_eq!(
            std::iter::from_fn(|| queue.pop()).collect::<Vec<_>>(),
            [4, 2, 7]
        );
        assert_eq!(queue.most_urgent(), 0.0);
        queue.push(4, 0.05);
        queue.push(4, 0.1);
        assert_eq!(queue.most_urgent(), 0.1);
        assert_eq!(queue.pop(), Some(4), "an item may wait again");
        assert_eq!(queue.pop(), None);
    }
}
