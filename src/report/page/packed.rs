//! Many numbers as a short text: each is one of 4095 levels between the lowest and the highest, written as two digits
//! in base 64. A picture shows no more, and a number takes two bytes where JSON would take seven.
//!
//! ```text
//! value = low + level / 4094 · (high − low),  level = 64 · digit₁ + digit₂;  level 4095 is none
//! ```

use serde::Serialize;

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
const LEVELS: f64 = 4094.0;
const NONE: usize = 4095;

/// Numbers between `low` and `high`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Packed {
    low: f64,
    high: f64,
    levels: String,
}

impl Packed {
    /// Values that are not finite count as none.
    pub(super) fn new(values: &[f64]) -> Self {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            let levels = "//".repeat(values.len());
            return Self {
                levels,
                ..Self::default()
            };
        }
        let level = |value: f64| match value.is_finite() {
            true if high > low => ((value - low) / (high - low) * LEVELS).round() as usize,
            true => 0,
            false => NONE,
        };
        let digits = |level: usize| [DIGITS[level / 64], DIGITS[level % 64]].map(char::from);
        Self {
            low,
            high,
            levels: values.iter().flat_map(|&v| digits(level(v))).collect(),
        }
    }

    /// How many.
    pub(super) fn len(&self) -> usize {
        self.levels.len() / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the page's script does.
    fn unpacked(packed: &Packed) -> Vec<f64> {
        let digit = |c: u8| DIGITS.iter().position(|&d| d == c).unwrap();
        let pairs = packed.levels.as_bytes().chunks(2);
        let levels = pairs.map(|pair| 64 * digit(pair[0]) + digit(pair[1]));
        levels
            .map(|level| match level {
                NONE => f64::NAN,
                level => packed.low + level as f64 / LEVELS * (packed.high - packed.low),
            })
            .collect()
    }

    #[test]
    fn nothing_is_not_zero() {
        let packed = Packed::new(&[f64::NAN, 2.0, f64::INFINITY]);
        assert_eq!(packed.levels, "//AA//");
        assert_eq!((packed.low, packed.len()), (2.0, 3));
        assert_eq!(Packed::new(&[f64::NAN]).levels, "//");
    }

    proptest! {
        #[test]
        fn values_come_back_to_half_a_level(values in prop::collection::vec(-1e6_f64..1e6, 1..50)) {
            let packed = Packed::new(&values);
            let half = (packed.high - packed.low) / LEVELS * 0.500_001;
            for (back, value) in unpacked(&packed).iter().zip(&values) {
                prop_assert!((back - value).abs() <= half, "{back} for {value}");
            }
        }
    }
}
