//! Elementary functions for the inner loops: branch-free and without calls, so that compilers turn
//! loops over them into vector code, and from correctly rounded operations alone, so that they give
//! the same bits on every machine. The polynomials are minimax (Remez) in relative error.

use crate::constants::{SRGB_GAMMA, SRGB_LINEAR_END, SRGB_OFFSET, SRGB_SCALE, SRGB_SLOPE};
use std::hint::select_unpredictable;

/// `1/√x` for normal `x > 0`, within 2e-7 of it relatively; finite for 0.
#[inline(always)]
pub fn reciprocal_sqrt(x: f32) -> f32 {
    // Within 6 % of it, then 1/√(1 − r) as a polynomial of the residual -0.05 < r < 0.13.
    let y = f32::from_bits(0x5f33_0000_u32.wrapping_sub(x.to_bits() >> 1));
    let r = (-(x * y)).mul_add(y, 1.0);
    let p = polynomial(r, [0.328_507_87, 0.309_433, 0.375_010_55, 0.500_001_55]);
    (y * r).mul_add(p, y)
}

/// `log₂ x` for normal `x > 0`, within 3e-7 of it relatively around 1; below -126 for 0.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    let bits = x.to_bits() as i32;
    // x = (1 + f)·2^e with 1 + f in 2/3..4/3.
    let e = bits.wrapping_sub(0x3f2a_aaab) >> 23;
    let f = f32::from_bits(bits.wrapping_sub(e << 23) as u32) - 1.0;
    let p = polynomial(
        f,
        [
            -0.221_680_21,
            0.246_862_14,
            -0.236_891_76,
            0.285_582_04,
            -0.360_783_73,
            0.480_965_5,
            -0.721_346_6,
            1.442_694_8,
        ],
    );
    f.mul_add(p, e as f32)
}

/// `2^y` for `-64 < y < 128`, within 3e-7 of it relatively; `2^-64` for all smaller `y`, so that
/// products of it stay clear of subnormal numbers, which are slow.
#[allow(clippy::approx_constant, reason = "a minimax coefficient near ln 2, not ln 2")]
#[inline(always)]
pub fn exp2(y: f32) -> f32 {
    /// Adding it leaves the nearest integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let y = if y > -64.0 { y } else { -64.0 };
    let rounded = y + ROUND;
    let f = y - (rounded - ROUND);
    let power =
        polynomial(f, [1.326_472_7e-3, 9.671_513e-3, 5.550_733_6e-2, 0.240_222_42, 0.693_147, 1.0]);
    f32::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 23))
}

/// `x` within 0..=1, 0 for what is not a number.
#[inline(always)]
pub fn clamp(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    if x < 1.0 { x } else { 1.0 }
}

/// `log₂ x^(1/2.4)`, what [`srgb_encode`] wants of a linear value.
#[inline(always)]
pub fn srgb_exponent(linear: f32) -> f32 {
    log2(linear) * (1.0 / SRGB_GAMMA)
}

/// The sRGB encoding of a linear value in 0..=1 by way of its [`srgb_exponent`]; see
/// [`crate::math::color::srgb_encode`].
#[inline(always)]
pub fn srgb_encode(linear: f32, exponent: f32) -> f32 {
    let power = SRGB_SCALE.mul_add(exp2(exponent), -SRGB_OFFSET);
    // A plain `if` becomes a branch, which keeps the loop from being vectorised.
    select_unpredictable(linear <= SRGB_LINEAR_END, SRGB_SLOPE * linear, power)
}

/// A polynomial of `x` by Horner's rule, the highest power's coefficient first.
#[inline(always)]
fn polynomial<const N: usize>(x: f32, coefficients: [f32; N]) -> f32 {
    let mut p = coefficients[0];
    for c in &coefficients[1..] {
        p = p.mul_add(x, *c);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::color;

    /// Every 64th float of a range.
    fn floats(from: f32, to: f32) -> impl Iterator<Item = f32> {
        (from.to_bits()..=to.to_bits()).step_by(64).map(f32::from_bits)
    }

    fn encode(linear: f32) -> f32 {
        let linear = clamp(linear);
        srgb_encode(linear, srgb_exponent(linear))
    }

    /// Largest relative error against the exact function.
    fn worst(range: impl Iterator<Item = f32>, f: fn(f32) -> f32, exact: fn(f64) -> f64) -> f64 {
        range.map(|x| (f64::from(f(x)) / exact(x.into()) - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn reciprocal_square_roots() {
        let error = worst(floats(1e-12, 1e12), reciprocal_sqrt, |x| 1.0 / x.sqrt());
        assert!(error < 2e-7, "{error}");
        assert!(reciprocal_sqrt(0.0).is_finite());
    }

    #[test]
    fn logarithms_keep_their_relative_precision_around_1() {
        let error = worst(floats(0.5, 0.999_999_9), log2, f64::log2);
        assert!(error < 3e-7, "{error}");
        let small = floats(1e-30, 0.5).map(|x| (f64::from(log2(x)) - f64::from(x).log2()).abs());
        assert!(small.fold(0.0, f64::max) < 8e-6);
        assert_eq!(log2(1.0), 0.0);
        assert!(log2(0.0) < -126.0);
    }

    #[test]
    fn powers_of_two() {
        let error = worst(floats(1e-9, 64.0).map(|y| -y), exp2, f64::exp2);
        assert!(error < 3e-7, "{error}");
        assert_eq!((exp2(0.0), exp2(-3.0)), (1.0, 0.125));
        assert_eq!(exp2(-1e9), 2f32.powi(-64));
        assert_eq!(exp2(f32::NEG_INFINITY), 2f32.powi(-64));
    }

    #[test]
    fn highlights_stay_accurate_for_the_largest_exponent() {
        for s in [1.0f32, 10.0, 100.0, 1000.0, 4096.0] {
            let error = floats(0.5, 1.0)
                .map(|q| {
                    let fast = exp2(0.5 * s * log2(q));
                    (f64::from(fast) - f64::from(q).powf(0.5 * f64::from(s))).abs()
                })
                .fold(0.0, f64::max);
            assert!(error < 4e-7, "{s}: {error}");
        }
    }

    #[test]
    fn the_srgb_encoding_is_that_of_the_plain_one() {
        let error = floats(1e-9, 1.0).map(|x| (encode(x) - color::srgb_encode(x)).abs());
        assert!(error.fold(0.0, f32::max) < 5e-7);
        for x in [0.0, -1.0, 1.0, 7.0, f32::INFINITY] {
            assert_eq!(encode(x), color::srgb_encode(x));
        }
        assert_eq!(encode(f32::NAN), 0.0);
    }

    #[test]
    fn a_wrong_coefficient_is_noticed() {
        let wrong = |x: f32| reciprocal_sqrt(x) + 1e-6 * reciprocal_sqrt(x);
        assert!(worst(floats(1.0, 4.0), wrong, |x| 1.0 / x.sqrt()) > 2e-7);
    }
}
