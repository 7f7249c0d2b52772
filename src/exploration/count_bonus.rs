//! The count bonus β/√N(s), the classic peer (Bellemare et al. 2016; Strehl & Littman 2008).

use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// Counts visits and pays for rare ones.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CountBonus {
    beta: f64,
    visits: Vec<u32>,
}

impl CountBonus {
    /// A bonus of `beta` reward units at the first visit.
    pub fn new(beta: f64) -> Self {
        Self {
            beta,
            visits: Vec::new(),
        }
    }

    /// Counts a visit of `state` and returns β/√N. Amortised O(1).
    pub fn visit(&mut self, state: StateId) -> f64 {
        if state.index() >= self.visits.len() {
            self.visits.resize(state.index() + 1, 0);
        }
        let visits = &mut self.visits[state.index()];
        *visits += 1;
        self.beta / f64::from(*visits).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bonus_falls_with_the_root_of_the_count() {
        let mut bonus = CountBonus::new(2.0);
        let paid: Vec<f64> = (0..4).map(|_| bonus.visit(StateId(3))).collect();
        for (i, b) in paid.iter().enumerate() {
            assert!((b - 2.0 / ((i + 1) as f64).sqrt()).abs() < 1e-15);
        }
        assert_eq!(bonus.visit(StateId(0)), 2.0);
    }
}
