//! u = e^{−v} as a number with an exponent of its own: u = m · 2^e with 1 ≤ m < 2.
//!
//! u falls by a constant factor per hop and leaves the range of f64 after some hundred hops. With the exponent apart
//! it never does, and a sweep needs neither exp nor ln: sums of neighbours are taken relative to the largest exponent
//! among them, where whatever is lost lies below 2^−900 of the sum.

/// u of one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Desirability {
    mantissa: f64,
    exponent: i64,
}

/// log₂ of the smallest ratio to the largest term that a sum still sees. With probabilities ≥ 1e-30 every product
/// stays a normal number.
const SMALLEST_RATIO: i64 = -900;

const FRACTION_BITS: u32 = f64::MANTISSA_DIGITS - 1;
const EXPONENT_BIAS: i64 = 1023;
const EXPONENT_MASK: u64 = 0x7ff << FRACTION_BITS;

impl Desirability {
    /// u = 0, v = ∞.
    pub const NONE: Self = Self {
        mantissa: 0.0,
        exponent: i64::MIN / 2,
    };

    /// e^{−v}; v = ∞ gives 0, a NaN stays a NaN.
    pub fn from_cost(v: f64) -> Self {
        if v == f64::INFINITY {
            return Self::NONE;
        }
        let exponent = (-v / std::f64::consts::LN_2).floor();
        Self {
            mantissa: (-v - exponent * std::f64::consts::LN_2).exp(),
            exponent: exponent as i64,
        }
    }

    /// v = −ln u.
    pub fn cost(self) -> f64 {
        -(self.mantissa.ln() + self.exponent as f64 * std::f64::consts::LN_2)
    }

    /// x · 2^reference for x > 0.
    #[inline]
    fn new(x: f64, reference: i64) -> Self {
        let bits = x.to_bits();
        let exponent = ((bits & EXPONENT_MASK) >> FRACTION_BITS) as i64 - EXPONENT_BIAS;
        if x == 0.0 || exponent > EXPONENT_BIAS {
            // 0, or a NaN or infinity, which must not be mistaken for numbers.
            let mantissa = if x == 0.0 { 0.0 } else { f64::NAN };
            return Self {
                mantissa,
                ..Self::NONE
            };
        }
        let one_to_two = (bits & !EXPONENT_MASK) | ((EXPONENT_BIAS as u64) << FRACTION_BITS);
        Self {
            mantissa: f64::from_bits(one_to_two),
            exponent: reference + exponent,
        }
    }

    /// Σ_k weights_k · u[columns_k]; 0 without terms.
    #[inline]
    pub fn weighted_sum(columns: &[u32], weights: &[f64], u: &[Self]) -> Self {
        let exponents = columns.iter().map(|&j| u[j as usize].exponent);
        let reference = exponents.fold(Self::NONE.exponent, i64::max);
        let terms = columns.iter().zip(weights);
        Self::new(
            terms
                .map(|(&j, w)| w * u[j as usize].relative_to(reference))
                .sum(),
            reference,
        )
    }

    /// u + w.
    #[inline]
    pub fn plus(self, other: Self) -> Self {
        let reference = self.exponent.max(other.exponent);
        Self::new(
            self.relative_to(reference) + other.relative_to(reference),
            reference,
        )
    }

    /// x · u for x ≥ 0.
    #[inline]
    pub fn times(self, x: f64) -> Self {
        Self::new(self.mantissa * x, self.exponent)
    }

    /// u ÷ w, at least and at most about 2^±900; ∞ where w = 0.
    #[inline]
    pub fn over(self, other: Self) -> f64 {
        let shift = self.exponent - other.exponent;
        self.mantissa * power_of_two(shift.min(-SMALLEST_RATIO)) / other.mantissa
    }

    /// Whether u = 0.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.mantissa == 0.0
    }

    /// u · 2^−reference; `reference` must not be below u's exponent.
    #[inline]
    fn relative_to(self, reference: i64) -> f64 {
        self.mantissa * power_of_two(self.exponent - reference)
    }
}

/// 2^max(exponent, −900) for an exponent up to 1023.
#[inline]
fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((EXPONENT_BIAS + exponent.max(SMALLEST_RATIO)) as u64) << FRACTION_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn zero_and_nan_keep_their_meaning() {
        assert_eq!(Desirability::from_cost(f64::INFINITY), Desirability::NONE);
        assert_eq!(Desirability::NONE.cost(), f64::INFINITY);
        let one = Desirability::from_cost(0.0);
        assert_eq!(one.plus(Desirability::NONE), one);
        assert_eq!(one.over(Desirability::NONE), f64::INFINITY);
        assert_eq!(Desirability::NONE.over(one), 0.0);
        assert_eq!(
            Desirability::weighted_sum(&[], &[], &[]),
            Desirability::NONE
        );
        assert!(Desirability::from_cost(f64::NAN).cost().is_nan());
        assert!(Desirability::new(f64::NAN, 3).cost().is_nan());
        assert!(Desirability::new(f64::INFINITY, 3).cost().is_nan());
        assert_eq!(Desirability::new(0.0, 3), Desirability::NONE);
        assert_eq!(Desirability::from_cost(0.0), Desirability::new(1.0, 0));
    }

    proptest! {
        /// Over 10⁷ nats, where e^{−v} itself has long been 0.
        #[test]
        fn costs_come_back(v in -1e3_f64..1e7) {
            let u = Desirability::from_cost(v);
            prop_assert!((u.cost() - v).abs() <= 1e-13 * v.abs().max(1.0), "{} from {}", u.cost(), v);
        }

        #[test]
        fn sums_and_ratios_agree_with_plain_numbers(
            a in 0.0_f64..200.0,
            b in 0.0_f64..200.0,
            depth in 0.0_f64..1e6,
        ) {
            let (u, w) = (Desirability::from_cost(depth + a), Desirability::from_cost(depth + b));
            let total = u.plus(w);
            let expected = -((-a).exp() + (-b).exp()).ln();
            prop_assert!((total.cost() - depth - expected).abs() < 1e-8);
            let twice = Desirability::weighted_sum(&[0, 1], &[2.0, 2.0], &[u, w]);
            prop_assert!((twice.cost() - total.times(2.0).cost()).abs() < 1e-8);
            let share = u.over(total);
            prop_assert!((share - 1.0 / (1.0 + (a - b).exp())).abs() < 1e-8 * share.max(1e-9));
        }
    }
}
