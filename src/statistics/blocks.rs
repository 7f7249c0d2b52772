//! Many episodes as few: blocks whose ends lie evenly on a logarithmic scale.
//!
//! ```text
//! e_i = round(n^(i/m)),  i = 0 … m,  without repetitions
//! ```
//!
//! What is learnt is learnt early, so the first episodes keep a block each, while the last blocks hold n ln(n) / m.

use std::ops::Range;

/// Blocks that cover episodes 0..`episodes`, at most `most` + 1 of them. O(most).
///
/// # Panics
/// If `most` is 0.
pub fn blocks(episodes: usize, most: usize) -> Vec<Range<usize>> {
    assert!(most > 0, "no blocks");
    if episodes <= most {
        return (0..episodes).map(|i| i..i + 1).collect();
    }
    let mut begin = 0;
    let mut blocks = Vec::with_capacity(most + 1);
    for i in 0..=most {
        let end = libm::pow(episodes as f64, i as f64 / most as f64).round() as usize;
        let end = if i == most { episodes } else { end };
        if end > begin {
            blocks.push(begin..end);
            begin = end;
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn few_episodes_stay_single() {
        assert_eq!(blocks(3, 10), [0..1, 1..2, 2..3]);
        assert!(blocks(0, 10).is_empty());
    }

    proptest! {
        #[test]
        fn blocks_cover_every_episode_once(episodes in 1_usize..200_000, most in 1_usize..500) {
            let blocks = blocks(episodes, most);
            prop_assert!(blocks.len() <= most + 1);
            prop_assert_eq!(blocks[0].start, 0);
            prop_assert_eq!(blocks[blocks.len() - 1].end, episodes);
            prop_assert!(blocks.windows(2).all(|w| w[0].end == w[1].start));
            prop_assert!(blocks.iter().all(|block| !block.is_empty()));
        }
    }
}
