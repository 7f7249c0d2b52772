//! One master seed, one independent random stream per component.
//!
//! A ChaCha generator has a 64-bit stream number beside its seed: the master seed keys the cipher and the
//! component picks the stream, so that no component's draws depend on how many another one made, nor on
//! which thread it runs.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Component that draws. The discriminant is the ChaCha stream number: append, never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Layout of a generated world (mazes, random doors).
    Layout = 1,
    /// Slips and start states.
    Environment = 2,
    /// Action choice.
    Agent = 3,
    /// Start blocks and guard columns of the eigensolver.
    Spectral = 4,
    /// Initial weights and sampled labels of the GCN.
    Gcn = 5,
    /// Random walks of DeepWalk.
    Walks = 6,
    /// Resampling in statistics.
    Bootstrap = 7,
    /// Ties of the exploration.
    Exploration = 8,
    /// Random features, the control for learnt ones.
    Features = 9,
    /// Slips and start states after the goals have moved.
    MovedEnvironment = 10,
    /// Where a goal is that each seed has of its own.
    Goals = 11,
    /// Random potentials, a control for those that know something.
    Potential = 12,
}

/// The generator of `stream` under `master_seed`.
pub fn stream(master_seed: u64, stream: Stream) -> ChaCha8Rng {
    substream(master_seed, stream, 0)
}

/// The generator of the component `stream` that has this number among several of its kind. Number 0 is [`stream`] itself.
pub fn substream(master_seed: u64, stream: Stream, number: u32) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(master_seed);
    rng.set_stream(stream as u64 | u64::from(number) << 32);
    rng
}

/// A standard normal number, the same bits everywhere: Box & Muller 1958, one of the two.
pub(crate) fn standard_normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - rng.random::<f64>())).sqrt();
    radius * libm::cos(TAU * rng.random::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn streams_repeat_and_differ() {
        let draw = |seed, s| stream(seed, s).next_u64();
        assert_eq!(draw(7, Stream::Agent), draw(7, Stream::Agent));
        assert_ne!(draw(7, Stream::Agent), draw(7, Stream::Environment));
        assert_ne!(draw(7, Stream::Agent), draw(8, Stream::Agent));
        let several = |number| substream(7, Stream::Agent, number).next_u64();
        assert_eq!(several(0), draw(7, Stream::Agent));
        assert_ne!(several(0), several(1));
    }
}
