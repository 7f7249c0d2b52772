//! A queue of items to update, most urgent first (prioritised sweeping, Moore & Atkeson 1993).
//!
//! An item has one place at most: raising its priority adds a second copy to the heap, and the outdated one is
//! skipped when it surfaces. Equal priorities come out in order of number, so that runs repeat.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Urgency {
    priority: f64,
    item: u32,
}

impl Eq for Urgency {}

impl Ord for Urgency {
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority
            .total_cmp(&other.priority)
            .then(other.item.cmp(&self.item))
    }
}

impl PartialOrd for Urgency {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Items 0, 1, 2, … with priorities > 0.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SweepQueue {
    heap: BinaryHeap<Urgency>,
    /// The priority of each item; 0 when it does not wait.
    waiting: Vec<f64>,
}

impl SweepQueue {
    /// Makes `item` wait with `priority`, or raises it to that; ignored if priority is not above 0. O(log n).
    pub fn push(&mut self, item: usize, priority: f64) {
        if item >= self.waiting.len() {
            self.waiting.resize(item + 1, 0.0);
        }
        if priority > self.waiting[item] {
            self.waiting[item] = priority;
            let item = u32::try_from(item).expect("items are numbered by u32");
            self.heap.push(Urgency { priority, item });
        }
    }

    /// The priority of the most urgent item; 0 if none waits. Amortised O(log n).
    pub fn most_urgent(&mut self) -> f64 {
        while let Some(top) = self.heap.peek() {
            if self.waiting[top.item as usize] == top.priority {
                return top.priority;
            }
            self.heap.pop();
        }
        0.0
    }

    /// Takes the most urgent item. Amortised O(log n).
    pub fn pop(&mut self) -> Option<usize> {
        while let Some(Urgency { priority, item }) = self.heap.pop() {
            let item = item as usize;
            if self.waiting[item] == priority {
                self.waiting[item] = 0.0;
                return Some(item);
            }
        }
        None
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
