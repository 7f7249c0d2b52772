//! e^x, without branches and without the processor's fused operations: the same bits everywhere, and fit for SIMD.
//!
//! ```text
//! x = k ln 2 + r,  |r| ≤ ½ ln 2,        e^x = 2^k e^r,        e^r = 1 + r + r² (1/2! + r/3! + … + r¹¹/13!)
//! ```
//!
//! The series leaves a relative error of ½ ln 2¹⁴ / 14! < 4.1e-18; with rounding a result is at most 1 ulp from the nearest number
//! (measured against libm's), 2 where it is subnormal. k ln 2 is subtracted in two parts, the first of which is exact (Cody & Waite 1980).

use std::array::from_fn;

/// ln 2 in two parts; the first has 33 bits, so that it times k is exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// From here on e^x is 0 or ∞, in f64.
const RANGE: (f64, f64) = (-746.0, 710.0);
/// Added to a number of less than 51 bits it leaves the nearest integer in the low bits, and the bias of the exponent with it.
const TO_EXPONENT: f64 = 6_755_399_441_055_744.0 + 1023.0;

/// 1/n!, from 2! to 13!.
const COEFFICIENTS: [f64; 12] = {
    let mut coefficients = [0.0; 12];
    let (mut n, mut factorial) = (2, 1.0);
    while n < 14 {
        factorial *= n as f64;
        coefficients[n - 2] = 1.0 / factorial;
        n += 1;
    }
    coefficients
};

/// e^x: ∞ above 709.8, 0 below −745.2, NaN of NaN.
#[inline]
pub(crate) fn exp(x: f64) -> f64 {
    let x = if x < RANGE.0 { RANGE.0 } else { x };
    let x = if x > RANGE.1 { RANGE.1 } else { x };
    let k = nearest(x * std::f64::consts::LOG2_E);
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    let e_r = 1.0 + (r + r * r * series(r));
    // In two steps: 2^k need not be a number where e^x is one.
    let half = nearest(0.5 * k);
    e_r * power_of_two(half) * power_of_two(k - half)
}

/// Estrin's scheme: the terms of each level at once.
#[inline]
fn series(r: f64) -> f64 {
    let (r2, c) = (r * r, &COEFFICIENTS);
    let r4 = r2 * r2;
    let pairs: [f64; 6] = from_fn(|i| c[2 * i] + c[2 * i + 1] * r);
    let fours: [f64; 3] = from_fn(|i| pairs[2 * i] + pairs[2 * i + 1] * r2);
    fours[0] + (fours[1] + fours[2] * r4) * r4
}

#[inline]
fn nearest(x: f64) -> f64 {
    (x + TO_EXPONENT) - TO_EXPONENT
}

/// 2^k for whole −1022 ≤ k ≤ 1023.
#[inline]
fn power_of_two(k: f64) -> f64 {
    f64::from_bits((k + TO_EXPONENT).to_bits() << 52)
}

/// Replaces each x by e^x, four at a time.
#[inline]
pub(crate) fn exp_in_place(x: &mut [f64]) {
    let (fours, rest) = x.as_chunks_mut::<4>();
    fours.iter_mut().for_each(exp_of_four);
    rest.iter_mut().for_each(|x| *x = exp(*x));
}

/// Replaces four at once.
#[inline]
pub(crate) fn exp_of_four(x: &mut [f64; 4]) {
    for x in x {
        *x = exp(*x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ulps(a: f64, b: f64) -> u64 {
        a.to_bits().abs_diff(b.to_bits())
    }

    #[test]
    fn far_out_it_is_zero_or_infinite_and_nan_stays() {
        for x in [-1e308, -1e4, -745.2, f64::NEG_INFINITY] {
            assert_eq!(exp(x), 0.0, "{x}");
        }
        for x in [709.8, 1e4, 1e308, f64::INFINITY] {
            assert_eq!(exp(x), f64::INFINITY, "{x}");
        }
        assert!(exp(f64::NAN).is_nan());
        assert_eq!([exp(0.0), exp(-0.0)], [1.0, 1.0]);
        assert!(exp(709.78) < f64::INFINITY && exp(-745.1) > 0.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1 << 16))]

        #[test]
        fn it_is_next_to_libms(x in -708.0..709.7_f64, small in -1.0..1.0_f64, subnormal in -745.0..-708.0_f64) {
            for x in [x, small, small * 1e-9] {
                prop_assert!(ulps(exp(x), libm::exp(x)) <= 1, "{}", x);
            }
            prop_assert!(ulps(exp(subnormal), libm::exp(subnormal)) <= 2, "{}", subnormal);
        }

        #[test]
        fn many_at_once_are_the_same_bits(xs in prop::collection::vec(-800.0..800.0_f64, 0..11)) {
            let mut found = xs.clone();
            exp_in_place(&mut found);
            for (x, found) in xs.into_iter().zip(found) {
                prop_assert_eq!(found.to_bits(), exp(x).to_bits());
            }
        }
    }
}
