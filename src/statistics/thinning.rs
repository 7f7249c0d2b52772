//! Thinning of a stream of unknown length: which of its items to keep.

use serde::{Deserialize, Serialize};

/// Filter of a stream: keeps every stride-th of a stream, from the first on, and doubles the stride after each `run` of them: of n there are
/// at most `run` · (1 + log₂(1 + n / run)) kept. Decides by numbers alone, so that equal runs keep the same.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Thinning {
    run: u64,
    stride: u64,
    kept: u64,
    /// To be left out before the next one that is kept.
    skip: u64,
}

impl Thinning {
    /// Runs of `run`, at least 1.
    pub fn new(run: u64) -> Self {
        Self {
            run,
            stride: 1,
            kept: 0,
            skip: 0,
        }
    }

    /// Whether to keep the next one.
    pub fn keeps(&mut self) -> bool {
        if self.skip > 0 {
            self.skip -= 1;
            return false;
        }
        self.kept += 1;
        if self.kept.is_multiple_of(self.run) {
            self.stride *= 2;
        }
        self.skip = self.stride - 1;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ever_fewer_are_kept() {
        let mut thinning = Thinning::new(3);
        let kept: Vec<u64> = (0..40).filter(|_| thinning.keeps()).collect();
        assert_eq!(kept, [0, 1, 2, 4, 6, 8, 12, 16, 20, 28, 36]);
        let mut thinning = Thinning::new(2000);
        let kept = (0..1_000_000).filter(|_| thinning.keeps()).count();
        assert!(kept <= 2000 * 10, "{kept}");
    }
}
