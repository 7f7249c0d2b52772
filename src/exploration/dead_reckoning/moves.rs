//! Displacements that actions mean.

/// The moves of a world: δ of each action, and which action undoes which.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Moves {
    pub shifts: Vec<Vec<i32>>,
    pub inverse: Vec<usize>,
}

impl Moves {
    pub fn num_actions(&self) -> usize {
        self.shifts.len()
    }

    /// Which action's δ leads from one position to the other.
    pub fn between(&self, from: &[i32], to: &[i32]) -> Option<usize> {
        let reaches = |shift: &Vec<i32>| {
            from.iter()
                .zip(shift)
                .zip(to)
                .all(|((a, b), c)| a + b == *c)
        };
        self.shifts.iter().position(reaches)
    }
}
